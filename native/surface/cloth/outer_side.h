// SPDX-License-Identifier: GPL-3.0-or-later
// Garments whose thickness was modelled: an outer side, an inner one behind it, and rims between them. The
// outer side is the cloth; what it does, the others do with it. (Not in a paper.)
#pragma once

#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

struct OuterSide {
    std::vector<bool>
        polygons;  // of every polygon: it is of the outer side, or of a part without an inner one
    float thickness =
        0.0f;  // object units: the median by area; 0: no thickness is modelled, all polygons count
};

// By the shape at rest. A polygon lies on another one where that is behind it, faces the other way, and is
// nearer than a fiftieth of the bounding box's diagonal. Of two sides that lie on one another the larger one
// is the outer one: it goes round. No thickness is modelled in a part of which less than three tenths is an
// inner side (a hem that is turned in), or less than seven tenths lies on its other side; nor in a mesh with
// less than three tenths of inner sides (a belt). Cost: about 0.5 us a polygon.
OuterSide outer_side(const Surface& surface);

}  // namespace rumple
