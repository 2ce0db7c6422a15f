// SPDX-License-Identifier: GPL-3.0-or-later
// Checks of positions: the same rules for rest shapes, frames and bodies of every system.
#pragma once

#include <string>

#include "surface/mesh/topology.h"

namespace rumple {

// Throws InvalidInput about the first vertex that is not finite, or that has a coordinate beyond
// kFarthestCoordinate, where squared areas overflow a float.
void check_coordinates(const std::string& name, std::span<const Vec3> positions);

// The same for a frame, (n) of the surface's vertices. Also refused: a vertex farther from the origin than
// kExploded sizes of the rest shape. Only an exploding simulation gets there, and nothing useful is visible:
// the rounding error of a float is a twentieth of the mesh. Such a frame is not solved at all, so that it
// cannot damage later frames. Cost: O(vertices).
void check_frame(const Surface& surface, std::span<const Vec3> positions,
                 const std::string& name = "positions");

}  // namespace rumple
