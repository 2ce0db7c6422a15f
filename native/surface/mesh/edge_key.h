// SPDX-License-Identifier: GPL-3.0-or-later
// The edges of a surface's triangles, diagonals of polygons included. Internal to surface.
#pragma once

#include <algorithm>
#include <compare>

#include "surface/mesh/topology.h"

namespace rumple {

// A triangle edge, a < b over welded vertices. A diagonal belongs to its
// polygon: two polygons may both have a diagonal, or a diagonal and an edge,
// between the same two vertices, and these are different lines of the mesh.
struct EdgeKey {
    Index a;
    Index b;
    Index diagonal_of;  // kNone for a polygon edge

    auto operator<=>(const EdgeKey&) const = default;
};

inline EdgeKey edge_key(const Surface& surface, const Triangle& triangle, int k) {
    const Index begin = surface.welded.polygon_start[triangle.polygon];
    const Index n = surface.welded.polygon_size(triangle.polygon);
    const Index i = triangle.corner[k] - begin, j = triangle.corner[(k + 1) % 3] - begin;
    const bool neighbours = (i + 1) % n == j || (j + 1) % n == i;
    const Index a = surface.welded.corner_vertex[triangle.corner[k]];
    const Index b = surface.welded.corner_vertex[triangle.corner[(k + 1) % 3]];
    return {std::min(a, b), std::max(a, b), neighbours ? kNone : triangle.polygon};
}

}  // namespace rumple
