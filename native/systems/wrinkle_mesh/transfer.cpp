// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_mesh/transfer.h"

#include <set>

#include "base/expect.h"
#include "base/solve_team.h"
#include "systems/wrinkle_mesh/pose.h"

namespace rumple::wrinkle_mesh {
namespace {

// The finest layer is as fine as the folds, so an accuracy of a thousandth of its edges is enough.
constexpr Index kFinestLimitLevels = 2;

// The smooth surface of the finest layer at rest, and which part of the base mesh each triangle stands for.
struct Finest {
    Surface surface;
    std::span<const Vec3> positions_rest;
    std::vector<Index> part;
    float edge;  // of the coarse mesh
};

Finest finest_of(const Layers& layers, const CoarseMesh& coarse, const Surface& base,
                 std::span<const Index> parts) {
    const Model& finest = *layers.layers.back();
    Finest out{solved_surface(finest), finest.positions_rest, {}, coarse.mean_edge};
    const PolygonMesh& polygons = layers.base.welded;
    // Shown polygons of a solved one follow one another.
    const Index shown = layers.shown.mesh.polygons() / out.surface.welded.polygons();
    for (const Triangle& triangle : out.surface.triangles) {
        const Index polygon = layers.shown.polygon_source[triangle.polygon * shown];
        const Index vertex =
            layers.base.representative[polygons.corner_vertex[polygons.polygon_start[polygon]]];
        out.part.push_back(parts[base.welded_of[coarse.base_vertex[vertex]]]);
    }
    return out;
}

// The nearest points of the finest layer's surface.
struct Nearest {
    SparseRows rows;  // <- its vertices
    std::vector<float> distance;
};

// part: of every point; a point only finds its own part, if the coarse mesh has it.
Nearest nearest_on(const Finest& finest, std::span<const Vec3> points, std::span<const Index> part) {
    const std::set<Index> known(finest.part.begin(), finest.part.end());
    std::vector<Index> sought(part.begin(), part.end());
    for (Index& p : sought)
        if (!known.contains(p)) p = kNone;
    Nearest out;
    out.distance.resize(points.size());
    out.rows = limit_stencils(finest.surface,
                              closest_points(finest.surface, points, out.distance, finest.part, sought),
                              kFinestLimitLevels);
    for (Index& vertex : out.rows.index) vertex = finest.surface.representative[vertex];
    return out;
}

SparseRows rows_between(const SparseRows& rows, size_t from, size_t to) {
    SparseRows out;
    for (size_t r = from; r < to; ++r) out.append_row(rows, Index(r));
    return out;
}

// The rows by which attach() weighs the welded vertices.
SparseRows attachment_rows(const Surface& base, const Attachments& attachments) {
    if (attachments.kind == AttachmentKind::kLimit) return attachments.limit;
    SparseRows out;
    for (const SurfacePoint& place : attachments.places) {
        const std::array<Index, 3> corners = welded_vertices(base, place.triangle);
        for (int k = 0; k < 3; ++k) out.add(corners[k], place.weights()[k]);
        out.end_row();
    }
    return out;
}

// Finds how the moved vertices, and the vertices of the base mesh, follow the finest layer, by one search.
// rest: of the moved vertices. smooth: they lie on the limit surface of the base mesh.
void find_nearest(Transfer& transfer, const CoarseMesh& coarse, const Layers& layers,
                  std::span<const Vec3> rest, bool smooth) {
    const Surface& base = transfer.base;
    const std::vector<Index> parts = connected_parts(base);
    const Finest finest = finest_of(layers, coarse, base, parts);
    SparseRows passes = smooth ? vertex_limit_stencils(base) : identity_rows(base.welded.vertex_count);
    std::vector<Vec3> points(parts.size());
    apply<Vec3>(passes, base.positions_rest, points);
    std::vector<Index> part = parts;
    points.insert(points.end(), rest.begin(), rest.end());
    for (const SurfacePoint& place : transfer.attachments.places)
        part.push_back(parts[welded_vertices(base, place.triangle)[0]]);
    const Nearest nearest = nearest_on(finest, points, part);
    const size_t own = parts.size();
    std::vector<float> share, remainder;
    for (size_t i = own; i < points.size(); ++i) {
        share.push_back(bound_share(nearest.distance[i], finest.edge));
        remainder.push_back(1.0f - share.back());
    }
    transfer.from_finest = scaled(rows_between(nearest.rows, own, points.size()), share);
    transfer.from_base = scaled(attachment_rows(base, transfer.attachments), remainder);
    transfer.binding =
        bind_to_finest(base, std::move(passes), rows_between(nearest.rows, 0, own),
                       std::span(nearest.distance).first(own), finest.positions_rest, finest.edge);
}

}  // namespace

std::shared_ptr<const Transfer> build_transfer(Surface base, const CoarseMesh& coarse, const Layers& layers,
                                               Index level, Index display_steps, Index most_vertices,
                                               Index viewport_steps) {
    expect_count("layers", layers.base.display.vertex_count, coarse.base_vertex.size(), "coarse vertices");
    auto out = std::make_shared<Transfer>();
    out->base = std::move(base);
    FineSource source;
    source.level = level;
    source.most_vertices = most_vertices;
    const FineMesh fine = refine(out->base, source, display_steps);
    // Modelled vertices keep their places.
    out->attachments =
        attach_refined(out->base, source, fine, level > 0 ? AttachmentKind::kLimit : AttachmentKind::kLinear);
    const std::vector<Vec3> rest = attached_at_rest(out->base, out->attachments);
    find_nearest(*out, coarse, layers, rest, level > 0);
    out->shown = show_fine(out->base, out->base, fine, display_steps, rest);
    out->shown_in_viewport =
        show_in_viewport(out->base, out->base, fine, display_steps, viewport_steps, rest);
    out->stretch = build_stretch(out->base);
    return out;
}

void show(const Transfer& transfer, const CoarseMesh& coarse, const Layers& layers,
          std::span<const Vec3> animated, const LayersState& state, Picture& picture, bool in_viewport) {
    const SolveTeam team(0, transfer.attachments.places.size(), kVerticesForTeam);
    std::vector<Vec3> displacements =
        offsets(layers, coarse_positions(coarse, transfer.base, animated), state);
    const std::vector<Vec3> missed = missed_by_limit(layers, layers.layers.size() - 1, displacements);
    std::vector<Vec3> unwrinkled(missed.size());
    for (size_t v = 0; v < missed.size(); ++v) {
        unwrinkled[v] = state.solved[v] - displacements[v];
        displacements[v] += missed[v];
    }
    const std::vector<Vec3> base = weld_positions(transfer.base, animated);
    const std::vector<Vec3> bound = bound_offsets(transfer.binding, transfer.base, base, unwrinkled);
    const size_t moved = transfer.attachments.places.size();
    std::vector<Vec3> offset(moved), solved(moved), to_bound(moved), followed(moved);
    apply(transfer.from_finest, to_rows(displacements), offset);
    attach(transfer.base, transfer.attachments, base, {}, solved);
    attach(transfer.base, transfer.attachments, bound, {}, to_bound);
    apply<Vec3>(transfer.from_base, bound_displacements(transfer.binding, displacements), followed);
    for (size_t v = 0; v < moved; ++v) {
        offset[v] += followed[v] + to_bound[v];
        solved[v] += offset[v];
    }
    show_frame(transfer.base, shown_mesh(transfer, in_viewport), transfer.stretch, base,
               triangle_frames(transfer.base, base), solved, offset, picture);
}

}  // namespace rumple::wrinkle_mesh
