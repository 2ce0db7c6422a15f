// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes with narrow faces, on which folds would be as narrow as the faces.
#pragma once

#include "surface/mesh/topology.h"

namespace rumple {

// Whether more than a tenth of the area lies in polygons narrower than `width`, object units. The width of a
// polygon is its area / its longest side; of a triangle twice that: its height. Cost: O(corners).
bool is_uneven(const Surface& surface, float width);

}  // namespace rumple
