// SPDX-License-Identifier: GPL-3.0-or-later
// Section 3 of Mueller and Chentanez 2010: the fine mesh, its places on the base, and its constraints.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <tuple>

#include "base/errors.h"
#include "base/expect.h"
#include "base/graph_coloring.h"
#include "base/lanes.h"
#include "base/parallel.h"
#include "base/stop.h"
#include "base/tolerances.h"
#include "surface/mesh/border_rings.h"
#include "surface/query/bounds.h"
#include "systems/wrinkle_mesh/pose.h"
#include "systems/wrinkle_mesh/wrinkle_mesh.h"

namespace rumple::wrinkle_mesh {
namespace {

// A smaller block is swept in less time than threads take to meet. Blocks do not depend on the number of
// threads, so the order of the sweeps does not either.
constexpr Index kBlockRows = 1024;

FineMesh copy_own(const Surface& own, const Source& source, Index display_steps) {
    FineSource as_it_is = source;
    as_it_is.level = 0;
    as_it_is.kind = FineSource::Kind::kSubdivision;
    refuse_too_many(own.welded.corners(), as_it_is, display_steps);
    return refine_subdivision(own.welded, 0);
}

// Constraints act on triangles, as in the paper. Quads are cut along their shorter diagonal, other polygons
// into a fan.
std::vector<std::array<Index, 3>> triangulate(const PolygonMesh& mesh, std::span<const Vec3> rest) {
    std::vector<std::array<Index, 3>> triangles;
    for (Index p = 0; p < mesh.polygons(); ++p) {
        const Index size = mesh.polygon_size(p);
        const auto vertex = [&](Index k) { return mesh.corner_vertex[mesh.polygon_start[p] + k % size]; };
        const bool turn = size == 4 && glm::distance(rest[vertex(1)], rest[vertex(3)]) <
                                           glm::distance(rest[vertex(0)], rest[vertex(2)]);
        const Index first = turn ? 1 : 0;
        for (Index k = 1; k + 1 < size; ++k) {
            triangles.push_back({vertex(first), vertex(first + k), vertex(first + k + 1)});
        }
    }
    return triangles;
}

using Pair = std::array<Index, 2>;

Pair sorted_pair(Index a, Index b) {
    return a < b ? Pair{a, b} : Pair{b, a};
}

struct PairSets {
    std::vector<Pair> edges;     // of the triangles
    std::vector<Pair> opposite;  // the two vertices opposite an edge of two triangles
    std::vector<Pair> border;    // edges of one triangle

