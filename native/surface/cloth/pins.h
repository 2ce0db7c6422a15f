// SPDX-License-Identifier: GPL-3.0-or-later
// Finds where a garment holds by itself: at its collar, its waistband, its cuffs.
#pragma once

#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

// How firmly every display vertex follows the animation, 0 (free) to 1 (pinned), derived from the open
// borders at rest. The highest border is pinned (a collar, a waistband). Narrow ones are pinned partly (a
// cuff at the wrist completely, a short sleeve a little, a leg of trousers hardly). Wide ones are free (a
// hem). For a sheet (a cape, a scarf) the upper end of the outline is pinned, for a garment without a border
// (trousers of games with closed ends) its upper end. The value fades out over a part of the garment's size.
// Each connected part is treated separately. On a garment that is worn, not a sheet, what is sewn on is
// pinned as a whole.
//   up: unit, object space at rest.
// Cost: O(edges log edges).
std::vector<float> suggest_follow(const Surface& surface, const Vec3& up);

// Per polygon: whether its part is sewn on another one. Nothing of it is held by the rules above, and two
// fifths or more of its vertices lie over or under another part (surface/cloth/overlaps.h): pockets, lapels,
// the shirt front in a jacket. Alone they would fall. Cost: as suggest_follow(); with such a part O(n log n).
std::vector<bool> find_sewn_on(const Surface& surface, const Vec3& up);

// The number of openings of the connected part that has most of them. An opening is an open border that is
// not the outline of a sheet. A shirt has four, a skirt two, a head one. Separate heads, arms and feet also
// give one. A wide hem is not an outline if its part has a waist.
Index count_openings(const Surface& surface);

}  // namespace rumple
