// SPDX-License-Identifier: GPL-3.0-or-later
// The coarse base mesh: checked once, then stored as flat arrays.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "base/array.h"

namespace rumple {

// A crease of this sharpness or more is never rounded: OpenSubdiv's measure.
inline constexpr float kSharp = 10.0f;

// An edge (a < b) and for how many subdivisions it stays sharp; a fraction rounds it partly. The sharpness is
// above 0, at most kSharp.
struct Crease {
    Index a = kNone;
    Index b = kNone;
    float sharpness = 0.0f;
};

// Polygons as Blender stores them. Polygon p owns the corners
// [polygon_start[p], polygon_start[p + 1]).
struct PolygonMesh {
    Index vertex_count = 0;
    std::vector<Index> polygon_start{0};
    std::vector<Index> corner_vertex;
    // Of edges between two polygons, ascending by (a, b); refinement rounds these edges less
    std::vector<Crease> creases{};

    Index polygons() const { return static_cast<Index>(polygon_start.size()) - 1; }
    Index corners() const { return static_cast<Index>(corner_vertex.size()); }
    Index polygon_size(Index p) const { return polygon_start[p + 1] - polygon_start[p]; }
};

// An undirected edge (a < b) and up to two polygons beside it.
struct Edge {
    Index a = kNone;
    Index b = kNone;
    Index left = kNone;   // first polygon that uses the edge
    Index right = kNone;  // second one; kNone on a boundary
};

// Every edge once, sorted by (a, b): the order does not depend on the order of
// the polygons. An edge used by more than two polygons keeps the first two.
std::vector<Edge> collect_edges(const PolygonMesh& mesh);

// Triangles of a base mesh, as corner indices of `mesh`, and their polygon.
struct Triangle {
    Index corner[3];
    Index polygon;
};

// The base surface at rest, built by build_surface() and never changed.
//   display  the artist's mesh
//   welded   the same polygons over welded vertices, for refinement and solve; it has the creases
// Both share polygons and corners; only corner_vertex differs.
struct Surface {
    PolygonMesh display;
    PolygonMesh welded;
    std::vector<Index> welded_of;       // display vertex -> welded vertex
    std::vector<Index> representative;  // welded vertex -> its first display vertex
    std::vector<Vec3> positions_rest;   // per welded vertex, object space, object units
    std::vector<Triangle> triangles;    // of every polygon, as given
    std::vector<Edge> edges;            // of the welded mesh
    std::vector<bool> boundary_vertex;  // per welded vertex
    std::vector<std::string> warnings;  // loose vertices, zero-area triangles, ...
};

struct SurfaceInput {
    std::span<const Vec3> positions_rest;    // per vertex, object space, object units
    std::span<const Index> polygon_start;    // polygons + 1, ascending from 0
    std::span<const Index> corner_vertex;    // per corner
    std::span<const Index> triangle_corner;  // 3 per triangle: corner indices of one polygon
    bool weld_seams = true;                  // join boundary vertices at the same place
    // Pairs of vertices in any order, duplicates allowed. A crease without an edge of two polygons is
    // dropped, because borders are always sharp. The largest sharpness of an edge is used. Sharpness: 0 or
    // more.
    std::span<const Crease> creases = {};
};

// Checks the mesh (through OpenMesh: every polygon must be addable to a
// manifold), welds it, and takes its edges.
// Welding joins boundary edges at the same place (both ends within kWeldDistance x bounding box diagonal)
// with opposite directions, like the two sides of a cut. It does not join edges if that would make an edge
// non-manifold, a polygon degenerate or two polygons equal. Then there is a warning. Other warnings: loose
// vertices (they keep a welded vertex without polygons), bow ties (a vertex where two fans of polygons touch:
// it is refined as a sharp corner), zero-area triangles, zero-length edges. Loose edges are not part of the
// input. Throws InvalidInput (not finite, an index out of range, no faces, all vertices at one place, a face
// whose triangles are not its own or not as many as its corners less two) and TopologyError (an edge with
// three polygons, neighbours of opposite winding, polygons over the same vertices, a vertex twice in a
// polygon). The error names the first bad element in the caller's numbering. Cost: O(corners log corners).
Surface build_surface(const SurfaceInput& input);

// SurfaceInput::triangle_corner of polygons whose triangles meet at their first corner.
std::vector<Index> fan_triangles(const PolygonMesh& mesh);

// The one-rings: of every welded vertex v the others of the triangles around it, ascending: vertex[start[v]]
// to vertex[start[v + 1] - 1]. Cost: O(triangles x log valence).
struct OneRings {
    std::vector<Index> start{0};
    std::vector<Index> vertex;
};
OneRings one_rings(const Surface& surface);

// The connected part of every welded vertex: its lowest vertex. Cost: O(edges).
std::vector<Index> connected_parts(const Surface& surface);

// For every triangle t, those that share a welded vertex with it, itself included, ascending:
// triangle[start[t]] to triangle[start[t + 1] - 1]. Cost: O(triangles x valence log valence).
struct NearTriangles {
    std::vector<Index> start{0};
    std::vector<Index> triangle;
};
NearTriangles near_triangles(const Surface& surface);

// The corners of a triangle, as display vertices.
std::array<Index, 3> display_vertices(const Surface& surface, Index triangle);

// The same corners, as welded vertices. Inline, for loops over the triangles around a vertex.
inline std::array<Index, 3> welded_vertices(const Surface& surface, Index triangle) {
    const Index* corner = surface.triangles[triangle].corner;
    const std::vector<Index>& vertex = surface.welded.corner_vertex;
    return {vertex[corner[0]], vertex[corner[1]], vertex[corner[2]]};
}

// Deformed positions of the display vertices -> positions of the welded vertices: the mean of the joined ones
// (equal positions give exactly the same position).
void weld_positions(const Surface& surface, std::span<const Vec3> display, std::span<Vec3> welded);
std::vector<Vec3> weld_positions(const Surface& surface, std::span<const Vec3> display);

}  // namespace rumple
