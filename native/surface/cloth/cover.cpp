// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/cover.h"

#include <algorithm>
#include <limits>

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

// A point of the surface, or all points around a vertex.
struct Clearance {
    float lift = 0.0f;                                    // how far it must move outwards
    float room = std::numeric_limits<float>::infinity();  // how far it may move inwards
};

// spacing: distance of the next tested points.
Clearance clearance_of(const CoverSettings& settings, const PosedCollider& bodies, const Vec3& point,
                       const Vec3& normal, const Vec3& rest, Index hint, float spacing) {
    const float length = glm::length(normal);
    if (length < kShortestNormal) return {};
    const BodyContact body = bodies.closest_around(point, normal / length, reach(settings), hint, rest);
    if (body.triangle == kNone || body.distance < -settings.depth) return {};
    const float lift = settings.thickness - body.distance;
    const float room = std::max(-lift, 0.0f);
    // The border of a body that is deleted under the cloth must stay below the surface between the samples.
    // Where it is far above a sample, as in an armpit, the cloth passes beside it.
    if (body.border) {
        const float far = kFarAbove * std::max(settings.thickness, kShortestEdge);
        const float share = smooth_step(-far, -0.5f * far, body.distance);
        return {share * std::max(lift - std::max(body.beside - spacing, 0.0f), 0.0f), room};
    }
    if (body.weight <= 0.0f) return {};
    return {body.weight * std::max(lift, 0.0f), room};
}

// before: the lift of every vertex in the pass before. A triangle that did not move then needs no more lift,
// so it is left out.
std::vector<Clearance> clearance_of_samples(const Surface& surface, const CoverModel& model,
                                            const CoverSettings& settings, const PosedCollider& bodies,
                                            std::span<const Vec3> at, std::span<const Vec3> points,
                                            std::span<const Vec3> normals, std::span<const float> before,
                                            std::span<const Index> hints) {
    std::vector<Clearance> found(points.size());
    for_each_index(points.size(), kLeastSearches, [&](size_t s) {
        const SurfacePoint& place = model.samples.places[s];
        if (place.triangle == kNone) return;
        const std::array<Index, 3> corners = welded_vertices(surface, place.triangle);
        if (before[corners[0]] + before[corners[1]] + before[corners[2]] == 0.0f) return;
        const Index hint = hint_at(surface, place.triangle, hints);
        if (hint == kNone) return;
        found[s] =
            clearance_of(settings, bodies, points[s], interpolate(surface, place, normals),
                         interpolate(surface, place, surface.positions_rest), hint, half_side(corners, at));
    });
    return found;
}

// Sets every vertex's lift to the largest one of the samples around it. Lowers its room to their least one.
void spread_to_vertices(const Surface& surface, const CoverModel& model,
                        std::span<const Clearance> of_samples, std::vector<float>& lift,
                        std::vector<float>& room) {
    std::ranges::fill(lift, 0.0f);
    for (size_t s = 0; s < of_samples.size(); ++s) {
        const SurfacePoint& place = model.samples.places[s];
        if (place.triangle == kNone) continue;
        const std::array<Index, 3> corners = welded_vertices(surface, place.triangle);
        const std::array<float, 3> weights = place.weights();
        for (int k = 0; k < 3; ++k) {
            if (weights[k] <= kLeastWeight) continue;
            lift[corners[k]] = std::max(lift[corners[k]], of_samples[s].lift);
            room[corners[k]] = std::min(room[corners[k]], of_samples[s].room);
        }
    }
}

}  // namespace

CoverModel build_cover(const Surface& surface) {
    FineSource source;
    source.level = 1;
    return {attach_refined(surface, source, refine(surface, source), AttachmentKind::kLimit)};
}

Cover cover_over(const Surface& surface, const CoverModel& model, const CoverSettings& settings,
                 const PosedCollider& bodies, std::span<const Vec3> positions, std::span<const Index> hints) {
    expect_within("thickness", settings.thickness, 0.0, 1e9);
    expect_within("depth", settings.depth, 1e-9, 1e9);
    check_frame(surface, positions);
    expect_count("hints", hints.size(), surface.display.vertex_count, "values");
    const size_t vertices = surface.welded.vertex_count, samples = model.samples.places.size();
    const SolveTeam team(0, samples, kLeastSearches);
    std::vector<Vec3> at = weld_positions(surface, positions), normals(vertices), points(samples);
    std::vector<float> lift(vertices, 1.0f);  // not 0: the first pass leaves out no triangle
    std::vector<float> room(vertices, kFarthestCoordinate);
    Cover out{std::vector<Vec3>(positions.size(), Vec3(0.0f)), {}};
    for (int pass = 0; pass < kPasses; ++pass) {
        vertex_normals(surface, at, normals);
        attach(surface, model.samples, at, normals, points);
        const std::vector<Clearance> found =
            clearance_of_samples(surface, model, settings, bodies, at, points, normals, lift, hints);
        spread_to_vertices(surface, model, found, lift, room);
        for (size_t v = 0; v < vertices; ++v) at[v] += lift[v] * normals[v];
        for (size_t v = 0; v < out.lifts.size(); ++v)
            out.lifts[v] += lift[surface.welded_of[v]] * normals[surface.welded_of[v]];
    }
    for (const Index welded : surface.welded_of) out.room.push_back(room[welded]);
    return out;
}

}  // namespace rumple
