// SPDX-License-Identifier: GPL-3.0-or-later
// Parts of a garment that lie over one another.
#include <gtest/gtest.h>

#include "surface/cloth/overlaps.h"
#include "surface/cloth/pins.h"
#include "surface/output/attachments.h"
#include "tests/base_cloth_rig.h"

namespace rumple::tests {
namespace {

using namespace base_cloth;

constexpr float kSquare = 0.1f, kAbove = 0.005f;
constexpr Index kOfOne = 16;  // vertices of one sheet

// Two meshes of quads in one; the second one is moved.
MeshData with_part(MeshData mesh, const MeshData& part, const Vec3& shift) {
    const Index first = static_cast<Index>(mesh.positions.size());
    for (const Vec3& p : part.positions) mesh.positions.push_back(p + shift);
    for (size_t c = 0; c < part.corner_vertex.size(); c += 4) {
        const Index* v = &part.corner_vertex[c];
        mesh.add_polygon({first + v[0], first + v[1], first + v[2], first + v[3]});
    }
    return mesh;
}

// Two sheets of three by three squares; the second one is moved.
MeshData two_sheets(const Vec3& shift) {
    return with_part(grid(3, 3, kSquare), grid(3, 3, kSquare), shift);
}

// Of the vertices of a sheet, all of which are pinned where `value` is 1.
Paint pinned(Index first) {
    Paint paint;
    paint.follow.assign(2 * kOfOne, 0.0f);
    std::fill_n(paint.follow.begin() + first, kOfOne, 1.0f);
    return paint;
}

Settings falling(float gravity) {
    Settings settings;
    settings.follow = 20.0f;
    settings.gravity = {0.0f, 0.0f, gravity};
    return settings;
}

TEST(BaseClothOverlaps, VerticesKnowWhatLiesUnderAndOverThem) {
    const Surface surface = build(two_sheets({0.5f * kSquare, 0.5f * kSquare, kAbove}));
    int outer = 0, inner = 0;
    for (const Overlap& overlap : find_overlaps(surface)) {
        const Vec3 way = surface.positions_rest[overlap.vertex] -
                         interpolate(surface, overlap.place, surface.positions_rest);
        EXPECT_LT(glm::distance(way, Vec3(0.0f, 0.0f, overlap.outer ? kAbove : -kAbove)), 1e-6f);
        EXPECT_EQ(overlap.outer, overlap.vertex >= kOfOne);
        ++(overlap.outer ? outer : inner);
    }
    EXPECT_EQ(outer, 9);
    EXPECT_EQ(inner, 9);
}

TEST(BaseClothOverlaps, NeitherOneSheetNorSheetsBesideOrFarFromOneAnotherHaveAny) {
    EXPECT_TRUE(find_overlaps(build(grid(3, 3, kSquare))).empty());
    for (const float higher : {0.0f, 0.002f})
        EXPECT_TRUE(find_overlaps(build(two_sheets({3.05f * kSquare, 0.0f, higher}))).empty());
    EXPECT_TRUE(find_overlaps(build(two_sheets({0.0f, 0.0f, 0.05f}))).empty());
    MeshData back_to_back = two_sheets({0.0f, 0.0f, kAbove});
    for (size_t p = 9; p < 18; ++p)
        std::reverse(back_to_back.corner_vertex.begin() + back_to_back.polygon_start[p],
                     back_to_back.corner_vertex.begin() + back_to_back.polygon_start[p + 1]);
    EXPECT_TRUE(find_overlaps(build(back_to_back)).empty());
}

TEST(BaseClothOverlaps, TheOuterPartSinksNoDeeperThanTheThickness) {
    const Garment garment(two_sheets({0.0f, 0.0f, kAbove}));
    const Settings settings = falling(-9.81f);
    const float thickness = settings.clearance.thickness;
    for (const float lowered : {0.0f, 0.008f}) {  // in the animation: then it lies under the inner one
        Points pose = garment.mesh.positions;
        for (Index v = kOfOne; v < 2 * kOfOne; ++v) pose[v].z -= lowered;
        const Result result = garment.solve(settings, pose, nullptr, pinned(0));
        for (Index v = kOfOne; v < 2 * kOfOne; ++v) {
            EXPECT_GT(result.positions[v].z, thickness - 1e-4f) << "vertex " << v;
            EXPECT_LT(result.positions[v].z, thickness + 1e-4f) << "vertex " << v;  // it does sink
        }
    }
}

TEST(BaseClothOverlaps, TheInnerPartStaysBelowTheMiddle) {
    const Garment garment(two_sheets({0.0f, 0.0f, kAbove}));
    const Result result = garment.solve(falling(9.81f), garment.mesh.positions, nullptr, pinned(kOfOne));
    for (Index v = 0; v < kOfOne; ++v) {
        EXPECT_LT(result.positions[v].z, 0.5f * kAbove + 1e-4f) << "vertex " << v;
        EXPECT_GT(result.positions[v].z, 0.5f * kAbove - 1e-4f) << "vertex " << v;
    }
}

// A sleeve around the end of another one, from `hem` on along it; the inner one ends at 0.2.
MeshData over_the_end(float hem) {
    return with_part(tube(24, 20, 0.1f, 0.2f), tube(24, 20, 0.105f, 0.4f), {hem, 0.0f, 0.0f});
}

// Where it covers two centimetres, it may draw back by seven tenths of that, and farther away by more.
TEST(BaseClothOverlaps, AHemDoesNotLayBareTheBorderThatItCovers) {
    const Surface surface = build(over_the_end(0.18f));
    const std::vector<float> room = room_to_cover(surface, find_overlaps(surface));
    for (size_t v = 0; v < room.size(); ++v) {
        const Vec3& p = surface.positions_rest[v];
        const bool inner = glm::length(Vec2(p.y, p.z)) < 0.1025f;
        if (inner) {
            EXPECT_EQ(room[v], std::numeric_limits<float>::infinity());
        } else {
            EXPECT_NEAR(room[v], 0.014f + (p.x - 0.18f), 2e-4f) << p.x;
        }
    }
}

TEST(BaseClothOverlaps, BordersThatLieTogetherAndOnesThatAreNotCoveredLeaveAllRoom) {
    for (const float hem : {0.2f, 0.21f}) {
        const Surface surface = build(over_the_end(hem));
        for (const float room : room_to_cover(surface, find_overlaps(surface)))
            EXPECT_EQ(room, std::numeric_limits<float>::infinity()) << hem;
    }
}

// All of a second layer lies under the first one, and its end two centimetres behind the hem.
TEST(BaseClothOverlaps, ALiningHoldsNoHem) {
    MeshData lined = over_the_end(0.0f);
    for (Vec3& p : lined.positions)
        if (glm::length(Vec2(p.y, p.z)) < 0.1025f) p.x = 0.02f + 1.8f * p.x;
    const Surface surface = build(lined);
    for (const float room : room_to_cover(surface, find_overlaps(surface)))
        EXPECT_EQ(room, std::numeric_limits<float>::infinity());
}

// A patch under the border of a sheet: as small as a button it is none that the sheet has to cover.
TEST(BaseClothOverlaps, AButtonHoldsNoHem) {
    for (const float radius : {0.004f, 0.02f}) {
        // Two fifths of it below the sheet, farther from its border than what goes together.
        const MeshData mesh =
            with_part(grid(20, 20, 0.02f), grid(4, 4, 0.5f * radius), {-1.2f * radius, 0.2f, -0.1f * radius});
        const Surface surface = build(mesh);
        const std::vector<float> room = room_to_cover(surface, find_overlaps(surface));
        const bool held = std::ranges::any_of(room, [](float r) { return std::isfinite(r); });
        EXPECT_EQ(held, radius > 0.01f) << radius;
    }
}

// Cloth that falls along the sleeve: without what it covers it would slide by its whole room.
TEST(BaseClothOverlaps, ClothThatFallsKeepsTheBorderCovered) {
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

}  // namespace
}  // namespace rumple::tests
