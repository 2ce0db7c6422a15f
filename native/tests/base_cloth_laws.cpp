// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of the base cloth: what must hold on any mesh and in any pose.
#include <gtest/gtest.h>

#include "surface/output/attachments.h"
#include "tests/base_cloth_rig.h"
#include "tests/refusals.h"

namespace rumple::tests {
namespace {

using namespace base_cloth;

Settings stiff_and_slack() {
    Settings settings = without_contact();
    settings.compression = 200.0f;
    settings.slack = 1.05f;
    settings.hang = {0.6f, 0.0f, -0.8f};
    return settings;
}

TEST(BaseClothLaws, WithoutGravityRestStaysAtRest) {
    for (const MeshData& mesh : garment_meshes()) {
        const Garment garment(mesh);
        Result result = garment.solve(weightless(), mesh.positions);
        EXPECT_LT(farthest(result.positions, mesh.positions), 1e-6f);
        EXPECT_GT(result.report.steps, 0);
        result = garment.solve(weightless(), mesh.positions, &result.state);
        EXPECT_LT(farthest(result.positions, mesh.positions), 1e-6f);
        EXPECT_EQ(result.report.taut, 0.0f);
    }
}

TEST(BaseClothLaws, GravityMovesIt) {  // else the laws of rest say nothing
    for (const MeshData& mesh : garment_meshes()) {
        const Garment garment(mesh);
        const Result result = garment.solve({}, mesh.positions);
        EXPECT_GT(farthest(result.positions, mesh.positions), 2e-3f);
        EXPECT_FLOAT_EQ(result.report.offset_max, farthest(result.positions, mesh.positions));
    }
}

Vec3 turned(const Vec3& p) {
    const Vec3 axis = glm::normalize(Vec3(1, 2, 3));
    const float angle = 1.1f;
    return std::cos(angle) * p + std::sin(angle) * glm::cross(axis, p) +
           (1.0f - std::cos(angle)) * glm::dot(axis, p) * axis;
}

// A skirt that is animated as a cone: held at its waist, its hem goes inwards, and it is the same skirt
// whatever pose it comes from. As firmly held as on a body it stays the cone.
TEST(BaseClothLaws, WhatHangsFreeHangs) {
    MeshData skirt = tube(24, 14, 1.0f, 0.5f);
    for (Vec3& p : skirt.positions) p *= Vec3(1.0f, glm::mix(0.13f, 0.30f, 2.0f * p.x) * Vec2(1.0f));
    const Garment garment(skirt);
    Settings settings;
    settings.follow = 150.0f;
    settings.flat_share = 0.05f;
    settings.gravity = settings.hang = {1.0f, 0.0f, 0.0f};
    settings.gravity *= 9.81f;
    Paint held;
    for (const Vec3& p : skirt.positions) held.follow.push_back(p.x == 0.0f ? 1.0f : 0.0f);
    Paint free = held;
    for (const Vec3& p : skirt.positions)
        free.room.push_back(1.0f + 7.0f * std::clamp((p.x - 0.05f) / 0.1f, 0.0f, 1.0f));
    const auto hem = [&](const Paint& paint, const Points& from) {
        Result result = garment.solve(settings, from, nullptr, paint);
        EXPECT_GT(garment.settle(settings, skirt.positions, result, paint, nullptr, 60), 0);
        float radius = 0.0f;
        for (size_t v = 14 * 24; v < skirt.positions.size(); ++v)
            radius += glm::length(Vec2(result.positions[v].y, result.positions[v].z)) / 24.0f;
        return radius;
    };
    const float hanging = hem(free, skirt.positions);
    EXPECT_GT(hem(held, skirt.positions), 0.28f);
    EXPECT_LT(hanging, 0.25f);
    EXPECT_NEAR(hem(free, garment.crumpled(0.9f, 0.5f, 0.1f)), hanging, 2e-3f);
    settings.gravity = Vec3(0.0f);
    EXPECT_NEAR(hem(free, skirt.positions), 0.30f, 1e-5f);
}

// Also in crumpled poses, also where the cloth hardly resists compression.
TEST(BaseClothLaws, RigidMotionCarriesTheClothAlong) {
    const Vec3 shift(0.5f, -0.25f, 1.0f);
    for (const float compression : {1.0f, 200.0f}) {
        for (const Vec3& gravity : {Vec3(0.0f), Vec3(0.0f, 0.0f, -9.81f)}) {
            Settings here;
            here.gravity = gravity;
            here.compression = compression;
            here.folded = 200.0f;
            here.start_steps = 200;  // stiff cloth buckles slowly, and until it is done roundings grow
            Settings there = here;
            there.gravity = turned(gravity);
            for (const MeshData& mesh : garment_meshes()) {
                const Garment garment(mesh);
                for (const Points& pose : {mesh.positions, garment.crumpled(0.93f, 1.5f, 0.05f)}) {
                    Points moved = pose;
                    for (Vec3& p : moved) p = turned(p) + shift;
                    Result still = garment.solve(here, pose);
                    const Result anew = garment.solve(there, moved);
                    EXPECT_LT(farthest(anew.state.offset, still.state.offset), 5e-5f);
                    ASSERT_GT(garment.settle(here, pose, still), 0);
                    // What is at rest is not solved again.
                    const Result carried = garment.solve(there, moved, &still.state);
                    EXPECT_EQ(carried.report.steps, 0);
                    EXPECT_TRUE(equal_bits(carried.state.offset, still.state.offset));
                    Points expected = still.positions;
                    for (Vec3& p : expected) p = turned(p) + shift;
                    EXPECT_LT(farthest(carried.positions, expected), 2e-6f);
                }
            }
        }
    }
}

// Contacts and friction are those of the step before, so cloth may slip to and fro for ever: what moves
// little, and not half as far as in the frame before, stays.
TEST(BaseClothLaws, WhatComesNoNearerToRestStays) {
    const Garment garment(grid(8, 8, 0.02f));
    Settings settings;
    Result rest;
    ASSERT_GT(garment.settle(settings, garment.mesh.positions, rest), 0);
    settings.steps = 1;
    const float still = kStillCloth * settings.room;
    for (const auto& [moved_before, stays] : {std::pair(1.1f * still, true), {1.0f, false}}) {
        State state = rest.state;
        state.moved = moved_before;
        state.offset[27].x += 4.0f * still;
        const Result slipped = garment.solve(settings, garment.mesh.positions, &state);
        EXPECT_GT(slipped.report.moved, still);
        EXPECT_EQ(slipped.state.moved, stays ? 0.0f : slipped.report.moved);
        const Result next = garment.solve(settings, garment.mesh.positions, &slipped.state);
        EXPECT_EQ(next.report.steps == 0, stays);
    }
    State state = rest.state;
    state.moved = 1.1f * still;
    state.offset[27].x += 100.0f * still;
    EXPECT_GT(garment.solve(settings, garment.mesh.positions, &state).state.moved, still);  // this is no slip
}

TEST(BaseClothLaws, TheSameInputGivesTheSameBits) {
    const Garment garment(tube(16, 10, 0.1f, 0.5f)), twin(tube(16, 10, 0.1f, 0.5f));
    const Points pose = garment.crumpled(0.85f, 2.0f, 0.2f), next = garment.crumpled(0.8f, 2.2f, 0.2f);
    const Result first = garment.solve({}, pose), again = twin.solve({}, pose);
    EXPECT_TRUE(equal_bits(first, again));
    EXPECT_TRUE(equal_bits(garment.solve({}, next, &first.state), twin.solve({}, next, &again.state)));
}

// Poses in which cloth without_contact() keeps clear of contact and of the edge of its room.
std::vector<Points> free_poses(const Garment& garment) {
    std::vector<Points> poses{garment.mesh.positions, garment.crumpled(1.0f, 0.5f, 0.0f)};
    const bool flat = garment.mesh.positions.back().z == 0.0f;
    if (flat)
        poses.insert(poses.end(), {garment.crumpled(0.8f, 2.0f, 0.3f), garment.crumpled(0.7f, 2.5f, 0.3f)});
    return poses;
}

void expect_free(const Settings& settings, const Result& result) {
    ASSERT_EQ(result.report.touching, 0.0f);
    ASSERT_LT(result.report.offset_max, 0.95f * settings.room);
}

TEST(BaseClothLaws, TheEnergyNeverGrowsInAHeldPose) {
    for (const MeshData& mesh : garment_meshes()) {
        const Garment garment(mesh);
        for (Settings settings : {without_contact(), stiff_and_slack()}) {
            settings.start_steps = settings.steps = 1;
            settings.slide_room = 1.5f * (settings.room *= 1.1f);
            for (const Points& pose : free_poses(garment)) {
                double former = energy(*garment.model, settings, pose, in_double(pose));
                const double first = former;
                Result result;
                for (int frame = 0; frame < 25; ++frame) {
                    result = garment.solve(settings, pose, frame ? &result.state : nullptr);
                    ASSERT_NO_FATAL_FAILURE(expect_free(settings, result));
                    const double now = energy(*garment.model, settings, pose, in_double(result.positions));
                    ASSERT_LE(now, former + 1e-6 * std::abs(first - now)) << "frame " << frame;
                    former = now;
                }
                EXPECT_LT(former, first - 1e-3 * std::abs(first));
            }
        }
    }
}

// In each frame spring after spring becomes taut that was slack in the one before. Steps that stopped where
// the first did left the cloth up to 20 mm behind: the pose, set again and again, took it there.
TEST(BaseClothLaws, ALimbThatStraightensIsAtRestInEveryFrame) {
    const Garment sleeve(tube(30, 50, 0.1f, 0.9f));
    Settings settings;
    settings.slide_room = 0.15f;
    Result result = sleeve.solve(settings, sleeve.crumpled(1.0f, 1.5f, 0.0f));
    for (int frame = 1; frame <= 6; ++frame) {
        const Points pose = sleeve.crumpled(1.0f, 1.5f - 0.2f * float(frame), 0.0f);
        result = sleeve.solve(settings, pose, &result.state);
        Result at_rest = result;
        ASSERT_NE(sleeve.settle(settings, pose, at_rest, {}, nullptr, 50), -1);
        EXPECT_LT(farthest(result.positions, at_rest.positions), 1e-3f) << "frame " << frame;
    }
}

TEST(BaseClothLaws, AtRestNoVertexIsBetterOffElsewhere) {
    for (const MeshData& mesh : garment_meshes()) {
        const Garment garment(mesh);
        for (const Points& pose : free_poses(garment)) {
            Settings settings = without_contact();
            settings.slide_room = 1.5f * settings.room;
            settings.flat_share = 0.1f;  // along the tubes; around them 0.24
            settings.slack = 1.03f;
            settings.hang = {0.0f, 0.6f, -0.8f};
            settings.start_steps = 100;
            settings.most_cg_iterations = 300;
            const Result result = garment.solve(settings, pose);
            ASSERT_NO_FATAL_FAILURE(expect_free(settings, result));
            std::vector<glm::dvec3> x = in_double(result.positions);
            const double least = energy(*garment.model, settings, pose, x);
            std::uint32_t count = 0;
            for (size_t v = 0; v < x.size(); ++v) {
                for (const double size : {1e-3, 1e-4, 2e-5}) {
                    for (int way = 0; way < 8; ++way, count += 3) {
                        const glm::dvec3 before = x[v];
                        x[v] += size * glm::normalize(glm::dvec3(noise(1, count), noise(1, count + 1),
                                                                 noise(1, count + 2)));
                        ASSERT_GT(energy(*garment.model, settings, pose, x), least)
                            << "vertex " << v << " by " << size;
                        x[v] = before;
                    }
                }
            }
        }
    }
}

// One vertex without a face, left behind by an edit, made every position of a garment NaN: it has no area, so
// neither weight nor force.
TEST(BaseClothLaws, ALooseVertexChangesNothingAndStays) {
    for (const MeshData& mesh : garment_meshes()) {
        MeshData loose = mesh;
        loose.positions.push_back(0.5f * (mesh.positions.front() + mesh.positions.back()));
        const Garment garment(mesh), other(loose);
        const Points pose = other.crumpled(0.93f, 1.5f, 0.05f);
        const Result expected = garment.solve({}, {pose.begin(), pose.end() - 1});
        const Result result = other.solve({}, pose);
        EXPECT_TRUE(
            std::equal(expected.positions.begin(), expected.positions.end(), result.positions.begin()));
        EXPECT_EQ(result.positions.back(), pose.back());
    }
}

TEST(BaseClothLaws, PinnedVerticesStay) {
    // A few rows below one pinned row: it gives way by what hangs on it (base_cloth_exact.cpp).
    const MeshData mesh = grid(6, 4, 0.04f);
    const Garment garment(mesh);
    Paint paint;
    for (size_t v = 0; v < mesh.positions.size(); ++v) paint.follow.push_back(v < 7 ? 1.0f : 0.0f);
    // Hanging, and pulled by an animation that leaves the cloth behind.
    Points hanging = mesh.positions;
    for (Vec3& p : hanging) p = {p.x, 0.0f, -p.y};
    Points pulled = hanging;
    for (Vec3& p : pulled) p.z *= 1.01f;
    for (const Points& pose : {mesh.positions, hanging, pulled}) {
        Result result = garment.solve({}, pose, nullptr, paint);
        for (int frame = 0; frame < 10; ++frame) result = garment.solve({}, pose, &result.state, paint);
        for (size_t v = 0; v < 7; ++v) EXPECT_LT(glm::distance(result.positions[v], pose[v]), 1e-4f) << v;
        EXPECT_GT(farthest(result.positions, pose), 5e-5f);
    }
}

TEST(BaseClothLaws, NothingLeavesItsRoom) {
    for (const MeshData& mesh : garment_meshes()) {
        const Garment garment(mesh);
        Settings settings;
        settings.gravity *= 30.0f;
        settings.slide_room = 3.0f * settings.room;
        settings.tube_radius = 1e-6f;  // no hem is unfolded
        Paint paint;
        // Worn, held, free: what hangs free has no more room to slide.
        constexpr std::array kFactors{1.0f, 0.2f, 5.0f};
        for (size_t v = 0; v < mesh.positions.size(); ++v) paint.room.push_back(kFactors[v % 3]);
        Result result = garment.solve(settings, mesh.positions, nullptr, paint);
        float reached = 0.0f;
        for (const Points& pose : {mesh.positions, garment.crumpled(0.7f, 2.0f, 0.5f)}) {
            result = garment.solve(settings, pose, &result.state, paint);
            Points normals(pose.size());
            vertex_normals(garment.model->surface, pose, normals);
            for (size_t v = 0; v < pose.size(); ++v) {
                const Vec3 away = result.positions[v] - pose[v],
                           off = glm::dot(away, normals[v]) * normals[v];
                const float room = settings.room * paint.room[v],
                            slide = std::max(room, settings.slide_room * std::min(paint.room[v], 1.0f));
                const float used =
                    glm::length(Vec2(glm::length(off) / room, glm::length(away - off) / slide));
                ASSERT_LE(used, 1.0f + 1e-4f / std::min(paint.room[v], 1.0f)) << v;
                reached = std::max(reached, used);
            }
        }
        EXPECT_GT(reached, 0.99f);
    }
}

// Pulled along its surface, what hangs free goes as far as its room, and not to so many times its slide.
TEST(BaseClothLaws, WhatHangsFreeSlidesWithinItsRoom) {
    const Garment garment(grid(8, 8, 0.02f));
    Settings settings = falling(0.0f);
    settings.gravity = {400.0f, 0.0f, 0.0f};
    settings.room = 0.01f;
    settings.slide_room = 0.03f;
    for (const auto& [factor, farthest_slide] : {std::pair(1.0f, 0.03f), {0.5f, 0.015f}, {5.0f, 0.05f}}) {
        Paint paint;
        paint.room.assign(garment.mesh.positions.size(), factor);
        Result result;
        garment.settle(settings, garment.mesh.positions, result, paint);
        EXPECT_NEAR(farthest(result.positions, garment.mesh.positions), farthest_slide, 1e-3f) << factor;
    }
}

TEST(BaseClothLaws, ASlideWithinTheRoomChangesNothing) {
    for (const MeshData& mesh : garment_meshes()) {
        const Garment garment(mesh);
        Settings settings;
        const Points pose = garment.crumpled(0.8f, 2.0f, 0.3f);
        const Result without = garment.solve(settings, pose);
        settings.slide_room = settings.room;
        EXPECT_TRUE(equal_bits(garment.solve(settings, pose), without));
        settings.slide_room = 3.0f * settings.room;
        EXPECT_FALSE(equal_bits(garment.solve(settings, pose), without));
    }
}

// Solved anew it comes to the same place as played through, once both have come to rest.
TEST(BaseClothLaws, AJumpEndsWhereThePlayedClipEnds) {
    const Garment garment(tube(16, 10, 0.1f, 0.5f));
    Result played = garment.solve({}, garment.mesh.positions);
    Points pose;
    for (int frame = 1; frame <= 20; ++frame) {
        const float t = float(frame) / 20.0f;
        pose = garment.crumpled(1.0f - 0.15f * t, 2.0f * t, 0.2f * t);
        played = garment.solve({}, pose, &played.state);
    }
    ASSERT_GT(garment.settle({}, pose, played, {}, nullptr, 60), 0);
    Result jumped = garment.solve({}, pose);
    EXPECT_LT(farthest(jumped.positions, played.positions), 2e-3f);
    ASSERT_GT(garment.settle({}, pose, jumped, {}, nullptr, 60), 0);
    EXPECT_LT(farthest(jumped.positions, played.positions), 2e-4f);
    EXPECT_GT(farthest(jumped.positions, pose), 5e-3f);
}

TEST(BaseClothLaws, AStateOfAnotherMeshIsNotUsedAndBadInputIsNamed) {
    const Garment garment(grid(6, 6, 0.05f)), other(grid(4, 4, 0.05f));
    const Points& pose = garment.mesh.positions;
    const Result foreign = other.solve({}, other.mesh.positions);
    EXPECT_TRUE(equal_bits(garment.solve({}, pose, &foreign.state), garment.solve({}, pose)));
    const Result large = garment.solve({}, pose);
    EXPECT_TRUE(equal_bits(other.solve({}, other.mesh.positions, &large.state), foreign));
    expect_refused([&] { garment.solve({}, other.mesh.positions); }, {"positions", "49", "25"});
    Points bad = pose;
    bad[5].z = kNan;
    expect_refused([&] { garment.solve({}, bad); }, {"positions", "vertex 5", "finite"});
    Settings settings;
    settings.stretch = 0.0f;
    expect_refused([&] { garment.solve(settings, pose); }, {"stretch", "got 0"});
    settings = {};
    settings.clearance.reach = kNan;
    expect_refused([&] { garment.solve(settings, pose); }, {"reach"});
    settings = {};
    settings.gravity.z = kNan;
    expect_refused([&] { garment.solve(settings, pose); }, {"gravity: value 0", "finite"});
}

}  // namespace
}  // namespace rumple::tests
