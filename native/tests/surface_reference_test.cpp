// SPDX-License-Identifier: GPL-3.0-or-later
// Reference triangles (Gillette 2015, chapter 4): small cases worked by hand.
#include <gtest/gtest.h>

#include <cmath>

#include "surface/strain/adaptive_reference.h"
#include "tests/meshes.h"

namespace rumple::tests {
namespace {

const FlatTriangle kRight{1.0f, 0.0f, 1.0f};

void expect_shape(const FlatTriangle& got, float x1, float x2, float y2, float tolerance = 1e-6f) {
    EXPECT_NEAR(got.x1, x1, tolerance);
    EXPECT_NEAR(got.x2, x2, tolerance);
    EXPECT_NEAR(got.y2, y2, tolerance);
}

// Height halved: Sigma = diag(1/2, 1), relaxed by 0.05 to 0.525: the reference height is 0.5 / 0.525.
TEST(AdaptiveReference, RelaxesByTheShareOfTheSingularValues) {
    expect_shape(relaxed(kRight, {1.0f, 0.0f, 0.5f}, 0.05f), 1.0f, 0.0f, 0.5f / 0.525f);
    expect_shape(relaxed(kRight, {1.0f, 0.0f, 0.5f}, 0.0f), 1.0f, 0.0f, 1.0f);
    expect_shape(relaxed(kRight, {1.0f, 0.0f, 0.5f}, 1.0f), 1.0f, 0.0f, 0.5f);
}

// Whatever the two shapes: relaxed by s, the stretches are (1 - s) sigma + s along the same directions.
TEST(AdaptiveReference, RelaxingKeepsTheDirections) {
    const FlatTriangle reference{0.04f, 0.013f, 0.03f}, current{0.035f, 0.02f, 0.021f};
    const Stretch before = measure_stretch(reference, current);
    const Stretch after = measure_stretch(relaxed(reference, current, 0.2f), current);
    EXPECT_NEAR(1.0f / after.compression, 0.8f / before.compression + 0.2f, 1e-5f);
    EXPECT_NEAR(after.stretch, 0.8f * before.stretch + 0.2f, 1e-5f);
    EXPECT_NEAR(std::abs(glm::dot(after.direction, before.direction)), 1.0f, 1e-5f);
}

TEST(AdaptiveReference, IsCappedAtTheRestPose) {
    expect_shape(capped({1.2f, 0.0f, 0.9f}, kRight, 1.05f), 1.05f, 0.0f, 0.9f);
    expect_shape(capped({1.2f, 0.0f, 1.3f}, kRight, 1.05f), 1.05f, 0.0f, 1.05f);
    expect_shape(capped({0.8f, 0.1f, 1.0f}, kRight, 1.05f), 0.8f, 0.1f, 1.0f);
}

TEST(AdaptiveReference, RelaxesTheSameInTheSameTimeAtEveryFrameRate) {
    for (const int rate : {24, 30, 60, 120}) {
        FlatTriangle reference = kRight;
        for (int f = 0; f < rate; ++f)
            reference = relaxed(reference, {1.0f, 0.0f, 0.5f}, fraction_in(0.01f, 1.0 / rate));
        // 30 steps of 1 %: the distance of sigma from 1 falls to 0.99^30.
        EXPECT_NEAR(0.5f / reference.y2, 1.0f - 0.5f * std::pow(0.99f, 30.0f), 1e-4f) << rate;
    }
}

// F = [[2, 0.5], [0, 3]]: F^T F = [[4, 1], [1, 9.25]]; its rotation has F10 - F01 = -0.5 over F00 + F11 = 5.
TEST(FlatTriangles, MetricAndRotationOfAMap) {
    const FlatTriangle to{2.0f, 0.5f, 3.0f};
    const Tensor2 c = metric(kRight, to);
    EXPECT_NEAR(c.xx, 4.0f, 1e-6f);
    EXPECT_NEAR(c.xy, 1.0f, 1e-6f);
    EXPECT_NEAR(c.yy, 9.25f, 1e-6f);
    const Vec2 turn(rotation(kRight, to));
    EXPECT_NEAR(turn.y / turn.x, -0.1f, 1e-6f);
    for (const FlatTriangle& t : {to, FlatTriangle{0.0313f, -0.0117f, 0.0271f}, FlatTriangle{}}) {
        const Tensor2 same = metric(t, t);
        EXPECT_EQ(same.xx, 1.0f);
        EXPECT_EQ(same.xy, 0.0f);
        EXPECT_EQ(same.yy, 1.0f);
        EXPECT_EQ(rotation(t, t), glm::dvec2(1.0, 0.0));
    }
    EXPECT_EQ(metric(FlatTriangle{}, to).xx, 1.0f);
    EXPECT_EQ(metric(to, FlatTriangle{}).yy, 1.0f);
}

struct OneTriangle {
    Surface surface;
    ReferenceModel model;
    ReferenceSettings settings;

