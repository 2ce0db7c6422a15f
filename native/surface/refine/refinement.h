// SPDX-License-Identifier: GPL-3.0-or-later
// Fine meshes over a base surface (Mueller and Chentanez 2010, section 3).
#pragma once

#include <array>
#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

// The most levels of subdivision: a face in 65,536 pieces.
inline constexpr Index kMostLevels = 8;

// The most segments of an edge: a triangle in a million pieces.
inline constexpr Index kMostSegments = 1024;

// By default limit_stencils() is exact at the vertices of this number of levels.
inline constexpr Index kExactLimitLevels = 6;

// A fine mesh and where every piece of it comes from. The weights are *linear*
// (bilinear in a quad): they carry UVs, colours, vertex groups and bindings,
// not the smooth shape. "parent" is the coarser mesh that was refined.
// Every fine vertex has a polygon: loose vertices of the parent are left out.
struct FineMesh {
    PolygonMesh mesh;
    SparseRows vertex_from_parent;      // fine vertex <- parent vertices; rows sum to 1
    SparseRows corner_from_parent;      // fine corner <- parent corners; rows sum to 1
    std::vector<Index> polygon_parent;  // fine polygon -> parent polygon
};

// Uniform subdivision by OpenSubdiv, `levels` times: Loop when every polygon of
// the parent is a triangle, else Catmull-Clark. Boundaries keep their edges and
// their corners; so do bow ties. Creases keep the rest of the parent's sharpness (DeRose, Kass and Truong
// 1998). Level 0 copies the parent. Throws InvalidInput unless 0 <= levels <= kMostLevels and the corners can
// be counted.
FineMesh refine_subdivision(const PolygonMesh& parent, Index levels);

// fine vertex <- parent vertices, the smooth subdivision surface, for the mesh
// that refine_subdivision(parent, levels) returns (same vertex order).
//   limit == false: refined positions;  limit == true: pushed to the limit (along creases that are rounded
//   after these levels: within a 64th of a fine edge of where they end).
SparseRows subdivision_stencils(const PolygonMesh& parent, Index levels, bool limit);

// Every triangle of the surface split regularly into segments^2 triangles
// (segments >= 1), over welded vertices. Vertices on shared edges are shared.
FineMesh refine_regular(const Surface& surface, Index segments);

// Edges of the triangulated surface are split at their middle until the
// longest (at rest, object units) is at most `longest` (> 0); the result conforms (no
// T-junction). Throws InvalidInput when that would need more than `most_vertices`.
FineMesh refine_longest_edge(const Surface& surface, float longest, Index most_vertices);

// outer refines what inner made: the parents of the result are inner's parents.
FineMesh compose(const FineMesh& outer, const FineMesh& inner);

// A place on a triangulated surface: triangle index and barycentric
// coordinates of its corners 1 and 2, as in equation (1).
struct SurfacePoint {
    Index triangle = kNone;
    float b0 = 0.0f;  // weight of corner 1
    float b1 = 0.0f;  // weight of corner 2

    // Of the three corners.
    std::array<float, 3> weights() const { return {1.0f - b0 - b1, b0, b1}; }

    // Linear interpolation: equation (1). at_corner(k): the value at corner k.
    template <typename AtCorner>
    auto interpolate(const AtCorner& at_corner) const {
        const auto [a, b, c] = weights();
        return a * at_corner(0) + b * at_corner(1) + c * at_corner(2);
    }
};

// Where each fine vertex sits: the closest point, within the triangles of one
// parent polygon of the vertex, to its linear rest position. fine's parent is
// surface.welded.
std::vector<SurfacePoint> locate_on_parents(const Surface& surface, const FineMesh& fine);

// Closest point on the whole surface at rest for every query (an artist's own
// mesh), by a bounding volume hierarchy; ties go to the lowest triangle index.
// distance gets object units. Cost: O(log triangles) a query.
// part_of_triangle, part_of_query: a query only finds triangles of the same part; kNone: of any part. Empty:
// all find any.
std::vector<SurfacePoint> closest_points(const Surface& surface, std::span<const Vec3> queries,
                                         std::span<float> distance,
                                         std::span<const Index> part_of_triangle = {},
                                         std::span<const Index> part_of_query = {});

// Limit-surface stencils at arbitrary places of the base: row i gives the
// position of places[i] from the welded vertices (Catmull-Clark, or Loop when
// the base has only triangles). An unattached place (kNone) gets an empty row.
// Exact at the vertices of `exact_levels` subdivision levels and away from
// irregular vertices; else within about 1e-3 of an edge. A place in a quad is one
// of the square, a place in another polygon one of the regular polygon.
// Cost: dominated by the irregular vertices of the base, about 0.25 ms each with six levels.
SparseRows limit_stencils(const Surface& surface, std::span<const SurfacePoint> places,
                          Index exact_levels = kExactLimitLevels);

// Exact limit positions of the welded vertices. A vertex without a triangle gets an empty row. Cost: a mask
// per vertex, and a subdivision if the faces are neither all quads nor all triangles.
SparseRows vertex_limit_stencils(const Surface& surface);

// The same; a vertex without a triangle keeps its position.
SparseRows limit_of_all_vertices(const Surface& surface);

// The fine mesh with its vertices split again where the artist's mesh was split
// at seams: corners of one fine vertex stay together when they draw on the same
// display vertices. Same polygons and corners; display vertices are ordered by
// fine vertex, so without seams nothing changes. fine's parent is surface.welded.
struct Unwelded {
    PolygonMesh mesh;                // display vertices
    std::vector<Index> fine_vertex;  // display vertex -> fine vertex
    SparseRows vertex_from_display;  // display vertex <- base display vertices (linear)
};
Unwelded unweld(const Surface& surface, const FineMesh& fine);

}  // namespace rumple
