// SPDX-License-Identifier: GPL-3.0-or-later
// Small cases of the Wrinkle Paths worked by hand: reference triangles, walks, slides.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/tolerances.h"
#include "systems/wrinkle_paths_life.h"
#include "tests/wrinkle_paths_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_paths;

const FlatTriangle kRight{1.0f, 0.0f, 1.0f};

void expect_shape(const FlatTriangle& got, float x1, float x2, float y2, float tolerance = 1e-6f) {
    EXPECT_NEAR(got.x1, x1, tolerance);
    EXPECT_NEAR(got.x2, x2, tolerance);
    EXPECT_NEAR(got.y2, y2, tolerance);
}

// ---- section 4.2

// Height halved: Sigma = diag(1/2, 1), relaxed by 0.05 to 0.525: the reference height is 0.5 / 0.525.
TEST(PathReference, RelaxesByTheShareOfTheSingularValues) {
    expect_shape(relaxed(kRight, {1.0f, 0.0f, 0.5f}, 0.05f), 1.0f, 0.0f, 0.5f / 0.525f);
    expect_shape(relaxed(kRight, {1.0f, 0.0f, 0.5f}, 0.0f), 1.0f, 0.0f, 1.0f);
    expect_shape(relaxed(kRight, {1.0f, 0.0f, 0.5f}, 1.0f), 1.0f, 0.0f, 0.5f);
}

// Whatever the two shapes: relaxed by s, the stretches are (1 - s) sigma + s along the same directions.
TEST(PathReference, RelaxingKeepsTheDirections) {
    const FlatTriangle reference{0.04f, 0.013f, 0.03f}, current{0.035f, 0.02f, 0.021f};
    const Stretch before = measure_stretch(reference, current);
    const Stretch after = measure_stretch(relaxed(reference, current, 0.2f), current);
    EXPECT_NEAR(1.0f / after.compression, 0.8f / before.compression + 0.2f, 1e-5f);
    EXPECT_NEAR(after.stretch, 0.8f * before.stretch + 0.2f, 1e-5f);
    EXPECT_NEAR(std::abs(glm::dot(after.direction, before.direction)), 1.0f, 1e-5f);
}

TEST(PathReference, IsCappedAtTheRestPose) {
    expect_shape(capped({1.2f, 0.0f, 0.9f}, kRight, 1.05f), 1.05f, 0.0f, 0.9f);
    expect_shape(capped({1.2f, 0.0f, 1.3f}, kRight, 1.05f), 1.05f, 0.0f, 1.05f);
    expect_shape(capped({0.8f, 0.1f, 1.0f}, kRight, 1.05f), 0.8f, 0.1f, 1.0f);
}

TEST(PathReference, RelaxesTheSameInTheSameTimeAtEveryFrameRate) {
    for (const int rate : {24, 30, 60, 120}) {
        FlatTriangle reference = kRight;
        for (int f = 0; f < rate; ++f)
            reference = relaxed(reference, {1.0f, 0.0f, 0.5f}, share_in(0.01f, 1.0 / rate));
        // 30 steps of 1 %: the distance of sigma from 1 falls to 0.99^30.
        EXPECT_NEAR(0.5f / reference.y2, 1.0f - 0.5f * std::pow(0.99f, 30.0f), 1e-4f) << rate;
    }
}

struct OneTriangle : PathCloth {
    OneTriangle()
        : PathCloth([] {
              MeshData triangle;
              triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
              triangle.add_polygon({0, 1, 2});
              return triangle;
          }()) {}
    Pose make(float x, float y) const { return make_pose(*model, squeezed(x, y)); }
    FlatTriangle updated(const Pose& pose, std::uint8_t label, const State* state) const {
        return update_reference(*model, settings, pose, {label}, 1.0 / 30.0, state)[0];
    }
};

TEST(PathReference, FollowsTheLabel) {
    OneTriangle one;
    State state;
    state.reference = {kRight};
    expect_shape(one.updated(one.make(1.0f, 0.5f), kCompress, &state), 1.0f, 0.0f, 0.5f / 0.505f);
    expect_shape(one.updated(one.make(1.0f, 0.5f), kRest, &state), 1.0f, 0.0f, 1.0f);
    one.settings.growth_time = 0.0f;  // as printed
    expect_shape(one.updated(one.make(1.02f, 1.04f), kStretch, &state), 1.02f, 0.0f, 1.04f);
    expect_shape(one.updated(one.make(1.3f, 1.04f), kStretch, &state), 1.05f, 0.0f,
                 1.04f);  // capped at rest x 1.05
    expect_shape(one.updated(one.make(1.3f, 0.98f), kStretch, &state), 1.0f, 0.0f,
                 1.0f);  // not both above one
    expect_shape(one.updated(one.make(1.0f, 0.0f), kCompress, &state), 1.0f, 0.0f, 1.0f);  // collapsed: kept
}

