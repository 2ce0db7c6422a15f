// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "base/errors.h"
#include "tests/surface_laws.h"

namespace rumple::tests {
namespace {

constexpr Index kPlenty = 1000000;

std::vector<MeshData> samples() {
    return {cube(),
            triangulated(cube()),
            seam_split_cube(),
            tube(5, 3, 0.5f, 2.0f),
            mixed(),
            triangulated(mixed()),
            shaken(grid(4, 3, 0.5f), 0.1f, 3)};
}

// The polygons of the surface, triangle by triangle: what is split here.
PolygonMesh triangles_of(const Surface& surface) {
    PolygonMesh mesh;
    mesh.vertex_count = surface.welded.vertex_count;
    for (const Triangle& t : surface.triangles) {
        for (Index c : t.corner) mesh.corner_vertex.push_back(surface.welded.corner_vertex[c]);
        mesh.polygon_start.push_back(mesh.corners());
    }
    return mesh;
}

double longest_edge(const FineMesh& fine, const Surface& surface) {
    const auto x = apply_rows(fine.vertex_from_parent, surface.positions_rest);
    double longest = 0.0;
    for (const Edge& e : collect_edges(fine.mesh)) {
        longest = std::max(longest, static_cast<double>(glm::length(x[e.a] - x[e.b])));
    }
    return longest;
}

// Every edge has two polygons, but for those that lie on the rim of the base.
void expect_conforms(const FineMesh& fine, const Surface& surface) {
    std::set<std::pair<Index, Index>> rim;
    for (const Edge& e : surface.edges) {
        if (e.right == kNone) rim.insert({e.a, e.b});
    }
    for (const Edge& e : collect_edges(fine.mesh)) {
        if (e.right != kNone) continue;
        std::set<Index> columns;
        for (Index v : {e.a, e.b}) {
            const SparseRows& rows = fine.vertex_from_parent;
            columns.insert(rows.index.begin() + rows.start[v], rows.index.begin() + rows.start[v + 1]);
        }
        ASSERT_EQ(columns.size(), 2u) << "edge " << e.a << "-" << e.b;
        EXPECT_TRUE(rim.count({*columns.begin(), *columns.rbegin()}));
    }
}

// --- Regular ---

TEST(Regular, KeepsTheLawsOfRefinement) {
    for (const MeshData& mesh : samples()) {
        const Surface surface = build(mesh);
        for (Index n : {1, 2, 3, 5}) {
            const FineMesh fine = refine_regular(surface, n);
            expect_refinement_laws(fine, surface.welded, surface.positions_rest);
            expect_conforms(fine, surface);
            EXPECT_EQ(fine.mesh.polygons(), n * n * static_cast<Index>(surface.triangles.size()));
            EXPECT_EQ(boundary_edges(fine.mesh), n * boundary_edges(surface.welded));
        }
    }
}

TEST(Regular, OneSegmentIsTheTriangulation) {
    const Surface surface = build(mixed());
    EXPECT_EQ(refine_regular(surface, 1).mesh.corner_vertex, triangles_of(surface).corner_vertex);
}

TEST(Regular, PiecesAreSimilarToTheirTriangle) {
    const Surface surface = build(triangulated(mixed()));
    const FineMesh fine = refine_regular(surface, 4);
    const auto x = apply_rows(fine.vertex_from_parent, surface.positions_rest);
    for (Index p = 0; p < fine.mesh.polygons(); ++p) {
        const Vec3 piece = area_vector(fine.mesh, x, p);
        const Vec3 whole = area_vector(surface.welded, surface.positions_rest, fine.polygon_parent[p]);
        EXPECT_LT(glm::length(16.0f * piece - whole), 1e-4f * glm::length(whole));
    }
}

TEST(Regular, DiagonalsOfTwoPolygonsBetweenTheSameVerticesAreTwoLines) {
    // Two quads around vertex 1 of valence two; both have the diagonal 0-2.
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {0.5f, 0.5f, 0.2f}, {1, 1, 0}, {0, 1, 0}, {1, 0, 0}};
    mesh.add_polygon({0, 1, 2, 3});
    mesh.add_polygon({2, 1, 0, 4});
    const Surface surface = build(mesh);
    const FineMesh fine = refine_regular(surface, 2);
    // 5 vertices, 6 polygon edges, 2 diagonals (were they one line, it would have four triangles).
    EXPECT_EQ(fine.mesh.vertex_count, 5 + 6 + 2);
}

TEST(Regular, RefusesNoSegments) {
    const Surface surface = build(cube());
    EXPECT_THROW(refine_regular(surface, 0), InvalidInput);
    EXPECT_THROW(refine_regular(surface, 100000), InvalidInput);
}

// --- Longest edge ---

TEST(LongestEdge, KeepsTheLawsOfRefinementAndConforms) {
    for (const MeshData& mesh : samples()) {
        const Surface surface = build(mesh);
        for (float longest : {10.0f, 1.0f, 0.31f, 0.1f}) {
            const FineMesh fine = refine_longest_edge(surface, longest, kPlenty);
            expect_refinement_laws(fine, surface.welded, surface.positions_rest);
            expect_conforms(fine, surface);
            EXPECT_LE(longest_edge(fine, surface), longest * 1.00001);
        }
    }
}

TEST(LongestEdge, DoesNotSplitMoreThanItMust) {
    // An edge is split only while it is longer than asked, so halves are longer than half of it;
    // the cuts across triangles may be shorter, but not by much where angles are bounded.
    const Surface surface = build(grid(3, 3, 1.0f));
    const FineMesh fine = refine_longest_edge(surface, 0.3f, kPlenty);
    const auto x = apply_rows(fine.vertex_from_parent, surface.positions_rest);
    for (const Edge& e : collect_edges(fine.mesh)) EXPECT_GE(glm::length(x[e.a] - x[e.b]), 0.15f);
    const FineMesh whole = refine_longest_edge(surface, 2.0f, kPlenty);
    EXPECT_EQ(whole.mesh.corner_vertex, triangles_of(surface).corner_vertex);
}

TEST(LongestEdge, OneSquareByHand) {
    // Sides 1, diagonal 1.414. Asked 1.2: only the diagonal is split, in the middle.
    const Surface surface = build(grid(1, 1, 1.0f));
    const FineMesh fine = refine_longest_edge(surface, 1.2f, kPlenty);
    EXPECT_EQ(fine.mesh.vertex_count, 5);
    EXPECT_EQ(fine.mesh.polygons(), 4);
    EXPECT_EQ(apply_rows(fine.vertex_from_parent, surface.positions_rest)[4], Vec3(0.5f, 0.5f, 0));
    EXPECT_FLOAT_EQ(longest_edge(fine, surface), 1.0);
    // A length equal to an edge leaves the edge alone.
    EXPECT_EQ(refine_longest_edge(surface, 1.0f, kPlenty).mesh.vertex_count, 5);
}

TEST(LongestEdge, RefusesBadLengthsAndTooManyVertices) {
    const Surface surface = build(cube());
    for (float bad :
         {0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        EXPECT_THROW(refine_longest_edge(surface, bad, kPlenty), InvalidInput) << bad;
    }
    EXPECT_THROW(refine_longest_edge(surface, 0.01f, 1000), InvalidInput);
    const Index needed = refine_longest_edge(surface, 0.5f, kPlenty).mesh.vertex_count;
    EXPECT_EQ(refine_longest_edge(surface, 0.5f, needed).mesh.vertex_count, needed);
    EXPECT_THROW(refine_longest_edge(surface, 0.5f, needed - 1), InvalidInput);
}

}  // namespace
}  // namespace rumple::tests
