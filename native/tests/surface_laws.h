// SPDX-License-Identifier: GPL-3.0-or-later
// Laws that every refinement obeys.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "surface/refine/refinement.h"
#include "tests/meshes.h"

namespace rumple::tests {

inline std::vector<Vec3> apply_rows(const SparseRows& rows, std::span<const Vec3> values) {
    std::vector<Vec3> out(rows.rows());
    apply<Vec3>(rows, values, out);
    return out;
}

inline void expect_rows_sum_to_one(const SparseRows& rows, Index columns) {
    ASSERT_EQ(rows.start.back(), static_cast<Index>(rows.index.size()));
    ASSERT_EQ(rows.index.size(), rows.weight.size());
    for (Index r = 0; r < rows.rows(); ++r) {
        double sum = 0.0;
        for (Index k = rows.start[r]; k < rows.start[r + 1]; ++k) {
            ASSERT_GE(rows.index[k], 0);
            ASSERT_LT(rows.index[k], columns);
            sum += rows.weight[k];
        }
        ASSERT_NEAR(sum, 1.0, 1e-6) << "row " << r;
    }
}

// A corner's own place, interpolated from the corners of its parent polygon,
// is the place of its vertex, interpolated from the parent's vertices.
inline void expect_corners_agree_with_vertices(const FineMesh& fine, const PolygonMesh& parent,
                                               std::span<const Vec3> positions) {
    std::vector<Vec3> at_corners(parent.corners());
    for (Index c = 0; c < parent.corners(); ++c) at_corners[c] = positions[parent.corner_vertex[c]];
    const auto by_vertex = apply_rows(fine.vertex_from_parent, positions);
    const auto by_corner = apply_rows(fine.corner_from_parent, at_corners);
    for (Index c = 0; c < fine.mesh.corners(); ++c) {
        ASSERT_LT(glm::length(by_corner[c] - by_vertex[fine.mesh.corner_vertex[c]]), 2e-6f) << "corner " << c;
    }
}

// Corners draw only on corners of the parent polygon.
inline void expect_corners_stay_in_their_polygon(const FineMesh& fine, const PolygonMesh& parent) {
    for (Index p = 0; p < fine.mesh.polygons(); ++p) {
        const Index q = fine.polygon_parent[p];
        for (Index c = fine.mesh.polygon_start[p]; c < fine.mesh.polygon_start[p + 1]; ++c) {
            for (Index k = fine.corner_from_parent.start[c]; k < fine.corner_from_parent.start[c + 1]; ++k) {
                ASSERT_GE(fine.corner_from_parent.index[k], parent.polygon_start[q]);
                ASSERT_LT(fine.corner_from_parent.index[k], parent.polygon_start[q + 1]);
            }
        }
    }
}

inline Vec3 area_vector(const PolygonMesh& mesh, std::span<const Vec3> x, Index p) {
    Vec3 sum(0.0f);
    const Index begin = mesh.polygon_start[p], n = mesh.polygon_size(p);
    for (Index i = 0; i < n; ++i) {
        sum += glm::cross(x[mesh.corner_vertex[begin + i]], x[mesh.corner_vertex[begin + (i + 1) % n]]);
    }
    return 0.5f * sum;
}

// The vector areas of a polygon's pieces add up to that of the polygon: nothing
// overlaps, nothing is missing, nothing is turned over.
inline void expect_pieces_fill_their_polygon(const FineMesh& fine, const PolygonMesh& parent,
                                             std::span<const Vec3> positions) {
    const auto x = apply_rows(fine.vertex_from_parent, positions);
    std::vector<Vec3> sum(parent.polygons(), Vec3(0.0f));
    for (Index p = 0; p < fine.mesh.polygons(); ++p) {
        sum[fine.polygon_parent[p]] += area_vector(fine.mesh, x, p);
    }
    for (Index q = 0; q < parent.polygons(); ++q) {
        const Vec3 whole = area_vector(parent, positions, q);
        ASSERT_LT(glm::length(sum[q] - whole), 1e-4f * glm::length(whole)) << "polygon " << q;
    }
}

inline Index euler(const PolygonMesh& mesh) {
    return mesh.vertex_count - static_cast<Index>(collect_edges(mesh).size()) + mesh.polygons();
}

inline Index boundary_edges(const PolygonMesh& mesh) {
    const auto edges = collect_edges(mesh);
    return static_cast<Index>(
        std::count_if(edges.begin(), edges.end(), [](const Edge& e) { return e.right == kNone; }));
}

inline void expect_refinement_laws(const FineMesh& fine, const PolygonMesh& parent,
                                   std::span<const Vec3> positions) {
    ASSERT_EQ(fine.vertex_from_parent.rows(), fine.mesh.vertex_count);
    ASSERT_EQ(fine.corner_from_parent.rows(), fine.mesh.corners());
    ASSERT_EQ(static_cast<Index>(fine.polygon_parent.size()), fine.mesh.polygons());
    ASSERT_EQ(std::set<Index>(fine.mesh.corner_vertex.begin(), fine.mesh.corner_vertex.end()).size(),
              static_cast<std::size_t>(fine.mesh.vertex_count));
    expect_rows_sum_to_one(fine.vertex_from_parent, parent.vertex_count);
    expect_rows_sum_to_one(fine.corner_from_parent, parent.corners());
    expect_corners_agree_with_vertices(fine, parent, positions);
    expect_corners_stay_in_their_polygon(fine, parent);
    expect_pieces_fill_their_polygon(fine, parent, positions);
    EXPECT_EQ(euler(fine.mesh), euler(parent));
}

// Two meshes over the same corners are the same but for the numbering of vertices.
inline void expect_same_partition(const std::vector<Index>& x, const std::vector<Index>& y) {
    ASSERT_EQ(x.size(), y.size());
    std::map<Index, Index> forth, back;
    for (std::size_t c = 0; c < x.size(); ++c) {
        EXPECT_EQ(forth.try_emplace(x[c], y[c]).first->second, y[c]) << "corner " << c;
        EXPECT_EQ(back.try_emplace(y[c], x[c]).first->second, x[c]) << "corner " << c;
    }
}

// A triangle, a pentagon and quads in one mesh, nothing flat.
inline MeshData mixed() {
    MeshData mesh;
    mesh.positions = {{0, 0, 0},          {1, 0, 0.1f},      {2, 0.1f, 0},    {0, 1, 0.2f},
                      {1.1f, 0.9f, 0.3f}, {2, 1, 0.1f},      {0.1f, 2, 0.1f}, {0.9f, 2.1f, 0.2f},
                      {2.4f, 1.6f, 0.2f}, {1.8f, 2.3f, 0.4f}};
    mesh.add_polygon({0, 1, 4, 3});
    mesh.add_polygon({1, 2, 5, 4});
    mesh.add_polygon({3, 4, 7, 6});
    mesh.add_polygon({4, 5, 8, 9, 7});
    mesh.add_polygon({2, 8, 5});
    return mesh;
}

}  // namespace rumple::tests
