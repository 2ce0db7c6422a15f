// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_paths.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/errors.h"
#include "base/tolerances.h"
#include "systems/wrinkle_paths_life.h"

namespace rumple::wrinkle_paths {
namespace {

void expect_count(const std::string& name, size_t got, size_t expected, const char* what) {
    if (got == expected) return;
    throw InvalidInput(name + ": expected " + std::to_string(expected) + " " + what + ", got " +
                       std::to_string(got));
}

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
    if (state.past_times.empty())
        throw InvalidInput("state.past_times: expected at least the state's own, got none");
    expect_count("state.past_positions", state.past_positions.size(), state.past_times.size() * vertices,
                 "vertices");
    for (const std::uint8_t label : state.labels) {
        if (label > kStretch) throw InvalidInput("state.labels: expected 0..2, got " + std::to_string(label));
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
    for (size_t v = 0; v < positions.size(); ++v) {
        const Vec3& p = positions[v];
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            throw InvalidInput(std::string(name) + ": vertex " + std::to_string(v) + " is not finite");
    }
}

std::vector<FlatTriangle> flat_triangles(const Model& model, std::span<const Vec3> welded) {
    std::vector<FlatTriangle> shapes(size_t(model.net.triangles()));
    for (size_t t = 0; t < shapes.size(); ++t) {
        const Index* vertex = &model.net.vertex[3 * t];
        shapes[t] = flatten(welded[vertex[0]], welded[vertex[1]], welded[vertex[2]]);
    }
    return shapes;
}

Pose make_pose(const Model& model, std::span<const Vec3> positions) {
    std::vector<Vec3> welded(size_t(model.base.welded.vertex_count));
    weld_positions(model.base, positions, welded);
    return make_welded_pose(model, std::move(welded));
}

Pose make_welded_pose(const Model& model, std::vector<Vec3> welded) {
    Pose pose;
    pose.positions = std::move(welded);
    pose.frames.resize(model.rest.size());
    triangle_frames(model.base, pose.positions, pose.frames);
    pose.shapes = flat_triangles(model, pose.positions);
    for (const FlatTriangle& shape : pose.shapes) pose.collapsed += !shape.has_area();
    return pose;
}

std::vector<Stretch> stretches(const Model& model, const State& state,
                               std::span<const Vec3> welded_positions) {
    const std::vector<FlatTriangle> shapes = flat_triangles(model, welded_positions);
    std::vector<Stretch> out;
    for (size_t t = 0; t < shapes.size(); ++t) out.push_back(measure_stretch(state.reference[t], shapes[t]));
    return out;
}

float hem_weight(const Model& model, const Settings& settings, Index vertex) {
    const Index ring = model.border_ring[vertex];
    if (settings.hem_rings == 0 || ring == kNone || ring >= settings.hem_rings) return 1.0f;
    const float x = float(ring) / float(settings.hem_rings);
    return x * x * (3.0f - 2.0f * x);
}

Ground make_ground(const Model& model, const Settings& settings, const Paint& paint, const Pose& pose,
                   const std::vector<FlatTriangle>& reference, const std::vector<Stretch>& changes) {
    Ground ground{model, pose, {}, {}, {}};
    for (size_t t = 0; t < reference.size(); ++t) {
        ground.stretch.push_back(measure_stretch(reference[t], pose.shapes[t]));
        float mask = 0.0f;
        for (const Index corner : model.base.triangles[t].corner) {
            const float painted =
                paint.mask.empty() ? 1.0f : paint.mask[model.base.display.corner_vertex[corner]];
            mask += painted * hem_weight(model, settings, model.base.welded.corner_vertex[corner]) / 3.0f;
        }
        const float strain = std::max(changes[t].compression, changes[t].stretch) - 1.0f;
        const float x = std::clamp((strain - kHeldChange) / (kFreeChange - kHeldChange), 0.0f, 1.0f);
        ground.activity.push_back(x * x * (3.0f - 2.0f * x));
        ground.compression.push_back(1.0f + mask * (ground.stretch[t].compression - 1.0f));
    }
    return ground;
}

// Lambda_min, not its inverse, is filtered: a collapse of one frame is soon forgotten.
void smooth_in_time(const Settings& settings, double seconds, const State* state, Ground& ground) {
    if (!state) return;
    const float share = share_of(seconds, settings.smoothing);
    for (size_t t = 0; t < ground.compression.size(); ++t) {
        const float before = 1.0f / state->compression[t], now = 1.0f / ground.compression[t];
        ground.compression[t] = 1.0f / (before + share * (now - before));
    }
}

State solve(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
            const State* state, Report& report) {
    check(settings);
    check(model, paint);
    check(model, input, state);
    const Pose pose = make_pose(model, input.positions);
    const double seconds = state ? input.time - state->time : 0.0;
    State next;
    next.time = input.time;
    const std::vector<Stretch> changes = recent_changes(model, settings, input.time, pose, state);
    next.labels = label_frame(model, settings, input, pose, changes, state);
    next.reference = update_reference(model, settings, pose, next.labels, seconds, state);
    remember(settings, pose, state, next);
    report = {};
    Ground ground = make_ground(model, settings, paint, pose, next.reference, changes);
    smooth_in_time(settings, seconds, state, ground);
    next.compression = ground.compression;
    SegmentMap map(ground);
    const bool from_state = state && settings.persistent;
    if (from_state) {
        next.paths = state->paths;
        follow_all(ground, *state, settings, seconds, next.paths, report);
        live(ground, settings, seconds, next.paths, map, report);
    }
    next.next_id = state ? state->next_id : 0;
    bear(ground, settings, !from_state, next, map, report);
    report.paths = static_cast<Index>(next.paths.size());
    report.collapsed_triangles = pose.collapsed;
    for (const std::uint8_t label : next.labels) {
        report.compressed += label == kCompress;
        report.stretched += label == kStretch;
    }
    return next;
}

}  // namespace rumple::wrinkle_paths
