// SPDX-License-Identifier: GPL-3.0-or-later
// Subdivision through OpenSubdiv's Far: it makes the tables, our arrays keep them.
#include <cmath>
#include <limits>

#include "base/errors.h"
#include "surface/refine/subdivider.h"

namespace rumple {
namespace {

using StencilFactory = Far::StencilTableFactoryReal<double>;

void check_levels(const PolygonMesh& parent, Index levels) {
    if (levels < 0 || levels > kMostLevels) {
        throw InvalidInput("levels: expected 0 to " + std::to_string(kMostLevels) + ", got " +
                           std::to_string(levels));
    }
    const double corners = std::ldexp(static_cast<double>(parent.corners()), 2 * levels);
    if (4.0 * corners > std::numeric_limits<Index>::max()) {
        throw InvalidInput("levels: " + std::to_string(levels) +
                           " levels make more corners than can be counted");
    }
}

Refiner refine_uniformly(const PolygonMesh& parent, const UsedVertices& used, Index levels) {
    Refiner refiner = make_refiner(parent, used);
    Far::TopologyRefiner::UniformOptions options(levels);
    options.fullTopologyInLastLevel = true;  // or the limit of the last level has no masks
    refiner->RefineUniform(options);
    return refiner;
}

SparseRows identity_rows(Index count) {
    SparseRows rows;
    for (Index i = 0; i < count; ++i) {
        rows.add(i, 1.0f);
        rows.end_row();
    }
    return rows;
}

// Rows of the last level in terms of the parent.
SparseRows make_rows(const Far::TopologyRefiner& refiner, StencilFactory::Mode mode,
                     std::span<const Index> column_of) {
    StencilFactory::Options options;
    options.interpolationMode = mode;
    options.generateIntermediateLevels = false;
    options.factorizeIntermediateLevels = true;
    options.generateControlVerts = false;
    options.maxLevel = static_cast<unsigned>(refiner.GetMaxLevel());
    const std::unique_ptr<const Far::StencilTableReal<double>> table(
        StencilFactory::Create(refiner, options));
    return copy_rows(*table, column_of);
}

// Rows that PrimvarRefiner writes by "adding" columns.
struct Column {
    Index index;
};
struct RowBuilder {
    std::vector<std::pair<Index, double>> entries;

    void Clear() { entries.clear(); }
    void AddWithWeight(const Column& column, double weight) { entries.emplace_back(column.index, weight); }
};

// Last-level vertices on the limit surface <- last-level vertices.
SparseRows make_limit_rows(const Far::TopologyRefiner& refiner) {
    const Index count = refiner.GetLevel(refiner.GetMaxLevel()).GetNumVertices();
    std::vector<Column> columns(count);
    for (Index v = 0; v < count; ++v) columns[v].index = v;
    std::vector<RowBuilder> builders(count);
    Far::PrimvarRefinerReal<double>(refiner).Limit(columns, builders);
    SparseRows rows;
    for (const RowBuilder& builder : builders) {
        for (const auto& [column, weight] : builder.entries) rows.add(column, static_cast<float>(weight));
        rows.end_row();
    }
    return rows;
}

PolygonMesh copy_last_level(const Far::TopologyRefiner& refiner) {
    const Far::TopologyLevel& level = refiner.GetLevel(refiner.GetMaxLevel());
    PolygonMesh mesh;
    mesh.vertex_count = level.GetNumVertices();
    for (int f = 0; f < level.GetNumFaces(); ++f) {
        const Far::ConstIndexArray corners = level.GetFaceVertices(f);
        mesh.corner_vertex.insert(mesh.corner_vertex.end(), corners.begin(), corners.end());
        mesh.polygon_start.push_back(mesh.corners());
    }
    return mesh;
}

std::vector<Index> trace_polygons(const Far::TopologyRefiner& refiner) {
    std::vector<Index> ancestor(refiner.GetLevel(0).GetNumFaces());
    for (std::size_t p = 0; p < ancestor.size(); ++p) ancestor[p] = static_cast<Index>(p);
    for (int l = 1; l <= refiner.GetMaxLevel(); ++l) {
        const Far::TopologyLevel& level = refiner.GetLevel(l);
        std::vector<Index> next(level.GetNumFaces());
        for (int f = 0; f < level.GetNumFaces(); ++f) next[f] = ancestor[level.GetFaceParentFace(f)];
        ancestor = std::move(next);
    }
    return ancestor;
}

// Face-varying values are numbered by OpenSubdiv; we want them by corner.
SparseRows make_corner_rows(const Far::TopologyRefiner& refiner, Index parent_corners) {
    std::vector<Index> same(parent_corners);
    for (Index c = 0; c < parent_corners; ++c) same[c] = c;
    const SparseRows values = make_rows(refiner, StencilFactory::INTERPOLATE_FACE_VARYING, same);
    const Far::TopologyLevel& level = refiner.GetLevel(refiner.GetMaxLevel());
    SparseRows pick;
    for (int f = 0; f < level.GetNumFaces(); ++f) {
        for (int value : level.GetFaceFVarValues(f)) {
            pick.add(value, 1.0f);
            pick.end_row();
        }
    }
    return compose(pick, values);
}

FineMesh copy_parent(const PolygonMesh& parent, const UsedVertices& used) {
    FineMesh fine;
    fine.mesh = {static_cast<Index>(used.vertex_of.size()), parent.polygon_start, used.corner};
    for (Index v : used.vertex_of) {
        fine.vertex_from_parent.add(v, 1.0f);
        fine.vertex_from_parent.end_row();
    }
    fine.corner_from_parent = identity_rows(parent.corners());
    fine.polygon_parent.resize(parent.polygons());
    for (Index p = 0; p < parent.polygons(); ++p) fine.polygon_parent[p] = p;
    return fine;
}

}  // namespace

FineMesh refine_subdivision(const PolygonMesh& parent, Index levels) {
    check_levels(parent, levels);
    const UsedVertices used(parent);
    if (levels == 0) return copy_parent(parent, used);
    const Refiner refiner = refine_uniformly(parent, used, levels);
    FineMesh fine;
    fine.mesh = copy_last_level(*refiner);
    fine.vertex_from_parent = make_rows(*refiner, StencilFactory::INTERPOLATE_VARYING, used.vertex_of);
    fine.corner_from_parent = make_corner_rows(*refiner, parent.corners());
    fine.polygon_parent = trace_polygons(*refiner);
    return fine;
}

SparseRows subdivision_stencils(const PolygonMesh& parent, Index levels, bool limit) {
    check_levels(parent, levels);
    const UsedVertices used(parent);
    const Refiner refiner = refine_uniformly(parent, used, levels);
    const SparseRows refined = levels == 0
                                   ? copy_parent(parent, used).vertex_from_parent
                                   : make_rows(*refiner, StencilFactory::INTERPOLATE_VERTEX, used.vertex_of);
    return limit ? compose(make_limit_rows(*refiner), refined) : refined;
}

}  // namespace rumple
