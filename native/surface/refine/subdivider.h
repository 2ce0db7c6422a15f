// SPDX-License-Identifier: GPL-3.0-or-later
// Wrappers for the parts of OpenSubdiv's Far that we use. Internal to surface.
#pragma once

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <memory>
#include <utility>
#include <vector>

#include "surface/refine/refinement.h"

namespace rumple {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;
using Refiner = std::unique_ptr<Far::TopologyRefiner>;

// The vertices with polygons. OpenSubdiv leaves a vertex without polygons undefined, so they are removed.
struct UsedVertices {
    std::vector<Index> vertex_of;  // used -> parent
    std::vector<Index> corner;     // per corner: used vertex

    explicit UsedVertices(const PolygonMesh& mesh);
    Index number_of(Index vertex) const;  // of a parent vertex that is used. Cost: O(log vertices)
};

// Level 0 of the mesh, not yet refined: Loop when all polygons are triangles,
// else Catmull-Clark.
Refiner make_refiner(const PolygonMesh& mesh, const UsedVertices& used);

// Creases of the vertices of the last level between two faces each. Empty without creases at level 0.
std::vector<Crease> creases_of_last_level(const Far::TopologyRefiner& refiner);

// Limit of every vertex <- vertices, for a mesh whose vertices all have a polygon. Near rounded creases it
// has an error of at most a 64th of an edge, because OpenSubdiv's masks treat a crease of any sharpness as
// permanent.
SparseRows limit_rows_by_patches(const PolygonMesh& mesh);

// Linear weights (bilinear in a quad) of a uniformly refined mesh's last level.
struct LinearRows {
    SparseRows corner;           // corner <- corners of the mesh
    SparseRows vertex;           // vertex <- vertices of the mesh
    std::vector<Index> polygon;  // face -> polygon of the mesh
};
LinearRows linear_rows(const Far::TopologyRefiner& refiner, const PolygonMesh& mesh);

// Appends a row: columns and their weights, which are sorted; zeros are dropped.
void add_sorted_row(std::vector<std::pair<Index, double>>& entries, SparseRows& rows);

// The rows of an OpenSubdiv table, columns renamed by `column_of`, sorted, zeros dropped.
SparseRows copy_rows(const Far::StencilTableReal<double>& table, std::span<const Index> column_of);

}  // namespace rumple
