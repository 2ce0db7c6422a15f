// SPDX-License-Identifier: GPL-3.0-or-later
// Subdivision with OpenSubdiv's Far: it makes the tables, which are copied to our arrays.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/errors.h"
#include "base/stop.h"
#include "surface/refine/subdivider.h"

namespace rumple {
namespace {

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
    stop_if_asked();
    Refiner refiner = make_refiner(parent, used);
    stop_if_asked();
    Far::TopologyRefiner::UniformOptions options(levels);
    options.fullTopologyInLastLevel = true;  // otherwise the last level has no limit masks
    refiner->RefineUniform(options);
    return refiner;
}

// Rows: vertices of a level; columns: vertices of level 0. The sums are the same, to the bit, as those of
// OpenSubdiv's StencilTableFactory. This factory is not used, because it takes most of the time for a large
// mesh, in a single call that cannot be stopped.
class LevelRows {
  public:
    // The interface that PrimvarRefiner writes and reads.
    class Row {
      public:
        Row(LevelRows& rows, Index row) : rows_(rows), row_(row) {}
        void Clear() { rows_.begin(row_); }
        void AddWithWeight(const Row& from, double weight) {
            if (weight != 0.0) rows_.add(row_, from.rows_, from.row_, weight);
        }

      private:
        LevelRows& rows_;
        Index row_;
    };

    explicit LevelRows(Index rows) : begin_(rows), end_(rows) {}

    static LevelRows identity(Index count) {
        LevelRows rows(count);
        for (Index v = 0; v < count; ++v) {
            rows.begin(v);
            rows.entries_.emplace_back(v, 1.0);
            rows.end_[v] = rows.entries_.size();
        }
        return rows;
    }

    // PrimvarRefiner gets its source as const.
    Row operator[](Index row) const { return {const_cast<LevelRows&>(*this), row}; }

    SparseRows sorted(std::span<const Index> column_of) const {
        SparseRows rows;
        std::vector<std::pair<Index, double>> entries;
        for (size_t v = 0; v < begin_.size(); ++v) {
            stop_if_asked(v);
            entries.assign(entries_.begin() + std::ptrdiff_t(begin_[v]),
                           entries_.begin() + std::ptrdiff_t(end_[v]));
            for (auto& [column, weight] : entries) column = column_of[column];
            add_sorted_row(entries, rows);
        }
        return rows;
    }

  private:
    void begin(Index row) {
        stop_if_asked(begun_++);
        begin_[row] = end_[row] = entries_.size();
    }

    // from: these rows, or those of the level before. `row` must be the row that was begun last.
    void add(Index row, const LevelRows& from, Index from_row, double weight) {
        for (size_t k = from.begin_[from_row], end = from.end_[from_row]; k < end; ++k) {
            const Index column = from.entries_[k].first;
            const double share = from.entries_[k].second * weight;
            const auto found = std::find_if(entries_.begin() + std::ptrdiff_t(begin_[row]), entries_.end(),
                                            [&](const auto& entry) { return entry.first == column; });
            if (found != entries_.end()) {
                found->second += share;
            } else {
                entries_.emplace_back(column, share);
            }
        }
        end_[row] = entries_.size();
    }

    std::vector<size_t> begin_, end_;  // of each row, in entries_
    std::vector<std::pair<Index, double>> entries_;
    size_t begun_ = 0;
};

// Rows: vertices of the last level; columns: parent vertices; smooth.
SparseRows make_rows(const Far::TopologyRefiner& refiner, std::span<const Index> column_of) {
    stop_if_asked();
    const Far::PrimvarRefinerReal<double> primvars(refiner);
    LevelRows rows = LevelRows::identity(refiner.GetLevel(0).GetNumVertices());
    for (int level = 1; level <= refiner.GetMaxLevel(); ++level) {
        LevelRows next(refiner.GetLevel(level).GetNumVertices());
        primvars.Interpolate(level, rows, next);
        rows = std::move(next);
    }
    return rows.sorted(column_of);
}

// A row that PrimvarRefiner writes by "adding" columns.
struct Column {
    Index index;
};
struct RowBuilder {
    std::vector<std::pair<Index, double>> entries;

