// SPDX-License-Identifier: GPL-3.0-or-later
// Sections 4 and 5 of Loviscach 2006: "Crush" (estimate_waves) and "Relax".
#include <algorithm>
#include <cassert>
#include <cmath>
#include <complex>
#include <limits>
#include <utility>

#include "base/elementary.h"
#include "base/expect.h"
#include "base/parallel.h"
#include "base/tolerances.h"
#include "systems/wrinkle_field/frames.h"
#include "systems/wrinkle_field/wrinkle_field.h"

namespace rumple::wrinkle_field {
namespace {

using formulas::Link;

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

// A neighbour in relaxation.
struct Pull {
    Index vertex;
    float weight;  // attenuation of the neighbour's amplitude
    Link link;
};

// In the same order as model.neighbours.
std::vector<Pull> collect_pulls(const Model& model, const Settings& settings, const Waves& waves) {
    std::vector<Pull> pulls(model.neighbours.size());
    for_each_vertex(settings, waves.height.size(), [&](size_t v) {
        for (Index i = model.neighbour_start[v]; i < model.neighbour_start[v + 1]; ++i) {
            const Index n = model.neighbours[i].vertex;
            pulls[i] = {n, formulas::attenuation(waves.fullness[n]),
                        formulas::link_waves(waves.wave_vector[v], waves.wave_vector[n],
                                             waves.positions[n] - waves.positions[v])};
        }
    });
    return pulls;
}

std::span<const Pull> pulls_of(const Model& model, std::span<const Pull> pulls, size_t v) {
    return pulls.subspan(model.neighbour_start[v], model.neighbour_start[v + 1] - model.neighbour_start[v]);
}

// The share of a round that every vertex takes. It is 0 if the links to the waves around it are the same as
// in its last relaxation, so that a standing leg does not change when the arm moves. Updates solved_offset
// for relaxed links.
std::vector<float> activity(const Model& model, std::span<const Pull> pulls, std::span<float> solved_offset) {
    std::vector<float> active(model.base.positions_rest.size(), 0.0f);
    for (size_t v = 0; v < active.size(); ++v) {
        for (Index i = model.neighbour_start[v]; i < model.neighbour_start[v + 1]; ++i) {
            if (pulls[i].weight <= 0.0f) continue;
            const float act = formulas::activity(pulls[i].link.offset - solved_offset[i]);
            active[v] = std::max(active[v], act);
            if (act > 0.0f) solved_offset[i] = pulls[i].link.offset;
        }
    }
    return active;
}

float misfit_of(const Model& model, const Waves& waves, std::span<const Pull> pulls,
                std::span<const float> phase) {
    double sum = 0.0, weights = 0.0;
    for (size_t v = 0; v < phase.size(); ++v) {
        const double own = formulas::attenuation(waves.fullness[v]);
        for (const Pull& pull : pulls_of(model, pulls, v)) {
            const double error = formulas::misfit(pull.link, phase[v], phase[pull.vertex]);
            sum += own * pull.weight * error * error;
            weights += own * pull.weight;
        }
    }
    return weights > 0.0 ? static_cast<float>(std::sqrt(sum / weights)) : 0.0f;
}

// Runs `rounds` rounds of step(v, from) -> new value for all vertices, from one buffer into another.
template <typename T, typename Step>
void ping_pong(const Settings& settings, int rounds, std::vector<T>& values, Step&& step) {
    std::vector<T> buffers[2] = {std::move(values), {}};
    buffers[1].resize(buffers[0].size());
    Team team(threads_for(settings, buffers[0].size()));
    team.run([&](int thread) {
        const Team::Range part = team.partition(0, buffers[0].size(), thread);
        for (int round = 0; round < rounds; ++round) {
            const std::vector<T>& from = buffers[round % 2];
            for (size_t v = part.begin; v < part.end; ++v) buffers[1 - round % 2][v] = step(v, from);
            team.barrier();
        }
    });
    values = std::move(buffers[rounds % 2]);
}

float largest_change(const Waves& waves, std::span<const float> before, std::span<const float> after) {
    float largest = 0.0f;
    for (size_t v = 0; v < after.size(); ++v) {
        if (formulas::attenuation(waves.fullness[v]) <= 0.0f) continue;
        largest = std::max(largest, std::abs(formulas::wrapped(after[v] - before[v])));
    }
    return largest;
}

void align_phases(const Model& model, const Settings& settings, std::span<const Pull> pulls, int rounds,
                  std::vector<float>& phase) {
    using Complex = std::complex<double>;  // double precision, because the length may shrink in every round
    const auto wave_of = [](double angle) { return Complex(elementary::cos(angle), elementary::sin(angle)); };
    std::vector<Complex> asked(pulls.size()), waves_at(phase.size());
    for (size_t i = 0; i < pulls.size(); ++i)
        asked[i] = double(pulls[i].weight) * wave_of(double(pulls[i].link.offset));
    for (size_t v = 0; v < phase.size(); ++v) waves_at[v] = wave_of(double(phase[v]));
    ping_pong(settings, rounds, waves_at, [&](size_t v, const std::vector<Complex>& from) {
        Complex sum = from[v];
        double weights = 1.0;
        for (Index i = model.neighbour_start[v]; i < model.neighbour_start[v + 1]; ++i) {
            const Complex other = from[pulls[i].vertex];
            sum += asked[i] * (pulls[i].link.flip < 0.0f ? std::conj(other) : other);
            weights += pulls[i].weight;
        }
        return sum / weights;
    });
    for (size_t v = 0; v < phase.size(); ++v) {
        const Complex& wave = waves_at[v];
        if (wave != Complex())
            phase[v] = formulas::wrapped(static_cast<float>(elementary::atan2(wave.imag(), wave.real())));
    }
}

// active: share of a round that every vertex takes; empty: 1.
void relax_phases(const Model& model, const Settings& settings, std::span<const Pull> pulls,
                  std::span<const float> active, int rounds, std::vector<float>& phase) {
    ping_pong(settings, rounds, phase, [&](size_t v, const std::vector<float>& from) {
        float sum = 0.0f;
        for (const Pull& pull : pulls_of(model, pulls, v)) {
            if (pull.weight > 0.0f)
                sum += pull.weight * formulas::misfit(pull.link, from[v], from[pull.vertex]);
        }
        const float neighbours = float(model.neighbour_start[v + 1] - model.neighbour_start[v]);
        return formulas::relaxed(from[v], sum, neighbours,
                                 settings.rate * (active.empty() ? 1.0f : active[v]));
    });
}

}  // namespace

void check(const Settings& settings) {
    expect_within("wavelength", settings.wavelength, 1e-6, 1e6);
    expect_within("strength", settings.strength, 0.0, 1e3);
    expect_within("buckling_threshold", settings.buckling_threshold, 0.0, 0.99);
    expect_within("rate", settings.rate, 0.0, 1.0);
    expect_within("rounds", settings.rounds, 0, 1e6);
    expect_within("start_rounds", settings.start_rounds, 0, 1e6);
    expect_within("bend_radius", settings.bend_radius, 0.0, kFarthestCoordinate);
    expect_within("irregularity", settings.irregularity, 0.0, 1.0);
    expect_within("threads", settings.threads, 0, 1024);
    check_reference(settings.rest);
}

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
    const size_t vertices = model.base.positions_rest.size();
    assert(pose.around.size() == vertices);
    if (!before.empty()) expect_count("directions", before.size(), vertices, "welded vertices");
    if (!stretches.empty()) expect_count("stretches", stretches.size(), vertices, "welded vertices");
    expect_finite("stretches", stretches, "welded vertex");
    Waves waves;
    waves.positions = pose.positions;
    waves.normals = pose.normals;
    waves.wave_vector.assign(vertices, Vec3(0.0f));
    waves.height.assign(vertices, 0.0f);
    waves.fullness.assign(vertices, 0.0f);
    waves.compression.assign(vertices, 1.0f);
    waves.gather.assign(vertices, 1.0f);
    waves.direction.assign(vertices, Vec2(1.0f, 0.0f));
    const std::vector<Vec2> first = before.empty() ? first_directions(model) : std::vector<Vec2>();
    if (before.empty()) before = first;
    std::vector<SpareCloth> spare;
    if (settings.bend_radius > 0.0f)
        spare = spare_cloth(model.base, model.bent_lines, pose.positions, settings.bend_radius);
    const auto asked_along = [&](size_t v) {
        return paint.along.empty() ? Vec2(0.0f)
                                   : in_rest_frame(model, v, paint.along[model.base.representative[v]]);
    };
    for_each_vertex(settings, vertices, [&](size_t v) {
        const std::optional<Neighbourhood>& around = pose.around[v];
        if (!around) return;
        const glm::mat2 m = stretches.empty() ? around->m : formulas::restretched(around->m, stretches[v]);
        formulas::WaveEstimate estimate = formulas::estimate_wave(
            m, parameters.rest_wrinkle[v], before[v], parameters.turn[v], settings.buckling_threshold);
        float gather = glm::length(estimate.k_deformed);
        const Vec2 along = asked_along(v);
        if (along != Vec2(0.0f)) {
            turn_along(along, m, parameters.rest_wrinkle[v], before[v], parameters.turn[v],
                       settings.buckling_threshold, estimate, gather);
        }
        const float w = parameters.wavelength[v];
        waves.compression[v] = estimate.r;
        waves.direction[v] = estimate.k;
        if (estimate.fullness > 0.0f) waves.gather[v] = gather;
        const Vec3 across =
            estimate.k_deformed.x * around->tangent + estimate.k_deformed.y * around->bitangent;
        waves.fullness[v] = estimate.fullness * parameters.mask[v];
        if (!spare.empty() && across != Vec3(0.0f)) {
            // Painted wrinkles are kept.
            const float painted =
                std::min(std::max(glm::length(parameters.rest_wrinkle[v]), glm::length(along)), 1.0f);
            waves.fullness[v] *= 1.0f - (1.0f - painted) * spare[v].share_without_place(across);
        }
        waves.height[v] = 0.25f * w * settings.strength * waves.fullness[v];  // equation (2)
        waves.wave_vector[v] = (formulas::kTwoPi / w) * across;
    });
    return waves;
}

