// SPDX-License-Identifier: GPL-3.0-or-later
// Section 5 of Loviscach 2006: "Relax". Section 4 is in waves.cpp.
#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>

#include "base/elementary.h"
#include "base/expect.h"
#include "base/parallel.h"
#include "base/tolerances.h"
#include "systems/wrinkle_field/frames.h"
#include "systems/wrinkle_field/pulls.h"
#include "systems/wrinkle_field/wrinkle_field.h"

namespace rumple::wrinkle_field {
namespace {

// The part that vertices take in a round.
struct Activity {
    std::vector<Lanes> share;  // per four vertices
    std::vector<Index> fours;  // those of which a vertex may move
};

// All vertices take all of it.
Activity all_active(const Model& model) {
    Activity out{std::vector(model.columns.count.size(), all_lanes(1.0f)),
                 std::vector<Index>(model.columns.count.size())};
    std::iota(out.fours.begin(), out.fours.end(), 0);
    return out;
}

// The share is 0 if the links to the waves around a vertex are the same as in its last relaxation, so that a
// standing leg does not change when the arm moves. Updates solved_offset for relaxed links.
Activity activity(const Model& model, const Pulls& pulls, std::span<float> solved_offset) {
    const NeighbourColumns& columns = model.columns;
    const auto last = static_cast<Index>(solved_offset.size()) - 1;
    Activity out;
    out.share.reserve(columns.count.size());
    for_each_four(model.tangent_rest.size(), [&](size_t first, auto how_many) {
        const size_t four = first / kLanes;
        LaneMask place{};  // of the column's neighbours among all; beyond `last` only missing ones
        std::memcpy(&place, &model.neighbour_start[first], how_many * sizeof(Index));
        Lanes share{};
        LaneMask any{};
        for (Index c = columns.start[four]; c < columns.start[four + 1]; ++c, place += 1) {
            const Pull& pull = pulls[c];
            const auto neighbour = std::bit_cast<LaneIndices>(place < last ? place : last);
            const Lanes change = pull.link.offset - gathered(solved_offset, neighbour);
            const Lanes act = pull.weight > 0.0f ? lane_formulas::activity(change) : 0.0f;
            share = most(share, act);
            any |= act != 0.0f;  // also if it is not a number
            for (int lane = 0; lane < kLanes; ++lane)
                if (act[lane] > 0.0f) solved_offset[neighbour[lane]] = pull.link.offset[lane];
        }
        out.share.push_back(share);
        if (bits_of(any) != 0) out.fours.push_back(static_cast<Index>(four));
    });
    return out;
}

std::vector<float> offsets(const Model& model, const Pulls& pulls) {
    std::vector<float> offset(model.neighbours.size());
    for (size_t v = 0; v < model.base.positions_rest.size(); ++v)
        pulls.for_each_of(v, [&](Index i, float, const formulas::Link& link) { offset[i] = link.offset; });
    return offset;
}

// Phase errors of a column of neighbours, in turns.
Lanes misfits(const NeighbourColumns& columns, const Pulls& pulls, Index column, const Lanes& own,
              std::span<const float> phase) {
    return lane_formulas::misfit(pulls[column].link, own, gathered(phase, columns.vertex[column]));
}

float misfit_of(const Model& model, const Waves& waves, const Pulls& pulls, std::span<const float> phase) {
    const NeighbourColumns& columns = model.columns;
    using Doubles = double __attribute__((vector_size(32)));
    Doubles squares{}, weights{};
    for_each_four(phase.size(), [&](size_t first, auto how_many) {
        const size_t four = first / kLanes;
        const Lanes own = load_lanes(&phase[first], how_many);
        Lanes sum{}, weight{};
        for (Index c = columns.start[four]; c < columns.start[four + 1]; ++c) {
            const Lanes error = misfits(columns, pulls, c, own, phase);
            sum += pulls[c].weight * error * error;
            weight += pulls[c].weight;
        }
        const Lanes attenuation = lane_formulas::attenuation(load_lanes(&waves.fullness[first], how_many));
        squares += __builtin_convertvector(attenuation * sum, Doubles);
        weights += __builtin_convertvector(attenuation * weight, Doubles);
    });
    const auto total = [](const Doubles& of) { return of[0] + of[1] + of[2] + of[3]; };
    return total(weights) > 0.0 ? static_cast<float>(std::sqrt(total(squares) / total(weights))) : 0.0f;
}

// Runs `rounds` rounds of step(begin, end, from, to), from one buffer into another, for parts of the items.
// Values that no item changes stay.
template <typename T, typename Step>
void ping_pong(const Settings& settings, int rounds, size_t items, std::vector<T>& values, Step&& step) {
    std::vector<T> buffers[2] = {values, std::move(values)};
    Team team(threads_for(settings, buffers[0].size()));
    team.run([&](int thread) {
        const Team::Range part = team.partition(0, items, thread);
        for (int round = 0; round < rounds; ++round) {
            step(part.begin, part.end, std::as_const(buffers[round % 2]), buffers[1 - round % 2]);
            team.barrier();
        }
    });
    values = std::move(buffers[rounds % 2]);
}

// Counts the vertices with and without a wave.
void count_waves(const Waves& waves, Report& report) {
    Index wrinkled = 0, collapsed = 0;
    for (const float fullness : waves.fullness) wrinkled += formulas::attenuation(fullness) > 0.0f;
    for (const float r : waves.compression) collapsed += r < formulas::kCollapsed;
    report.wrinkled = wrinkled;
    report.collapsed = collapsed;
}

float largest_change(const Waves& waves, std::span<const float> before, std::span<const float> after) {
    Lanes largest{};
    for_each_four(after.size(), [&](size_t first, auto how_many) {
        const auto four = [&](const auto& values) { return load_lanes(&values[first], how_many); };
        const Lanes change = lane_formulas::abs(lane_formulas::wrapped(four(after) - four(before)));
        const LaneMask has_wave = lane_formulas::attenuation(four(waves.fullness)) > 0.0f;
        largest = most(largest, has_wave ? change : 0.0f);
    });
    return std::max({largest[0], largest[1], largest[2], largest[3]});
}

void align_phases(const Model& model, const Settings& settings, const Pulls& pulls, int rounds,
                  std::vector<float>& phase) {
    using Complex = std::complex<double>;  // double precision, because the length may shrink in every round
    const auto wave_of = [](double angle) { return Complex(elementary::cos(angle), elementary::sin(angle)); };
    struct Asked {
        Complex wave;  // ... of the neighbour, times its weight
        double weight;
        bool turned;
    };
    std::vector<Asked> asked(model.neighbours.size());
    std::vector<Complex> waves_at(phase.size());
    for (size_t v = 0; v < phase.size(); ++v) {
        waves_at[v] = wave_of(double(phase[v]));
        pulls.for_each_of(v, [&](Index i, float weight, const formulas::Link& link) {
            asked[i] = {double(weight) * wave_of(double(link.offset)), weight, link.flip < 0.0f};
        });
    }
    const auto mean = [&](size_t v, const std::vector<Complex>& from) {
        Complex sum = from[v];
        double weights = 1.0;
        for (Index i = model.neighbour_start[v]; i < model.neighbour_start[v + 1]; ++i) {
            const Complex other = from[model.neighbours[i].vertex];
            sum += asked[i].wave * (asked[i].turned ? std::conj(other) : other);
            weights += asked[i].weight;
        }
        return sum / weights;
    };
    ping_pong(settings, rounds, waves_at.size(), waves_at,
              [&](size_t begin, size_t end, const auto& from, auto& to) {
                  for (size_t v = begin; v < end; ++v) to[v] = mean(v, from);
              });
    for (size_t v = 0; v < phase.size(); ++v) {
        const Complex& wave = waves_at[v];
        if (wave != Complex())
            phase[v] = formulas::wrapped(static_cast<float>(elementary::atan2(wave.imag(), wave.real())));
    }
}

// Fours whose sums are computed before their phases. Both are chains of operations that wait for one another;
// a processor overlaps more of them if they are short.
constexpr size_t kBlock = 64;

void relax_phases(const Model& model, const Settings& settings, const Pulls& pulls, const Activity& active,
                  int rounds, std::vector<float>& phase) {
    const NeighbourColumns& columns = model.columns;
    const auto sum_of_misfits = [&](Index four, std::span<const float> from) {
        const Lanes own = load_lanes(&from[kLanes * size_t(four)]);
        Lanes sum{};
        for (Index c = columns.start[four]; c < columns.start[four + 1]; ++c)
            sum += pulls[c].weight * misfits(columns, pulls, c, own, from);
        return sum;
    };
    const auto relaxed = [&](Index four, std::span<const float> from, const Lanes& sum) {
        const Lanes own = load_lanes(&from[kLanes * size_t(four)]);
        return lane_formulas::relaxed(own, sum, columns.count[four], settings.rate * active.share[four]);
    };
    std::vector<float> phases(in_fours(phase.size()));
    std::copy(phase.begin(), phase.end(), phases.begin());
    ping_pong(settings, rounds, active.fours.size(), phases,
              [&](size_t begin, size_t end, std::span<const float> from, std::vector<float>& to) {
                  std::array<Lanes, kBlock> sum;
                  for (; begin < end; begin += kBlock) {
                      const std::span<const Index> fours(&active.fours[begin], std::min(end - begin, kBlock));
                      for (size_t k = 0; k < fours.size(); ++k) sum[k] = sum_of_misfits(fours[k], from);
                      for (size_t k = 0; k < fours.size(); ++k)
                          store_lanes(relaxed(fours[k], from, sum[k]), &to[kLanes * size_t(fours[k])]);
                  }
              });
    std::copy_n(phases.begin(), phase.size(), phase.begin());
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
    align_phases(model, settings, Pulls(model, settings, waves), rounds, phase);
}

void relax(const Model& model, const Settings& settings, const Waves& waves, int rounds,
           std::vector<float>& phase) {
    const Pulls pulls(model, settings, waves);
    relax_phases(model, settings, pulls, all_active(model), rounds, phase);
}

float misfit(const Model& model, const Waves& waves, std::span<const float> phase) {
    return misfit_of(model, waves, Pulls(model, Settings{}, waves), phase);
}

void dissolve(const Model& model, const Settings& settings, std::span<const float> phase, Waves& waves) {
    expect_count("phase", phase.size(), waves.height.size(), "welded vertices");
    const Pulls pulls(model, settings, waves);
    for_each_vertex(settings, waves.height.size(), [&](size_t v) {
        float sum = 1.0f, weights = 1.0f;
        pulls.for_each_of(v, [&](Index i, float weight, const formulas::Link& link) {
            const Index n = model.neighbours[i].vertex;
            sum += weight *
                   formulas::agreement(waves.wave_vector[v], waves.wave_vector[n], link, phase[v], phase[n]);
            weights += weight;
        });
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
    const Pulls pulls(model, settings, waves);
    after.direction = waves.direction;
    report = {};
    report.rounds = state ? settings.rounds : settings.start_rounds;
    if (state) {
        after.phase = state->phase;
        after.solved_offset = state->solved_offset;
        report.misfit_before = misfit_of(model, waves, pulls, after.phase);
        const Activity active = activity(model, pulls, after.solved_offset);
        relax_phases(model, settings, pulls, active, settings.rounds, after.phase);
        report.largest_change = largest_change(waves, state->phase, after.phase);
    } else {
        after.phase = random_phases(model, settings.seed);
        after.solved_offset = offsets(model, pulls);
        report.misfit_before = misfit_of(model, waves, pulls, after.phase);
        if (settings.aligned_start) align_phases(model, settings, pulls, settings.start_rounds, after.phase);
        relax_phases(model, settings, pulls, all_active(model), settings.start_rounds, after.phase);
    }
    const bool moved = !state || after.phase != state->phase;
    report.misfit_after = moved ? misfit_of(model, waves, pulls, after.phase) : report.misfit_before;
    count_waves(waves, report);
    if (estimated) *estimated = std::move(waves);
    return after;
}

}  // namespace rumple::wrinkle_field