    OneTriangle() {
        MeshData triangle;
        triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        triangle.add_polygon({0, 1, 2});
        surface = build(triangle);
        model = build_reference(surface);
    }
    FlatPose make(float x, float y) const { return flat_pose(model.net, {{0, 0, 0}, {x, 0, 0}, {0, y, 0}}); }
    FlatTriangle updated(const FlatPose& pose, std::uint8_t label, const ReferenceState* state) const {
        return update_reference(model, settings, pose, {label}, 1.0 / 30.0, state)[0];
    }
};

TEST(AdaptiveReference, FollowsTheLabel) {
    OneTriangle one;
    ReferenceState state;
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

TEST(AdaptiveReference, GrowsInTime) {
    OneTriangle one;
    one.settings.growth_time = 0.1f;
    ReferenceState state;
    state.reference = {kRight};
    state.labels = {kRest};  // in the frame before: this one may be a glitch
    expect_shape(one.updated(one.make(1.0001f, 1.04f), kStretch, &state), 1.0f, 0.0f, 1.0f);
    state.labels = {kStretch};
    // Squared lengths take over 1 - exp(-(1 / 30) / 0.1) of the way from 1 to 1.04^2.
    const float y = std::sqrt(1.0f + (1.0f - std::exp(-1.0f / 3.0f)) * (1.04f * 1.04f - 1.0f));
    expect_shape(one.updated(one.make(1.0001f, 1.04f), kStretch, &state), 1.0f, 0.0f, y, 1e-4f);
}

TEST(AdaptiveReference, StartsWhereItIsAskedTo) {
    OneTriangle one;
    const FlatPose pose = one.make(1.0f, 0.5f);
    expect_shape(one.updated(pose, kRest, nullptr), 1.0f, 0.0f, 1.0f);
    one.settings.reference = Reference::kFirstFrame;
    expect_shape(one.updated(pose, kRest, nullptr), 1.0f, 0.0f, 0.5f);
    ReferenceState none;  // a reference without area takes what comes
    none.reference = {FlatTriangle{}};
    expect_shape(one.updated(pose, kRest, &none), 1.0f, 0.0f, 0.5f);
    one.settings.reference = Reference::kStaticRest;
    expect_shape(one.updated(one.make(1.2f, 1.2f), kStretch, &none), 1.0f, 0.0f, 1.0f);
}

// A pose half way between two frames of the past: squared lengths are mixed, 1 and 0.64 to 0.82.
TEST(AdaptiveReference, CompareWithThePoseAWindowAgo) {
    OneTriangle one;
    one.settings.window = 0.05f;
    ReferenceState state;
    state.past_times = {0.0, 0.1};
    for (const float size : {1.0f, 0.8f}) {
        const FlatPose pose = one.make(size, 1.0f);
        state.past_positions.insert(state.past_positions.end(), pose.positions.begin(), pose.positions.end());
    }
    const std::vector<Stretch> changes =
        recent_changes(one.model, one.settings, 0.1, one.make(0.8f, 1.0f), &state);
    EXPECT_NEAR(changes[0].compression, std::sqrt(0.82f) / 0.8f, 1e-5f);
    EXPECT_NEAR(recent_changes(one.model, one.settings, 0.13, one.make(0.8f, 1.0f), &state)[0].compression,
                std::sqrt(0.2f * 1.0f + 0.8f * 0.64f) / 0.8f, 1e-5f);
    one.settings.window = 0.0f;  // as printed: the frame before
    EXPECT_NEAR(recent_changes(one.model, one.settings, 0.2, one.make(0.8f, 1.0f), &state)[0].compression,
                1.0f, 1e-5f);
    EXPECT_FALSE(recent_changes(one.model, one.settings, 0.2, one.make(0.8f, 1.0f), nullptr)[0].defined);
}

}  // namespace
}  // namespace rumple::tests
