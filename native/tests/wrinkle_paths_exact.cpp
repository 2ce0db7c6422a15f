// SPDX-License-Identifier: GPL-3.0-or-later
// Small cases of the Wrinkle Paths worked by hand: walks, slides.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "base/tolerances.h"
#include "systems/wrinkle_paths/lifecycle.h"
#include "tests/wrinkle_paths_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_paths;

// Squared lengths are filtered: of 1 and 1/4, after one time constant exp(-1) of the way is left.
TEST(PathShapes, AreFilteredInTime) {
    PathCloth one(grid(1, 1, 1.0f));
    one.settings.smoothing = 0.1f;
    const Pose rest = make_pose(*one.model, one.mesh.positions);
    const Pose pose = make_pose(*one.model, one.squeezed(1.0f, 0.5f));
    State state;
    state.shapes = rest.base.shapes;
    const std::vector<FlatTriangle> shapes = smoothed_shapes(one.settings, 0.1, &state, pose);
    for (size_t t = 0; t < shapes.size(); ++t) {
        const Stretch stretch = measure_stretch(rest.base.shapes[t], shapes[t]);
        EXPECT_NEAR(1.0f / stretch.compression, std::sqrt(0.25f + 0.75f * std::exp(-1.0f)), 1e-6f);
        EXPECT_NEAR(stretch.stretch, 1.0f, 1e-6f);
    }
    EXPECT_EQ(smoothed_shapes(one.settings, 0.1, nullptr, pose)[0].y2, pose.base.shapes[0].y2);
}

// Why squared lengths: of a triangle that only jitters, the mean of lambda_min is 4 % short, and the
// compression that folds live on grows by as much. Its mean squared lengths are a quarter of a per cent long.
TEST(PathShapes, OfATriangleThatJittersAreNotShorter) {
    PathCloth one(grid(1, 1, 0.04f));
    const Pose rest = make_pose(*one.model, one.mesh.positions);
    std::mt19937 random(1);
    std::normal_distribution<float> noise(0.0f, 0.001f);
    State state;
    state.shapes = rest.base.shapes;
    double of_smoothed = 0.0, of_each = 0.0;
    constexpr int kFrames = 3000, kSettled = 100;
    for (int f = 0; f < kFrames; ++f) {
        Pose3 pose = one.mesh.positions;
        for (Vec3& p : pose) p += Vec3(noise(random), noise(random), noise(random));
        const Pose jittered = make_pose(*one.model, pose);
        state.shapes = smoothed_shapes(one.settings, 1.0 / 30.0, &state, jittered);
        if (f < kSettled) continue;
        of_each += 1.0 / measure_stretch(rest.base.shapes[0], jittered.base.shapes[0]).compression /
                   (kFrames - kSettled);
        of_smoothed +=
            1.0 / measure_stretch(rest.base.shapes[0], state.shapes[0]).compression / (kFrames - kSettled);
    }
    EXPECT_LT(of_each, 0.97);
    EXPECT_GT(of_smoothed, 0.98);
}

// ---- section 5.2.1

struct Sliding : Squeezed {
    std::vector<PathPoint> path;  // straight up at x = 0.8
    Sliding() {
        std::fill(context.activity.begin(), context.activity.end(), 1.0f);
        WalkLimits limits;
        limits.compression = 1.5f;
        limits.length = 100.0f;
        const Index t = triangle_at({0.8f, 0.3f, 0.0f});
        std::vector<Index> visited{t};
        const glm::dvec2 at = context.to_flat(t, {0.8f, 0.3f, 0.0f}),
                         up = context.to_flat(t, {0.8f, 1.3f, 0.0f});
        path = walk(context, t, at, up - at, limits, visited).points;
        path.insert(path.begin(), inside(context, t, at));
    }
    float off_axis(const std::vector<PathPoint>& points) const {
        const std::vector<Vec3> at = positions(context, points);
        float most = 0.0f;
        for (size_t i = 0; i + 1 < at.size(); ++i) most = std::max(most, std::abs(at[i + 1].x - at[i].x));
        return most;
    }
};

