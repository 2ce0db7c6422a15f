// SPDX-License-Identifier: GPL-3.0-or-later
// Code that both methods of splitting triangles use. Internal to surface.
#pragma once

#include "surface/mesh/edge_key.h"
#include "surface/refine/refinement.h"

namespace rumple {

// Zeros are left out.
inline void add_row(SparseRows& rows, const Index (&column)[3], const glm::dvec3& weight) {
    for (int k = 0; k < 3; ++k) {
        if (weight[k] != 0.0) rows.add(column[k], static_cast<float>(weight[k]));
    }
    rows.end_row();
}

// Adds triangles over fine vertices, each inside a triangle of the base.
class FineTriangles {
  public:
    FineTriangles(const Surface& surface, FineMesh& fine) : surface_(surface), fine_(fine) {}

    // weights: of the base triangle's corners, one set per corner of the new one.
    void add(Index base, const Index (&vertex)[3], const glm::dvec3 (&weights)[3]) {
        for (int k = 0; k < 3; ++k) {
            fine_.mesh.corner_vertex.push_back(vertex[k]);
            add_row(fine_.corner_from_parent, surface_.triangles[base].corner, weights[k]);
        }
        fine_.mesh.polygon_start.push_back(fine_.mesh.corners());
        fine_.polygon_parent.push_back(surface_.triangles[base].polygon);
    }

  private:
    const Surface& surface_;
    FineMesh& fine_;
};

// The fine vertices at welded vertices: those with a triangle, in order.
inline std::vector<Index> add_base_vertices(const Surface& surface, FineMesh& fine) {
    std::vector<Index> fine_of(surface.welded.vertex_count, kNone);
    for (Index v : surface.welded.corner_vertex) fine_of[v] = 0;
    for (Index v = 0; v < surface.welded.vertex_count; ++v) {
        if (fine_of[v] == kNone) continue;
        fine_of[v] = fine.mesh.vertex_count++;
        fine.vertex_from_parent.add(v, 1.0f);
        fine.vertex_from_parent.end_row();
    }
    return fine_of;
}

}  // namespace rumple
