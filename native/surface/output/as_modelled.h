// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh as it was modelled: before its quads were cut into triangles, and before it was subdivided.
#pragma once

#include <optional>
#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

struct MeshBefore {
    PolygonMesh mesh;           // every vertex has a polygon
    std::vector<Index> vertex;  // per vertex of `mesh`: that of the later one
};

// The same polygons over the vertices that they use.
MeshBefore without_loose_vertices(PolygonMesh mesh);

// Joins triangles in pairs, the best quads first: their angles are nearest to right angles, and they are
// flat. Other polygons stay. None if less than half of the polygons are triangles, or if less than kJoined of
// these make quads, as in a mesh that was modelled of triangles. Cost: O(edges log edges).
std::optional<MeshBefore> joined_triangles(const Surface& surface);
inline constexpr double kJoined = 0.8;

// Takes a subdivision back. Catmull and Clark 1978: every polygon becomes a quad at each of its corners,
// around a new vertex, and every edge has a new vertex. Other schemes that divide so (Blender's Simple) are
// alike. Only the polygons say it, not the positions. Of several answers, as a regular grid has, it is that
// with the lowest vertex of each part, which Blender writes first. None if some polygon is not of such a
// quad. Cost: O(corners x log corners).
std::optional<MeshBefore> undivided(const PolygonMesh& mesh);

}  // namespace rumple
