// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/cover.h"

#include <algorithm>

#include "base/expect.h"
#include "base/smooth_step.h"
#include "base/tolerances.h"
#include "surface/mesh/positions.h"
#include "surface/output/shown_mesh.h"

namespace rumple {
namespace {

constexpr int kPasses = 2;

// Unit: thicknesses. A border of a body this far above a tested point does not lift it; half as far it does.
constexpr float kFarAbove = 2.0f;

// The search distance. A body outside of the cloth, farther away than the thickness, lifts nothing.
float reach(const CoverSettings& settings) {
    return settings.depth + settings.thickness;
}

// Half of the longest side of a triangle: as far from a sample nothing else of it is tested.
float half_side(const std::array<Index, 3>& corners, std::span<const Vec3> positions) {
    const auto& [a, b, c] = corners;
    return 0.5f *
           std::max({glm::distance(positions[a], positions[b]), glm::distance(positions[b], positions[c]),
                     glm::distance(positions[c], positions[a])});
}

// How far a point of the surface must move outwards. spacing: distance of the next tested points.
float lift_of(const CoverSettings& settings, const PosedCollider& bodies, const Vec3& point,
              const Vec3& normal, const Vec3& rest, Index hint, float spacing) {
    const float length = glm::length(normal);
    if (length < kShortestNormal) return 0.0f;
    const BodyContact body = bodies.closest_around(point, normal / length, reach(settings), hint, rest);
    if (body.triangle == kNone || body.distance < -settings.depth) return 0.0f;
    const float lift = settings.thickness - body.distance;
    // The border of a body that is deleted under the cloth must stay below the surface between the samples.
    // Where it is far above a sample, as in an armpit, the cloth passes beside it.
    if (body.border) {
        const float far = kFarAbove * std::max(settings.thickness, kShortestEdge);
        const float share = smooth_step(-far, -0.5f * far, body.distance);
        return share * std::max(lift - std::max(body.beside - spacing, 0.0f), 0.0f);
    }
    return body.weight * std::max(lift, 0.0f);
}

// Per sample of the surface: how far it must move outwards. before: the lift of every vertex in the pass
// before. A triangle that did not move then needs no more lift, so it is left out.
std::vector<float> lifts_of_samples(const Surface& surface, const CoverModel& model,
                                    const CoverSettings& settings, const PosedCollider& bodies,
                                    std::span<const Vec3> at, std::span<const Vec3> points,
                                    std::span<const Vec3> normals, std::span<const float> before,
                                    std::span<const Index> hints) {
    std::vector<float> lift(points.size(), 0.0f);
    for_each_index(points.size(), kLeastSearches, [&](size_t s) {
        const SurfacePoint& place = model.samples.places[s];
        if (place.triangle == kNone) return;
        const std::array<Index, 3> corners = welded_vertices(surface, place.triangle);
        if (before[corners[0]] + before[corners[1]] + before[corners[2]] == 0.0f) return;
        const Index hint = hint_at(surface, place.triangle, hints);
        if (hint == kNone) return;
        lift[s] = lift_of(settings, bodies, points[s], interpolate(surface, place, normals),
                          interpolate(surface, place, surface.positions_rest), hint, half_side(corners, at));
    });
    return lift;
}

// Per vertex: the largest lift of the samples around it.
std::vector<float> lifts_of_vertices(const Surface& surface, const CoverModel& model,
                                     std::span<const float> of_samples) {
    std::vector<float> lift(surface.welded.vertex_count, 0.0f);
    for (size_t s = 0; s < of_samples.size(); ++s) {
        if (of_samples[s] == 0.0f) continue;
        const SurfacePoint& place = model.samples.places[s];
        const std::array<Index, 3> corners = welded_vertices(surface, place.triangle);
        const std::array<float, 3> weights = place.weights();
        for (int k = 0; k < 3; ++k)
            if (weights[k] > kLeastWeight) lift[corners[k]] = std::max(lift[corners[k]], of_samples[s]);
    }
    return lift;
}

}  // namespace

CoverModel build_cover(const Surface& surface) {
    FineSource source;
    source.level = 1;
    return {attach_refined(surface, source, refine(surface, source), AttachmentKind::kLimit)};
}

std::vector<Vec3> lifts_over(const Surface& surface, const CoverModel& model, const CoverSettings& settings,
                             const PosedCollider& bodies, std::span<const Vec3> positions,
                             std::span<const Index> hints) {
    expect_within("thickness", settings.thickness, 0.0, 1e9);
    expect_within("depth", settings.depth, 1e-9, 1e9);
    check_frame(surface, positions);
    expect_count("hints", hints.size(), surface.display.vertex_count, "values");
    const size_t vertices = surface.welded.vertex_count, samples = model.samples.places.size();
    const SolveTeam team(0, samples, kLeastSearches);
    std::vector<Vec3> at = weld_positions(surface, positions), normals(vertices), points(samples);
    std::vector<Vec3> lifts(positions.size(), Vec3(0.0f));
    std::vector<float> lift(vertices, 1.0f);  // not 0: the first pass leaves out no triangle
    for (int pass = 0; pass < kPasses; ++pass) {
        vertex_normals(surface, at, normals);
        attach(surface, model.samples, at, normals, points);
        lift = lifts_of_vertices(
            surface, model,
            lifts_of_samples(surface, model, settings, bodies, at, points, normals, lift, hints));
        for (size_t v = 0; v < vertices; ++v) at[v] += lift[v] * normals[v];
        for (size_t v = 0; v < lifts.size(); ++v)
            lifts[v] += lift[surface.welded_of[v]] * normals[surface.welded_of[v]];
    }
    return lifts;
}

}  // namespace rumple
