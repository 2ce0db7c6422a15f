// SPDX-License-Identifier: GPL-3.0-or-later
// Section 4 of Mueller and Chentanez 2010: the runtime update.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/expect.h"
#include "base/lanes.h"
#include "base/random.h"
#include "base/smooth_step.h"
#include "base/tolerances.h"
#include "systems/wrinkle_mesh/bounds.h"
#include "systems/wrinkle_mesh/pose.h"
#include "systems/wrinkle_mesh/relax.h"
#include "systems/wrinkle_mesh/wrinkle_mesh.h"

namespace rumple::wrinkle_mesh {
namespace {

// The share of a new solution that every vertex takes. It is 0 where the base has kept its shape since it was
// last solved. So a held pose stays exactly the same, and a standing leg does not creep while the arm moves.
// lengths: as in State::solved_length.
std::vector<float> activity(const Model& model, std::span<const float> lengths, const State& state) {
    std::vector<float> active(model.attached.size(), 0.0f);
    const Lanes shortest = all_lanes(kShortestEdge);
    const auto take_changed = [&](const Pairs& pairs, size_t before) {
        for_each_group(pairs, [&](size_t begin, size_t end) {
            for_each_four(end - begin, [&](size_t first, size_t count) {
                first += begin;
                const Lanes difference = load_lanes(&lengths[before + first], count) -
                                         load_lanes(&state.solved_length[before + first], count);
                const Lanes change =
                    most(difference, -difference) / most(load_lanes(&pairs.rest[first], count), shortest);
                const Lanes act = smooth_step(kHeldStrain, kFreeStrain, change);
                if (bits_of(act > Lanes{}) == 0) return;
                for (size_t k = 0; k < count; ++k) {
                    for (const Index v : {pairs.a[first + k], pairs.b[first + k]})
                        active[v] = std::max(active[v], act[k]);
                }
            });
        });
    };
    take_changed(model.distance, 0);
    take_changed(model.bending, model.distance.size());
    // A solved vertex moves its neighbours by half, so that there is no hard border between held and solved.
    std::vector<float> spread = active;
    for_each_pair(model.distance, [&](size_t, Index a, Index b) {
        spread[a] = std::max(spread[a], 0.5f * active[b]);
        spread[b] = std::max(spread[b], 0.5f * active[a]);
    });
    return spread;
}

// A flat sheet under compression is in an unstable equilibrium. So vertices that have hardly left their
// attachment are pushed a little along the normal, by an amount that grows with the compression of their
// edges. At rest nothing is pushed.
void perturb_unbuckled(const Model& model, const Settings& settings, const Pose& pose,
                       std::span<const float> lengths, const Targets& targets, std::span<Vec3> positions) {
    if (settings.nudge <= 0.0f) return;
    std::vector<float> compression(positions.size(), 0.0f);
    for_each_pair(model.distance, [&](size_t i, Index a, Index b) {
        const float c = 1.0f - lengths[i] / std::max(targets.distance[i], kShortestEdge);
        for (const Index v : {a, b}) compression[v] = std::max(compression[v], c);
    });
    for_each_index(positions.size(), kLeastSteps, [&](size_t v) {
        const float full_at = 0.1f;  // from a compression of a tenth on the push is full
        const float size = settings.nudge * model.local_edge[v] * std::min(1.0f, compression[v] / full_at);
        if (glm::distance(positions[v], pose.attachment[v]) >= size) return;
        positions[v] += size * noise(settings.seed, static_cast<std::uint32_t>(v)) * pose.normal[v];
    });
}

float share_above_zero(std::span<const float> values) {
    size_t above = 0;
    for (const float value : values) above += value > 0.0f;
    return values.empty() ? 0.0f : float(above) / float(values.size());
}

bool fits(const Model& model, const State* state) {
    return state && state->offset.size() == model.attached.size() &&
           state->solved_length.size() == model.distance.size() + model.bending.size();
}

// Calls work(v) for every vertex, in the order of its bounds in memory.
template <typename Work>
void for_each_in_rows(const Model& model, const Work& work) {
    for_each_index(model.vertex_of_row.size(), kLeastSteps,
                   [&](size_t row) { work(size_t(model.vertex_of_row[row])); });
}

// Moves every vertex by its share to the new position, and puts it back within its bounds. The blend may be
// outside of a plane that has turned since the frame before.
void blend(const Model& model, const Settings& settings, std::span<const Vec3> before,
           std::span<const float> active, const Bounds& bounds, std::span<Vec3> positions) {
    const std::span<const Index> rows(model.vertex_of_row);
    for_each_part(rows.size(), kLeastSteps, [&](size_t begin, size_t end) {
        for (; begin < end; begin += kLanes) {
            const std::span<const Index> four = rows.subspan(begin, std::min<size_t>(kLanes, end - begin));
            std::array<Row, kLanes> blended;
            for (size_t k = 0; k < four.size(); ++k) {
                const auto v = size_t(four[k]);
                const float share = active[v] * (1.0f - settings.damping);
                blended[k] = before[v] + share * (positions[v] - before[v]);
            }
            bounds.project_four(begin / kLanes, blended);
            for (size_t k = 0; k < four.size(); ++k)
                if (active[size_t(four[k])] > 0.0f) positions[size_t(four[k])] = blended[k].vec();
        }
    });
}

// Pairs between held vertices keep the lengths of the pose in which they were solved, so that a slow drift
// adds up until they are solved.
void remember_lengths(const Model& model, std::span<const float> active, const State& before,
                      std::vector<float>& lengths) {
    size_t first = 0;
    for (const Pairs* pairs : {&model.distance, &model.bending}) {
        for_each_index(pairs->size(), kLeastSteps, [&](size_t k) {
            const bool held = active[pairs->a[k]] <= 0.0f && active[pairs->b[k]] <= 0.0f;
            if (held) lengths[first + k] = before.solved_length[first + k];
        });
        first += pairs->size();
    }
}

using Relax = void (*)(const Model&, const Targets&, const Bounds&, int, std::span<Vec3>);

// The data with which a frame is solved.
struct Frame {
    const Model& model;
    const Settings& settings;
    const Pose& pose;
    const State* before;  // of this model, or none
    OffsetFrames offsets;
    std::span<const float> lengths;  // of the pairs, at the attachments
    Targets targets;
    std::vector<float> active;  // per vertex: activity(); 1 without a state
    Bounds bounds;
};

// Where the offsets from the frame before are; without one at the attachments.
std::vector<Vec3> start_positions(const Frame& frame) {
    if (!frame.before) return frame.pose.attachment;
    return solved_positions(frame.pose, frame.offsets.in_object(*frame.before));
}

// Moves the active vertices. Returns the number of iterations.
int relax_active(const Frame& frame, Relax relax, std::span<const Vec3> start, std::span<Vec3> positions) {
    const Settings& settings = frame.settings;
    perturb_unbuckled(frame.model, settings, frame.pose, frame.lengths, frame.targets, positions);
    const int iterations = frame.before ? settings.iterations : settings.start_iterations;
    relax(frame.model, frame.targets, frame.bounds, iterations, positions);
    if (frame.before) blend(frame.model, settings, start, frame.active, frame.bounds, positions);
    return iterations;
}

// o_i = p_i - a_i. The offset of a held vertex keeps its bits, unless a plane that has turned or a smaller
// radius pushes it. Then `positions` receives the new place. Returns the number of vertices that are kept
// apart.
Index store_offsets(const Frame& frame, std::span<const Vec3> start, std::span<Vec3> positions,
                    std::vector<Vec3>& offset) {
    std::vector<std::uint8_t> kept_apart(positions.size(), 0);
    for_each_in_rows(frame.model, [&](size_t v) {
        const bool held = frame.before && frame.active[v] <= 0.0f;
        if (held) positions[v] = start[v];
        const bool pushed = held && frame.bounds.push_back(v, positions[v]);
        const bool kept = held && !pushed;
        offset[v] =
            kept ? frame.before->offset[v] : frame.offsets.stored(v, positions[v] - frame.pose.attachment[v]);
        kept_apart[v] = frame.bounds.kept_apart(v, positions[v]);
    });
    return static_cast<Index>(std::ranges::count(kept_apart, 1));
}

State solve_with(Relax relax, const Model& model, const Settings& settings, const Paint& paint,
                 const Input& input, const Pose& given, const State* before, Report& report) {
    check(settings);
    check(model, paint);
    const SolveTeam team = team_for(model, settings.threads);
    const std::optional<Pose> guided = guided_pose(model, paint, given);
    const Pose& pose = guided ? *guided : given;
    const OffsetFrames offsets(model, settings, input, pose);
    if (!fits(model, before)) before = nullptr;
    const std::vector<float> lengths = pair_lengths(model, pose.attachment);
    State state{std::vector<Vec3>(pose.attachment.size()), lengths,
                adapt_rest(model, settings, input, pose, before)};
    const std::vector<float> scales = rest_scales(model, settings, state.reference, pose, lengths);
    for (size_t i = 0; i < scales.size(); ++i) state.solved_length[i] /= std::max(scales[i], kShortestEdge);
    const Frame frame{model,
                      settings,
                      pose,
                      before,
                      offsets,
                      lengths,
                      make_targets(model, settings, paint, lengths, pose, scales),
                      before ? activity(model, state.solved_length, *before)
                             : std::vector<float>(pose.attachment.size(), 1.0f),
                      Bounds(model, settings, paint, pose)};
    report = {};
    report.collapsed_triangles = pose.collapsed;
    report.active = share_above_zero(frame.active);
    report.error_before = length_error(frame.targets.distance, lengths).rms;
    const std::vector<Vec3> start = start_positions(frame);
    std::vector<Vec3> positions = start;
    if (report.active > 0.0f) report.iterations = relax_active(frame, relax, start, positions);
    report.kept_apart = store_offsets(frame, start, positions, state.offset);
    const LengthError after =
        length_error(frame.targets.distance, pair_lengths(model.distance, to_rows(positions)));
    report.error_after = after.rms;
    report.largest_error = after.largest;
    if (before) remember_lengths(model, frame.active, *before, state.solved_length);
    return state;
}

}  // namespace

void check(const Settings& settings) {
    expect_within("radius", settings.radius, 0.0, 1e6);
    expect_within("prestretch", settings.prestretch, 1e-3, 1e3);
    expect_within("slack", settings.slack, 1e-3, 1e3);
    expect_within("taut_range", settings.taut_range, 0.0, 1e3);
    expect_within("hang", glm::length(settings.hang), 0.0, 1.001);
    expect_within("bend_radius", settings.bend_radius, 0.0, kFarthestCoordinate);
    expect_within("bending", settings.bending, 0.0, 1.0);
    expect_within("inside", settings.inside, 0.0, 1.0);
    expect_within("stretch_relief", settings.stretch_relief, 0.0, 1.0);
    expect_within("buckling_threshold", settings.buckling_threshold, 0.0, 1.0);
    expect_within("compression_limit", settings.compression_limit, 1.0, 1e6);
    expect_within("hem_rings", settings.hem_rings, 0, 1e6);
    expect_within("iterations", settings.iterations, 0, 1e6);
    expect_within("start_iterations", settings.start_iterations, 0, 1e6);
    expect_within("damping", settings.damping, 0.0, 1.0);
    expect_within("tangential_pull", settings.tangential_pull, 0.0, 1.0);
    expect_within("normal_pull", settings.normal_pull, 0.0, 1.0);
    expect_within("contact_gather", settings.contact_gather, 0.0, 1.0);
    expect_within("apart", settings.apart, 0.0, 0.5);
    expect_within("slide", settings.slide, 0.0, 0.5);
    expect_within("nudge", settings.nudge, 0.0, 1e3);
    expect_within("threads", settings.threads, 0, 1024);
    check_reference(settings.rest);
}

State activated(const State& state) {
    // No attachment has an infinite length, so every pair counts as changed.
    return {state.offset,
            std::vector<float>(state.solved_length.size(), std::numeric_limits<float>::infinity()),
            state.reference};
}

State solve(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
            const State* state, Report& report) {
    return solve_pose(model, settings, paint, input, make_pose(model, input), state, report);
}

State solve_pose(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
                 const Pose& pose, const State* state, Report& report) {
    return solve_with(relax_by_blocks, model, settings, paint, input, pose, state, report);
}

State solve_in_order(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
                     const State* state, Report& report) {
    return solve_with(relax_in_order, model, settings, paint, input, make_pose(model, input), state, report);
}

}  // namespace rumple::wrinkle_mesh
