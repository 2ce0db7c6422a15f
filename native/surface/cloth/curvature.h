// SPDX-License-Identifier: GPL-3.0-or-later
// How wide the tubes are that a garment is made of: a leg, a sleeve, the trunk. Internal to surface.
#pragma once

#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

// Per welded vertex: curvature of the surface at rest, 1 / object units. 1 / R on a tube of radius R, 0 on
// what is flat; what is narrower than a tenth of the garment's diagonal, as modelled folds are, is smoothed
// away. Cost: at most 0.2 s for 50,000 vertices.
std::vector<float> curvature_at_rest(const Surface& surface);

}  // namespace rumple
