// SPDX-License-Identifier: GPL-3.0-or-later
// A coarse mesh over a dense one: what is wide is solved on few vertices, whatever the density that was
// modelled. Farthest points and the triangles between their Voronoi cells: Peyre and Cohen 2006, Geodesic
// Remeshing Using Front Propagation (distances here run along the edges).
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

// Built once at rest, then immutable.
struct CoarseMesh {
    Surface surface;  // triangles; its smooth (limit) surface runs through the dense mesh
    std::vector<Index>
        dense_vertex;        // per vertex of `surface`: a vertex of the dense mesh, as the artist has it
    float mean_edge = 0.0f;  // object units
    SparseRows limit;        // limit position <- vertices; empty rows for vertices without a triangle
};

// spacing: about the mean length of its edges, object units, > 0. Cells that are as wide as the mesh (a
// narrow strap) make no triangles, nor do loose vertices, which have none of it. Throws InvalidInput where
// nothing has any. Cost: about O(vertices x log vertices x log coarse vertices), and that of limit_stencils()
// at the coarse vertices.
std::shared_ptr<const CoarseMesh> build_coarse(const Surface& dense, float spacing);

// positions: of the dense mesh's vertices, object space -> of the coarse ones, such that the smooth surface
// of the coarse mesh is where the dense one is. Throws InvalidInput when positions do not match or are not
// finite.
std::vector<Vec3> coarse_positions(const CoarseMesh& coarse, const Surface& dense,
                                   std::span<const Vec3> positions);

}  // namespace rumple
