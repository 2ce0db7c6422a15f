// SPDX-License-Identifier: GPL-3.0-or-later
// Section 5.2.3 of Gillette 2015: folds grow, shrink, merge and end.
#include "systems/wrinkle_paths/lifecycle.h"

#include <algorithm>
#include <cmath>

#include "base/elementary.h"
#include "base/tolerances.h"

namespace rumple::wrinkle_paths {
namespace {

using glm::dvec2;

// The length to remove from the last half of a path: where the compression is too low, and beyond a crossing
// with an older path.
float surplus(const PathContext& context, const Settings& settings, const SegmentMap& map,
              const std::vector<PathPoint>& points, bool& crosses) {
    const std::vector<Vec3> at = positions(context, points);
    const float half = 0.5f * length(context, points);
    float travelled = 0.0f, cut = 0.0f;
    bool slack = true;
    for (size_t i = points.size() - 1; i > 0 && travelled < half; --i) {
        const Index t = segment_triangle(context.model, points, i - 1);
        const float size = glm::distance(at[i - 1], at[i]);
        const dvec2 a = context.to_flat(t, at[i]), b = context.to_flat(t, at[i - 1]);
        slack = slack && context.compression[t] < keep_threshold(settings);
        if (slack) cut = travelled + size;
        map.in_triangle(t, [&](const SegmentMap::Segment& s) {
            double fraction = 0.0;
            if (!segments_cross(a, b, context.to_flat(t, s.a), context.to_flat(t, s.b), fraction)) return;
            const float beyond = travelled + float(fraction) * size;
            crosses = crosses || beyond > kStill * settings.width;
            cut = std::max(cut, beyond);
        });
        travelled += size;
    }
    return cut;
}

// Removes `amount` from the end, but keeps at least one segment.
void shorten(const PathContext& context, std::vector<PathPoint>& points, float amount) {
    while (true) {
        const size_t last = points.size() - 1;
        const Index t = segment_triangle(context.model, points, last - 1);
        const dvec2 a = flat_in(context, t, points[last]), b = flat_in(context, t, points[last - 1]);
        const float size = float(glm::distance(a, b));
        if (size > amount || last == 1) {
            const double fraction = size > 0.0f ? std::min(amount, 0.9f * size) / size : 0.0f;
            points[last] = inside(context, t, glm::mix(a, b, fraction));
            return;
        }
        amount -= size;
        points.pop_back();
    }
}

// Extends the path, first straight in the end's triangle, then like a new path.
bool lengthen(const PathContext& context, const Settings& settings, const SegmentMap& map, float amount,
              std::vector<PathPoint>& points) {
    const size_t last = points.size() - 1;
    const Index t = points[last].triangle;
    const dvec2 from = flat_in(context, t, points[last - 1]), at = flat_in(context, t, points[last]);
    const double size = glm::distance(from, at);
    if (size <= 0.0 || context.compression[t] < reach_threshold(settings)) return false;
    WalkLimits limits;
    limits.compression = reach_threshold(settings);
    limits.length = amount;
    limits.others = &map;
    limits.turned = turning(context, points);
    std::vector<Index> visited;
    for (size_t i = 0; i < last; ++i) visited.push_back(segment_triangle(context.model, points, i));
    const Walk more = walk(context, t, at, (at - from) / size, limits, visited);
    if (more.length < kStill * settings.width) return false;
    points.pop_back();
    points.insert(points.end(), more.points.begin(), more.points.end());
    return true;
}

// Returns whether the end has moved.
bool update_end(const PathContext& context, const Settings& settings, const SegmentMap& map, float most,
                std::vector<PathPoint>& points, bool& crosses) {
    if (!context.pose.base.shapes[points.back().triangle].has_area()) return false;
    const float cut = std::min(surplus(context, settings, map, points, crosses), most);
    if (cut <= 0.0f) return lengthen(context, settings, map, most, points);
    if (cut < kStill * settings.width) return false;
    shorten(context, points, cut);
    return true;
}

// Moves a value towards a target; a change of 1 takes `fade` seconds.
void approach(float& value, float target, double seconds, float fade) {
    const float step = fade > 0.0f ? float(seconds / fade) : 1.0f;
    value = std::clamp(target, value - step, value + step);
}

}  // namespace

void update_lifecycle(const PathContext& context, const Settings& settings, double seconds,
                      std::vector<Path>& paths, SegmentMap& map, Report& report) {
    std::vector<Path> left;
    for (Path& path : paths) {
        const size_t middle = (path.points.size() - 1) / 2;
        const float width =
            settings.width * context.width(segment_triangle(context.model, path.points, middle));
        const float size = std::max(length(context, path.points), kShortestPath * width);
        const float most =
            0.5f * size * float(elementary::pow(1.0 + settings.growth_limit, 30.0 * seconds) - 1.0);
        bool crosses = false;
        update_end(context, settings, map, most, path.points, crosses);
        std::vector<PathPoint> backwards = reversed(context.model, path.points);
        if (update_end(context, settings, map, most, backwards, crosses))
            path.points = reversed(context.model, backwards);
        report.merging += crosses;

        const float compression = strongest(context, path.points);
        // An error in a single frame is over before a fold has grown. So until then it needs the compression
        // of a new fold.
        const float needed = path.fade < 1.0f ? settings.threshold : reach_threshold(settings);
        const bool alive = compression >= needed &&
                           length(context, path.points) >= 0.5f * kShortestPath * width &&
                           overlap(context, map, path.points, kCrowdDistance * width) <= kMostOverlap;
        approach(path.fade, alive ? 1.0f : 0.0f, seconds, settings.fade);
        if (!alive && path.fade <= 0.0f) {
            ++report.died;
            continue;
        }
        if (alive) map.add(path.points);
        left.push_back(std::move(path));
    }
    paths = std::move(left);
}

}  // namespace rumple::wrinkle_paths