TEST(PathReference, GrowsInTime) {
    OneTriangle one;
    one.settings.growth_time = 0.1f;
    State state;
    state.reference = {kRight};
    // Squared lengths take over 1 - exp(-(1 / 30) / 0.1) of the way from 1 to 1.04^2.
    const float y = std::sqrt(1.0f + (1.0f - std::exp(-1.0f / 3.0f)) * (1.04f * 1.04f - 1.0f));
    expect_shape(one.updated(one.make(1.0001f, 1.04f), kStretch, &state), 1.0f, 0.0f, y, 1e-4f);
}

// Lambda_min is filtered: from 1 to 1/2 in one time constant it goes 1 - exp(-1) of the way.
TEST(PathReference, CompressionIsFilteredInTime) {
    OneTriangle one;
    one.settings.smoothing = 0.1f;
    const Pose pose = one.make(1.0f, 0.5f);
    Ground ground{*one.model, pose, {}, {2.0f}, {}};
    State state;
    state.compression = {1.0f};
    smooth_in_time(one.settings, 0.1, &state, ground);
    EXPECT_NEAR(1.0f / ground.compression[0], 1.0f - 0.5f * (1.0f - std::exp(-1.0f)), 1e-6f);
    ground.compression = {2.0f};
    smooth_in_time(one.settings, 0.1, nullptr, ground);
    EXPECT_EQ(ground.compression[0], 2.0f);
}

TEST(PathReference, StartsWhereItIsAskedTo) {
    OneTriangle one;
    const Pose pose = one.make(1.0f, 0.5f);
    expect_shape(one.updated(pose, kRest, nullptr), 1.0f, 0.0f, 1.0f);
    one.settings.reference = Reference::kFirstFrame;
    expect_shape(one.updated(pose, kRest, nullptr), 1.0f, 0.0f, 0.5f);
    State none;  // a reference without area takes what comes
    none.reference = {FlatTriangle{}};
    expect_shape(one.updated(pose, kRest, &none), 1.0f, 0.0f, 0.5f);
    one.settings.reference = Reference::kStaticRest;
    expect_shape(one.updated(one.make(1.2f, 1.2f), kStretch, &none), 1.0f, 0.0f, 1.0f);
}

// A pose half way between two frames of the past: squared lengths are mixed, 1 and 0.64 to 0.82.
TEST(PathLabels, CompareWithThePoseAWindowAgo) {
    OneTriangle one;
    one.settings.window = 0.05f;
    State state;
    state.past_times = {0.0, 0.1};
    for (const float size : {1.0f, 0.8f}) {
        const Pose pose = one.make(size, 1.0f);
        state.past_positions.insert(state.past_positions.end(), pose.positions.begin(), pose.positions.end());
    }
    const std::vector<Stretch> changes =
        recent_changes(*one.model, one.settings, 0.1, one.make(0.8f, 1.0f), &state);
    EXPECT_NEAR(changes[0].compression, std::sqrt(0.82f) / 0.8f, 1e-5f);
    EXPECT_NEAR(recent_changes(*one.model, one.settings, 0.13, one.make(0.8f, 1.0f), &state)[0].compression,
                std::sqrt(0.2f * 1.0f + 0.8f * 0.64f) / 0.8f, 1e-5f);
    one.settings.window = 0.0f;  // as printed: the frame before
    EXPECT_NEAR(recent_changes(*one.model, one.settings, 0.2, one.make(0.8f, 1.0f), &state)[0].compression,
                1.0f, 1e-5f);
    EXPECT_FALSE(recent_changes(*one.model, one.settings, 0.2, one.make(0.8f, 1.0f), nullptr)[0].defined);
}

// ---- section 5.2.1

struct Sliding : Squeezed {
    std::vector<PathPoint> path;  // straight up at x = 0.8
    Sliding() {
        std::fill(ground.activity.begin(), ground.activity.end(), 1.0f);
        WalkLimits limits;
        limits.compression = 1.5f;
        limits.length = 100.0f;
        const Index t = triangle_at({0.8f, 0.3f, 0.0f});
        std::vector<Index> visited{t};
        const glm::dvec2 at = ground.to_flat(t, {0.8f, 0.3f, 0.0f}),
                         up = ground.to_flat(t, {0.8f, 1.3f, 0.0f});
        path = walk(ground, t, at, up - at, limits, visited).points;
        path.insert(path.begin(), inside(ground, t, at));
    }
    float off_axis(const std::vector<PathPoint>& points) const {
        const std::vector<Vec3> at = positions(ground, points);
        float most = 0.0f;
        for (size_t i = 0; i + 1 < at.size(); ++i) most = std::max(most, std::abs(at[i + 1].x - at[i].x));
        return most;
    }
};

