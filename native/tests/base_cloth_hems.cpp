// SPDX-License-Identifier: GPL-3.0-or-later
// Hems lay nothing bare.
#include <gtest/gtest.h>

#include "base/smooth_step.h"
#include "surface/cloth/hem_room.h"
#include "tests/base_cloth_rig.h"

namespace rumple::tests {
namespace {

using namespace base_cloth;

constexpr float kInfinity = std::numeric_limits<float>::infinity(), kUnheld = 0.15f;

std::vector<float> room_of_pose(const Surface& surface, const Points& pose) {
    const Hems hems = find_hems(surface);
    return room_over_parts(surface, hems, find_hem_overlaps(surface, hems, find_overlaps(surface)), pose,
                           vertex_normals(surface, pose));
}
std::vector<float> room_at_rest(const Surface& surface) {
    return room_of_pose(surface, surface.positions_rest);
}

// A sleeve around the end of another one, from `hem` on along it; the inner one ends at 0.2.
MeshData over_the_end(float hem, Index around = 24) {
    return with_part(tube(24, 20, 0.1f, 0.2f), tube(around, 20, 0.105f, 0.4f), {hem, 0.0f, 0.0f});
}
bool is_inner(const Vec3& rest) {
    return glm::length(Vec2(rest.y, rest.z)) < 0.1025f;
}

// The hem covers two centimetres, less half of the five millimetres between both. It may move by seven tenths
// of that, and vertices farther away by more. The border below may move by the rest.
TEST(BaseClothHems, AHemDoesNotLayBareTheBorderThatItCovers) {
    const Surface surface = build(over_the_end(0.18f));
    const std::vector<float> room = room_at_rest(surface);
    for (size_t v = 0; v < room.size(); ++v) {
        const Vec3& p = surface.positions_rest[v];
        const float expected =
            is_inner(p) ? 0.00525f + 0.15f * (0.2f - p.x) : 0.01225f + 0.15f * (p.x - 0.18f);
        EXPECT_NEAR(room[v], expected, 2e-4f) << p.x;
    }
}

// Skinning moves the inner sleeve back, until seven millimetres are covered, and until none are.
TEST(BaseClothHems, WhatIsCoveredInAPoseCounts) {
    const Surface surface = build(over_the_end(0.18f));
    for (const float back : {0.013f, 0.025f}) {
        Points pose = surface.positions_rest;
        for (Vec3& p : pose)
            if (is_inner(p)) p.x -= back;
        const float seen = std::max(0.02f - back - 0.0025f, 0.0f);
        const std::vector<float> room = room_of_pose(surface, pose);
        for (size_t v = 0; v < room.size(); ++v) {
            const Vec3& p = surface.positions_rest[v];
            if (p.x != (is_inner(p) ? 0.2f : 0.18f)) continue;
            EXPECT_NEAR(room[v], (is_inner(p) ? 0.3f : 0.7f) * seen, 2e-4f);
        }
    }
}

// The vertices of both borders do not lie across from one another. What counts is how far the lines overlap.
TEST(BaseClothHems, HowFarVerticesLieAsideDoesNotCount) {
    for (const Index around : {9, 16, 31}) {
        const Surface surface = build(over_the_end(0.185f, around));
        const std::vector<float> room = room_at_rest(surface);
        for (size_t v = 0; v < room.size(); ++v) {
            const Vec3& p = surface.positions_rest[v];
            if (p.x != 0.185f || is_inner(p)) continue;
            EXPECT_LT(room[v], 0.7f * 0.015f) << around;
        }
    }
}

TEST(BaseClothHems, BordersThatLieTogetherAndOnesThatAreNotCoveredLeaveAllRoom) {
    for (const float hem : {0.2f, 0.21f}) {
        const Surface surface = build(over_the_end(hem));
        for (const float room : room_at_rest(surface)) EXPECT_EQ(room, kInfinity) << hem;
    }
}

// All of a second layer lies under the first one, and its end two centimetres behind the hem.
TEST(BaseClothHems, ALiningHoldsNoHem) {
    MeshData lined = over_the_end(0.0f);
    for (Vec3& p : lined.positions)
        if (glm::length(Vec2(p.y, p.z)) < 0.1025f) p.x = 0.02f + 1.8f * p.x;
    const Surface surface = build(lined);
    for (const float room : room_at_rest(surface)) EXPECT_EQ(room, kInfinity);
}

// A patch under the border of a sheet: as small as a button it is none that the sheet has to cover.
TEST(BaseClothHems, AButtonHoldsNoHem) {
    for (const float radius : {0.004f, 0.02f}) {
        // Two fifths of it below the sheet, farther from its border than what goes together.
        const MeshData mesh =
            with_part(grid(20, 20, 0.02f), grid(4, 4, 0.5f * radius), {-1.2f * radius, 0.2f, -0.1f * radius});
        const Surface surface = build(mesh);
        const std::vector<float> room = room_at_rest(surface);
        const bool held = std::ranges::any_of(room, [](float r) { return std::isfinite(r); });
        EXPECT_EQ(held, radius > 0.01f) << radius;
    }
}

// Cloth that falls along the sleeve: without what it covers it would slide by its whole room.
TEST(BaseClothHems, ClothThatFallsKeepsTheBorderCovered) {
    const Garment garment(over_the_end(0.18f));
    Settings settings = falling(0.0f);
    settings.gravity = {40.0f, 0.0f, 0.0f};
    settings.room = 0.03f;
    settings.slide_room = 0.1f;
    for (const float back : {0.0f, 0.01f}) {  // skinning moves the inner sleeve back
        const Points pose =
            garment.moved([&](const Vec3& p) { return is_inner(p) ? p - Vec3(back, 0, 0) : p; });
        Result result;
        garment.settle(settings, pose, result);
        float least = 1.0f, most = 0.0f;
        for (size_t v = 0; v < result.positions.size(); ++v) {
            const Vec3& rest = garment.mesh.positions[v];
            if (rest.x == 0.18f && !is_inner(rest)) most = std::max(most, result.positions[v].x - rest.x);
            if (rest.x > 0.5f) least = std::min(least, result.positions[v].x - rest.x);
        }
        EXPECT_LE(most, 0.7f * (0.0175f - back) + 1e-4f);
        EXPECT_GT(most, 0.5f * (0.0175f - back));
        EXPECT_GT(least, 0.03f - back);
    }
}

// ---------------------------------------------------------------- over bodies
constexpr float kHem = 0.18f;

// A sleeve with its hem at kHem, over a body that ends at 0.2, and may go on deeper.
MeshData sleeve(float radius) {
    return with_part({}, tube(24, 20, radius, 0.4f), {kHem, 0.0f, 0.0f});
}
Body arm(float deeper = 0.0f) {
    const MeshData end = tube(24, 20, 0.1f, 0.2f);
    return body_of(deeper > 0.0f ? with_part(end, tube(24, 30, 0.1f - deeper, 0.7f), Vec3(0.0f)) : end);
}

std::vector<float> room_over(const MeshData& mesh, const Body& body) {
    const Surface surface = build(mesh);
    Points normals(mesh.positions.size());
    vertex_normals(surface, mesh.positions, normals);
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    std::vector<Index> hints;
    const Clearance found =
        clearance(build_clearance(surface), {}, mesh.positions, normals, {}, &posed, hints);
    return room_over_bodies(surface, find_hems(surface), posed, found.bodies, mesh.positions, normals,
                            ClearanceSettings{}.reach, kUnheld);
}

TEST(BaseClothHems, AHemDoesNotLayBareTheEndOfABody) {
    const MeshData mesh = sleeve(0.105f);
    const std::vector<float> room = room_over(mesh, arm());
    for (size_t v = 0; v < room.size(); ++v)
        EXPECT_NEAR(room[v], 0.014f + 0.15f * (mesh.positions[v].x - kHem), 2e-4f) << mesh.positions[v].x;
}

// A trouser leg hangs along -x from its upper end, and a foot tilts its hem by 22 degrees. How much the cloth
// above the hem is crushed on one side.
TEST(BaseClothHems, ATiltedHemCrushesTheLegAboveItLess) {
    const Garment leg(tube(24, 25, 0.07f, 0.5f));
    Points pose = leg.mesh.positions;
    for (Vec3& p : pose) p.x += (1.0f - smooth_step(0.0f, 0.12f, p.x)) * 0.4f * p.z;
    Settings settings;
    settings.gravity = {-9.81f, 0.0f, 0.0f};
    const auto crushed = [&](float hem_share, float held) {
        settings.hem_share = hem_share;
        Paint paint;
        for (const Vec3& p : leg.mesh.positions)
            paint.follow.push_back(p.x > 0.45f ? 1.0f : p.x < 0.01f ? held : 0.0f);
        Result result;
        leg.settle(settings, pose, result, paint, nullptr, 60);
        float least = 1.0f;
        for (const Model::Spring& spring : leg.model->springs) {
            const Index a = spring.a, b = spring.b;
            const bool along =
                std::abs(leg.mesh.positions[a].x - leg.mesh.positions[b].x) > 0.5f * spring.rest;
            if (spring.diagonal || !along) continue;
            least = std::min(least, glm::distance(result.positions[a], result.positions[b]) / spring.rest);
        }
        return 1.0f - least;
    };
    EXPECT_LT(crushed(0.1f, 0.0f), 0.65f * crushed(1.0f, 0.0f));
    EXPECT_EQ(crushed(0.1f, 1.0f), crushed(1.0f, 1.0f)) << "a held hem";
}

// A tube along x. Over the last ten centimetres to its hem, at x = 0, it is drawn in to a cone.
Points drawn_in(const Points& rest, float by) {
    Points pose = rest;
    for (Vec3& p : pose) {
        const float share = 1.0f - by * std::max(1.0f - p.x / 0.1f, 0.0f);
        p = {p.x, share * p.y, share * p.z};
    }
    return pose;
}
Points quarter_turned(Points points) {
    for (Vec3& p : points) p = {-p.y + 3.0f, p.x, p.z};
    return points;
}

TEST(BaseClothHems, ClothThatIsFoldedInAboveAHemGoesOnStraight) {
    const Garment garment(tube(24, 25, 0.15f, 0.5f));
    const Points& rest = garment.mesh.positions;
    const auto unfolded = [&](Points pose, float held) {
        unfold_hems(garment.model->surface, garment.model->near_hems, std::vector(rest.size(), held), 0.15f,
                    pose);
        return pose;
    };
    const auto radius_at_hem = [&](const Points& pose) {
        float sum = 0.0f;
        for (size_t v = 0; v < pose.size(); ++v)
            if (rest[v].x == 0.0f) sum += glm::length(Vec2(pose[v].y, pose[v].z)) / 24.0f;
        return sum;
    };
    const Points folded = drawn_in(rest, 0.45f), straight = unfolded(folded, 0.0f);
    EXPECT_NEAR(radius_at_hem(folded), 0.0825f, 1e-5f);
    EXPECT_GT(radius_at_hem(straight), 0.12f);
    EXPECT_LT(farthest(unfolded(quarter_turned(folded), 0.0f), quarter_turned(straight)), 1e-5f);
    EXPECT_TRUE(equal_bits(unfolded(folded, 1.0f), folded)) << "a held hem";
    Settings off;
    off.steps = off.start_steps = 0;
    EXPECT_TRUE(equal_bits(garment.solve(off, folded).positions, folded)) << "what does not hang stays";
    for (const Points& pose : {rest, quarter_turned(rest), drawn_in(rest, 0.03f), drawn_in(rest, -0.45f)})
        EXPECT_TRUE(equal_bits(unfolded(pose, 0.0f), pose));
}

// The hem of a shirt in dungarees was unfolded when the figure bent back, and left a hole at the hip.
TEST(BaseClothHems, AHemUnderAnotherPartIsNotUnfolded) {
    constexpr float kLength = 0.6f;
    const MeshData sleeve = tube(24, 30, 0.1f, kLength);
    const MeshData tucked = with_part(sleeve, tube(24, 20, 0.105f, 0.4f), {kLength - 0.06f, 0.0f, 0.0f});
    Settings settings;
    settings.room = 0.0f;  // what is solved is the animation, unfolded
    const auto unfolded_by = [&](const MeshData& mesh) {
        Points pose = mesh.positions;
        for (size_t v = 0; v < sleeve.positions.size(); ++v) {
            const float share = 1.0f - 0.45f * std::max(1.0f - (kLength - pose[v].x) / 0.1f, 0.0f);
            pose[v] = {pose[v].x, share * pose[v].y, share * pose[v].z};
        }
        return farthest(Garment(mesh).solve(settings, pose).positions, pose);
    };
    EXPECT_GT(unfolded_by(sleeve), 0.015f);
    EXPECT_EQ(unfolded_by(tucked), 0.0f);
}

TEST(BaseClothHems, TheHemNearestAlongTheEdgesIsFound) {
    const Garment leg(tube(12, 10, 0.07f, 0.5f));
    for (size_t v = 0; v < leg.mesh.positions.size(); ++v) {
        const float x = leg.mesh.positions[v].x, away = std::min(x, 0.5f - x);
        const NearHem& near = leg.model->near_hems[v];
        EXPECT_NEAR(near.distance, away, 1e-5f);
        EXPECT_NEAR(std::abs(leg.mesh.positions[size_t(near.vertex)].x - x), away, 1e-5f);
        EXPECT_EQ(share_of_smoothing(near, 0.1f, 1.0f, 0.2f), 1.0f) << "a held hem";
        EXPECT_EQ(share_of_smoothing(near, 0.1f, 0.0f, 0.01f), away < 0.01f ? 0.1f : 1.0f);
    }
    const Garment sheet(grid(8, 8, 0.05f));
    for (const NearHem& near : sheet.model->near_hems) EXPECT_EQ(near.vertex, kNone) << "it has no opening";
}

// A waistband over a belly that was not deleted.
TEST(BaseClothHems, WhereTheBodyGoesOnNothingIsLaidBare) {
    for (const float deeper : {0.01f, 0.04f})  // nearer than the waistband's border, and farther
        for (const float room : room_over(sleeve(0.105f), arm(deeper))) EXPECT_EQ(room, kInfinity);
}

// A body from a game is split at its seams, and where an edge is sharp; this one everywhere.
TEST(BaseClothHems, ASeamOfABodyIsNoEnd) {
    for (const bool goes_on : {false, true}) {
        const Body whole = arm(goes_on ? 0.01f : 0.0f);
        Body split;
        for (const auto& triangle : whole.triangles) {
            const auto first = static_cast<Index>(split.positions.size());
            for (const Index v : triangle) split.positions.push_back(whole.positions[v]);
            split.triangles.push_back({first, first + 1, first + 2});
        }
        EXPECT_EQ(room_over(sleeve(0.105f), split), room_over(sleeve(0.105f), whole));
    }
}

// A hem that comes near to the body loses its room little by little: none would jump.
TEST(BaseClothHems, WhatIsFartherAwayIsHeldLess) {
    float before = 0.0f;
    for (float away = 0.005f; away < 0.07f; away += 0.0005f) {
        const float room = std::min(room_over(sleeve(0.1f + away), arm()).front(), kUnheld);
        EXPECT_GE(room, before - 1e-5f) << away;
        EXPECT_LT(before > 0.0f ? room - before : 0.0f, 0.02f) << away;
        before = room;
    }
    EXPECT_EQ(before, kUnheld);
}

TEST(BaseClothHems, ClothThatFallsKeepsTheEndOfABodyCovered) {
    const Garment garment(sleeve(0.105f));
    Settings settings = falling(0.0f);
    settings.gravity = {40.0f, 0.0f, 0.0f};
    settings.slide_room = 0.1f;
    for (const bool goes_on : {false, true}) {
        const Body body = arm(goes_on ? 0.01f : 0.0f);
        const Collider collider = body.collider();
        const PosedCollider posed(collider, body.positions);
        Result result;
        garment.settle(settings, garment.mesh.positions, result, {}, &posed);
        float most = 0.0f;
        for (size_t v = 0; v < result.positions.size(); ++v)
            if (garment.mesh.positions[v].x == kHem) most = std::max(most, result.positions[v].x - kHem);
        EXPECT_EQ(most <= 0.0141f, !goes_on) << most;
        EXPECT_GT(most, 0.01f);
    }
}

// The farther it is from the end of a body, the more of its own room a hem has, and what hangs free has more:
// with a limit of what is worn it would jump from there to where nothing holds it.
TEST(BaseClothHems, WhatHangsFreeIsHeldLittleByLittleToo) {
    const Body body = arm();
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    Settings settings = falling(0.0f);
    settings.gravity = {400.0f, 0.0f, 0.0f};
    settings.room = 0.03f;
    float before = 0.0f;
    for (const float away : {0.045f, 0.05f, 0.055f, 0.06f}) {
        const Garment garment(sleeve(0.1f + away));
        Paint paint;
        paint.room.assign(garment.mesh.positions.size(), 10.0f);
        Result result;
        garment.settle(settings, garment.mesh.positions, result, paint, &posed);
        float most = 0.0f;
        for (size_t v = 0; v < result.positions.size(); ++v) {
            if (garment.mesh.positions[v].x != kHem) continue;
            most = std::max(most, glm::distance(result.positions[v], garment.mesh.positions[v]));
        }
        EXPECT_LT(most - before, 0.2f) << away;
        before = most;
    }
    EXPECT_NEAR(before, 0.3f, 1e-3f);
}

}  // namespace
}  // namespace rumple::tests
