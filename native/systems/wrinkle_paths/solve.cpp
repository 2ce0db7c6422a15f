// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "base/expect.h"
#include "base/tolerances.h"
#include "systems/wrinkle_paths/lifecycle.h"
#include "systems/wrinkle_paths/wrinkle_paths.h"

namespace rumple::wrinkle_paths {
namespace {

void check(const Model& model, const Paint& paint) {
    if (!paint.along.empty()) check_along(model.base, paint.along);
    const auto fits = [&](const char* name, const std::vector<float>& values, float low) {
        if (values.empty()) return;
        expect_count(name, values.size(), size_t(model.base.display.vertex_count),
                     "values, one per vertex of the base, or none");
        expect_each_within(name, values, low, 1.0, "vertex");
    };
    fits("paint.mask", paint.mask, 0.0f);
    fits("paint.width", paint.width, kLeastWidth);
}

void check(const Model& model, const Input& input, const State* state) {
    if (state) check(model, *state);
    check_frame_time(model.base, input.frame_time, state ? &state->reference : nullptr);
}

// Section 5.2.1 for all paths, and statistics about the movement of their points.
void follow_all(const PathContext& context, const State& state, const Settings& settings, double seconds,
                std::vector<Path>& paths, Report& report) {
    const size_t vertices = context.pose.base.positions.size();
    const Pose before =
        make_welded_pose(context.model, {state.reference.past_positions.end() - std::ptrdiff_t(vertices),
                                         state.reference.past_positions.end()});
    std::vector<float> moved;
    for (Path& path : paths) follow(context, before, settings, seconds, path.points, moved);
    if (moved.empty()) return;
    double sum = 0.0;
    for (const float length : moved) sum += length;
    std::sort(moved.begin(), moved.end());
    // With the smallest possible width the quotient would be infinite.
    const auto in_widths = [&](double length) {
        return float(std::min(length / double(settings.width), double(std::numeric_limits<float>::max())));
    };
    report.moved_mean = in_widths(sum / double(moved.size()));
    report.moved_most = in_widths(moved[moved.size() * 99 / 100]);
}

}  // namespace

void check(const Model& model, const State& state) {
    check_reference(model.base, state.reference);
    expect_count("state.compression", state.compression.size(), model.triangles.rest.size(), "triangles");
    const auto refuse = [](const char* name, size_t at) {
        throw InvalidInput(std::string("state.") + name + ": number " + std::to_string(at) +
                           " is out of range");
    };
    expect_count("state.shapes", state.shapes.size(), model.triangles.rest.size(), "triangles");
    for (size_t t = 0; t < state.compression.size(); ++t) {
        if (!state.shapes[t].is_sound()) refuse("shapes", t);
        if (!(state.compression[t] > 0.0f && state.compression[t] <= kMostCompression))
            refuse("compression", t);
    }
    if (!state.width.empty())
        expect_count("state.width", state.width.size(), model.triangles.rest.size(), "triangles");
    for (size_t t = 0; t < state.width.size(); ++t) {
        if (!(state.width[t] >= kLeastWidth && state.width[t] <= 1.0f)) refuse("width", t);
    }
    for (size_t i = 0; i < state.paths.size(); ++i) {
        if (!(state.paths[i].fade >= 0.0f && state.paths[i].fade <= 1.0f)) refuse("path_fade", i);
    }
    const std::string wrong = validate(model, state.paths);
    if (!wrong.empty()) throw InvalidInput("state.paths: " + wrong);
}

State solve(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
            const Pose& pose, const State* state, Report& report) {
    check(settings);
    check(model, paint);
    check(model, input, state);
    report = {};
    const double seconds = state ? input.frame_time.time - state->reference.time : 0.0;
    State next;
    next.next_id = state ? state->next_id : 0;
    std::vector<Stretch> changes;
    next.reference = adapt(model.base, model.triangles, settings.rest, input.frame_time, pose.base,
                           state ? &state->reference : nullptr, changes);
    next.shapes = smoothed_shapes(settings, seconds, state, pose);
    const PathContext context =
        make_context(model, settings, paint, pose, next.shapes, next.reference.reference, changes);
    next.compression = context.compression;
    next.width = context.widths;

    SegmentMap map(context);
    const bool goes_on = state && settings.persistent;
    if (goes_on) {
        next.paths = state->paths;
        follow_all(context, *state, settings, seconds, next.paths, report);
        update_lifecycle(context, settings, seconds, next.paths, map, report);
    }
    spawn(context, settings, !goes_on, next, map, report);

    report.paths = static_cast<Index>(next.paths.size());
    report.collapsed_triangles = pose.collapsed;
    for (const std::uint8_t label : next.reference.labels) {
        report.compressed += label == kCompress;
        report.stretched += label == kStretch;
    }
    return next;
}

}  // namespace rumple::wrinkle_paths