    void Clear() {
        stop_if_asked();
        entries.clear();
    }
    void AddWithWeight(const Column& column, double weight) { entries.emplace_back(column.index, weight); }
};

PolygonMesh copy_last_level(const Far::TopologyRefiner& refiner) {
    const Far::TopologyLevel& level = refiner.GetLevel(refiner.GetMaxLevel());
    PolygonMesh mesh;
    mesh.vertex_count = level.GetNumVertices();
    for (int f = 0; f < level.GetNumFaces(); ++f) {
        const Far::ConstIndexArray corners = level.GetFaceVertices(f);
        mesh.corner_vertex.insert(mesh.corner_vertex.end(), corners.begin(), corners.end());
        mesh.polygon_start.push_back(mesh.corners());
    }
    mesh.creases = creases_of_last_level(refiner);
    return mesh;
}

bool is_rounded_later(const Crease& crease) {
    return crease.sharpness < kSharp;
}

// Rows: limit positions of the last level's vertices; columns: the last level's vertices.
SparseRows make_limit_rows(const Far::TopologyRefiner& refiner) {
    stop_if_asked();
    if (std::ranges::any_of(creases_of_last_level(refiner), is_rounded_later))
        return limit_rows_by_patches(copy_last_level(refiner));
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

// The number of levels before OpenSubdiv's limit masks can be used. They assume that every face is a quad, or
// with Loop a triangle. Other faces must be split once.
Index levels_before_masks(const PolygonMesh& mesh) {
    const Index size = mesh.polygons() > 0 ? mesh.polygon_size(0) : 3;
    if (size > 4) return 1;
    for (Index p = 0; p < mesh.polygons(); ++p) {
        if (mesh.polygon_size(p) != size) return 1;
    }
    return 0;
}

FineMesh copy_parent(const PolygonMesh& parent, const UsedVertices& used) {
    FineMesh fine;
    fine.mesh = {static_cast<Index>(used.vertex_of.size()), parent.polygon_start, used.corner};
    for (const Crease& crease : parent.creases)
        fine.mesh.creases.push_back({used.number_of(crease.a), used.number_of(crease.b), crease.sharpness});
    for (Index v : used.vertex_of) {
        fine.vertex_from_parent.add(v, 1.0f);
        fine.vertex_from_parent.end_row();
    }
    fine.corner_from_parent = identity_rows(parent.corners());
    fine.polygon_parent.resize(parent.polygons());
    for (Index p = 0; p < parent.polygons(); ++p) fine.polygon_parent[p] = p;
    return fine;
}

// Rows: vertices of the last level; columns: parent vertices.
SparseRows refined_rows(const PolygonMesh& parent, const UsedVertices& used,
                        const Far::TopologyRefiner& refiner) {
    return refiner.GetMaxLevel() == 0 ? copy_parent(parent, used).vertex_from_parent
                                      : make_rows(refiner, used.vertex_of);
}

// Rows: limit positions of a level's vertices; columns: parent vertices. If level 0 has no masks, those of
// level 1 are used, at the child vertices of level 0.
SparseRows limit_rows(const PolygonMesh& parent, const UsedVertices& used, Index levels) {
    const Index levels_of_masks = std::max(levels, levels_before_masks(parent));
    const Refiner refiner = refine_uniformly(parent, used, levels_of_masks);
    const SparseRows masks = make_limit_rows(*refiner), refined = refined_rows(parent, used, *refiner);
    if (levels == levels_of_masks) return compose(masks, refined);
    SparseRows at_vertices;  // rows: vertices of level 0; columns: vertices of level 1
    const Far::TopologyLevel& vertices = refiner->GetLevel(0);
    for (Index v = 0; v < vertices.GetNumVertices(); ++v)
        at_vertices.append_row(masks, vertices.GetVertexChildVertex(v));
    return compose(at_vertices, refined);
}

}  // namespace

FineMesh refine_subdivision(const PolygonMesh& parent, Index levels) {
    check_levels(parent, levels);
    const UsedVertices used(parent);
    if (levels == 0) return copy_parent(parent, used);
    const Refiner refiner = refine_uniformly(parent, used, levels);
    FineMesh fine;
    fine.mesh = copy_last_level(*refiner);
    LinearRows rows = linear_rows(*refiner, parent);
    fine.vertex_from_parent = std::move(rows.vertex);
    fine.corner_from_parent = std::move(rows.corner);
    fine.polygon_parent = std::move(rows.polygon);
    return fine;
}

SparseRows subdivision_stencils(const PolygonMesh& parent, Index levels, bool limit) {
    check_levels(parent, levels);
    const UsedVertices used(parent);
    if (limit) return limit_rows(parent, used, levels);
    if (levels == 0) return copy_parent(parent, used).vertex_from_parent;  // nothing to refine
    return refined_rows(parent, used, *refine_uniformly(parent, used, levels));
}

SparseRows vertex_limit_stencils(const Surface& surface) {
    const UsedVertices used(surface.welded);
    const SparseRows of_used = limit_rows(surface.welded, used, 0);
    SparseRows rows;
    Index next = 0;  // index of the next used vertex
    for (Index v = 0; v < surface.welded.vertex_count; ++v) {
        if (next < of_used.rows() && used.vertex_of[next] == v) {
            rows.append_row(of_used, next++);
        } else {
            rows.end_row();
        }
    }
    rows.fit();
    return rows;
}

SparseRows limit_of_all_vertices(const Surface& surface) {
    const SparseRows limit = vertex_limit_stencils(surface);
    SparseRows rows;
    for (Index v = 0; v < limit.rows(); ++v) {
        if (limit.start[v] == limit.start[v + 1]) rows.add(v, 1.0f);
        rows.append_row(limit, v);
    }
    return rows;
}

}  // namespace rumple