TEST(PathSlide, LeavesAnAlignedPathAlone) {
    Sliding sheet;
    std::vector<PathPoint> points = sheet.path;
    std::vector<float> moved;
    follow(sheet.context, sheet.pose, sheet.settings, 1.0 / 30.0, points, moved);
    ASSERT_EQ(points.size(), sheet.path.size());
    for (size_t i = 0; i < points.size(); ++i) EXPECT_EQ(points[i].at, sheet.path[i].at);
}

TEST(PathSlide, TurnsAPathTowardsTheFieldAndNotWithoutAlpha) {
    Sliding sheet;
    std::vector<PathPoint> points = sheet.path, kept;
    for (size_t i = 2; i + 2 < points.size(); i += 2) points[i].at.x += i % 4 ? 0.1f : -0.1f;
    kept = points;
    const float before = sheet.off_axis(points);
    std::vector<float> moved;
    follow(sheet.context, sheet.pose, sheet.settings, 1.0 / 30.0, points, moved);
    EXPECT_LT(sheet.off_axis(points), before);
    EXPECT_EQ(validate(*sheet.model, {{0, 1.0f, points}}), "");
    sheet.settings.alignment = 0.0f;
    follow(sheet.context, sheet.pose, sheet.settings, 1.0 / 30.0, kept, moved);
    EXPECT_EQ(sheet.off_axis(kept), before);
}

// A walk whose length is used up exactly at an edge ends there: its last segment has no length. Cut back to
// that segment alone, such a path once became not a number, and its own state was refused in the next frame.
TEST(PathLive, CutsAPathBackToASegmentWithoutLength) {
    PathCloth cloth(grid(1, 1, 0.125f));  // all lengths below are exact in binary
    cloth.settings.growth_limit = 1.0f;
    cloth.settings.fade = 10.0f;
    State state = cloth.solve(cloth.mesh.positions);
    const Pose pose = make_pose(*cloth.model, cloth.mesh.positions);
    const PathSurface surface{*cloth.model, pose};
    const PathPoint on_edge{1, 0, {0.5f, 0.0f}};  // the middle of the diagonal, (1/16, 1/16)
    ASSERT_EQ(triangle_of(cloth.model->triangles.net.twin[half_edge(on_edge)]), 0);
    state.paths = {{0,
                    1.0f,
                    {{1, kNone, {0.5f, 0.0f}},  // the same place
                     on_edge,
                     inside(surface, 0, {0.0625 + 1.0 / 512.0, 0.0625})}}};
    ASSERT_EQ(cloth.validate(state), "");
    for (int f = 0; f < 5; ++f) {
        ASSERT_NO_THROW(state = cloth.solve(cloth.mesh.positions, &state));
        ASSERT_EQ(cloth.validate(state), "");
    }
}