TEST(PathSlide, LeavesAnAlignedPathAlone) {
    Sliding sheet;
    std::vector<PathPoint> points = sheet.path;
    std::vector<float> moved;
    follow(sheet.ground, sheet.pose, sheet.settings, 1.0 / 30.0, points, moved);
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
    follow(sheet.ground, sheet.pose, sheet.settings, 1.0 / 30.0, points, moved);
    EXPECT_LT(sheet.off_axis(points), before);
    EXPECT_EQ(fault(*sheet.model, {{0, 1.0f, 1.0f, points}}), "");
    sheet.settings.alignment = 0.0f;
    follow(sheet.ground, sheet.pose, sheet.settings, 1.0 / 30.0, kept, moved);
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
    const Ground ground{*cloth.model, pose, {}, {}, {}};
    const PathPoint on_edge{1, 0, {0.5f, 0.0f}};  // the middle of the diagonal, (1/16, 1/16)
    ASSERT_EQ(triangle_of(cloth.model->net.twin[half_edge(on_edge)]), 0);
    state.paths = {{0,
                    1.0f,
                    1.5f,
                    {{1, kNone, {0.5f, 0.0f}},  // the same place
                     on_edge,
                     inside(ground, 0, {0.0625 + 1.0 / 512.0, 0.0625})}}};
    ASSERT_EQ(cloth.fault(state), "");
    for (int f = 0; f < 5; ++f) {
        ASSERT_NO_THROW(state = cloth.solve(cloth.mesh.positions, &state));
        ASSERT_EQ(cloth.fault(state), "");
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
    Ground ground{*cloth.model, pose, {}, {}, {}};
    for (int t = 0; t < 2; ++t) {
        const glm::dvec2 x = ground.to_flat(t, ground.vertex(3 * t) + Vec3(1, 0, 0));
        ground.stretch.push_back({2.0f, 1.0f, Vec2(x), true});
    }
    ground.compression = {2.0f, 2.0f};
    ground.activity = {1.0f, 1.0f};
    const float c = 0.1f, alpha = 0.4f;
    std::vector<PathPoint> points{inside(ground, 1, ground.to_flat(1, {0.5f + c, -0.5f, 0})),
                                  {1, 0, {0.5f, 0.0f}},
                                  inside(ground, 0, ground.to_flat(0, {0.5f + c, 0.5f, 0}))};
    ASSERT_EQ(fault(*cloth.model, {{0, 1.0f, 1.0f, points}}), "");
    cloth.settings.alignment = alpha;
    std::vector<float> moved;
    follow(ground, pose, cloth.settings, 1.0 / 30.0, points, moved);
    EXPECT_NEAR(position(ground, points[1]).x, 0.5f + 2.0f * alpha * c / (2.0f * alpha + 4.0f), 1e-5f);
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
    Ground ground{*cloth.model, pose, {}, {}, {}};
    ground.compression.assign(6, 2.0f);
    ground.activity.assign(6, 1.0f);
    ground.stretch.assign(6, {2.0f, 1.0f, {1.0f, 0.0f}, true});
    const Index upper = 2, lower = 3;  // left of the middle: from 120 to 180 and from 180 to 240 degrees
    for (const Index t : {upper, lower}) {
        const Vec3 e = glm::normalize(Vec3(0.4f, t == upper ? 0.35f : -0.35f, 0.0f));
        ground.stretch[t].direction = Vec2(ground.to_flat(t, ground.vertex(3 * t) + e));
    }
    const Index shared = 0;  // of the lower triangle: from the middle to (-1, 0)
    std::vector<PathPoint> points{inside(ground, lower, ground.to_flat(lower, {-0.25f, -0.4f, 0})),
                                  {lower, shared, {0.02f, 0.0f}},
                                  inside(ground, upper, ground.to_flat(upper, {-0.25f, 0.4f, 0}))};
    ASSERT_EQ(fault(*cloth.model, {{0, 1.0f, 1.0f, points}}), "");
    cloth.settings.alignment = 100.0f;
    std::vector<float> moved;
    follow(ground, pose, cloth.settings, 1.0 / 30.0, points, moved);
    EXPECT_EQ(fault(*cloth.model, {{0, 1.0f, 1.0f, points}}), "");
    ASSERT_EQ(points.size(), 7u);
    const float w = 0.4f * 0.4f / (0.4f * 0.4f + 0.35f * 0.35f), d = 200.0f * w * 0.12f / (200.0f * w + 4.0f);
    for (size_t i = 1; i < 6; ++i)
        EXPECT_NEAR(glm::length(position(ground, points[i])), d - 0.02f, 1e-4f) << i;
}

}  // namespace
}  // namespace rumple::tests
