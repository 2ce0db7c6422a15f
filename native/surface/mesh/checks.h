// SPDX-License-Identifier: GPL-3.0-or-later
// The checks of build_surface(). Internal to surface.
#pragma once

#include "surface/mesh/topology.h"

namespace rumple {

// One use of an edge by a polygon: the corner that starts it. a < b; forward
// when the polygon walks from a to b.
struct EdgeUse {
    Index a;
    Index b;
    Index polygon;
    Index corner;
    bool forward;
};

// All uses of all edges, sorted by (a, b, polygon, corner). Linear in the corners if vertices have few edges.
std::vector<EdgeUse> collect_edge_uses(const PolygonMesh& mesh);

// The end of the run of uses that share the edge of uses[begin].
std::size_t edge_run_end(const std::vector<EdgeUse>& uses, std::size_t begin);

// Checks ranges, finiteness, ascending starts, n - 2 triangles within each polygon, and creases. Throws
// InvalidInput.
void check_arrays(const SurfaceInput& input);

// Refuses a vertex twice in one polygon, and two polygons over the same vertices. Throws TopologyError.
void check_polygons(const PolygonMesh& mesh);

// Refuses edges used by three polygons, and neighbours with opposite winding. Throws TopologyError.
void check_edges(const PolygonMesh& mesh);

// Groups of two or more polygons over the same vertices in any order. Groups and their members are ascending.
std::vector<std::vector<Index>> find_equal_polygons(const PolygonMesh& mesh);

// The first pair (lower, higher) of polygons over the same vertices; kNone if there is none.
std::pair<Index, Index> find_duplicate_polygons(const PolygonMesh& mesh);

// The mesh with every vertex split into as many as it has fans of polygons, so
// that two fans that only touch do not share a vertex. `fans` gets, per vertex,
// the number of its fans (0: a loose vertex). Edges must have passed check_edges().
PolygonMesh split_fans(const PolygonMesh& mesh, std::vector<Index>& fans);

// Builds the mesh in OpenMesh, polygon by polygon, and returns its edges, in OpenMesh's order. The lower
// polygon is left of an edge. Throws TopologyError about the first polygon that cannot be added to a
// manifold. Cost: O(corners).
std::vector<Edge> check_manifold(const PolygonMesh& mesh);

}  // namespace rumple
