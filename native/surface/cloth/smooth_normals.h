// SPDX-License-Identifier: GPL-3.0-or-later
// Normals of a garment at rest without its small folds: they say how it is curved around a leg, a sleeve, the
// trunk. Internal to surface.
#pragma once

#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

// Per welded vertex: the normal at rest, unit or zero, smoothed so that what is narrower than a tenth of the
// garment's diagonal, as modelled folds are, does not count. Cost: at most 0.1 s for 50,000 vertices.
std::vector<Vec3> smooth_normals_at_rest(const Surface& surface);

}  // namespace rumple
