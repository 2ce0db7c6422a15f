// SPDX-License-Identifier: GPL-3.0-or-later
// A coarse mesh in place of the artist's base mesh: what a Wrinkle Mesh is attached to and what becomes
// cloth. So wide folds are solved on few vertices, with any density of the modelled mesh.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

// Built once at rest, then immutable.
struct CoarseMesh {
    Surface surface;                 // its smooth (limit) surface passes through that of the base mesh
    SparseRows from_base;            // where the smooth surface passes <- welded vertices of the base mesh
    SparseRows paint_from_base;      // painted values <- vertices of the base mesh, as the artist has them
    std::vector<Index> base_vertex;  // per vertex of `surface`: that of the base mesh, as the artist has it,
                                     // that is nearest to it along the edges
    float mean_edge = 0.0f;          // object units
    SparseRows limit;                // limit position <- vertices; empty rows for vertices without a triangle
};

// An even mesh of triangles: farthest points and the triangles between their Voronoi cells. Peyre and Cohen
// 2006, Geodesic Remeshing Using Front Propagation (here distances are along the edges).
// spacing: about the mean length of its edges, object units, > 0. A mesh whose edges are not much shorter is
// subdivided first. Cells that are as wide as the mesh (a narrow strap) make no triangles. Loose vertices
// make none either. Throws InvalidInput if the result has no triangle. Cost: about O(vertices x log vertices
// x log coarse vertices), plus the cost of limit_stencils() at the coarse vertices.
std::shared_ptr<const CoarseMesh> build_coarse(const Surface& base, float spacing);

// The mesh as it was modelled (surface/output/as_modelled.h): triangles are joined to quads, and subdivisions
// taken back until the mean edge is at least least_edge, > 0, and the faces are not uneven (is_uneven()) for
// this width. If it was modelled with longer edges, it is subdivided until the mean edge is at most
// most_edge, at least 2 x least_edge. Object units. Throws InvalidInput if there is no such mesh, or if it is
// the base itself and may not be. Cost: O(corners x log corners), plus that of limit_stencils().
std::shared_ptr<const CoarseMesh> build_as_modelled(const Surface& base, float least_edge, float most_edge,
                                                    bool may_be_base = false);

// A coarse mesh that was built of a part of the base, for the whole base. part: a surface with some polygons
// and all vertices of the base. The base may join vertices that the part does not, and the other way round.
std::shared_ptr<const CoarseMesh> of_whole_base(const CoarseMesh& of_part, const Surface& part,
                                                const Surface& base);

// Computes positions of the coarse vertices, such that the smooth surface of the coarse mesh passes through
// the base mesh. positions: of the base mesh's vertices, object space. Throws InvalidInput if positions do
// not match or are not finite.
std::vector<Vec3> coarse_positions(const CoarseMesh& coarse, const Surface& base,
                                   std::span<const Vec3> positions);

}  // namespace rumple
