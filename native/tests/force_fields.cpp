// SPDX-License-Identifier: GPL-3.0-or-later
// Force fields in cases that are worked out by hand, and what they do to cloth that swings.
#include "surface/cloth/force_fields.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "tests/base_cloth_swing.h"
#include "tests/refusals.h"

namespace rumple::tests {
namespace {

using namespace force_fields;

Effect effect(const Field& field, const Vec3& at, std::int32_t frame = 1) {
    const Vec3 points[] = {at};
    return effects(std::span(&field, 1), frame, points)[0];
}

void expect_near(const Vec3& found, const Vec3& expected, float tolerance = 1e-6f) {
    EXPECT_LT(glm::distance(found, expected), tolerance)
        << found.x << " " << found.y << " " << found.z << " instead of " << expected.x << " " << expected.y
        << " " << expected.z;
}

Field of(Kind kind, float strength, Shape shape = Shape::kPoint) {
    Field field;
    field.kind = kind;
    field.strength = strength;
    field.shape = shape;
    return field;
}

TEST(ForceFields, NothingActsWithoutThem) {
    const Vec3 points[] = {{1, 2, 3}};
    const Effect none = effects({}, 7, points)[0];
    EXPECT_EQ(none.air, Vec3(0.0f));
    EXPECT_EQ(none.push, Vec3(0.0f));
    EXPECT_EQ(none.resist, Vec2(0.0f));
}

TEST(ForceFields, AForcePushesAwayFromItsShapeAsHardAtAnyDistance) {
    Field force = of(Kind::kForce, 6.0f);
    force.location = {1, 0, 0};
    expect_near(effect(force, {4, 0, 4}).push, {3.6, 0, 4.8});
    force.shape = Shape::kLine;
    expect_near(effect(force, {4, 0, 4}).push, {6, 0, 0});
    force.shape = Shape::kPlane;
    expect_near(effect(force, {4, 0, 4}).push, {0, 0, 6});
    expect_near(effect(force, {1, 0, 0}).push, Vec3(0.0f));  // no direction
    force.shape = Shape::kPoint;
    force.inverse_square = true;
    expect_near(effect(force, {4, 0, 4}).push, Vec3(3.6, 0, 4.8) / 25.0f);
}

TEST(ForceFields, FalloffOfSphereTubeAndCone) {
    Field force = of(Kind::kForce, 1.0f);
    force.along = {.power = 2.0f, .least = 1.0f, .most = 10.0f, .ends = true};
    EXPECT_NEAR(glm::length(effect(force, {0.5, 0, 0}).push), 1.0f, 1e-6f);
    EXPECT_NEAR(glm::length(effect(force, {4, 0, 0}).push), 1.0f / 16, 1e-7f);  // 1 + 4 - 1
    EXPECT_EQ(effect(force, {11, 0, 0}).push, Vec3(0.0f));
    force.falloff = Falloff::kTube;
    force.across = {.power = 1.0f, .least = 0.0f, .most = 4.0f, .ends = true};
    EXPECT_NEAR(glm::length(effect(force, {3, 0, -2}).push), 0.25f / 4.0f, 1e-7f);
    EXPECT_EQ(effect(force, {5, 0, 2}).push, Vec3(0.0f));
    force.falloff = Falloff::kCone;
    force.across = {.power = 0.0f, .least = 0.0f, .most = 44.0f, .ends = true};
    EXPECT_EQ(effect(force, {2, 0, 2}).push, Vec3(0.0f));  // 45 degrees
    force.across.most = 46.0f;
    EXPECT_NEAR(glm::length(effect(force, {2, 0, 2}).push), 0.25f, 1e-6f);
}

TEST(ForceFields, OneSideOnly) {
    Field force = of(Kind::kForce, 1.0f);
    force.side = Side::kAbove;
    EXPECT_EQ(effect(force, {0, 1, -1}).push, Vec3(0.0f));
    EXPECT_NE(effect(force, {0, 1, 1}).push, Vec3(0.0f));
    force.side = Side::kBelow;
    EXPECT_NE(effect(force, {0, 1, -1}).push, Vec3(0.0f));
    EXPECT_EQ(effect(force, {0, 1, 1}).push, Vec3(0.0f));
}

TEST(ForceFields, AWindIsAirAlongItsAxisWhoseLengthDoesNotCount) {
    Field wind = of(Kind::kWind, 5.0f, Shape::kPlane);
    wind.axis = {3, 0, 4};
    wind.flow = 1.0f;
    const Effect found = effect(wind, {7, 8, 9});
    expect_near(found.air, {3, 0, 4});
    EXPECT_EQ(found.push, Vec3(0.0f));
    EXPECT_EQ(found.resist, Vec2(0.0f));
}

TEST(ForceFields, AVortexTurnsAboutItsAxis) {
    const Field point = of(Kind::kVortex, 2.0f);
    expect_near(effect(point, {3, 0, 0}).push, {0, 6, 0});
    const Effect found = effect(of(Kind::kVortex, 2.0f, Shape::kPlane), {3, 0, 5});
    // With the velocity (0, 6, 0) of a body that turns at 2 rad/s nothing is left but the pull to the axis.
    EXPECT_EQ(found.resist, Vec2(1.0f, 0.0f));
    expect_near(found.push - Vec3(0, 6, 0), {-12, 0, 0});
}

TEST(ForceFields, HarmonicIsASpringAndCriticallyDampedByOne) {
    Field spring = of(Kind::kHarmonic, 9.0f);
    spring.damping = 1.0f;
    expect_near(effect(spring, {2, 0, 0}).push, {-18, 0, 0});
    EXPECT_EQ(effect(spring, {2, 0, 0}).resist, Vec2(6.0f, 0.0f));
    spring.size = 0.5f;
    expect_near(effect(spring, {2, 0, 0}).push, {-13.5, 0, 0});
}

TEST(ForceFields, DragIsAgainstTheVelocityAndFlowIsToo) {
    Field drag = of(Kind::kDrag, 0.5f);
    drag.damping = 0.25f;
    EXPECT_EQ(effect(drag, {1, 0, 0}).resist, Vec2(0.25f, 0.5f));
    drag.strength = drag.damping = 7.0f;
    EXPECT_EQ(effect(drag, {1, 0, 0}).resist, Vec2(2.0f, 2.0f));
    Field force = of(Kind::kForce, 1.0f);
    force.flow = 0.75f;
    EXPECT_EQ(effect(force, {1, 0, 0}).resist, Vec2(0.75f, 0.0f));
}

TEST(ForceFields, PerlinsNoiseIsZeroOnItsLatticeAndRepeatsAfter256) {
    EXPECT_EQ(perlin_noise(3.0, -7.0, 11.0), 0.0);
    for (const double at : {0.3, 7.9, -2.25}) {
        EXPECT_NEAR(perlin_noise(at, 2.5 * at, at - 1.0), perlin_noise(at + 256.0, 2.5 * at, at - 257.0),
                    1e-12);
        EXPECT_NE(perlin_noise(at, 2.5 * at, at - 1.0), 0.0);
    }
    // As mathutils.noise.noise((3.14, 42.5, 7.25), noise_basis="PERLIN_NEW") says.
    EXPECT_NEAR(perlin_noise(3.14, 42.5, 7.25), 0.12996697425842285, 2e-6);
}

TEST(ForceFields, TurbulenceIsTheSameEveryTimeAndSmoothOverItsSize) {
    Field turbulence = of(Kind::kTurbulence, 1.0f);
    turbulence.size = 2.0f;
    Vec3 before = effect(turbulence, {0.1f, 0.2f, 0.3f}).push;
    float most = 0.0f;
    for (int k = 1; k < 200; ++k) {
        const Vec3 at(0.1f + 0.01f * float(k), 0.2f, 0.3f);
        const Vec3 now = effect(turbulence, at, k).push;
        EXPECT_EQ(now, effect(turbulence, at, 1).push);
        EXPECT_LT(glm::distance(now, before), 0.1f);
        most = std::max(most, glm::length(now));
        before = now;
    }
    EXPECT_GT(most, 0.2f);
    turbulence.location = {5, 0, 0};
    const Vec3 moved = effect(turbulence, {5.1f, 0.2f, 0.3f}).push;
    turbulence.location = Vec3(0.0f);
    expect_near(moved, effect(turbulence, {0.1f, 0.2f, 0.3f}).push, 1e-4f);
    turbulence.in_world = true;
    turbulence.location = {5, 0, 0};
    const Vec3 still = effect(turbulence, {5.1f, 0.2f, 0.3f}).push;
    turbulence.location = {9, 0, 0};
    EXPECT_EQ(effect(turbulence, {5.1f, 0.2f, 0.3f}).push, still);
}

TEST(ForceFields, NoiseDiffersWithSeedFrameAndPoint) {
    Field wind = of(Kind::kWind, 3.0f);
    wind.noise = 2.0f;
    std::set<float> found;
    double sum = 0.0;
    const std::vector<Vec3> points(50, Vec3(1.0f));
    for (std::int32_t seed = 0; seed < 10; ++seed) {
        for (std::int32_t frame = 0; frame < 10; ++frame) {
            wind.seed = seed;
            const std::vector<Effect> now = effects(std::span(&wind, 1), frame, points);
            for (const Effect& e : now) {
                found.insert(e.air.z);
                sum += double(e.air.z) / 5000.0;
                EXPECT_GE(e.air.z, 2.0f);
                EXPECT_LE(e.air.z, 5.0f);
            }
        }
    }
    EXPECT_GT(found.size(), 4900u);
    // Of Blender's noise: 63 numbers of mean 96 / 128 above, 65 of mean 32 / 128 below, over a divisor of 1
    // to 2.
    EXPECT_NEAR(sum, 3.0 + 2.0 * std::numbers::ln2 * (63.0 * 96.0 - 65.0 * 32.0) / (128.0 * 128.0), 0.05);
}

TEST(ForceFields, BadOnesAreRefusedByName) {
    const auto refuse = [](auto change, const char* name) {
        Field field;
        change(field);
        expect_refused([&] { effect(field, {1, 0, 0}); }, {"fields[0]", name});
    };
    refuse([](Field& f) { f.location.y = kNan; }, "location");
    refuse([](Field& f) { f.strength = kInfinity; }, "strength");
    refuse([](Field& f) { f.along.power = -1.0f; }, "along.power");
    refuse([](Field& f) { f.noise = -1.0f; }, "noise");
    expect_refused([] { effect({}, {kNan, 0, 0}); }, {"positions", "vertex 0"});
}

// ---------------------------------------------------------------- on cloth
// Turbulence at the points of a pose, in metres.
std::vector<Vec3> turbulent(const Points& pose, float strength) {
    Field field = of(Kind::kTurbulence, strength);
    field.size = 0.2f;
    std::vector<Vec3> push;
    for (const Effect& e : effects(std::span(&field, 1), 1, pose)) push.push_back(e.push);
    return push;
}

base_cloth::Swing windy() {
    base_cloth::Swing swing = exactly(0.04f, 0.02f);
    swing.drag = 2.0f;
    swing.damping = 10.0f;
    return swing;
}

TEST(ForceFieldsOnCloth, AUniformWindPerVertexIsTheSingleWindToTheBit) {
    const Garment garment(grid(6, 4, 0.05f));
    const Points& pose = garment.mesh.positions;
    const Vec3 wind(0.3f, -1.7f, 5.1f);
    Swinging single(garment, base_cloth::Settings{}, windy(), pose);
    Swinging each(garment, base_cloth::Settings{}, windy(), pose);
    const std::vector<Vec3> air(pose.size(), wind), still(pose.size(), Vec3(0.0f));
    const std::vector<Vec2> free(pose.size(), Vec2(0.0f));
    single.swing.wind = wind;
    each.swing.air = air;
    each.swing.push = still;
    each.swing.resist = free;
    for (int frame = 0; frame < 10; ++frame)
        EXPECT_EQ(single.play(pose).positions, each.play(pose).positions);
    EXPECT_GT(farthest(each.now.positions, pose), 1e-3f);
}

// a = push: implicit Euler as of gravity. Against a resistance r |v|: v = (v + h push) / (1 + h r |v
// before|).
TEST(ForceFieldsOnCloth, APushIsAnAccelerationAndAResistanceTakesVelocity) {
    const Garment garment(grid(5, 4, 0.05f));
    const Points& pose = garment.mesh.positions;
    Swinging cloth(garment, in_empty_space(), exactly(0.02f, 0.02f), pose);
    const std::vector<Vec3> push(pose.size(), Vec3(0, 0, 4.0f));
    const std::vector<Vec2> resist(pose.size(), Vec2(3.0f, 0.5f));
    cloth.swing.push = push;
    cloth.swing.resist = resist;
    cloth.disturbed();
    double v = 0.0;
    for (int frame = 0; frame < 20; ++frame) {
        cloth.play(pose);
        v = (v + 0.02 * 4.0) / (1.0 + 0.02 * (3.0 + 0.5 * v));
        for (const Vec3& velocity : cloth.motion().velocity) expect_near(velocity, Vec3(0, 0, v), 3e-4f);
    }
    EXPECT_GT(v, 0.5);
}

// A field and a pose that stay: the cloth comes to rest, elsewhere than without it, and then stays to the
// bit; it goes on when the field changes.
TEST(ForceFieldsOnCloth, AHeldFieldIsHeldToTheBitAndAChangeOfItIsFelt) {
    const Garment garment(grid(6, 6, 0.05f));
    const Points& pose = garment.mesh.positions;
    base_cloth::Settings settings;
    soften(settings);
    Swinging cloth(garment, settings, windy(), pose);
    const Points calm = cloth.play(pose).positions;
    const std::vector<Vec3> push = turbulent(pose, 8.0f), other = turbulent(pose, 9.0f);
    cloth.swing.push = push;
    int frames = 0;
    do {
        cloth.play(pose);
    } while (cloth.now.report.steps > 0 && ++frames < 200);
    EXPECT_GT(frames, 5);
    EXPECT_LT(frames, 200);
    EXPECT_GT(farthest(cloth.now.positions, calm), 1e-3f);
    const Points held = cloth.now.positions;
    EXPECT_EQ(cloth.play(pose).positions, held);
    cloth.swing.push = other;
    EXPECT_GT(cloth.play(pose).report.steps, 0);
    EXPECT_NE(cloth.now.positions, held);
}

TEST(ForceFieldsOnCloth, WhatActsOnVerticesIsCheckedAsEverythingIs) {
    const Garment garment(grid(3, 3, 0.05f));
    const Points& pose = garment.mesh.positions;
    const auto play = [&](auto change) {
        return [&garment, &pose, change] {
            base_cloth::Swing swing = windy();
            change(swing);
            base_cloth::solve_swing(*garment.model, {}, swing, {}, pose, nullptr, nullptr);
        };
    };
    std::vector<Vec3> few(pose.size() - 1, Vec3(0.0f)), bad(pose.size(), Vec3(kNan));
    std::vector<Vec2> against(pose.size(), Vec2(0.0f, -1.0f));
    expect_refused(play([&](auto& s) { s.air = few; }), {"air", std::to_string(few.size())});
    expect_refused(play([&](auto& s) { s.push = few; }), {"push", std::to_string(few.size())});
    expect_refused(play([&](auto& s) { s.push = bad; }), {"push", "nan"});
    expect_refused(play([&](auto& s) { s.resist = against; }), {"resist", "-1"});
}

}  // namespace
}  // namespace rumple::tests
