// SPDX-License-Identifier: GPL-3.0-or-later
// Where a garment is held by itself: its collar, its waistband, its cuffs.
#pragma once

#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

// How firmly every display vertex follows the animation, 0 (free) to 1 (pinned), from the open borders at
// rest: the highest one is pinned (a collar, a waistband), narrow ones more or less (a cuff at the wrist
// wholly, a short sleeve a little, a leg of trousers hardly), wide ones not at all (a hem). Of a garment that
// is a sheet (a cape, a scarf) the upper end of its outline is pinned. It fades out over a part of the
// garment's size. Connected parts are looked at one by one.
//   up: unit, object space at rest.
// Cost: O(edges log edges).
std::vector<float> suggest_follow(const Surface& surface, const Vec3& up);

// How many openings a garment has, of its connected parts the one with most: open borders that are not the
// outline of a sheet. A shirt has four, a head one, and so have a head, two arms and two feet; a skirt two,
// for a wide hem in a part with a waist is no outline.
Index count_openings(const Surface& surface);

}  // namespace rumple