// One inner point, on an edge along x from 0 to 1, between ends straight below and above its place at t =
// 1/2, with e = x. Eq. 5.2 for its change d, all in square lengths: two segments give a' (d - c)^2 each, its
// place d^2, its bend and those of the ends d^2 each. By hand with c the offset of both ends: d = 2 a' c / (2
// a' + 4).
TEST(PathSlide, IsTheMinimumOfEquation52) {
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0.5f, 1, 0}, {0.5f, -1, 0}};
    mesh.add_polygon({0, 1, 2});
    mesh.add_polygon({1, 0, 3});
    PathCloth cloth(mesh);
    const Pose pose = make_pose(*cloth.model, mesh.positions);
    PathContext context{{{*cloth.model, pose}}};
    for (int t = 0; t < 2; ++t) {
        const glm::dvec2 x = context.to_flat(t, context.vertex(3 * t) + Vec3(1, 0, 0));
        context.stretch.push_back({2.0f, 1.0f, Vec2(x), true});
    }
    context.compression = {2.0f, 2.0f};
    context.activity = {1.0f, 1.0f};
    const float c = 0.1f, alpha = 0.4f;
    std::vector<PathPoint> points{inside(context, 1, context.to_flat(1, {0.5f + c, -0.5f, 0})),
                                  {1, 0, {0.5f, 0.0f}},
                                  inside(context, 0, context.to_flat(0, {0.5f + c, 0.5f, 0}))};
    ASSERT_EQ(validate(*cloth.model, {{0, 1.0f, points}}), "");
    cloth.settings.alignment = alpha;
    std::vector<float> moved;
    follow(context, pose, cloth.settings, 1.0 / 30.0, points, moved);
    EXPECT_NEAR(position(context, points[1]).x, 0.5f + 2.0f * alpha * c / (2.0f * alpha + 4.0f), 1e-5f);
    ASSERT_EQ(moved.size(), 1u);
    EXPECT_NEAR(moved[0], 2.0f * alpha * c / (2.0f * alpha + 4.0f), 1e-5f);
}

// Six triangles around (0, 0). The path runs upwards left of it, over the one edge to (-1, 0); the field
// wants it at x = 0.1 there. By hand, with (e . x)^2 = w in both triangles, from x = -0.02: d = 2 a' w 0.12 /
// (2 a' w + 4). So it goes beyond the middle by d - 0.02, and must pass it on the other five edges at that
// distance.
TEST(PathSlide, PassesAVertexToTheEdgesOnItsOtherSide) {
    MeshData mesh;
    mesh.positions = {{0, 0, 0}};
    for (int k = 0; k < 6; ++k) {
        const float a = float(k) * std::numbers::pi_v<float> / 3.0f;
        mesh.positions.push_back({std::cos(a), std::sin(a), 0.0f});
    }
    for (Index k = 0; k < 6; ++k) mesh.add_polygon({0, 1 + k, 1 + (k + 1) % 6});
    PathCloth cloth(mesh);
    const Pose pose = make_pose(*cloth.model, mesh.positions);
    PathContext context{{{*cloth.model, pose}}};
    context.compression.assign(6, 2.0f);
    context.activity.assign(6, 1.0f);
    context.stretch.assign(6, {2.0f, 1.0f, {1.0f, 0.0f}, true});
    const Index upper = 2, lower = 3;  // left of the middle: from 120 to 180 and from 180 to 240 degrees
    for (const Index t : {upper, lower}) {
        const Vec3 e = glm::normalize(Vec3(0.4f, t == upper ? 0.35f : -0.35f, 0.0f));
        context.stretch[t].direction = Vec2(context.to_flat(t, context.vertex(3 * t) + e));
    }
    const Index shared = 0;  // of the lower triangle: from the middle to (-1, 0)
    std::vector<PathPoint> points{inside(context, lower, context.to_flat(lower, {-0.25f, -0.4f, 0})),
                                  {lower, shared, {0.02f, 0.0f}},
                                  inside(context, upper, context.to_flat(upper, {-0.25f, 0.4f, 0}))};
    ASSERT_EQ(validate(*cloth.model, {{0, 1.0f, points}}), "");
    cloth.settings.alignment = 100.0f;
    std::vector<float> moved;
    follow(context, pose, cloth.settings, 1.0 / 30.0, points, moved);
    EXPECT_EQ(validate(*cloth.model, {{0, 1.0f, points}}), "");
    ASSERT_EQ(points.size(), 7u);
    const float w = 0.4f * 0.4f / (0.4f * 0.4f + 0.35f * 0.35f), d = 200.0f * w * 0.12f / (200.0f * w + 4.0f);
    for (size_t i = 1; i < 6; ++i)
        EXPECT_NEAR(glm::length(position(context, points[i])), d - 0.02f, 1e-4f) << i;
}

}  // namespace
}  // namespace rumple::tests
