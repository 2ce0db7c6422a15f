// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/clearance.h"

#include <algorithm>
#include <cmath>

#include "base/smooth_step.h"
#include "base/solve_team.h"
#include "base/tolerances.h"

namespace rumple {
namespace {

constexpr int kFillSweeps = 24;  // Gauss-Seidel; the interpolation is local (spread), so this is enough

// Shares over which the effect of a body comes and goes, so that the cloth does not jump when a vertex
// crosses a limit: from ClearanceSettings::depth up to this share of it, and from this share of the reach up
// to the reach.
constexpr float kWhollyOut = 0.25f, kFades = 0.7f;

// The clearance that is known at one vertex.
struct Known {
    float value = 0.0f;
    float weight = 0.0f;  // 0: unknown
};

// A bare garment inside the body is moved out to the thickness. Deep parts stay: they are hidden there.
float room_inwards(const ClearanceSettings& settings, float distance) {
    const float out = smooth_step(-settings.depth, -kWhollyOut * settings.depth, distance);
    return out * (distance - settings.thickness);
}

// `length`, or how far inwards a vertex may move where it hangs free, if that is more.
float at_least(float length, std::span<const float> free, size_t v) {
    return free.empty() ? length : std::max(length, free[v]);
}

// Per vertex: the clearance where no body is found.
std::vector<float> clearance_without_bodies(const ClearanceSettings& settings, std::span<const float> free,
                                            size_t vertices) {
    std::vector<float> unknown;
    for (size_t v = 0; v < vertices; ++v) unknown.push_back(at_least(settings.unknown, free, v));
    return unknown;
}

// Searches the body under every vertex, and returns the clearance over it. hints: as in clearance(). under:
// receives Clearance::bodies.
std::vector<Known> search_bodies(const ClearanceModel& model, const ClearanceSettings& settings,
                                 std::span<const Vec3> points, std::span<const Vec3> normals,
                                 std::span<const float> free, const PosedCollider& bodies,
                                 std::span<Index> hints, std::span<BodyContact> under) {
    std::vector<Known> known(points.size());
    for_each_index(points.size(), kLeastSearches, [&](size_t v) {
        if (normals[v] == Vec3(0.0f)) return;  // loose: it has no direction in which to search
        BodyContact& contact = under[v];
        const float reach = at_least(settings.reach, free, v);
        // Cloth that hangs free may meet bodies on which it was not modelled.
        const bool is_free = !free.empty() && free[v] > 0.0f;
        contact = bodies.closest(points[v], normals[v], reach, hints[v], is_free ? nullptr : &model.rest[v]);
        hints[v] = contact.triangle;
        if (contact.triangle == kNone) return;
        // The weight decreases towards the limit of the reach.
        const auto fading = [&](float farthest) {
            return contact.weight * (1.0f - smooth_step(kFades, 1.0f, std::abs(contact.distance) / farthest));
        };
        known[v] = {room_inwards(settings, contact.distance), fading(reach)};
        contact.weight = fading(settings.reach);
    });
    return known;
}

// The share of the vertices on faces that have a body under them.
float share_known(std::span<const Known> known, std::span<const Vec3> normals) {
    const auto found = std::ranges::count_if(known, [](const Known& k) { return k.weight > 0.0f; });
    const auto loose = std::ranges::count(normals, Vec3(0.0f));
    return float(found) / float(std::max<std::ptrdiff_t>(std::ptrdiff_t(known.size()) - loose, 1));
}

// Minimises sum_sides (c_i - c_j)^2 / l^2 + sum_i (c_i - unknown_i)^2 / spread^2 by Gauss-Seidel sweeps.
// Known values have a much larger weight.
void interpolate_clearance(const ClearanceModel& model, float spread, std::span<const float> unknown,
                           std::span<const Known> known, std::span<float> c) {
    const float pull = 1.0f / (spread * spread);
    for (int sweep = 0; sweep < kFillSweeps; ++sweep) {
        for (size_t step = 0; step < c.size(); ++step) {
            const size_t v = sweep % 2 ? c.size() - 1 - step : step;
            if (known[v].weight >= 1.0f) continue;
            float sum = pull * unknown[v], total = pull, sides = 0.0f;
            for (Index k = model.start[v]; k < model.start[v + 1]; ++k) {
                sum += model.inverse_square[k] * c[model.neighbour[k]];
                sides += model.inverse_square[k];
            }
            total += sides;
            const float weight = known[v].weight / std::max(1.0f - known[v].weight, kZeroWeight) * total;
            c[v] = (sum + weight * known[v].value) / (total + weight);
        }
    }
}

}  // namespace

ClearanceModel build_clearance(const Surface& surface) {
    std::vector<std::vector<std::pair<Index, float>>> around(surface.welded.vertex_count);
    for (const Edge& edge : surface.edges) {
        const float length = std::max(
            glm::distance(surface.positions_rest[edge.a], surface.positions_rest[edge.b]), kShortestEdge);
        around[edge.a].push_back({edge.b, 1.0f / (length * length)});
        around[edge.b].push_back({edge.a, 1.0f / (length * length)});
    }
    ClearanceModel model;
    model.rest = surface.positions_rest;
    for (const auto& sides : around) {
        for (const auto& [neighbour, inverse_square] : sides) {
            model.neighbour.push_back(neighbour);
            model.inverse_square.push_back(inverse_square);
        }
        model.start.push_back(static_cast<Index>(model.neighbour.size()));
    }
    return model;
}

Clearance clearance(const ClearanceModel& model, const ClearanceSettings& settings,
                    std::span<const Vec3> surface_points, std::span<const Vec3> normals,
                    std::span<const float> free, const PosedCollider* bodies, std::vector<Index>& hints) {
    const size_t vertices = surface_points.size();
    const std::vector<float> unknown = clearance_without_bodies(settings, free, vertices);
    Clearance clearance;
    clearance.inwards = unknown;
    if (!bodies) {
        hints.clear();
        return clearance;
    }
    hints.resize(vertices, kNone);
    clearance.bodies.resize(vertices);
    const std::vector<Known> known =
        search_bodies(model, settings, surface_points, normals, free, *bodies, hints, clearance.bodies);
    clearance.known = share_known(known, normals);
    for (size_t v = 0; v < vertices; ++v)
        clearance.inwards[v] = glm::mix(unknown[v], known[v].value, known[v].weight);
    interpolate_clearance(model, settings.spread, unknown, known, clearance.inwards);
    return clearance;
}

}  // namespace rumple
