// SPDX-License-Identifier: GPL-3.0-or-later
// Hems lay nothing bare.
#include <gtest/gtest.h>

#include "surface/cloth/hem_room.h"
#include "tests/base_cloth_rig.h"

namespace rumple::tests {
namespace {

using namespace base_cloth;

constexpr float kInfinity = std::numeric_limits<float>::infinity(), kUnheld = 0.15f;

// A sleeve around the end of another one, from `hem` on along it; the inner one ends at 0.2.
MeshData over_the_end(float hem) {
    return with_part(tube(24, 20, 0.1f, 0.2f), tube(24, 20, 0.105f, 0.4f), {hem, 0.0f, 0.0f});
}

// Where it covers two centimetres, it may draw back by seven tenths of that, and farther away by more. What
// it covers may draw back by the rest.
TEST(BaseClothHems, AHemDoesNotLayBareTheBorderThatItCovers) {
    const Surface surface = build(over_the_end(0.18f));
    const std::vector<float> room = room_over_parts(surface, find_hems(surface), find_overlaps(surface));
    for (size_t v = 0; v < room.size(); ++v) {
        const Vec3& p = surface.positions_rest[v];
        const bool inner = glm::length(Vec2(p.y, p.z)) < 0.1025f;
        const float expected = inner ? 0.006f + (0.2f - p.x) : 0.014f + (p.x - 0.18f);
        EXPECT_NEAR(room[v], expected, 2e-4f) << p.x;
    }
}

TEST(BaseClothHems, BordersThatLieTogetherAndOnesThatAreNotCoveredLeaveAllRoom) {
    for (const float hem : {0.2f, 0.21f}) {
        const Surface surface = build(over_the_end(hem));
        for (const float room : room_over_parts(surface, find_hems(surface), find_overlaps(surface)))
            EXPECT_EQ(room, kInfinity) << hem;
    }
}

// All of a second layer lies under the first one, and its end two centimetres behind the hem.
TEST(BaseClothHems, ALiningHoldsNoHem) {
    MeshData lined = over_the_end(0.0f);
    for (Vec3& p : lined.positions)
        if (glm::length(Vec2(p.y, p.z)) < 0.1025f) p.x = 0.02f + 1.8f * p.x;
    const Surface surface = build(lined);
    for (const float room : room_over_parts(surface, find_hems(surface), find_overlaps(surface)))
        EXPECT_EQ(room, kInfinity);
}

// A patch under the border of a sheet: as small as a button it is none that the sheet has to cover.
TEST(BaseClothHems, AButtonHoldsNoHem) {
    for (const float radius : {0.004f, 0.02f}) {
        // Two fifths of it below the sheet, farther from its border than what goes together.
        const MeshData mesh =
            with_part(grid(20, 20, 0.02f), grid(4, 4, 0.5f * radius), {-1.2f * radius, 0.2f, -0.1f * radius});
        const Surface surface = build(mesh);
        const std::vector<float> room = room_over_parts(surface, find_hems(surface), find_overlaps(surface));
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
    Result result;
    garment.settle(settings, garment.mesh.positions, result);
    float least = 1.0f, most = 0.0f;
    for (size_t v = 0; v < result.positions.size(); ++v) {
        const Vec3& rest = garment.mesh.positions[v];
        if (rest.x == 0.18f && glm::length(Vec2(rest.y, rest.z)) > 0.1025f)
            most = std::max(most, result.positions[v].x - rest.x);
        if (rest.x > 0.5f) least = std::min(least, result.positions[v].x - rest.x);
    }
    EXPECT_LE(most, 0.0141f);
    EXPECT_GT(most, 0.01f);
    EXPECT_GT(least, 0.03f);
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
        EXPECT_NEAR(room[v], 0.014f + (mesh.positions[v].x - kHem), 2e-4f) << mesh.positions[v].x;
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
