// SPDX-License-Identifier: GPL-3.0-or-later
// What positions may be: one rule for rest shapes, frames and bodies, of every system.
#pragma once

#include <string>

#include "surface/mesh/topology.h"

namespace rumple {

// Throws InvalidInput, with the first bad vertex, where a position is not finite, or has a coordinate beyond
// kFarthestCoordinate: areas squared are no floats there.
void check_coordinates(const std::string& name, std::span<const Vec3> positions);

// The same of a frame, (n) of the surface's vertices. Refused too: a vertex farther from the origin than
// kExploded sizes of the rest shape. A simulation that explodes goes there, and nothing is to be seen there:
// a float is rounded by a twentieth of the mesh. So that one wild frame spoils no later one, it is not solved
// at all. Cost: O(vertices).
void check_frame(const Surface& surface, std::span<const Vec3> positions,
                 const std::string& name = "positions");

}  // namespace rumple
