// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_paths.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/expect.h"
#include "systems/wrinkle_paths_life.h"

namespace rumple::wrinkle_paths {
namespace {

void check(const Model& model, const Paint& paint) {
    if (paint.mask.empty()) return;
    expect_count("paint.mask", paint.mask.size(), size_t(model.base.display.vertex_count),
                 "values, one per vertex of the base, or none");
    for (size_t v = 0; v < paint.mask.size(); ++v) {
        if (paint.mask[v] >= 0.0f && paint.mask[v] <= 1.0f) continue;
        throw InvalidInput("paint.mask: vertex " + std::to_string(v) + " is " +
                           std::to_string(paint.mask[v]) + ", expected 0..1");
    }
}

void check(const Model& model, const State& state) {
    const size_t triangles = model.rest.size(), vertices = size_t(model.base.welded.vertex_count);
    expect_count("state.labels", state.labels.size(), triangles, "triangles");
    expect_count("state.reference", state.reference.size(), triangles, "triangles");
    expect_count("state.compression", state.compression.size(), triangles, "triangles");
    if (state.past_times.empty()) throw InvalidInput("state.past_times: expected the state's own, got none");
    expect_count("state.past_positions", state.past_positions.size(), state.past_times.size() * vertices,
                 "vertices");
    const auto refuse = [](const char* name, size_t at) {
        throw InvalidInput(std::string("state.") + name + ": number " + std::to_string(at) +
                           " is out of range");
    };
    for (size_t t = 0; t < triangles; ++t) {
        const FlatTriangle& r = state.reference[t];
        if (state.labels[t] > kStretch) refuse("labels", t);
        if (!(r.x1 >= 0.0f) || !(r.y2 >= 0.0f) || !std::isfinite(r.x1 + r.x2 + r.y2)) refuse("reference", t);
        if (!(state.compression[t] > 0.0f) || !std::isfinite(state.compression[t])) refuse("compression", t);
    }
    for (size_t i = 0; i < state.past_times.size(); ++i) {
        if (!(state.past_times[i] <= state.time) || (i > 0 && state.past_times[i] < state.past_times[i - 1]))
            refuse("past_times", i);
    }
    for (size_t v = 0; v < state.past_positions.size(); ++v) {
        const Vec3& p = state.past_positions[v];
        if (!std::isfinite(p.x + p.y + p.z)) refuse("past_positions", v);
    }
    for (size_t i = 0; i < state.paths.size(); ++i) {
        if (!(state.paths[i].fade >= 0.0f && state.paths[i].fade <= 1.0f)) refuse("path_fade", i);
        if (!std::isfinite(state.paths[i].compression)) refuse("path_compression", i);
    }
    const std::string wrong = fault(model, state.paths);
    if (!wrong.empty()) throw InvalidInput("state.paths: " + wrong);
}

void check(const Model& model, const Input& input, const State* state) {
    check_positions(model, input.positions, "positions");
    if (!std::isfinite(input.time))
        throw InvalidInput("time: expected seconds, got a value that is not finite");
    if (!input.labels.empty()) {
        expect_count("labels", input.labels.size(), model.rest.size(), "triangles");
        for (const std::uint8_t label : input.labels) {
            if (label > kStretch) throw InvalidInput("labels: expected 0..2, got " + std::to_string(label));
        }
    }
    if (!input.next_positions.empty()) {
        check_positions(model, input.next_positions, "next_positions");
        if (!(input.next_time > input.time))
            throw InvalidInput("next_time: expected later than " + std::to_string(input.time) + " s, got " +
                               std::to_string(input.next_time));
    }
    if (!state) return;
    check(model, *state);
    if (state->time > input.time) {
        throw InvalidInput("time: the state is of " + std::to_string(state->time) +
                           " s, later than this frame at " + std::to_string(input.time));
    }
}

// Section 5.2.1 for all paths, and how far their points went.
void follow_all(const Ground& ground, const State& state, const Settings& settings, double seconds,
                std::vector<Path>& paths, Report& report) {
    const size_t vertices = ground.pose.positions.size();
    const Pose before = make_welded_pose(
        ground.model, {state.past_positions.end() - std::ptrdiff_t(vertices), state.past_positions.end()});
    std::vector<float> moved;
    for (Path& path : paths) follow(ground, before, settings, seconds, path.points, moved);
    if (moved.empty()) return;
    double sum = 0.0;
    for (const float way : moved) sum += way;
    std::sort(moved.begin(), moved.end());
    report.moved_mean = float(sum / double(moved.size())) / settings.width;
    report.moved_most = moved[moved.size() * 99 / 100] / settings.width;
}

}  // namespace

void check_positions(const Model& model, std::span<const Vec3> positions, const char* name) {
    expect_count(name, positions.size(), size_t(model.base.display.vertex_count), "vertices");
    expect_finite(name, positions, "vertex");
}

State solve(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
            const State* state, Report& report) {
    check(settings);
    check(model, paint);
    check(model, input, state);
    report = {};
    const Pose pose = make_pose(model, input.positions);
    const double seconds = state ? input.time - state->time : 0.0;
    State next;
    next.time = input.time;
    next.next_id = state ? state->next_id : 0;
    remember(settings, pose, state, next);

    const std::vector<Stretch> changes = recent_changes(model, settings, input.time, pose, state);
    next.labels = label_frame(model, settings, input, pose, changes, state);
    next.reference = update_reference(model, settings, pose, next.labels, seconds, state);
    Ground ground = make_ground(model, settings, paint, pose, next.reference, changes);
    smooth_in_time(settings, seconds, state, ground);
    next.compression = ground.compression;

    SegmentMap map(ground);
    const bool goes_on = state && settings.persistent;
    if (goes_on) {
        next.paths = state->paths;
        follow_all(ground, *state, settings, seconds, next.paths, report);
        live(ground, settings, seconds, next.paths, map, report);
    }
    bear(ground, settings, !goes_on, next, map, report);

    report.paths = static_cast<Index>(next.paths.size());
    report.collapsed_triangles = pose.collapsed;
    for (const std::uint8_t label : next.labels) {
        report.compressed += label == kCompress;
        report.stretched += label == kStretch;
    }
    return next;
}

}  // namespace rumple::wrinkle_paths
