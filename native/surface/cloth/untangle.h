// SPDX-License-Identifier: GPL-3.0-or-later
// Opens polygons of the base cloth that have turned over. Narrow polygons that are pressed together along a
// hem may pass through one another, because the cloth does not collide with itself: then there is a slit.
#pragma once

#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

// The positions of the cloth without triangles that are turned over there and not in the animation. Around
// them the displacement from the animation becomes smooth: in up to kUntanglePasses passes each of their
// vertices gets the mean displacement of its neighbours. Those whose edges would become more than twice as
// long as at rest, and longer than in the cloth, stay. Other vertices stay to the bit.
//   animated, positions: per display vertex. Throws InvalidInput if they do not match the surface.
// Cost: O(triangles), about 30 ns each.
inline constexpr int kUntanglePasses = 8;
std::vector<Vec3> untangled(const Surface& surface, std::span<const Vec3> animated,
                            std::span<const Vec3> positions);

}  // namespace rumple
