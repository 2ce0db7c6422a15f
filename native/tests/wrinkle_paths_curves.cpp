// SPDX-License-Identifier: GPL-3.0-or-later
// The paths as curves that ride on the base, and ellipses of stretch.
#include <gtest/gtest.h>

#include "systems/wrinkle_paths/curves.h"
#include "tests/refusals.h"
#include "tests/wrinkle_paths_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_paths;

// The formula of the header, from the artist's vertices alone.
Vec3 ridden(const RidingCurves& curves, size_t i, const Pose3& pose) {
    const auto& [a, b, c] = curves.corners[i];
    const SurfaceFrame frame = triangle_frame(pose[a], pose[b], pose[c]);
    return pose[a] + curves.weights[i].x * (pose[b] - pose[a]) + curves.weights[i].y * (pose[c] - pose[a]) +
           frame.to_object(curves.local_offset[i]);
}

// A tube that is bent, with its paths, whatever it is attached to.
struct BentTube : PathCloth {
    Pose3 pose;
    State state;
    explicit BentTube(AttachmentKind kind) : PathCloth(tube(16, 14, 0.06f, 0.5f)) {
        model = wrinkle_paths::build(tests::build(mesh), {}, kind);
        settings.rest.reference = Reference::kStaticRest;
        pose = bent(2.0f, 0.5f);
        state = solve(pose);
    }
    RidingCurves ride() const {
        return wrinkle_paths::ride(*model, settings, make_pose(*model, pose), state);
    }
};

TEST(PathCurves, RidingOnTheirOwnPoseTheyStandOnTheCrests) {
    for (const AttachmentKind kind : {AttachmentKind::kLinear, AttachmentKind::kPnTriangle}) {
        const BentTube cloth(kind);
        const RidingCurves curves = cloth.ride();
        const Curves flat = cloth.curves(cloth.pose, cloth.state);
        ASSERT_GT(curves.curves.id.size(), 2u);
        ASSERT_EQ(curves.corners.size(), curves.curves.positions.size());
        float highest = 0.0f;
        for (size_t i = 0; i < curves.curves.positions.size(); ++i) {
            EXPECT_LT(glm::distance(ridden(curves, i, cloth.pose), curves.curves.positions[i]), 1e-6f);
            const float above = glm::distance(curves.curves.positions[i], flat.positions[i]);
            EXPECT_LT(above, flat.height[i] + 0.5f * cloth.settings.width);  // PN triangles bulge
            highest = std::max(highest, above);
        }
        EXPECT_GT(highest, 0.1f * cloth.settings.width);
    }
}

// Smoothing in space drew them off a bend by a sixth of a width; folds were lower there.
TEST(PathCurves, SmoothedTheyStayOnTheTriangles) {
    const BentTube cloth(AttachmentKind::kLinear);
    const Curves flat = cloth.curves(cloth.pose, cloth.state);
    const RidingCurves lifted = cloth.ride();
    float most = 0.0f;
    for (size_t i = 0; i < flat.positions.size(); ++i) {
        const float above = glm::distance(lifted.curves.positions[i], flat.positions[i]);
        most = std::max(most, std::abs(above - lifted.curves.height[i]));
    }
    EXPECT_LT(most, 0.1f * cloth.settings.width);
}

// Without them the curves stood 12 mm before a fine mesh on the limit surface.
TEST(PathCurves, TheyLieOnTheFineMesh) {
    for (const AttachmentKind kind : {AttachmentKind::kPnTriangle, AttachmentKind::kLimit}) {
        BentTube cloth(kind);
        cloth.model = wrinkle_paths::build(tests::build(cloth.mesh), {.level = 3}, kind);
        const RidingCurves curves = cloth.ride();
        const Picture picture = cloth.show(cloth.pose, cloth.state);
        std::vector<float> away;
        for (const Vec3& p : curves.curves.positions) {
            float nearest = 1.0f;
            for (const Vec3& q : picture.positions) nearest = std::min(nearest, glm::distance(p, q));
            away.push_back(nearest);
        }
        std::sort(away.begin(), away.end());
        // Fine edges are 3 to 5 mm long. Some ends run below the flanks of higher folds.
        EXPECT_LT(away[away.size() / 2], 2.5e-3f);
        EXPECT_LT(away[away.size() * 9 / 10], 4e-3f);
    }
}

