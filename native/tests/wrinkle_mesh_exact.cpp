// SPDX-License-Identifier: GPL-3.0-or-later
// Small cases of the Wrinkle Mesh worked by hand.
#include <gtest/gtest.h>

#include <cmath>

#include "surface/attachments.h"
#include "surface/deformation.h"
#include "systems/wrinkle_mesh.h"
#include "tests/meshes.h"

namespace rumple::tests {
namespace {

void expect_near(const Vec3& a, const Vec3& b, float tolerance = 1e-6f) {
    EXPECT_LT(glm::distance(a, b), tolerance) << a.x << ' ' << a.y << ' ' << a.z;
}

// Vlachos et al. 2001: p0 = 0, p1 = 3x, p2 = 3y, normals z but at p1, where it leans by 45 degrees towards x.
// b011 etc. by hand: on the edge p0 p1, b01 = (1,0,0); b10 = p1 + (p0 - p1)/3 - w n with w = (-1,0,0).n =
// -1/sqrt 2, so b10 = (2,0,0) + (1/2, 0, 1/2). The cubic at 1/2 is (p0 + 3 b01 + 3 b10 + p1) / 8.
TEST(PnTriangle, FollowsItsControlPointsOnAnEdge) {
    const Vec3 p[3] = {{0, 0, 0}, {3, 0, 0}, {0, 3, 0}};
    const Vec3 n[3] = {{0, 0, 1}, glm::normalize(Vec3(1, 0, 1)), {0, 0, 1}};
    expect_near(pn_triangle(p, n, 0.0f, 0.0f), p[0]);
    expect_near(pn_triangle(p, n, 1.0f, 0.0f), p[1]);
    expect_near(pn_triangle(p, n, 0.0f, 1.0f), p[2]);
    const Vec3 b01(1, 0, 0), b10(2.5f, 0, 0.5f);
    expect_near(pn_triangle(p, n, 0.5f, 0.0f), (p[0] + 3.0f * b01 + 3.0f * b10 + p[1]) / 8.0f);
}

TEST(PnTriangle, IsFlatWhereTheNormalsAre) {
    const Vec3 p[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const Vec3 n[3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    expect_near(pn_triangle(p, n, 0.2f, 0.3f), {0.2f, 0.3f, 0.0f});
}

TEST(Stretch, OfASheetIsWhatItWasStretchedBy) {
    const MeshData mesh = grid(4, 4, 0.25f);
    const Surface surface = build(mesh);
    const StretchModel model = build_stretch(surface);
    const float angle = 0.5235988f;  // 30 degrees
    const Vec3 axis(std::cos(angle), std::sin(angle), 0.0f), across(-axis.y, axis.x, 0.0f);
    std::vector<Vec3> pose = mesh.positions;
    for (Vec3& p : pose) p = 0.8f * glm::dot(p, axis) * axis + 1.1f * glm::dot(p, across) * across;
    const std::vector<SurfacePoint> places{{0, 0.3f, 0.3f}, {9, 0.1f, 0.8f}, {31, 0.0f, 0.0f}};
    StretchField field;
    measure_stretch(surface, model, pose, places, field);
    for (size_t i = 0; i < places.size(); ++i) {
        EXPECT_NEAR(field.minimum[i], 0.8f, 1e-5f);
        EXPECT_NEAR(field.maximum[i], 1.1f, 1e-5f);
        EXPECT_NEAR(std::abs(glm::dot(field.direction[i], axis)), 1.0f, 1e-5f);
    }
}

TEST(Stretch, IsOneAtRestOnACurvedSurfaceToo) {
    const MeshData mesh = cube();
    const Surface surface = build(mesh);
    StretchField field;
    const std::vector<SurfacePoint> places{{0, 0.3f, 0.3f}, {5, 0.5f, 0.5f}};
    measure_stretch(surface, build_stretch(surface), surface.positions_rest, places, field);
    for (const float value : field.minimum) EXPECT_NEAR(value, 1.0f, 1e-5f);
    for (const float value : field.maximum) EXPECT_NEAR(value, 1.0f, 1e-5f);
}

TEST(Principal, OfADiagonalTensorAreItsEntries) {
    const Principal p = principal({4.0f, 0.0f, 9.0f});
    EXPECT_FLOAT_EQ(p.small, 4.0f);
    EXPECT_FLOAT_EQ(p.large, 9.0f);
    EXPECT_NEAR(std::abs(p.small_direction.x), 1.0f, 1e-6f);
}

TEST(Principal, OfEqualEigenvaluesHasADirection) {
    const Principal p = principal({2.0f, 0.0f, 2.0f});
    EXPECT_FLOAT_EQ(p.small, 2.0f);
    EXPECT_EQ(p.small_direction, Vec2(1.0f, 0.0f));
}

// One square metre, not refined: corners attached linearly, no fade, no bending, no nudge. Squeezed to 0.8
// along x. Equations (3) to (5) by hand for a pair of rest length 1 at distance 0.8: dp = (0.8 - 1), each end
// moves by 0.1; equation (7) then pulls an end that is farther than r = 0.05 back to r.
TEST(Equations, ThreeToFiveAndSevenOnAPair) {
    using namespace wrinkle_mesh;
    const MeshData mesh = grid(1, 1, 1.0f);
    Source source;
    source.level = 0;
    const auto model = wrinkle_mesh::build(build(mesh), source, AttachmentKind::kLinear, 0);
    Settings settings;
    settings.bending = settings.nudge = 0.0f;
    settings.hem_rings = 0;
    settings.start_iterations = 1;
    settings.radius = 0.05f / model->local_edge[0];
    settings.stretch_relief = 1.0f;
    std::vector<Vec3> pose = mesh.positions;
    for (Vec3& p : pose) p.x *= 0.8f;
    Report report;
    const State state = solve(*model, settings, {}, {pose}, nullptr, report);
    Picture picture;
    show(*model, settings, {pose}, state, picture);
    EXPECT_NEAR(glm::length(picture.offset[0]), 0.05f, 1e-6f);
    EXPECT_LT(picture.offset[0].x, -0.04f);  // outward along the squeezed edge
    EXPECT_EQ(report.iterations, 1);
    EXPECT_EQ(model->distance.size(), 5u);  // four sides and one diagonal
    EXPECT_EQ(model->bending.size(), 1u);   // the other diagonal
}

}  // namespace
}  // namespace rumple::tests
