// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/strain/adaptive_reference.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <string>

#include "base/elementary.h"
#include "base/expect.h"
#include "surface/mesh/positions.h"

namespace rumple {
namespace {

using Shapes = std::vector<FlatTriangle>;

Shapes flat_triangles(const TriangleNet& net, std::span<const Vec3> welded) {
    Shapes shapes(size_t(net.triangles()));
    for (size_t t = 0; t < shapes.size(); ++t) {
        const Index* vertex = &net.vertex[3 * t];
        shapes[t] = flatten(welded[vertex[0]], welded[vertex[1]], welded[vertex[2]]);
    }
    return shapes;
}

// Poses of the past, the oldest first.
class PastPoses {
  public:
    PastPoses(const TriangleNet& net, double window) : net_(net), window_(window) {}

    void add(double time, std::span<const Vec3> welded) { poses_.push_back({time, welded}); }

    // The shapes of the triangles `window` before `time`; the oldest shapes if no pose is that old.
    Shapes before(double time) const {
        const double then = time - window_;
        size_t later = 0;  // the first pose that is not before `then`
        while (later < poses_.size() && poses_[later].time < then) ++later;
        if (window_ <= 0.0 || later == poses_.size()) later = poses_.size() - 1;
        if (window_ <= 0.0 || later == 0 || poses_[later].time <= then)
            return flat_triangles(net_, poses_[later].positions);
        const PastPose& a = poses_[later - 1];
        const PastPose& b = poses_[later];
        Shapes shapes = flat_triangles(net_, a.positions);
        const Shapes shapes_b = flat_triangles(net_, b.positions);
        const float fraction = float((then - a.time) / (b.time - a.time));
        for (size_t t = 0; t < shapes.size(); ++t) shapes[t] = between(shapes[t], shapes_b[t], fraction);
        return shapes;
    }
    bool empty() const { return poses_.empty(); }