TEST(PathCurves, TheyTurnWithTheBase) {
    const BentTube cloth(AttachmentKind::kPnTriangle);
    const RidingCurves curves = cloth.ride();
    const auto turned = [](const Vec3& p) { return Vec3(-p.z, p.y, p.x) + Vec3(1.0f, 2.0f, 3.0f); };
    Pose3 pose = cloth.pose;
    for (Vec3& p : pose) p = turned(p);
    for (size_t i = 0; i < curves.curves.positions.size(); ++i)
        EXPECT_LT(glm::distance(ridden(curves, i, pose), turned(curves.curves.positions[i])), 2e-6f);
}

TEST(PathCurves, HemsFadeInTheirHeights) {
    BentTube cloth(AttachmentKind::kLinear);
    cloth.settings.hem_rings = 13;  // every ring of the tube
    const RidingCurves curves = cloth.ride();
    const Curves whole = cloth.curves(cloth.pose, cloth.state);
    for (size_t i = 0; i < curves.curves.height.size(); ++i) {
        EXPECT_LE(curves.curves.height[i], whole.height[i]);
        EXPECT_LT(curves.curves.height[i], 0.9f * whole.height[i] + 1e-9f);
    }
}

TEST(PathCurves, ACollapsedTriangleKeepsThemFinite) {
    BentTube cloth(AttachmentKind::kPnTriangle);
    const RidingCurves before = cloth.ride();
    const auto corners = before.corners[before.corners.size() / 2];
    cloth.pose[corners[1]] = cloth.pose[corners[2]] = cloth.pose[corners[0]];
    for (const Vec3& p : cloth.ride().curves.positions) EXPECT_TRUE(std::isfinite(p.x + p.y + p.z));
}

// A right triangle of legs 3 and 4 (inscribed circle: radius 1) at 0.8 along x and 1.5 along y.
TEST(PathEllipses, ByHand) {
    MeshData mesh;
    mesh.positions = {{0.0f, 0.0f, 0.0f}, {3.0f, 0.0f, 0.0f}, {0.0f, 4.0f, 0.0f}};
    mesh.add_polygon({0, 1, 2});
    const PathCloth cloth(mesh);
    const State rest = cloth.solve(cloth.mesh.positions);
    const Pose pose = make_pose(*cloth.model, cloth.squeezed(0.8f, 1.5f));
    const Ellipse ellipse = ellipses(*cloth.model, pose, rest, 1.0f)[0];
    EXPECT_LT(glm::distance(ellipse.centre, Vec3(0.8f, 2.0f, 0.0f)), 1e-6f);
    EXPECT_NEAR(std::abs(ellipse.compressed.x), 0.8f, 1e-6f);
    EXPECT_NEAR(glm::length(ellipse.compressed), 0.8f, 1e-6f);
    EXPECT_NEAR(std::abs(ellipse.stretched.y), 1.5f, 1e-6f);
    EXPECT_NEAR(glm::length(ellipse.stretched), 1.5f, 1e-6f);
    const Pose flat = make_pose(*cloth.model, cloth.squeezed(0.0f));
    EXPECT_EQ(ellipses(*cloth.model, flat, rest)[0].stretched, Vec3(0.0f)) << "nothing is known";
}

TEST(PathEllipses, WhatDoesNotFitIsRefused) {
    const PathCloth cloth(grid(3, 3, 0.1f));
    const State rest = cloth.solve(cloth.mesh.positions);
    const Pose pose = make_pose(*cloth.model, cloth.mesh.positions);
    State other = rest;
    other.reference.reference.pop_back();
    expect_refused([&] { ellipses(*cloth.model, pose, other); }, {"reference"});
}

}  // namespace
}  // namespace rumple::tests
