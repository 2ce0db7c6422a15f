// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/refine/subdivider.h"

#include <algorithm>
#include <cassert>

#include "base/errors.h"
#include "base/stop.h"

namespace rumple {
namespace {

bool all_triangles(const PolygonMesh& mesh) {
    for (Index p = 0; p < mesh.polygons(); ++p) {
        if (mesh.polygon_size(p) != 3) return false;
    }
    return true;
}

}  // namespace

UsedVertices::UsedVertices(const PolygonMesh& mesh) {
    std::vector<Index> used_of(mesh.vertex_count, kNone);
    for (Index v : mesh.corner_vertex) used_of[v] = 0;
    for (Index v = 0; v < mesh.vertex_count; ++v) {
        if (used_of[v] == kNone) continue;
        used_of[v] = static_cast<Index>(vertex_of.size());
        vertex_of.push_back(v);
    }
    corner.reserve(mesh.corner_vertex.size());
    for (Index v : mesh.corner_vertex) corner.push_back(used_of[v]);
}

Index UsedVertices::number_of(Index vertex) const {
    return Index(std::lower_bound(vertex_of.begin(), vertex_of.end(), vertex) - vertex_of.begin());
}

Refiner make_refiner(const PolygonMesh& mesh, const UsedVertices& used) {
    std::vector<int> sizes(mesh.polygons());
    for (Index p = 0; p < mesh.polygons(); ++p) sizes[p] = mesh.polygon_size(p);
    Far::TopologyDescriptor descriptor;
    descriptor.numVertices = static_cast<int>(used.vertex_of.size());
    descriptor.numFaces = mesh.polygons();
    descriptor.numVertsPerFace = sizes.data();
    descriptor.vertIndicesPerFace = used.corner.data();

    std::vector<int> crease_vertices;
    std::vector<float> crease_weights;
    for (const Crease& crease : mesh.creases) {
        for (const Index v : {crease.a, crease.b}) crease_vertices.push_back(used.number_of(v));
        crease_weights.push_back(crease.sharpness);
    }
    descriptor.numCreases = static_cast<int>(mesh.creases.size());
    descriptor.creaseVertexIndexPairs = crease_vertices.data();
    descriptor.creaseWeights = crease_weights.data();

    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
    const Sdc::SchemeType scheme = all_triangles(mesh) ? Sdc::SCHEME_LOOP : Sdc::SCHEME_CATMARK;
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    Refiner refiner(Factory::Create(descriptor, Factory::Options(scheme, options)));
    if (!refiner) throw TopologyError("OpenSubdiv cannot refine this mesh");
    return refiner;
}

std::vector<Crease> creases_of_last_level(const Far::TopologyRefiner& refiner) {
    std::vector<Crease> creases;
    const Far::TopologyLevel& level = refiner.GetLevel(refiner.GetMaxLevel());
    for (int e = 0; e < level.GetNumEdges(); ++e) {
        const float sharpness = level.GetEdgeSharpness(e);
        if (sharpness <= 0.0f || level.GetEdgeFaces(e).size() != 2) continue;  // a border is always sharp
        const Far::ConstIndexArray ends = level.GetEdgeVertices(e);
        creases.push_back(
            {std::min(ends[0], ends[1]), std::max(ends[0], ends[1]), std::min(sharpness, kSharp)});
    }
    std::sort(creases.begin(), creases.end(),
              [](const Crease& x, const Crease& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
    return creases;
}

void add_sorted_row(std::vector<std::pair<Index, double>>& entries, SparseRows& rows) {
    std::sort(entries.begin(), entries.end());
    for (std::size_t k = 0; k < entries.size(); ++k) {
        assert(k == 0 || entries[k].first != entries[k - 1].first);
        const float weight = static_cast<float>(entries[k].second);
        if (weight != 0.0f) rows.add(entries[k].first, weight);
    }
    rows.end_row();
}

SparseRows copy_rows(const Far::StencilTableReal<double>& table, std::span<const Index> column_of) {
    SparseRows rows;
    std::vector<std::pair<Index, double>> entries;
    for (int i = 0; i < table.GetNumStencils(); ++i) {
        stop_if_asked(std::size_t(i));
        const auto stencil = table.GetStencil(i);
        entries.clear();
        for (int k = 0; k < stencil.GetSize(); ++k) {
            entries.emplace_back(column_of[stencil.GetVertexIndices()[k]], stencil.GetWeights()[k]);
        }
        add_sorted_row(entries, rows);
    }
    return rows;
}

}  // namespace rumple
