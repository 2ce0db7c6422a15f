// SPDX-License-Identifier: GPL-3.0-or-later
// Paths from frame to frame: Gillette 2015, chapter 5. Only used inside this system.
#pragma once

#include "systems/wrinkle_paths/walk.h"

namespace rumple::wrinkle_paths {

// Least length of a new path / width. A path that becomes shorter than half of it ends.
inline constexpr float kShortestPath = 2.0f;

// Largest length of a path / width. A longer one is cut: around a sleeve it would meet itself earlier.
inline constexpr float kLongestPath = 200.0f;

// A path ends if more than kMostOverlap of it is closer to older paths than kCrowdDistance (in widths). A new
// path needs a smaller overlap, kMostOverlapAtBirth, because otherwise it would end after a little growth.
inline constexpr float kCrowdDistance = 0.6f;
inline constexpr float kMostOverlap = 0.6f;
inline constexpr float kMostOverlapAtBirth = 0.4f;

// The compression down to which a fold grows, and the one down to which its end stays.
inline float reach_threshold(const Settings& settings) {
    return 1.0f + settings.reach * (settings.threshold - 1.0f);
}
inline float keep_threshold(const Settings& settings) {
    return 1.0f + 0.75f * settings.reach * (settings.threshold - 1.0f);
}

// Section 5.2.1: moves the inner points of a path along their edges (eq. 5.2). If they leave an edge, they
// pass over its vertex. before: the pose of the points. moved: receives the displacement of every inner point
// along its edge, object units.
void follow(const PathContext& context, const Pose& before, const Settings& settings, double seconds,
            std::vector<PathPoint>& points, std::vector<float>& moved);

// Section 5.2.3: updates lengths, merges and fades of the paths of the frame before, by age. Removes paths
// that ended. map: receives the remaining paths.
void update_lifecycle(const PathContext& context, const Settings& settings, double seconds,
                      std::vector<Path>& paths, SegmentMap& map, Report& report);

// Section 5.1: creates new paths between those of the map, and adds them to it.
void spawn(const PathContext& context, const Settings& settings, bool grown, State& state, SegmentMap& map,
           Report& report);

// The share of a path's length within `radius` of paths of the map.
float overlap(const PathContext& context, const SegmentMap& map, const std::vector<PathPoint>& points,
              float radius);

// The largest compression along a path, with a smaller weight for slivers. A path lives while it is large
// enough.
float strongest(const PathContext& context, const std::vector<PathPoint>& points);

}  // namespace rumple::wrinkle_paths
