// SPDX-License-Identifier: GPL-3.0-or-later
// From frame to frame: Gillette 2015, chapter 5. Inside this system only.
#pragma once

#include "systems/wrinkle_paths/walk.h"

namespace rumple::wrinkle_paths {

// A path that would be shorter is not born, in widths; one shorter than half of it ends.
inline constexpr float kShortestPath = 2.0f;

// A longer one is cut off, in widths: round a sleeve it would meet itself before.
inline constexpr float kLongestPath = 200.0f;

// More than kMostOverlap of a path within this of older ones, in widths: it is no fold of its own. None is
// born with more than kMostOverlapAtBirth: it would end when it has grown a little.
inline constexpr float kCrowdDistance = 0.6f;
inline constexpr float kMostOverlap = 0.6f;
inline constexpr float kMostOverlapAtBirth = 0.4f;

// Compression that a fold goes on to, and that it keeps to its end.
inline float reach_threshold(const Settings& settings) {
    return 1.0f + settings.reach * (settings.threshold - 1.0f);
}
inline float keep_threshold(const Settings& settings) {
    return 1.0f + 0.75f * settings.reach * (settings.threshold - 1.0f);
}

// Section 5.2.1: moves the inner points of a path along their edges (eq. 5.2), over vertices where they leave
// them. before: the pose that the points stood on. moved: gets the way of every inner point along its edge,
// object units.
void follow(const PathContext& context, const Pose& before, const Settings& settings, double seconds,
            std::vector<PathPoint>& points, std::vector<float>& moved);

// Section 5.2.3: lengths, merging and fading of the paths of the frame before, by age. Those that ended are
// gone. map: gets the paths that stay.
void update_lifecycle(const PathContext& context, const Settings& settings, double seconds,
                      std::vector<Path>& paths, SegmentMap& map, Report& report);

// Section 5.1: new paths between those of the map, which gets them too.
void spawn(const PathContext& context, const Settings& settings, bool grown, State& state, SegmentMap& map,
           Report& report);

// The share of a path's length that lies within `radius` of paths of the map.
float overlap(const PathContext& context, const SegmentMap& map, const std::vector<PathPoint>& points,
              float radius);

// The largest compression along a path, slivers weighted down: what keeps it alive.
float strongest(const PathContext& context, const std::vector<PathPoint>& points);

}  // namespace rumple::wrinkle_paths
