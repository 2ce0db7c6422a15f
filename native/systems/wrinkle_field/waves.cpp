// SPDX-License-Identifier: GPL-3.0-or-later
// Section 4 of Loviscach 2006, "Crush": the wave of every vertex, without its phase.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <string>

#include "base/elementary.h"
#include "base/expect.h"
#include "systems/wrinkle_field/frames.h"
#include "systems/wrinkle_field/wrinkle_field.h"

namespace rumple::wrinkle_field {
namespace {

// For irregularity = 1: largest rotation of k in radians, and largest relative change of W.
constexpr float kMostTurn = 0.8f;
constexpr float kMostWavelengthChange = 0.4f;
// The distance over which the irregularity changes / wavelength.
constexpr float kIrregularityScale = 2.0f;

void check_paint(const Model& model, const Paint& paint) {
    const size_t vertices = model.base.welded_of.size();
    const auto fits = [&](const char* name, const std::vector<float>& values, double low) {
        if (values.empty()) return;
        expect_count(name, values.size(), vertices, "vertices");
        expect_each_within(name, values, low, kMostPainted, "vertex");
    };
    fits("mask", paint.mask, 0.0);
    fits("wavelength", paint.wavelength, kLeastPaintedWavelength);
    if (!paint.rest_wrinkle.empty()) check_rest_wrinkle(model, paint.rest_wrinkle);
    if (!paint.along.empty()) check_along(model.base, paint.along);
}

// Values of the welded vertices: the mean over their display vertices.
template <typename T>
std::vector<T> welded_values(const Surface& surface, const std::vector<T>& display, T unpainted) {
    std::vector<T> sum(surface.welded.vertex_count, display.empty() ? unpainted : T{});
    if (display.empty()) return sum;
    std::vector<float> count(sum.size(), 0.0f);
    for (size_t v = 0; v < display.size(); ++v) {
        sum[surface.welded_of[v]] += display[v];
        count[surface.welded_of[v]] += 1.0f;
    }
    for (size_t w = 0; w < sum.size(); ++w) sum[w] /= count[w];
    return sum;
}

// The effect of irregularity on a vertex's wave: seeded noise over the rest pose.
struct Disturbance {
    Vec2 turn{1.0f, 0.0f};    // (cos, sin)
    float wavelength = 1.0f;  // factor on W
};

Disturbance disturb(const Settings& settings, const Vec3& rest) {
    if (settings.irregularity <= 0.0f) return {};
    const Vec3 place = rest / (kIrregularityScale * settings.wavelength);
    const auto noise_at = [&](std::uint32_t which) {
        return settings.irregularity * smooth_noise(place, settings.seed, which);
    };
    const float angle = kMostTurn * noise_at(0);
    return {{elementary::cos(angle), elementary::sin(angle)}, 1.0f + kMostWavelengthChange * noise_at(1)};
}

// before, stretches: as in estimate_waves().
void check_before(const Model& model, std::span<const Vec2> before, std::span<const Vec3> stretches) {
    const size_t vertices = model.base.positions_rest.size();
    if (!before.empty()) expect_count("directions", before.size(), vertices, "welded vertices");
    if (!stretches.empty()) expect_count("stretches", stretches.size(), vertices, "welded vertices");
    expect_finite("stretches", stretches, "welded vertex");
}

// The pose without any wave.
Waves flat_waves(const Pose& pose) {
    const size_t vertices = pose.positions.size();
    Waves waves;
    waves.positions = pose.positions;
    waves.normals = pose.normals;
    waves.wave_vector.assign(vertices, Vec3(0.0f));
    waves.height.assign(vertices, 0.0f);
    waves.fullness.assign(vertices, 0.0f);
    waves.compression.assign(vertices, 1.0f);
    waves.gather.assign(vertices, 1.0f);
    waves.direction.assign(vertices, Vec2(1.0f, 0.0f));
    return waves;
}

// The line along which crests are painted at a vertex, rest frame; zero where nothing is painted.
Vec2 painted_line(const Model& model, const Paint& paint, size_t v) {
    if (paint.along.empty()) return Vec2(0.0f);
    return in_rest_frame(model, v, paint.along[model.base.representative[v]]);
}

// The share of a vertex's wave for which bends beside it leave place. across: from crest to crest, object
// space. Painted wrinkles are kept. q, along: the painted rest wrinkle and line of the vertex.
float share_with_place(std::span<const SpareCloth> spare, size_t v, const Vec3& across, const Vec2& q,
                       const Vec2& along) {
    if (spare.empty() || across == Vec3(0.0f)) return 1.0f;
    const float painted = std::min(std::max(glm::length(q), glm::length(along)), 1.0f);
    return 1.0f - (1.0f - painted) * spare[v].share_without_place(across);
}

}  // namespace

void check_rest_wrinkle(const Model& model, std::span<const Vec3> painted) {
    expect_count("rest_wrinkle", painted.size(), model.base.welded_of.size(), "vertices");
    expect_finite("rest_wrinkle", painted, "vertex");
    for (size_t v = 0; v < painted.size(); ++v) {
        const float length = glm::length(painted[v]);
        if (length < 1.0f) continue;
        throw InvalidInput("rest_wrinkle: vertex " + std::to_string(v) + " has length " + short_text(length) +
                           ", expected below 1");
    }
}

WaveParameters wave_parameters(const Model& model, const Settings& settings, const Paint& paint) {
    check(settings);
    check_paint(model, paint);
    WaveParameters out{welded_values(model.base, paint.wavelength, 1.0f),
                       welded_values(model.base, paint.mask, 1.0f),
                       {},
                       {}};
    const std::vector<Vec3> painted = welded_values(model.base, paint.rest_wrinkle, Vec3(0.0f));
    out.rest_wrinkle.resize(painted.size());
    out.turn.resize(painted.size());
    for_each_vertex(settings, painted.size(), [&](size_t v) {
        const Disturbance disturbance = disturb(settings, model.base.positions_rest[v]);
        out.wavelength[v] *= settings.wavelength * disturbance.wavelength;
        out.turn[v] = disturbance.turn;
        out.rest_wrinkle[v] = in_rest_frame(model, v, painted[v]);
    });
    return out;
}

std::vector<Vec2> first_directions(const Model& model) {
    const Vec3 somewhere(0.8660f, 0.4113f, 0.2847f);  // not along any axis that garments are modelled along
    std::vector<Vec2> directions;
    for (size_t v = 0; v < model.tangent_rest.size(); ++v) {
        const Vec2 k = in_rest_frame(model, v, somewhere);
        const float length = glm::length(k);
        directions.push_back(length > 0.0f ? k / length : Vec2(1.0f, 0.0f));
    }
    return directions;
}

Waves estimate_waves(const Model& model, const Settings& settings, const Paint& paint,
                     std::span<const Vec3> positions, std::span<const Vec2> before,
                     std::span<const Vec3> stretches) {
    return estimate_waves(model, settings, paint, make_pose(model, positions), before, stretches);
}

Waves estimate_waves(const Model& model, const Settings& settings, const Paint& paint, const Pose& pose,
                     std::span<const Vec2> before, std::span<const Vec3> stretches) {
    const WaveParameters parameters = wave_parameters(model, settings, paint);
    assert(pose.around.size() == model.base.positions_rest.size());
    check_before(model, before, stretches);
    const std::vector<Vec2> first = before.empty() ? first_directions(model) : std::vector<Vec2>();
    if (before.empty()) before = first;
    std::vector<SpareCloth> spare;
    if (settings.bend_radius > 0.0f)
        spare = spare_cloth(model.base, model.bent_lines, pose.positions, settings.bend_radius);
    Waves waves = flat_waves(pose);
    for_each_vertex(settings, pose.positions.size(), [&](size_t v) {
        const std::optional<Neighbourhood>& around = pose.around[v];
        if (!around) return;
        const glm::mat2 m = stretches.empty() ? around->m : formulas::restretched(around->m, stretches[v]);
        const Vec2 &q = parameters.rest_wrinkle[v], &turn = parameters.turn[v];
        formulas::WaveEstimate estimate =
            formulas::estimate_wave(m, q, before[v], turn, settings.buckling_threshold);
        float gather = glm::length(estimate.k_deformed);
        const Vec2 along = painted_line(model, paint, v);
        if (along != Vec2(0.0f))
            turn_along(along, m, q, before[v], turn, settings.buckling_threshold, estimate, gather);
        const float w = parameters.wavelength[v];
        const Vec3 across =
            estimate.k_deformed.x * around->tangent + estimate.k_deformed.y * around->bitangent;
        waves.compression[v] = estimate.r;
        waves.direction[v] = estimate.k;
        if (estimate.fullness > 0.0f) waves.gather[v] = gather;
        waves.fullness[v] =
            estimate.fullness * parameters.mask[v] * share_with_place(spare, v, across, q, along);
        waves.height[v] = 0.25f * w * settings.strength * waves.fullness[v];  // equation (2)
        waves.wave_vector[v] = (formulas::kTwoPi / w) * across;
    });
    return waves;
}

}  // namespace rumple::wrinkle_field
