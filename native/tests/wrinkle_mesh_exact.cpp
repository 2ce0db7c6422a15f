// SPDX-License-Identifier: GPL-3.0-or-later
// Small cases of the Wrinkle Mesh worked by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "surface/output/attachments.h"
#include "surface/strain/deformation.h"
#include "systems/wrinkle_mesh/wrinkle_mesh.h"
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

// The same triangle in its middle. With E the mean of the six controls on the edges, V that of the corners,
// the centre control is E + (E - V) / 2, and at weights of 1/3 the Bernstein sum is V / 9 + 2 E / 3 + 2 (3 E
// - V) / 18 = E. By hand b01 = (1,0,0), b10 = (5/2,0,1/2), b02 = (0,1,0), b20 = (0,2,0), b21 = (1,2,0), and
// with (p2 - p1).n1 n1 =
// -(3/2,0,3/2), b12 = ((6,3,0) + (3/2,0,3/2)) / 3 = (5/2,1,1/2).
TEST(PnTriangle, IsTheMeanOfItsEdgeControlPointsInTheMiddle) {
    const Vec3 p[3] = {{0, 0, 0}, {3, 0, 0}, {0, 3, 0}};
    const Vec3 n[3] = {{0, 0, 1}, glm::normalize(Vec3(1, 0, 1)), {0, 0, 1}};
    expect_near(pn_triangle(p, n, 1.0f / 3.0f, 1.0f / 3.0f), {7.0f / 6.0f, 1.0f, 1.0f / 6.0f});
    // On the edge p1 p2 at its middle: (p1 + 3 b12 + 3 b21 + p2) / 8.
    expect_near(pn_triangle(p, n, 0.5f, 0.5f), Vec3(3 + 7.5f + 3, 3 + 6 + 3, 1.5f) / 8.0f);
}

