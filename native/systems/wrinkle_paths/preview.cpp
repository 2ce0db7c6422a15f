// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_paths/preview.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/tolerances.h"
#include "base/unit_vector.h"
#include "systems/wrinkle_paths/context.h"
#include "systems/wrinkle_paths/fold.h"

namespace rumple::wrinkle_paths {
namespace {

// Section 7.3: target edge length in triangles with folds / L_min.
constexpr float kFoldedEdge = 3.0f / 8.0f;

// In other triangles: largest distance of a straight edge from the curved one / L_min.
constexpr float kFlatness = 0.04f;

Index power_of_two(float parts) {
    const float whole = parts >= 1.0f ? std::min(parts, float(kMostParts)) : 1.0f;  // NaN gives 1
    return std::min(std::bit_ceil(std::uint32_t(whole + 0.999f)), std::uint32_t(kMostParts));
}

bool has_folds(const TriangleLists& lists, Index triangle) {
    return lists.triangle_start[triangle] < lists.triangle_start[triangle + 1];
}

// The number of parts of an edge. It is equal for both half-edges, because it is computed from the lower
// vertex to the higher one.
Index parts_of_edge(const Model& model, const Settings& settings, const Drawing& drawing, Index half_edge) {
    const auto [a, b] = std::minmax(model.triangles.net.vertex[half_edge],
                                    model.triangles.net.vertex[next_in_triangle(half_edge)]);
    const Index twin = model.triangles.net.twin[half_edge];
    if (has_folds(drawing.lists, triangle_of(half_edge)) &&
        (twin == kNone || has_folds(drawing.lists, triangle_of(twin)))) {
        const float longest = kFoldedEdge * settings.width;
        return power_of_two(glm::distance(drawing.flat[a], drawing.flat[b]) / longest);
    }
    if (!drawing.curved) return 1;
    const Vec3 displacement = drawing.smooth[b] - drawing.smooth[a];
    const auto rise = [&](Index v) { return std::abs(glm::dot(displacement, drawing.normal[v])); };
    const float bulge =
        (rise(a) + rise(b)) / 8.0f;  // of a cubic whose control points rise by a third of these
    return power_of_two(std::sqrt(bulge / (kFlatness * settings.width)));
}

std::vector<Parts> cut(const Model& model, const Settings& settings, const Drawing& drawing) {
    std::vector<Parts> parts(size_t(model.triangles.net.triangles()));
    for (Index t = 0; t < model.triangles.net.triangles(); ++t) {
        for (Index k = 0; k < 3; ++k) {
            parts[t].edges[k] = parts_of_edge(model, settings, drawing, 3 * t + k);
            parts[t].triangle = std::max(parts[t].triangle, parts[t].edges[k]);
        }
    }
    return parts;
}

formulas::FoldBlend folds_at(const Settings& settings, const TriangleLists& lists, Index triangle,
                             const Vec3& p, const Vec3& n, float fraction) {
    formulas::FoldBlend blend = formulas::no_folds();
    for (Index r = lists.triangle_start[triangle]; r < lists.triangle_start[triangle + 1]; ++r) {
        for (Index i = lists.ranges[r][0]; i < lists.ranges[r][1]; ++i) {
            blend = formulas::with_fold(
                blend, formulas::fold_height(int(settings.profile), lists.ends[i], lists.ends[i + 1], p), n,
                fraction);
        }
    }
    return blend;
}

}  // namespace

Drawing draw(const Model& model, const Settings& settings, const Input& input, const Pose& pose,
             const State& state) {
    Drawing drawing;
    drawing.lists = build_triangle_lists(model, settings, pose, state);
    const Surface& base = model.base;
    const size_t vertices = size_t(base.welded.vertex_count);
    drawing.flat = pose.base.positions;
    drawing.smooth = drawing.flat;
    drawing.normal = vertex_normals(base, drawing.flat);
    drawing.curved = model.attachments.kind != AttachmentKind::kLinear;
    if (model.attachments.kind == AttachmentKind::kLimit)
        apply<Vec3>(model.vertex_limit, drawing.flat, drawing.smooth);
    for (Index v = 0; v < Index(vertices); ++v) drawing.hem.push_back(hem_weight(model, settings, v));
    drawing.parts = cut(model, settings, drawing);
    for (size_t v = 0; v < base.welded_of.size(); ++v)
        drawing.proxy_offset.push_back(drawing.smooth[base.welded_of[v]] - input.positions[v]);
    return drawing;
}

Drawn drawn_at(const Model& model, const Settings& settings, const Drawing& drawing,
               const SurfacePoint& place) {
    const Surface& base = model.base;
    Vec3 p[3], n[3];
    float hem[3];
    for (Index k = 0; k < 3; ++k) {
        const Index v = model.triangles.net.vertex[3 * place.triangle + k];
        p[k] = drawing.smooth[v];
        n[k] = float(drawing.curved) * drawing.normal[v];
        hem[k] = drawing.hem[v];
    }
    const float fraction = place.interpolate([&](int k) { return hem[k]; });
    const Vec3 flat = interpolate(base, place, drawing.flat),
               outwards = unit_or_zero(interpolate(base, place, drawing.normal), kShortestEdge);
    const formulas::FoldBlend blend =
        folds_at(settings, drawing.lists, place.triangle, flat, outwards, fraction);
    return {pn_triangle(p, n, place.b0, place.b1) + blend.height * outwards,
            formulas::blended_normal(blend, outwards), blend.height};
}

}  // namespace rumple::wrinkle_paths
