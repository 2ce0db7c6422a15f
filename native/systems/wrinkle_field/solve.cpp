// SPDX-License-Identifier: GPL-3.0-or-later
// Section 5 of Loviscach 2006: "Relax". Section 4 is in waves.cpp.
#include <algorithm>
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
