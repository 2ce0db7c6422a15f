// SPDX-License-Identifier: GPL-3.0-or-later
// Work at all vertices, and what several files of the Wrinkle Field need. Internal to wrinkle_field.
#pragma once

#include <algorithm>
#include <glm/gtc/noise.hpp>

#include "base/random.h"
#include "base/solve_team.h"
#include "systems/wrinkle_field/wrinkle_field.h"

namespace rumple::wrinkle_field {

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

// act(first, count) for every four vertices and for the rest, as for_each_four(), on all threads.
template <typename Act>
void for_each_four_vertices(const Settings& settings, size_t vertices, Act&& act) {
    const SolveTeam team(settings.threads, vertices, kVerticesForThreads);
    for_each_four_shared(vertices, act);
}

// work(v) for every vertex, on all threads.
template <typename Work>
void for_each_vertex(const Settings& settings, size_t vertices, Work&& work) {
    const SolveTeam team(settings.threads, vertices, kVerticesForThreads);
    for_each_index(vertices, kLeastSteps, work);
}

}  // namespace rumple::wrinkle_field