void align(const Model& model, const Settings& settings, const Waves& waves, int rounds,
           std::vector<float>& phase) {
    align_phases(model, settings, collect_pulls(model, settings, waves), rounds, phase);
}

void relax(const Model& model, const Settings& settings, const Waves& waves, int rounds,
           std::vector<float>& phase) {
    relax_phases(model, settings, collect_pulls(model, settings, waves), {}, rounds, phase);
}

float misfit(const Model& model, const Waves& waves, std::span<const float> phase) {
    return misfit_of(model, waves, collect_pulls(model, Settings{}, waves), phase);
}

void dissolve(const Model& model, const Settings& settings, std::span<const float> phase, Waves& waves) {
    expect_count("phase", phase.size(), waves.height.size(), "welded vertices");
    const std::vector<Pull> pulls = collect_pulls(model, settings, waves);
    for_each_vertex(settings, waves.height.size(), [&](size_t v) {
        float sum = 1.0f, weights = 1.0f;
        for (const Pull& pull : pulls_of(model, pulls, v)) {
            sum += pull.weight * formulas::agreement(waves.wave_vector[v], waves.wave_vector[pull.vertex],
                                                     pull.link, phase[v], phase[pull.vertex]);
            weights += pull.weight;
        }
        waves.height[v] *= formulas::kept_at_fork(sum / weights);
    });
}