    std::vector<bool> on_border(size_t vertices) const {
        std::vector<bool> out(vertices, false);
        for (const Pair& edge : border) out[edge[0]] = out[edge[1]] = true;
        return out;
    }
};

PairSets collect_pairs(const std::vector<std::array<Index, 3>>& triangles) {
    struct Side {
        Pair edge;
        Index third;  // of the triangle
    };
    std::vector<Side> sides;
    sides.reserve(3 * triangles.size());
    for (const auto& t : triangles)
        for (int k = 0; k < 3; ++k) sides.push_back({sorted_pair(t[k], t[(k + 1) % 3]), t[(k + 2) % 3]});
    std::stable_sort(sides.begin(), sides.end(),
                     [](const Side& s, const Side& t) { return s.edge < t.edge; });
    PairSets sets;
    for (size_t i = 0, next; i < sides.size(); i = next) {
        const Pair edge = sides[i].edge;
        for (next = i + 1; next < sides.size() && sides[next].edge == edge;) ++next;
        sets.edges.push_back(edge);
        if (next == i + 1) sets.border.push_back(edge);
        if (next == i + 1 || sides[i].third == sides[i + 1].third) continue;
        sets.opposite.push_back(sorted_pair(sides[i].third, sides[i + 1].third));
    }
    std::erase_if(sets.opposite, [&](const Pair& pair) {
        return std::binary_search(sets.edges.begin(), sets.edges.end(), pair);
    });
    std::sort(sets.opposite.begin(), sets.opposite.end());
    sets.opposite.erase(std::unique(sets.opposite.begin(), sets.opposite.end()), sets.opposite.end());
    return sets;
}

// Model::vertex_of_row
std::vector<Index> rows_along_longest_axis(std::span<const Vec3> points) {
    Vec3 low(points.empty() ? Vec3(0.0f) : points[0]), high(low);
    for (const Vec3& p : points) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    const int axis = longest_axis(high - low);
    std::vector<Index> vertex(points.size());
    std::iota(vertex.begin(), vertex.end(), 0);
    std::ranges::stable_sort(vertex, {}, [&](Index v) { return points[size_t(v)][axis]; });
    return vertex;
}

std::vector<Index> inverse(const std::vector<Index>& permutation) {
    std::vector<Index> out(permutation.size());
    for (size_t i = 0; i < out.size(); ++i) out[size_t(permutation[i])] = static_cast<Index>(i);
    return out;
}

using RowPairs = std::vector<std::array<Index, 2>>;  // the first row is the lower one

RowPairs rows_of(const std::vector<Pair>& pairs, std::span<const Index> row_of) {
    RowPairs out;
    for (const auto& [a, b] : pairs) out.push_back(sorted_pair(row_of[a], row_of[b]));
    return out;
}

// Computes Model::block_row. Pairs between two blocks extend some rows into both. A block is long enough that
// the pairs at one end share no vertex with the pairs at the other.
std::vector<Index> blocks_of_rows(Index rows, std::initializer_list<const RowPairs*> pairs) {
    // For each row: the largest row that a pair of this row, or of a row before it, contains.
    std::vector<Index> farthest(static_cast<size_t>(rows));
    std::iota(farthest.begin(), farthest.end(), 0);
    for (const RowPairs* some : pairs)
        for (const auto& [low, high] : *some) farthest[low] = std::max(farthest[low], high);
    for (size_t row = 1; row < farthest.size(); ++row)
        farthest[row] = std::max(farthest[row], farthest[row - 1]);
    std::vector<Index> start{0};
    if (rows < Index(kLeastBlocks) * kBlockRows) start.push_back(rows);  // one thread sweeps them
    while (start.back() < rows) {
        const Index begin = start.back(), from_below = begin > 0 ? farthest[begin - 1] : 0;
        const Index end = std::max(begin + kBlockRows, farthest[from_below] + 1);
        start.push_back(std::min(static_cast<Index>(in_fours(size_t(end))), rows));
    }
    return start;
}

// Computes Pairs::run_start and group_start. group, colour: of the pairs in their order.
void find_runs(std::span<const Index> group, std::span<const Index> colour, size_t groups, Pairs& pairs) {
    for (size_t i = 0; i < pairs.size(); ++i) {
        const bool new_group = i == 0 || group[i] != group[i - 1];
        if (new_group)
            pairs.group_start.resize(size_t(group[i]) + 1, static_cast<Index>(pairs.run_start.size()));
        if (new_group || colour[i] != colour[i - 1]) pairs.run_start.push_back(static_cast<Index>(i));
    }
    pairs.group_start.resize(groups + 1, static_cast<Index>(pairs.run_start.size()));
    pairs.run_start.push_back(static_cast<Index>(pairs.size()));
}

// Sorts by group, colour and row. Pairs of one colour share no vertex, so their order changes no bit.
Pairs in_sweep_order(const std::vector<Pair>& pairs, const RowPairs& rows, const Model& model) {
    const auto block_of = [&](Index row) {
        const auto after = std::upper_bound(model.block_row.begin(), model.block_row.end(), row);
        return static_cast<Index>(after - model.block_row.begin()) - 1;
    };
    std::vector<Index> a, b, group;
    for (size_t i = 0; i < pairs.size(); ++i) {
        a.push_back(pairs[i][0]);
        b.push_back(pairs[i][1]);
        group.push_back(block_of(rows[i][0]) + block_of(rows[i][1]));
    }
    const std::vector<Index> colour = color_constraints(static_cast<Index>(model.row_of.size()), a, b);
    stop_if_asked();
    std::vector<Index> order(pairs.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](Index i) { return std::tuple(group[i], colour[i], rows[i][0]); });
    Pairs out;
    for (std::vector<Index>* ends : {&out.a, &out.b, &out.row_a, &out.row_b}) ends->reserve(order.size());
    out.rest.reserve(order.size());
    std::vector<Index> group_of, colour_of;
    for (const Index i : order) {
        out.a.push_back(a[i]);
        out.b.push_back(b[i]);
        out.row_a.push_back(model.row_of[a[i]]);
        out.row_b.push_back(model.row_of[b[i]]);
        out.rest.push_back(glm::distance(model.positions_rest[a[i]], model.positions_rest[b[i]]));
        group_of.push_back(group[i]);
        colour_of.push_back(colour[i]);
    }
    find_runs(group_of, colour_of, 2 * (model.block_row.size() - 1), out);
    return out;
}

std::vector<float> mean_edge_around(const Pairs& edges, size_t vertices) {
    std::vector<float> sum(vertices, 0.0f);
    std::vector<int> count(vertices, 0);
    for (size_t i = 0; i < edges.size(); ++i) {
        for (const Index v : {edges.a[i], edges.b[i]}) {
            sum[v] += edges.rest[i];
            ++count[v];
        }
    }
    for (size_t v = 0; v < vertices; ++v) sum[v] = count[v] ? sum[v] / static_cast<float>(count[v]) : 0.0f;
    return sum;
}

// Binds the artist's mesh to closest points, and stores its distances from them. fine: the artist's mesh
// without the vertices that no polygon uses.
void bind_own(Model& model, const Source& source, const FineMesh& fine, std::span<const Vec3> rest) {
    model.unattached_distance.resize(rest.size());
    model.attachments.places = closest_points(model.base, rest, model.unattached_distance);
    for (size_t v = 0; v < rest.size(); ++v) {
        const Index vertex = source.own->representative[fine.vertex_from_parent.index[v]];
        if (source.farthest > 0.0f && model.unattached_distance[v] > source.farthest) {
            throw InvalidInput("vertex " + std::to_string(vertex) + " of the own mesh is " +
                               short_text(model.unattached_distance[v]) +
                               " away from the base, farther than " + short_text(source.farthest));
        }
        if (!source.attached.empty()) model.attached[v] = source.attached[vertex];
    }
}

// The offsets of the artist's mesh from the attachments, in the smooth frames of the attachments.
std::vector<Vec3> rest_offsets_of_own(const Model& model, std::span<const Vec3> own_rest) {
    const Surface& base = model.base;
    const std::vector<Vec3> attached = attached_at_rest(base, model.attachments),
                            normals = vertex_normals(base, base.positions_rest);
    const std::vector<SurfaceFrame> frames = triangle_frames(base, base.positions_rest);
    std::vector<Vec3> out;
    for (size_t v = 0; v < own_rest.size(); ++v) {
        const SurfacePoint& place = model.attachments.places[v];
        out.push_back(smooth_frame(frames[place.triangle], interpolate(base, place, normals))
                          .to_local(own_rest[v] - attached[v]));
    }
    return out;
}

// Attaches the fine mesh to the base. Returns the positions of its vertices at rest.
std::vector<Vec3> attach_fine_mesh(Model& model, const Source& source, const FineMesh& fine,
                                   AttachmentKind kind) {
    model.attached.assign(fine.mesh.vertex_count, 1);
    if (!source.own) {
        model.attachments = attach_refined(model.base, source, fine, kind);
        return attached_at_rest(model.base, model.attachments);
    }
    std::vector<Vec3> rest(fine.mesh.vertex_count);
    apply<Vec3>(fine.vertex_from_parent, source.own->positions_rest, rest);
    bind_own(model, source, fine, rest);
    model.attachments.kind = kind;
    if (kind == AttachmentKind::kLimit)
        model.attachments.limit = limit_stencils(model.base, model.attachments.places);
    model.rest_offset = rest_offsets_of_own(model, rest);
    return rest;
}

// Adds distance and bending pairs, and the data that depends on them.
void add_constraints(Model& model) {
    const std::vector<Vec3>& rest = model.positions_rest;
    model.triangles = triangulate(model.solved, rest);
    stop_if_asked();
    const PairSets sets = collect_pairs(model.triangles);
    stop_if_asked();
    model.vertex_of_row = rows_along_longest_axis(rest);
    model.row_of = inverse(model.vertex_of_row);
    const RowPairs edges = rows_of(sets.edges, model.row_of), opposite = rows_of(sets.opposite, model.row_of);
    model.block_row = blocks_of_rows(static_cast<Index>(rest.size()), {&edges, &opposite});
    model.distance = in_sweep_order(sets.edges, edges, model);
    model.bending = in_sweep_order(sets.opposite, opposite, model);
    model.local_edge = mean_edge_around(model.distance, rest.size());
    model.border_ring = border_rings(sets.edges, sets.on_border(rest.size()));
}

FineMesh make_fine_mesh(const Surface& base, const Source& source, Index display_steps) {
    return source.own ? copy_own(*source.own, source, display_steps) : refine(base, source, display_steps);
}

// A model with its base, its solved mesh and its attachments.
std::shared_ptr<Model> attach_to(Surface base, const Source& source, AttachmentKind attachment,
                                 const FineMesh& fine) {
    auto model = std::make_shared<Model>();
    model->base = std::move(base);
    model->solved = fine.mesh;
    model->positions_rest = attach_fine_mesh(*model, source, fine, attachment);
    return model;
}

}  // namespace

