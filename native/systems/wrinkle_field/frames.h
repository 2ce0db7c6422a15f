// SPDX-License-Identifier: GPL-3.0-or-later
// Equation (1) at one vertex of a pose, and work at all vertices. Internal to wrinkle_field.
#pragma once

#include <algorithm>
#include <glm/gtc/noise.hpp>
#include <optional>

#include "base/random.h"
#include "base/solve_team.h"
#include "systems/wrinkle_field/wrinkle_field.h"

namespace rumple::wrinkle_field {

// positions: of the welded vertices, deformed. normal: of the vertex there. None without a normal, in this
// pose or at rest.
inline std::optional<Neighbourhood> regress(const Model& model, std::span<const Vec3> positions,
                                            const Vec3& normal, size_t v) {
    if (normal == Vec3(0.0f) || model.tangent_rest[v] == Vec3(0.0f)) return {};
    const Index begin = model.neighbour_start[v], end = model.neighbour_start[v + 1];
    const Vec3 t =
        formulas::tangent_towards(positions[model.neighbours[begin].vertex] - positions[v], normal);
    Neighbourhood out{t, glm::cross(normal, t), glm::mat2(0.0f)};
    for (Index i = begin; i < end; ++i) {
        const Model::Neighbour& n = model.neighbours[i];
        const Vec3 displacement = positions[n.vertex] - positions[v];
        out.m += glm::outerProduct(
            formulas::tangent_space(displacement, out.tangent, out.bitangent, model.true_lengths),
            n.gradient);
    }
    return out;
}

// A vector of rest space, along the tangent and the bitangent of a vertex at rest.
inline Vec2 in_rest_frame(const Model& model, size_t v, const Vec3& way) {
    return {glm::dot(model.tangent_rest[v], way), glm::dot(model.bitangent_rest[v], way)};
}

// A smooth random function of the place, -1..1. which: number of the function; those of one seed are
// independent.
inline float smooth_noise(const Vec3& place, std::uint32_t seed, std::uint32_t which) {
    const Vec3 elsewhere(noise(seed, 3 * which), noise(seed, 3 * which + 1), noise(seed, 3 * which + 2));
    return glm::simplex(place + 100.0f * elsewhere);
}

// Changes an estimated wave so that its crests are along a painted line of the rest frame. It gets the
// largest compression, but across this line. Its wavelength in the rest pose stays W. m, q, before, turn,
// threshold: as for formulas::estimate_wave(). gather: its Waves::gather.
void turn_along(const Vec2& along, const glm::mat2& m, const Vec2& q, const Vec2& before, const Vec2& turn,
                float threshold, formulas::WaveEstimate& estimate, float& gather);

// Below this number of vertices one thread is faster: a round takes only some hundred microseconds.
inline constexpr size_t kVerticesForThreads = 50'000;

inline int threads_for(const Settings& settings, size_t vertices) {
    return choose_threads(settings.threads, vertices, kVerticesForThreads, kMostThreads);
}

// work(v) for every vertex, on all threads.
template <typename Work>
void for_each_vertex(const Settings& settings, size_t vertices, Work&& work) {
    const SolveTeam team(settings.threads, vertices, kVerticesForThreads);
    for_each_index(vertices, kLeastSteps, work);
}

}  // namespace rumple::wrinkle_field