State activated(const State& state) {
    // No link has an infinite offset, so every link counts as changed.
    return {state.phase, state.direction,
            std::vector<float>(state.solved_offset.size(), std::numeric_limits<float>::infinity()),
            state.reference};
}

State solve(const Model& model, const Settings& settings, const Paint& paint, const Pose& pose,
            const State* state, Report& report, const FrameTime& frame_time, Waves* estimated) {
    if (state && (state->phase.size() != model.base.positions_rest.size() ||
                  state->direction.size() != state->phase.size() ||
                  state->solved_offset.size() != model.neighbours.size())) {
        state = nullptr;
    }
    State after;
    if (settings.rest.reference != Reference::kStaticRest) {
        after.reference = adapt(model.base, model.triangles, settings.rest, frame_time, pose.positions,
                                state ? state->reference : ReferenceState{});
    }
    Waves waves = estimate_waves(model, settings, paint, pose,
                                 state ? std::span(state->direction) : std::span<const Vec2>(),
                                 reference_stretches(model, after.reference, pose));
    const std::vector<Pull> pulls = collect_pulls(model, settings, waves);
    after.direction = waves.direction;
    report = {};
    report.rounds = state ? settings.rounds : settings.start_rounds;
    if (state) {
        after.phase = state->phase;
        after.solved_offset = state->solved_offset;
        report.misfit_before = misfit_of(model, waves, pulls, after.phase);
        const std::vector<float> active = activity(model, pulls, after.solved_offset);
        relax_phases(model, settings, pulls, active, settings.rounds, after.phase);
        report.largest_change = largest_change(waves, state->phase, after.phase);
    } else {
        after.phase = random_phases(model, settings.seed);
        for (const Pull& pull : pulls) after.solved_offset.push_back(pull.link.offset);
        report.misfit_before = misfit_of(model, waves, pulls, after.phase);
        if (settings.aligned_start) align_phases(model, settings, pulls, settings.start_rounds, after.phase);
        relax_phases(model, settings, pulls, {}, settings.start_rounds, after.phase);
    }
    report.misfit_after = misfit_of(model, waves, pulls, after.phase);
    for (size_t v = 0; v < after.phase.size(); ++v) {
        report.wrinkled += formulas::attenuation(waves.fullness[v]) > 0.0f;
        report.collapsed += waves.compression[v] < formulas::kCollapsed;
    }
    if (estimated) *estimated = std::move(waves);
    return after;
}

}  // namespace rumple::wrinkle_field