std::shared_ptr<const Model> build_unshown(Surface base, const Source& source, AttachmentKind attachment) {
    const FineMesh fine = make_fine_mesh(base, source, 0);
    const std::shared_ptr<Model> model = attach_to(std::move(base), source, attachment, fine);
    add_constraints(*model);
    model->near = near_triangles(model->base);
    return model;
}

std::shared_ptr<const Model> build(Surface base, const Source& source, AttachmentKind attachment,
                                   Index display_steps, Index viewport_steps) {
    const FineMesh fine = make_fine_mesh(base, source, display_steps);
    const std::shared_ptr<Model> model = attach_to(std::move(base), source, attachment, fine);
    const Surface& inherited = source.own ? *source.own : model->base;
    const auto add_what_is_solved = [&] {
        add_constraints(*model);
        model->stretch = build_stretch(model->base);
        if (source.adaptive) model->adaptive = place_pairs(*model);
        if (attachment == AttachmentKind::kLimit) model->vertex_limit = limit_of_all_vertices(model->base);
        model->near = near_triangles(model->base);
        model->shown_in_viewport = show_in_viewport(model->base, inherited, fine, display_steps,
                                                    viewport_steps, model->positions_rest);
    };
    const auto add_what_is_shown = [&] {
        model->shown = show_fine(model->base, inherited, fine, display_steps, model->positions_rest);
    };
    in_parallel(add_what_is_shown, add_what_is_solved);
    return model;
}

std::vector<float> carry_paint(const Model& model, std::span<const float> base_values) {
    std::vector<float> out = carry(model, base_values);
    for_each_index(out.size(), kLeastSteps, [&](size_t v) {
        const auto [a, b, c] = display_vertices(model.base, model.attachments.places[v].triangle);
        const auto [least, most] = std::minmax({base_values[a], base_values[b], base_values[c]});
        out[v] = std::clamp(out[v], least, most);
    });
    return out;
}

}  // namespace rumple::wrinkle_mesh
