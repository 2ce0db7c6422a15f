// SPDX-License-Identifier: GPL-3.0-or-later
// Parts of a garment that lie over one another.
#include <gtest/gtest.h>

#include "surface/cloth/overlaps.h"
#include "surface/mesh/positions.h"
#include "surface/output/attachments.h"
#include "surface/query/bounds.h"
#include "surface/refine/triangle_tree.h"
#include "tests/base_cloth_rig.h"

namespace rumple::tests {
namespace {

using namespace base_cloth;

constexpr float kSquare = 0.1f, kAbove = 0.005f;
constexpr Index kOfOne = 16;  // vertices of one sheet

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

// What find_overlaps() finds for one vertex and side, by looking at every triangle.
SurfacePoint nearest_of_all(const Surface& surface, std::span<const Index> part,
                            std::span<const Vec3> normals, Index v, bool outer) {
    TrianglePoint best{{}, std::pow(bounding_diagonal(surface.positions_rest) / 30.0, 2.0)};
    for (Index t = 0; t < static_cast<Index>(surface.triangles.size()); ++t) {
        if (part[surface.welded.corner_vertex[surface.triangles[t].corner[0]]] == part[v]) continue;
        const TrianglePoint point = closest_point(surface, t, surface.positions_rest[v]);
        const Vec3 way = (outer ? -1.0f : 1.0f) * (interpolate(surface, point.place, surface.positions_rest) -
                                                   surface.positions_rest[v]);
        const Vec3 normal = interpolate(surface, point.place, normals);
        const bool lies = glm::dot(normal, normals[v]) > 0.5f * glm::length(normal) &&
                          glm::dot(way, normals[v]) > 0.7f * glm::length(way);
        if (lies && point.squared_distance < best.squared_distance) best = point;
    }
    return best.place;
}

TEST(BaseClothOverlaps, AreTheNearestOfAllPlacesThatLieUnderOrOver) {
    MeshData garment = with_part(tube(24, 16, 0.1f, 0.4f), tube(20, 13, 0.104f, 0.3f), {0.0f, 0.0f, 0.05f});
    garment = with_part(garment, grid(3, 3, 0.02f), {0.08f, -0.03f, 0.2f});
    Random random(3);
    for (Vec3& point : garment.positions) point += 0.003f * random.vector();
    const Surface surface = build(garment);
    const std::vector<Index> part = connected_parts(surface);
    const std::vector<Vec3> normals = vertex_normals(surface, surface.positions_rest);
    std::vector<Overlap> expected;
    for (Index v = 0; v < surface.welded.vertex_count; ++v) {
        for (const bool outer : {true, false}) {
            const SurfacePoint place = nearest_of_all(surface, part, normals, v, outer);
            if (place.triangle != kNone) expected.push_back({v, place, outer});
        }
    }
    const std::vector<Overlap> found = find_overlaps(surface);
    ASSERT_EQ(found.size(), expected.size());
    EXPECT_GT(found.size(), 150u);
    for (size_t k = 0; k < found.size(); ++k) {
        EXPECT_EQ(found[k].vertex, expected[k].vertex);
        EXPECT_EQ(found[k].outer, expected[k].outer);
        EXPECT_EQ(found[k].place.triangle, expected[k].place.triangle);
    }
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

}  // namespace
}  // namespace rumple::tests
