// SPDX-License-Identifier: GPL-3.0-or-later
// Chapter 4 of Gillette 2015: what compression is measured against.
#include <algorithm>
#include <cmath>
#include <string>

#include "base/errors.h"
#include "systems/wrinkle_paths_ground.h"

namespace rumple::wrinkle_paths {
namespace {

using Shapes = std::vector<FlatTriangle>;

// Poses of the past, the oldest first, that times of `ages` ask for.
class PastPoses {
  public:
    PastPoses(const Model& model, double window) : model_(model), window_(window) {}

    void add(double time, std::span<const Vec3> welded) { poses_.push_back({time, welded}); }

    // The shapes of the triangles `window` before `time`; the oldest where there is none so old.
    Shapes before(double time) const {
        const double then = time - window_;
        size_t later = 0;  // the first pose that is not before then
        while (later < poses_.size() && poses_[later].time < then) ++later;
        if (window_ <= 0.0 || later == poses_.size()) later = poses_.size() - 1;
        if (window_ <= 0.0 || later == 0 || poses_[later].time <= then)
            return flat_triangles(model_, poses_[later].positions);
        const PastPose& a = poses_[later - 1];
        const PastPose& b = poses_[later];
        Shapes shapes = flat_triangles(model_, a.positions);
        const Shapes shapes_b = flat_triangles(model_, b.positions);
        const float share = float((then - a.time) / (b.time - a.time));
        for (size_t t = 0; t < shapes.size(); ++t) shapes[t] = between(shapes[t], shapes_b[t], share);
        return shapes;
    }
    bool empty() const { return poses_.empty(); }

  private:
    struct PastPose {
        double time;
        std::span<const Vec3> positions;
    };
    const Model& model_;
    double window_;
    std::vector<PastPose> poses_;
};

PastPoses past_of(const Model& model, const Settings& settings, const State* state) {
    PastPoses past(model, settings.window);
    const size_t vertices = size_t(model.base.welded.vertex_count);
    for (size_t i = 0; state && i < state->past_times.size(); ++i)
        past.add(state->past_times[i], std::span(state->past_positions).subspan(i * vertices, vertices));
    return past;
}

void add_costs(const Shapes& before, const Shapes& now, std::vector<LabelCosts>& costs) {
    for (size_t t = 0; t < now.size(); ++t) costs.push_back(label_costs(measure_stretch(before[t], now[t])));
}

}  // namespace

std::vector<Stretch> recent_changes(const Model& model, const Settings& settings, double time,
                                    const Pose& pose, const State* state) {
    std::vector<Stretch> changes(pose.shapes.size());
    const PastPoses past = past_of(model, settings, state);
    if (past.empty()) return changes;
    const Shapes before = past.before(time);
    for (size_t t = 0; t < changes.size(); ++t) changes[t] = measure_stretch(before[t], pose.shapes[t]);
    return changes;
}

Labels label_frame(const Model& model, const Settings& settings, const Input& input, const Pose& pose,
                   const std::vector<Stretch>& changes, const State* state) {
    if (!input.labels.empty()) return {input.labels.begin(), input.labels.end()};
    const size_t triangles = model.rest.size();
    std::vector<LabelCosts> costs;
    for (const Stretch& change : changes) costs.push_back(label_costs(change));
    Pose next;
    if (!input.next_positions.empty()) {
        next = make_pose(model, input.next_positions);
        PastPoses past = past_of(model, settings, state);
        past.add(input.time, pose.positions);
        add_costs(past.before(input.next_time), next.shapes, costs);
    }
    Labels labels = cut(model.net, costs, state ? std::span(state->labels) : std::span<const std::uint8_t>());
    labels.resize(triangles);
    return labels;
}

void remember(const Settings& settings, const Pose& pose, const State* state, State& next) {
    const size_t vertices = pose.positions.size();
    size_t first = 0;  // still needed: the newest that is at least a window old, and all after it
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

std::vector<FlatTriangle> update_reference(const Model& model, const Settings& settings, const Pose& pose,
                                           const Labels& labels, double seconds, const State* state) {
    if (settings.reference == Reference::kStaticRest) return model.rest;
    const bool from_rest = settings.reference == Reference::kRestPose;
    std::vector<FlatTriangle> reference = state ? state->reference : from_rest ? model.rest : pose.shapes;
    const float share = share_in(settings.relaxation, seconds);
    const float growth = share_of(seconds, settings.growth_time);
    for (size_t t = 0; t < reference.size(); ++t) {
        const FlatTriangle& now = pose.shapes[t];
        FlatTriangle& ref = reference[t];
        if (!now.has_area()) continue;
        if (!ref.has_area()) {
            ref = now;
        } else if (labels[t] == kCompress) {
            ref = relaxed(ref, now, share);
        } else if (labels[t] == kStretch && measure_stretch(ref, now).compression < 1.0f) {
            // Both eigenvalues above one: a fold that was never seen has dissolved.
            ref = between(ref, now, growth);
        } else {
            continue;
        }
        if (from_rest) ref = capped(ref, model.rest[t], settings.growth);
    }
    return reference;
}

Labels label_clip(const Model& model, const Settings& settings, std::span<const double> times,
                  std::span<const Vec3> positions, bool raw) {
    check(settings);
    const size_t vertices = size_t(model.base.display.vertex_count);
    if (positions.size() != times.size() * vertices) {
        throw InvalidInput("positions: expected " + std::to_string(times.size()) + " frames of " +
                           std::to_string(vertices) + " vertices, got " + std::to_string(positions.size()) +
                           " vertices");
    }
    std::vector<Pose> poses;
    std::vector<LabelCosts> costs;
    size_t first = 0;  // pose that the window may still reach
    for (size_t f = 0; f < times.size(); ++f) {
        if (f > 0 && !(times[f] > times[f - 1])) {
            throw InvalidInput("times: expected ascending seconds, but frame " + std::to_string(f) +
                               " is at " + std::to_string(times[f]) + " after " +
                               std::to_string(times[f - 1]));
        }
        const std::span<const Vec3> frame = positions.subspan(f * vertices, vertices);
        check_positions(model, frame, "positions");
        poses.push_back(make_pose(model, frame));
        if (f == 0) {
            costs.assign(model.rest.size(), label_costs({}));
            continue;
        }
        PastPoses past(model, settings.window);
        while (first + 1 < f && times[first + 1] <= times[f] - settings.window) ++first;
        for (size_t i = first; i < f; ++i) past.add(times[i], poses[i].positions);
        add_costs(past.before(times[f]), poses[f].shapes, costs);
    }
    return raw ? cheapest(costs) : cut(model.net, costs, {});
}

}  // namespace rumple::wrinkle_paths
