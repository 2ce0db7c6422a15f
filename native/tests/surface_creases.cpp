// SPDX-License-Identifier: GPL-3.0-or-later
// Creases: edges that stay for all levels, and edges that stay for some (DeRose, Kass and Truong 1998).
#include <gtest/gtest.h>

#include <limits>

#include "base/errors.h"
#include "surface/output/shown_mesh.h"
#include "tests/surface_laws.h"

namespace rumple::tests {
namespace {

// Every edge of a mesh.
std::vector<Crease> all_edges(const MeshData& mesh, float sharpness) {
    std::vector<Crease> creases;
    for (std::size_t p = 0; p + 1 < mesh.polygon_start.size(); ++p) {
        const Index begin = mesh.polygon_start[p], size = mesh.polygon_start[p + 1] - begin;
        for (Index k = 0; k < size; ++k)
            creases.push_back(
                {mesh.corner_vertex[begin + k], mesh.corner_vertex[begin + (k + 1) % size], sharpness});
    }
    return creases;
}

Surface creased(const MeshData& mesh, std::span<const Crease> creases) {
    SurfaceInput input = mesh.input();
    input.creases = creases;
    return build_surface(input);
}

// The upper ring of the cube.
std::vector<Crease> ring(float sharpness) {
    return {{4, 5, sharpness}, {5, 7, sharpness}, {7, 6, sharpness}, {6, 4, sharpness}};
}

float largest(std::span<const Vec3> x, std::span<const Vec3> y) {
    EXPECT_EQ(x.size(), y.size());
    float most = 0.0f;
    for (std::size_t v = 0; v < x.size(); ++v) most = std::max(most, glm::length(x[v] - y[v]));
    return most;
}

// How far a point is from the surface of the cube [-1, 1]^3.
float from_cube(const Vec3& p) {
    return std::abs(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) - 1.0f);
}

TEST(Creases, ACubeOfSharpEdgesStaysTheCube) {
    for (const MeshData& mesh : {cube(), triangulated(cube()), seam_split_cube()}) {
        const Surface surface = creased(mesh, all_edges(mesh, kSharp));
        for (Index levels : {0, 1, 2, 4}) {
            const FineMesh fine = refine_subdivision(surface.welded, levels);
            const auto linear = apply_rows(fine.vertex_from_parent, surface.positions_rest);
            for (bool limit : {false, true}) {
                const SparseRows rows = subdivision_stencils(surface.welded, levels, limit);
                expect_rows_sum_to_one(rows, surface.welded.vertex_count);
                EXPECT_LT(largest(apply_rows(rows, surface.positions_rest), linear), 1e-6f)
                    << levels << limit;
            }
            const auto places = locate_on_parents(surface, fine);
            EXPECT_LT(largest(apply_rows(limit_stencils(surface, places), surface.positions_rest), linear),
                      1e-6f);
        }
        EXPECT_LT(largest(apply_rows(vertex_limit_stencils(surface), surface.positions_rest),
                          surface.positions_rest),
                  1e-6f);
    }
}

TEST(Creases, ASharpnessOfZeroIsNone) {
    const Surface without = build(cube()), with = creased(cube(), ring(0.0f));
    EXPECT_TRUE(with.welded.creases.empty());
    for (bool limit : {false, true}) {
        const SparseRows x = subdivision_stencils(without.welded, 2, limit),
                         y = subdivision_stencils(with.welded, 2, limit);
        EXPECT_EQ(x.index, y.index);
        EXPECT_EQ(x.weight, y.weight);
    }
}

TEST(Creases, TheSharperTheNearerToTheEdge) {
    float before = 1.0f;
    for (float sharpness : {0.0f, 0.4f, 1.0f, 1.6f, 2.0f, 3.5f, 6.0f, 9.5f, kSharp}) {
        const Surface surface = creased(cube(), ring(sharpness));
        const auto at = apply_rows(subdivision_stencils(surface.welded, 3, true), surface.positions_rest);
        float gap = 1.0f;  // of the plane of the ring from it
        for (const Vec3& p : at) gap = std::min(gap, 1.0f - p.z);
        EXPECT_LT(gap, before + 1e-6f) << sharpness;
        before = gap;
    }
    EXPECT_LT(before, 1e-6f);
}

// Masks of the limit hold where no crease is left: there, after more levels, is what patches say of fewer.
TEST(Creases, TheLimitIsThatOfMoreLevels) {
    for (const MeshData& mesh : {cube(), triangulated(cube())}) {
        for (float sharpness : {0.3f, 1.0f, 2.5f, 4.0f}) {
            const Surface surface = creased(mesh, ring(sharpness));
            const FineMesh few = refine_subdivision(surface.welded, 1),
                           many = refine_subdivision(surface.welded, 4);
            ASSERT_EQ(many.mesh.creases.empty(), true) << sharpness;
            const auto from = apply_rows(few.vertex_from_parent, surface.positions_rest),
                       to = apply_rows(many.vertex_from_parent, surface.positions_rest);
            const auto x = apply_rows(subdivision_stencils(surface.welded, 1, true), surface.positions_rest),
                       y = apply_rows(subdivision_stencils(surface.welded, 4, true), surface.positions_rest);
            for (std::size_t v = 0; v < from.size(); ++v) {
                const auto same =
                    std::ranges::find_if(to, [&](const Vec3& p) { return glm::length(p - from[v]) < 1e-5f; });
                ASSERT_NE(same, to.end());
                EXPECT_LT(glm::length(x[v] - y[std::size_t(same - to.begin())]), 1e-6f) << sharpness;
            }
        }
    }
}

TEST(Creases, WhatIsLeftOfThemGoesOn) {
    const Surface surface = creased(cube(), ring(2.5f));
    const FineMesh one = refine_subdivision(surface.welded, 1), two = refine_subdivision(surface.welded, 2);
    ASSERT_EQ(one.mesh.creases.size(), 8u);
    ASSERT_EQ(two.mesh.creases.size(), 16u);
    for (const Crease& crease : one.mesh.creases) EXPECT_FLOAT_EQ(crease.sharpness, 1.5f);
    for (const Crease& crease : two.mesh.creases) EXPECT_FLOAT_EQ(crease.sharpness, 0.5f);
    const auto at_once = apply_rows(subdivision_stencils(surface.welded, 3, false), surface.positions_rest);
    const auto half = apply_rows(subdivision_stencils(surface.welded, 1, false), surface.positions_rest);
    const auto in_steps = apply_rows(subdivision_stencils(one.mesh, 2, false), half);
    for (const Vec3& p : in_steps) {  // in another order
        const auto nearest =
            std::ranges::min_element(at_once, {}, [&](const Vec3& q) { return glm::dot(p - q, p - q); });
        EXPECT_LT(glm::length(*nearest - p), 1e-6f);
    }
}

TEST(Creases, SeamsAreWeldedWithThem) {
    const MeshData split = seam_split_cube();
    std::vector<Crease> creases;  // of one side of every seam of the upper face: 4, 5, 7, 6
    for (Index k = 0; k < 4; ++k) creases.push_back({4 + k, 4 + (k + 1) % 4, 1.0f + float(k)});
    const Surface surface = creased(split, creases);
    ASSERT_EQ(surface.welded.creases.size(), 4u);
    for (const Crease& crease : surface.welded.creases) EXPECT_LT(crease.a, crease.b);
}

TEST(Creases, TheSharpestOfAnEdgeCounts) {
    const std::vector<Crease> twice{{4, 5, 2.0f}, {5, 4, 30.0f}};
    const Surface surface = creased(cube(), twice);
    ASSERT_EQ(surface.welded.creases.size(), 1u);
    EXPECT_EQ(surface.welded.creases[0].sharpness, kSharp);
}

TEST(Creases, WhereThereIsNoEdgeNothingIsCreased) {
    const std::vector<Crease> none{
        {0, 1, 5.0f}, {0, 4, 5.0f}, {2, 2, 5.0f}};  // a border, a diagonal, a point
    EXPECT_TRUE(creased(grid(2, 1, 1.0f), none).welded.creases.empty());
}

TEST(Creases, OfVerticesThatAreNotThereAreRefused) {
    const std::vector<Crease> far{{4, 5, 1.0f}, {0, 8, 1.0f}}, below{{-1, 0, 1.0f}},
        odd{{4, 5, std::numeric_limits<float>::quiet_NaN()}}, negative{{4, 5, -1.0f}};
    for (const auto& creases : {far, below, odd, negative})
        EXPECT_THROW(creased(cube(), creases), InvalidInput);
}

// Also where edges are split by other means than subdivision, and the pieces are subdivided to be shown.
TEST(Creases, StayInEveryKindOfFineMesh) {
    const MeshData mesh = cube();
    const Surface surface = creased(mesh, all_edges(mesh, kSharp));
    for (const auto kind :
         {FineSource::Kind::kSubdivision, FineSource::Kind::kRegular, FineSource::Kind::kLongestEdge}) {
        FineSource source;
        source.kind = kind;
        source.level = 1;
        source.segments = 3;
        source.longest_edge = 0.7f;
        const FineMesh fine = refine(surface, source, 2);
        EXPECT_FALSE(fine.mesh.creases.empty());
        const Attachments attachments = attach_refined(surface, source, fine, AttachmentKind::kLimit);
        const ShownMesh shown = show_fine(surface, surface, fine, 2, attached_at_rest(surface, attachments));
        for (const Vec3& p : shown.positions_rest) EXPECT_LT(from_cube(p), 1e-6f);
    }
}

TEST(Creases, LoseALevelWithEveryHalvingOfTheirEdge) {
    const Surface surface = creased(cube(), ring(2.5f));
    FineSource source;
    source.kind = FineSource::Kind::kRegular;
    for (const auto& [segments, left] : {std::pair(1, 2.5f), std::pair(2, 1.5f), std::pair(3, 1.0f)}) {
        source.segments = segments;
        const FineMesh fine = refine(surface, source);
        ASSERT_EQ(Index(fine.mesh.creases.size()), 4 * segments);
        for (const Crease& crease : fine.mesh.creases) EXPECT_FLOAT_EQ(crease.sharpness, left);
    }
}

}  // namespace
}  // namespace rumple::tests
