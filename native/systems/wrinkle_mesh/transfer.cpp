// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_mesh/transfer.h"

#include "base/expect.h"
#include "base/smooth_step.h"
#include "base/solve_team.h"
#include "systems/wrinkle_mesh/pose.h"

namespace rumple::wrinkle_mesh {
namespace {

// Unit: edges of the coarse mesh. Vertices within kNear of it move fully with it, vertices beyond kFar do not
// move.
constexpr float kNear = 1.0f, kFar = 2.0f;

// The finest layer is as fine as the folds, so an accuracy of a thousandth of its edges is enough.
constexpr Index kFinestLimitLevels = 2;

SparseRows ways_from(const Surface& finest, std::span<const Vec3> points, float edge) {
    std::vector<float> distance(points.size());
    const std::vector<SurfacePoint> places = closest_points(finest, points, distance);
    const SparseRows smooth = limit_stencils(finest, places, kFinestLimitLevels);
    SparseRows out;
    for (Index v = 0; v < smooth.rows(); ++v) {
        const float fraction = 1.0f - smooth_step(kNear * edge, kFar * edge, distance[v]);
        for (Index k = smooth.start[v]; fraction > 0.0f && k < smooth.start[v + 1]; ++k)
            out.add(finest.representative[smooth.index[k]], fraction * smooth.weight[k]);
        out.end_row();
    }
    return out;
}

}  // namespace

std::shared_ptr<const Transfer> build_transfer(Surface base, const CoarseMesh& coarse, const Layers& layers,
                                               Index level, Index display_steps, Index most_vertices,
                                               Index viewport_steps) {
    expect_count("layers", layers.base.display.vertex_count, coarse.dense_vertex.size(), "coarse vertices");
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
    out->from_finest = ways_from(solved_surface(*layers.layers.back()), rest, coarse.mean_edge);
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
    for (size_t v = 0; v < missed.size(); ++v) displacements[v] += missed[v];
    const std::vector<Vec3> base = weld_positions(transfer.base, animated);
    const size_t moved = transfer.attachments.places.size();
    std::vector<Vec3> offset(moved), solved(moved);
    apply(transfer.from_finest, to_rows(displacements), offset);
    attach(transfer.base, transfer.attachments, base, {}, solved);
    for (size_t v = 0; v < moved; ++v) solved[v] += offset[v];
    show_frame(transfer.base, shown_mesh(transfer, in_viewport), transfer.stretch, base,
               triangle_frames(transfer.base, base), solved, offset, picture);
}

}  // namespace rumple::wrinkle_mesh
