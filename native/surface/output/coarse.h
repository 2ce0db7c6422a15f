// SPDX-License-Identifier: GPL-3.0-or-later
// A coarse mesh over a dense one. Wide folds are solved on few vertices, with any density of the modelled
// mesh. Farthest points and the triangles between their Voronoi cells: Peyre and Cohen 2006, Geodesic
// Remeshing Using Front Propagation (here distances are along the edges).
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

// Built once at rest, then immutable.
struct CoarseMesh {
    Surface surface;                  // its smooth (limit) surface passes through the dense mesh
    SparseRows from_dense;            // where the smooth surface passes <- welded vertices of the dense mesh
    std::vector<Index> dense_vertex;  // per vertex of `surface`: the vertex of the dense mesh, as the artist
                                      // has it, that is nearest to it along the edges
    float mean_edge = 0.0f;           // object units
    SparseRows limit;  // limit position <- vertices; empty rows for vertices without a triangle
};

// spacing: about the mean length of its edges, object units, > 0. A mesh whose edges are not much shorter is
// subdivided first. Cells that are as wide as the mesh (a narrow strap) make no triangles. Loose vertices
// make none either. Throws InvalidInput if the result has no triangle. Cost: about O(vertices x log vertices
// x log coarse vertices), plus the cost of limit_stencils() at the coarse vertices.
std::shared_ptr<const CoarseMesh> build_coarse(const Surface& dense, float spacing);

// The mesh as it was modelled (surface/output/as_modelled.h): triangles are joined to quads, and subdivisions
// taken back until the mean edge is at least least_edge, object units, > 0. Throws InvalidInput if the mesh
// was neither cut into triangles nor subdivided, not so often, or if what it was made from is_uneven() for
// this width. Cost: O(corners x log corners), plus that of limit_stencils().
std::shared_ptr<const CoarseMesh> build_as_modelled(const Surface& dense, float least_edge);

// Computes positions of the coarse vertices, such that the smooth surface of the coarse mesh passes through
// the dense mesh. positions: of the dense mesh's vertices, object space. Throws InvalidInput if positions do
// not match or are not finite.
std::vector<Vec3> coarse_positions(const CoarseMesh& coarse, const Surface& dense,
                                   std::span<const Vec3> positions);

}  // namespace rumple