// Catmull-Clark at a vertex of four quads: 16, 4 at the ends of the edges, 1 at the corners across, over 36.
TEST(LimitSurface, OfARegularGridVertexIsTheBicubicSpline) {
    MeshData mesh = shaken(grid(4, 4, 0.25f), 0.05f, 3);
    const Surface surface = build(mesh);
    const Index v = 2 + 2 * 5;
    const auto at = [&](int i, int j) { return mesh.positions[v + i + 5 * j]; };
    const Vec3 hand = (16.0f * at(0, 0) + 4.0f * (at(1, 0) + at(-1, 0) + at(0, 1) + at(0, -1)) + at(1, 1) +
                       at(1, -1) + at(-1, 1) + at(-1, -1)) /
                      36.0f;
    wrinkle_mesh::Source source;
    source.level = 0;
    const auto model = wrinkle_mesh::build(build(mesh), source, AttachmentKind::kLimit, 0);
    expect_near(model->positions_rest[v], hand);
    // ... and as the attachment in a deformed pose.
    std::vector<Vec3> out(mesh.positions.size()), pose = mesh.positions;
    for (Vec3& p : pose) p = 2.0f * p + Vec3(1.0f, 0.0f, 0.0f);
    attach(surface, model->attachments, pose, {}, out);
    expect_near(out[v], 2.0f * hand + Vec3(1.0f, 0.0f, 0.0f));
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

TEST(Principal, OfAFullTensorIsItsEigensystem) {
    // R diag(4, 9) R^T for a turn by 30 degrees: the small one lies along (cos 30, sin 30).
    const float c = std::sqrt(0.75f), s = 0.5f;
    const Principal p = principal({4 * c * c + 9 * s * s, (4 - 9) * c * s, 4 * s * s + 9 * c * c});
    EXPECT_NEAR(p.small, 4.0f, 1e-5f);
    EXPECT_NEAR(p.large, 9.0f, 1e-5f);
    EXPECT_NEAR(std::abs(p.small_direction.x * c + p.small_direction.y * s), 1.0f, 1e-6f);
}

// [5 2; 2 2] (1, -2) = (1, -2) and [5 2; 2 2] (2, 1) = 6 (2, 1); likewise with x and y exchanged.
TEST(Principal, PointsAlongTheSmallEigenvectorWhicheverColumnIsLonger) {
    const float unit = std::sqrt(0.2f);
    const Principal steep = principal({5.0f, 2.0f, 2.0f}), gentle = principal({2.0f, 2.0f, 5.0f});
    EXPECT_NEAR(std::abs(glm::dot(steep.small_direction, Vec2(unit, -2.0f * unit))), 1.0f, 1e-6f);
    EXPECT_NEAR(std::abs(glm::dot(gentle.small_direction, Vec2(2.0f * unit, -unit))), 1.0f, 1e-6f);
    EXPECT_NEAR(steep.small, 1.0f, 1e-6f);
    EXPECT_NEAR(gentle.large, 6.0f, 1e-6f);
    // One column of T - 9 I vanishes: the other one must answer.
    EXPECT_NEAR(std::abs(principal({9.0f, 0.0f, 4.0f}).small_direction.y), 1.0f, 1e-6f);
}

// R diag(4, 9) R^T for a turn so small that 9 - 4 sin^2 rounds to 9: the short column of T - 9 I has no digit
// right, the long one has all.
TEST(Principal, KeepsItsDirectionThroughTurnsThatOneColumnCannotHold) {
    for (const float turn : {1e-5f, -1e-4f, 1e-3f, -1e-2f}) {
        const float c = std::cos(turn), s = std::sin(turn);
        const Vec2 x = principal({4 * c * c + 9 * s * s, -5 * c * s, 4 * s * s + 9 * c * c}).small_direction;
        EXPECT_NEAR(x.y / x.x, s / c, 1e-6f) << turn;
        const Vec2 y = principal({9 * c * c + 4 * s * s, 5 * c * s, 9 * s * s + 4 * c * c}).small_direction;
        EXPECT_NEAR(-y.x / y.y, s / c, 1e-6f) << turn;
    }
}

using namespace wrinkle_mesh;

// The paper's constraints and nothing else: not refined, linear, one sweep from the attachments.
Settings plain() {
    Settings settings;
    settings.radius = 100.0f;
    settings.bending = settings.nudge = settings.stretch_relief = 0.0f;
    settings.compression_limit = 1e6f;
    settings.collision = Collision::kNone;
    settings.hem_rings = 0;
    settings.start_iterations = 1;
    return settings;
}

std::shared_ptr<const Model> unrefined(const MeshData& mesh) {
    Source source;
    source.level = 0;
    return wrinkle_mesh::build(build(mesh), source, AttachmentKind::kLinear, 0);
}

using Solve = State (*)(const Model&, const Settings&, const Paint&, const Input&, const State*, Report&);

class Equations : public testing::TestWithParam<Solve> {
  protected:
    // Offsets in object space.
    std::vector<Vec3> offsets(const Model& model, const Settings& settings, const std::vector<Vec3>& pose) {
        Report report;
        const State state = GetParam()(model, settings, {}, {pose}, nullptr, report);
        Picture picture;
        show(model, settings, {pose}, state, picture);
        return picture.offset;
    }
};

// p0 = 0, p1 = x, p2 = y. The side p0 p2 is turned towards p1 by asin(3/5), so p2 = (3/5, 4/5) and only the
// pair p1 p2 is not at rest: its length is sqrt(4/5), asked for is sqrt 2. (3): dp = (p2 - p1) / |p2 - p1|
// (|p2 - p1| - sqrt 2).
TEST_P(Equations, ThreeToFiveMoveBothEndsOfAPairByHalf) {
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.add_polygon({0, 1, 2});
    const auto model = unrefined(mesh);
    const std::vector<Vec3> pose = {{0, 0, 0}, {1, 0, 0}, {0.6f, 0.8f, 0}};
    const float length = std::sqrt(0.8f);
    const Vec3 dp = Vec3(-0.4f, 0.8f, 0.0f) / length * (length - std::sqrt(2.0f));
    // The others would pull at it if they came later; the order of colours is not promised, so it is asked
    // for.
    const Pairs& pairs = model->distance;
    ASSERT_EQ(pairs.size(), 3u);
    ASSERT_EQ(std::minmax(pairs.a[2], pairs.b[2]), std::minmax(Index(1), Index(2)));
    const std::vector<Vec3> o = offsets(*model, plain(), pose);
    expect_near(o[0], Vec3(0.0f));
    expect_near(o[1], 0.5f * dp);
    expect_near(o[2], -0.5f * dp);
}

// As above, with p1 p2 turned to p2 = (0.28, 0.96): its length is 1.2, asked for is sqrt 2, and the base
// gives in to the first tenth.
TEST_P(Equations, TheFirstCompressionBearsNoFolds) {
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.add_polygon({0, 1, 2});
    const auto model = unrefined(mesh);
    const std::vector<Vec3> pose = {{0, 0, 0}, {1, 0, 0}, {0.28f, 0.96f, 0}};
    Settings settings = plain();
    settings.buckling_threshold = 0.1f;
    const Vec3 dp = Vec3(-0.6f, 0.8f, 0.0f) * (1.2f - 0.9f * std::sqrt(2.0f));
    const std::vector<Vec3> o = offsets(*model, settings, pose);
    expect_near(o[1], 0.5f * dp);
    expect_near(o[2], -0.5f * dp);
    settings.buckling_threshold = 0.16f;  // more than 1 - 1.2 / sqrt 2
    for (const Vec3& offset : offsets(*model, settings, pose)) expect_near(offset, Vec3(0.0f));
}

// (7): both ends were moved by |dp| / 2 = 0.26, farther than r = 0.1, and are put on the sphere, in the same
// direction.
TEST_P(Equations, SevenPutsAVertexOnItsSphere) {
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.add_polygon({0, 1, 2});
    const auto model = unrefined(mesh);
    Settings settings = plain();
    settings.radius = 0.1f / model->local_edge[1];
    const std::vector<Vec3> o = offsets(*model, settings, {{0, 0, 0}, {1, 0, 0}, {0.6f, 0.8f, 0}});
    const Vec3 direction = glm::normalize(Vec3(-0.4f, 0.8f, 0.0f));
    expect_near(o[1], -0.1f * direction);
    expect_near(o[2], 0.1f * direction);
}

// A square cut along the diagonal d from p0 to p2, both wings raised by 30 degrees: a valley. Sides and
// diagonal keep their length; p1 and p3, of height h = 1 / sqrt 2 over the diagonal, come closer by 2 h (1 -
// cos 30).
struct Valley {
    MeshData mesh;
    std::shared_ptr<const Model> model;
    std::vector<Vec3> pose;
    float h = std::sqrt(0.5f), c = std::sqrt(0.75f), s = 0.5f;
    Vec3 across = Vec3(1, -1, 0) * std::sqrt(0.5f), up = Vec3(0, 0, 1);  // from the diagonal to p1

    Valley() {
        mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
        mesh.add_polygon({0, 1, 2, 3});
        model = unrefined(mesh);
        const Vec3 middle(0.5f, 0.5f, 0.0f);
        pose = {mesh.positions[0], middle + h * (c * across + s * up), mesh.positions[2],
                middle + h * (-c * across + s * up)};
    }
};

TEST_P(Equations, BendingMovesOppositeVerticesByItsShare) {
    const Valley valley;
    ASSERT_EQ(valley.model->distance.size(), 5u);  // four sides and the diagonal
    ASSERT_EQ(valley.model->bending.size(), 1u);
    for (const float k : {0.0f, 0.25f, 1.0f}) {
        Settings settings = plain();
        settings.bending = k;
        const std::vector<Vec3> o = offsets(*valley.model, settings, valley.pose);
        const Vec3 push = k * valley.h * (1.0f - valley.c) * valley.across;
        expect_near(o[0], Vec3(0.0f));
        expect_near(o[1], push);
        expect_near(o[2], Vec3(0.0f));
        expect_near(o[3], -push);
    }
}

// The push points behind the plane of the wing, whose normal is n = -sin 30 across + cos 30 up: with the
// plane at the attachment only its share within the wing is left, with the plane at a depth so much more of
// -n.
TEST_P(Equations, ThePlaneTakesAwayWhatIsBehindIt) {
    const Valley valley;
    const Vec3 along = valley.c * valley.across + valley.s * valley.up;
    const Vec3 n = -valley.s * valley.across + valley.c * valley.up;
    const float push = valley.h * (1.0f - valley.c);
    Settings settings = plain();
    settings.bending = 1.0f;
    settings.collision = Collision::kPlane;
    for (const float depth : {0.0f, 0.01f}) {
        settings.inside = depth / (settings.radius * valley.model->local_edge[1]);
        expect_near(offsets(*valley.model, settings, valley.pose)[1], push * valley.c * along - depth * n);
    }
    settings.inside = 1.0f;  // deeper than the push
    expect_near(offsets(*valley.model, settings, valley.pose)[1], push * valley.across);
}

// A triangle can always have the lengths it is asked for: s l0 after enough sweeps.
TEST_P(Equations, PreStretchScalesTheLengthThatIsAskedFor) {
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.add_polygon({0, 1, 2});
    const auto model = unrefined(mesh);
    Settings settings = plain();
    settings.prestretch = 2.0f;
    settings.start_iterations = 200;
    Report report;
    const State state = GetParam()(*model, settings, {}, {mesh.positions}, nullptr, report);
    Picture picture;
    show(*model, settings, {mesh.positions}, state, picture);
    const auto& p = picture.positions;
    EXPECT_NEAR(glm::distance(p[0], p[1]), 2.0f, 1e-5f);
    EXPECT_NEAR(glm::distance(p[0], p[2]), 2.0f, 1e-5f);
    EXPECT_NEAR(glm::distance(p[1], p[2]), 2.0f * std::sqrt(2.0f), 1e-5f);
    EXPECT_NEAR(report.error_before, 0.5f, 1e-6f);
    EXPECT_NEAR(report.error_after, 0.0f, 1e-5f);
}

INSTANTIATE_TEST_SUITE_P(ColouredAndPrinted, Equations, testing::Values(&solve, &solve_in_order));

}  // namespace
}  // namespace rumple::tests
