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

// What the waves of a frame depend on beside its pose.
struct Crush {
    const Model& model;
    const Settings& settings;
    const Paint& paint;
    const WaveParameters& parameters;
    std::span<const Vec2> before;
    std::span<const Vec3> stretches;
    std::span<const SpareCloth> spare;
};

// The waves of four vertices.
struct FourWaves {
    lane_formulas::WaveEstimate estimate;
    Lanes gather;      // |k'|
    Vec3Lanes across;  // k' in object space
};

// turn_along() where lines are painted. m, last: M and the direction before.
void turn_along_lines(const Crush& crush, size_t first, size_t how_many, const lane_formulas::mat2& m,
                      const Vec2Lanes& last, FourWaves& waves) {
    for (size_t lane = 0; lane < how_many; ++lane) {
        const size_t v = first + lane;
        const Vec2 along = painted_line(crush.model, crush.paint, v);
        if (along == Vec2(0.0f)) continue;
        formulas::WaveEstimate estimate = at_lane(waves.estimate, int(lane));
        float gather = waves.gather[lane];
        turn_along(along, at_lane(m, int(lane)), crush.parameters.rest_wrinkle[v], last.at(int(lane)),
                   crush.parameters.turn[v], crush.settings.buckling_threshold, estimate, gather);
        set_lane(waves.estimate, int(lane), estimate);
        waves.gather[lane] = gather;
    }
}

FourWaves estimate_four(const Crush& crush, const Neighbourhoods& around, size_t first, auto how_many) {
    const Vec2Lanes q = load_lanes(&crush.parameters.rest_wrinkle[first], how_many),
                    turn = load_lanes(&crush.parameters.turn[first], how_many),
                    last = load_lanes(&crush.before[first], how_many);
    lane_formulas::mat2 m = around.m;
    if (!crush.stretches.empty())
        m = lane_formulas::restretched(m, load_lanes(&crush.stretches[first], how_many));
    FourWaves out;
    out.estimate = lane_formulas::estimate_wave(m, q, last, turn, crush.settings.buckling_threshold);
    out.gather = lane_formulas::length(out.estimate.k_deformed);
    if (!crush.paint.along.empty()) turn_along_lines(crush, first, how_many, m, last, out);
    out.across = out.estimate.k_deformed.x * around.tangent + out.estimate.k_deformed.y * around.bitangent;
    return out;
}

// share_with_place() of four vertices.
Lanes shares_with_place(const Crush& crush, size_t first, size_t how_many, const Vec3Lanes& across) {
    Lanes share = all_lanes(1.0f);
    if (crush.spare.empty()) return share;
    for (size_t lane = 0; lane < how_many; ++lane) {
        const size_t v = first + lane;
        share[lane] = share_with_place(crush.spare, v, across.at(int(lane)), crush.parameters.rest_wrinkle[v],
                                       painted_line(crush.model, crush.paint, v));
    }
    return share;
}

// Where vertices have no neighbourhood the pose stays without a wave.
void crush_four(const Crush& crush, const Neighbourhoods& around, size_t first, auto how_many, Waves& waves) {
    const FourWaves four = estimate_four(crush, around, first, how_many);
    const Lanes w = load_lanes(&crush.parameters.wavelength[first], how_many),
                mask = load_lanes(&crush.parameters.mask[first], how_many),
                share = shares_with_place(crush, first, how_many, four.across),
                fullness = around.exist ? four.estimate.fullness * mask * share : 0.0f;
    const auto store = [&](const auto& value, auto& to) { store_lanes(value, &to[first], how_many); };
    store(fullness, waves.fullness);
    store(0.25f * w * crush.settings.strength * fullness, waves.height);  // equation (2)
    store(around.exist ? four.estimate.r : 1.0f, waves.compression);
    store((around.exist & (four.estimate.fullness > 0.0f)) ? four.gather : 1.0f, waves.gather);
    store(lane_formulas::chosen(around.exist, four.estimate.k, {1.0f, 0.0f}), waves.direction);
    store(choose(around.exist, (formulas::kTwoPi / w) * four.across, Vec3Lanes()), waves.wave_vector);
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
                       std::vector<Vec2>(model.tangent_rest.size(), Vec2(0.0f)),
                       std::vector<Vec2>(model.tangent_rest.size())};
    for_each_vertex(settings, out.turn.size(), [&](size_t v) {
        const Disturbance disturbance = disturb(settings, model.base.positions_rest[v]);
        out.wavelength[v] *= settings.wavelength * disturbance.wavelength;
        out.turn[v] = disturbance.turn;
    });
    if (paint.rest_wrinkle.empty()) return out;
    const std::vector<Vec3> painted = welded_values(model.base, paint.rest_wrinkle, Vec3(0.0f));
    for (size_t v = 0; v < painted.size(); ++v) out.rest_wrinkle[v] = in_rest_frame(model, v, painted[v]);
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
    assert(pose.around.size() == model.columns.count.size());
    check_before(model, before, stretches);
    const std::vector<Vec2> start = before.empty() ? first_directions(model) : std::vector<Vec2>();
    if (before.empty()) before = start;
    std::vector<SpareCloth> spare;
    if (settings.bend_radius > 0.0f)
        spare = spare_cloth(model.base, model.bent_lines, pose.positions, settings.bend_radius);
    const size_t vertices = pose.positions.size();
    Waves waves{pose.positions,
                pose.normals,
                std::vector<Vec3>(vertices),
                std::vector<float>(vertices),
                std::vector<float>(vertices),
                std::vector<float>(vertices),
                std::vector<float>(vertices),
                std::vector<Vec2>(vertices)};
    const Crush crush{model, settings, paint, parameters, before, stretches, spare};
    for_each_four_vertices(settings, vertices, [&](size_t first, auto how_many) {
        crush_four(crush, pose.around[first / kLanes], first, how_many, waves);
    });
    return waves;
}

}  // namespace rumple::wrinkle_field
