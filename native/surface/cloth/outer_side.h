// SPDX-License-Identifier: GPL-3.0-or-later
// Garments with modelled thickness: an outer side, an inner side behind it, and rims between them. Only the
// outer side is solved as cloth. The others follow it. (Not from a paper.)
#pragma once

#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

struct OuterSide {
    // Per polygon: whether it is on the outer side, or in a part without an inner side
    std::vector<bool> polygons;
    // Object units: the median by area; 0: no thickness is modelled, and all polygons are outer
    float thickness = 0.0f;
};

// Finds the outer side by the shape at rest. A polygon is opposite to another one if that is behind it, faces
// the other way, and is nearer than a fiftieth of the bounding box's diagonal. Of two opposite sides, the
// larger one is the outer side, because it surrounds the other. A part has no modelled thickness if less than
// three tenths of it is an inner side (a hem that is turned in), or if less than seven tenths of it is
// opposite to its other side. A mesh with less than three tenths of inner sides has none either (a belt).
// Cost: about 0.5 us per polygon.
OuterSide outer_side(const Surface& surface);

}  // namespace rumple
