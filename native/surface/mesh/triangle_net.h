// SPDX-License-Identifier: GPL-3.0-or-later
// Half-edges of a surface's triangles, for walks over the surface.
#pragma once

#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

// Half-edge 3 t + k runs from corner k of triangle t to its corner k + 1. The two half-edges of
// an edge run in opposite directions. Numbers of half-edges do not depend on those of vertices.
struct TriangleNet {
    std::vector<Index> vertex;  // welded vertex that a half-edge starts from
    std::vector<Index> twin;    // the other half-edge of the same edge; kNone at an open border

    Index triangles() const { return static_cast<Index>(vertex.size()) / 3; }
};

inline Index triangle_of(Index half_edge) {
    return half_edge / 3;
}
inline Index next_in_triangle(Index half_edge) {
    return half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1;
}
inline Index previous_in_triangle(Index half_edge) {
    return half_edge % 3 == 0 ? half_edge + 2 : half_edge - 1;
}

// Cost: O(triangles log triangles).
TriangleNet build_net(const Surface& surface);

}  // namespace rumple