  private:
    struct PastPose {
        double time;
        std::span<const Vec3> positions;
    };
    const TriangleNet& net_;
    double window_;
    std::vector<PastPose> poses_;
};

PastPoses past_of(const TriangleNet& net, const ReferenceSettings& settings, size_t vertices,
                  const ReferenceState* state) {
    PastPoses past(net, settings.window);
    for (size_t i = 0; state && i < state->past_times.size(); ++i)
        past.add(state->past_times[i], std::span(state->past_positions).subspan(i * vertices, vertices));
    return past;
}

void add_costs(const Shapes& before, const Shapes& now, std::vector<LabelCosts>& costs) {
    for (size_t t = 0; t < now.size(); ++t) costs.push_back(label_costs(measure_stretch(before[t], now[t])));
}

Labels label_frame(const Surface& surface, const ReferenceModel& model, const ReferenceSettings& settings,
                   const FrameTime& frame_time, const FlatPose& pose, const std::vector<Stretch>& changes,
                   const ReferenceState* state) {
    if (!frame_time.labels.empty()) return {frame_time.labels.begin(), frame_time.labels.end()};
    std::vector<LabelCosts> costs;
    costs.reserve(changes.size());
    for (const Stretch& change : changes) costs.push_back(label_costs(change));
    if (!frame_time.next_positions.empty()) {
        const std::vector<Vec3> next = weld_positions(surface, frame_time.next_positions);
        PastPoses past = past_of(model.net, settings, pose.positions.size(), state);
        past.add(frame_time.time, pose.positions);
        add_costs(past.before(frame_time.next_time), flat_triangles(model.net, next), costs);
    }
    Labels labels =
        cut_labels(model.net, costs, state ? std::span(state->labels) : std::span<const std::uint8_t>());
    labels.resize(pose.shapes.size());
    return labels;
}

// next: receives the poses that later frames need. These are the poses of `state` and this one, without those
// that are too old.
void remember(const ReferenceSettings& settings, const FlatPose& pose, const ReferenceState* state,
              ReferenceState& next) {
    const size_t vertices = pose.positions.size();
    size_t first = 0;  // the first pose that is still needed: the newest one that is at least a window old
    if (state) {
        const std::vector<double>& times = state->past_times;
        while (first + 1 < times.size() && times[first + 1] <= next.time - settings.window) ++first;
        if (settings.window <= 0.0f) first = times.size();
        next.past_times.assign(times.begin() + first, times.end());
        next.past_positions.assign(state->past_positions.begin() + first * vertices,
                                   state->past_positions.end());
    }
    next.past_times.push_back(next.time);
    next.past_positions.insert(next.past_positions.end(), pose.positions.begin(), pose.positions.end());
}

}  // namespace

float fraction_of(double seconds, double time) {
    return time > 0.0 ? float(1.0 - elementary::exp(-seconds / time)) : 1.0f;
}

float fraction_in(float share_per_thirtieth, double seconds) {
    return float(1.0 - elementary::pow(1.0 - share_per_thirtieth, 30.0 * seconds));
}

void check_reference(const ReferenceSettings& settings) {
    expect_within("window", settings.window, 0.0, 10.0);
    expect_within("relaxation", settings.relaxation, 0.0, 1.0);
    expect_within("growth", settings.growth, 1.0, 1e6);
    expect_within("growth_time", settings.growth_time, 0.0, 10.0);
}

void check_frame_time(const Surface& surface, const FrameTime& frame_time, const ReferenceState* state) {
    if (!std::isfinite(frame_time.time))
        throw InvalidInput("time: expected seconds, got a value that is not finite");
    if (!frame_time.labels.empty()) {
        expect_count("labels", frame_time.labels.size(), surface.triangles.size(), "triangles");
        for (const std::uint8_t label : frame_time.labels) {
            if (label > kStretch) throw InvalidInput("labels: expected 0..2, got " + std::to_string(label));
        }
    }
    if (!frame_time.next_positions.empty()) {
        check_frame(surface, frame_time.next_positions, "next_positions");
        if (!(frame_time.next_time > frame_time.time))
            throw InvalidInput("next_time: expected later than " + std::to_string(frame_time.time) +
                               " s, got " + std::to_string(frame_time.next_time));
    }
    if (state && state->time > frame_time.time) {
        throw InvalidInput("time: the state is of " + std::to_string(state->time) +
                           " s, later than this frame at " + std::to_string(frame_time.time));
    }
}

void check_reference(const Surface& surface, const ReferenceState& state) {
    const size_t triangles = surface.triangles.size(), vertices = size_t(surface.welded.vertex_count);
    expect_count("state.labels", state.labels.size(), triangles, "triangles");
    expect_count("state.reference", state.reference.size(), triangles, "triangles");
    if (state.past_times.empty()) throw InvalidInput("state.past_times: expected the state's own, got none");
    expect_count("state.past_positions", state.past_positions.size(), state.past_times.size() * vertices,
                 "vertices");
    const auto refuse = [](const char* name, size_t at) {
        throw InvalidInput(std::string("state.") + name + ": number " + std::to_string(at) +
                           " is out of range");
    };
    for (size_t t = 0; t < triangles; ++t) {
        if (state.labels[t] > kStretch) refuse("labels", t);
        if (!state.reference[t].is_sound()) refuse("reference", t);
    }
    for (size_t i = 0; i < state.past_times.size(); ++i) {
        if (!std::isfinite(state.past_times[i]) || !(state.past_times[i] <= state.time) ||
            (i > 0 && state.past_times[i] < state.past_times[i - 1]))
            refuse("past_times", i);
    }
    for (size_t v = 0; v < state.past_positions.size(); ++v) {
        if (!is_finite(state.past_positions[v])) refuse("past_positions", v);
    }
}

ReferenceModel build_reference(const Surface& surface) {
    ReferenceModel model;
    model.net = build_net(surface);
    model.rest = flat_triangles(model.net, surface.positions_rest);
    return model;
}

FlatPose flat_pose(const TriangleNet& net, std::vector<Vec3> welded) {
    FlatPose pose;
    pose.shapes = flat_triangles(net, welded);
    pose.positions = std::move(welded);
    return pose;
}

std::vector<Stretch> recent_changes(const ReferenceModel& model, const ReferenceSettings& settings,
                                    double time, const FlatPose& pose, const ReferenceState* state) {
    std::vector<Stretch> changes(pose.shapes.size());
    const PastPoses past = past_of(model.net, settings, pose.positions.size(), state);
    if (past.empty()) return changes;
    const Shapes before = past.before(time);
    for (size_t t = 0; t < changes.size(); ++t) changes[t] = measure_stretch(before[t], pose.shapes[t]);
    return changes;
}

std::vector<FlatTriangle> update_reference(const ReferenceModel& model, const ReferenceSettings& settings,
                                           const FlatPose& pose, const Labels& labels, double seconds,
                                           const ReferenceState* state) {
    if (settings.reference == Reference::kStaticRest) return model.rest;
    const bool from_rest = settings.reference == Reference::kRestPose;
    std::vector<FlatTriangle> reference = state ? state->reference : from_rest ? model.rest : pose.shapes;
    const float fraction = fraction_in(settings.relaxation, seconds);
    const float growth = fraction_of(seconds, settings.growth_time);
    const bool at_once = settings.growth_time <= 0.0f;  // as in the thesis
    // An error in a single frame is not a fold that dissolves. So the triangle must have stretched in the
    // frame before, too.
    const auto stretches_on = [&](size_t t) {
        return labels[t] == kStretch && (at_once || (state && state->labels[t] == kStretch));
    };
    for (size_t t = 0; t < reference.size(); ++t) {
        const FlatTriangle& now = pose.shapes[t];
        FlatTriangle& ref = reference[t];
        if (!now.has_area()) continue;
        if (!ref.has_area()) {
            ref = now;
        } else if (labels[t] == kCompress) {
            ref = relaxed(ref, now, fraction);
        } else if (stretches_on(t) && measure_stretch(ref, now).compression < 1.0f) {
            // Both eigenvalues are above one: a fold has dissolved that was already in the reference.
            ref = between(ref, now, growth);
        } else {
            continue;
        }
        if (from_rest) ref = capped(ref, model.rest[t], settings.growth);
    }
    return reference;
}

ReferenceState adapt(const Surface& surface, const ReferenceModel& model, const ReferenceSettings& settings,
                     const FrameTime& frame_time, const FlatPose& pose, const ReferenceState* before,
                     std::vector<Stretch>& changes) {
    ReferenceState next;
    next.time = frame_time.time;
    remember(settings, pose, before, next);
    changes = recent_changes(model, settings, frame_time.time, pose, before);
    next.labels = label_frame(surface, model, settings, frame_time, pose, changes, before);
    const double seconds = before ? frame_time.time - before->time : 0.0;
    next.reference = update_reference(model, settings, pose, next.labels, seconds, before);
    return next;
}

ReferenceState adapt(const Surface& surface, const ReferenceModel& model, const ReferenceSettings& settings,
                     const FrameTime& frame_time, std::span<const Vec3> welded,
                     const ReferenceState& before) {
    check_reference(settings);
    const ReferenceState* state = before.empty() ? nullptr : &before;
    if (state) check_reference(surface, *state);
    check_frame_time(surface, frame_time, state);
    std::vector<Stretch> changes;
    return adapt(surface, model, settings, frame_time, flat_pose(model.net, {welded.begin(), welded.end()}),
                 state, changes);
}

Labels label_clip(const Surface& surface, const ReferenceModel& model, const ReferenceSettings& settings,
                  std::span<const double> times, std::span<const Vec3> positions, bool raw) {
    check_reference(settings);
    const size_t vertices = size_t(surface.display.vertex_count);
    if (positions.size() != times.size() * vertices) {
        throw InvalidInput("positions: expected " + std::to_string(times.size()) + " frames of " +
                           std::to_string(vertices) + " vertices, got " + std::to_string(positions.size()) +
                           " vertices");
    }
    std::deque<std::vector<Vec3>> poses;  // welded, from frame `first` on: those within the window
    std::vector<LabelCosts> costs;
    size_t first = 0;
    for (size_t f = 0; f < times.size(); ++f) {
        if (f > 0 && !(times[f] > times[f - 1])) {
            throw InvalidInput("times: expected ascending seconds, but frame " + std::to_string(f) +
                               " is at " + std::to_string(times[f]) + " after " +
                               std::to_string(times[f - 1]));
        }
        const std::span<const Vec3> frame = positions.subspan(f * vertices, vertices);
        check_frame(surface, frame);
        std::vector<Vec3> welded = weld_positions(surface, frame);
        if (f == 0) {
            costs.assign(model.rest.size(), label_costs({}));
        } else {
            for (; first + 1 < f && times[first + 1] <= times[f] - settings.window; ++first)
                poses.pop_front();
            PastPoses past(model.net, settings.window);
            for (size_t i = 0; i < poses.size(); ++i) past.add(times[first + i], poses[i]);
            add_costs(past.before(times[f]), flat_triangles(model.net, welded), costs);
        }
        poses.push_back(std::move(welded));
    }
    return raw ? cheapest_labels(costs) : cut_clip(model.net, costs);
}

}  // namespace rumple
