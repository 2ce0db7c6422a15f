// SPDX-License-Identifier: GPL-3.0-or-later
// Normals of a garment at rest without its small folds. They describe its curvature around a leg, a sleeve or
// the trunk. Internal to surface.
#pragma once

#include <span>
#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

// Replaces the value of every welded vertex by the mean of it and its neighbours', times a share, this many
// times. share: per vertex; empty: 1.
void average_with_neighbours(const Surface& surface, int times, std::span<const float> share,
                             std::vector<Vec3>& values);

// Per welded vertex: the normal at rest, unit or zero. It is smoothed, so that shapes narrower than a tenth
// of the garment's diagonal, such as modelled folds, have no effect. Cost: at most 0.1 s for 50,000 vertices.
std::vector<Vec3> smooth_normals_at_rest(const Surface& surface);

}  // namespace rumple
