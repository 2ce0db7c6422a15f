// SPDX-License-Identifier: GPL-3.0-or-later
// Where one part of a garment lies over another: straps over a shirt, a jacket over trousers.
#pragma once

#include <vector>

#include "surface/mesh/topology.h"
#include "surface/refine/refinement.h"

namespace rumple::base_cloth {

// A vertex and a place of another part that is under or over it. Both face the same way.
struct Overlap {
    Index vertex;  // welded
    SurfacePoint place;
    bool outer;  // whether the vertex is over the place
};

// For each vertex at most one place under it and one over it: the nearest at rest, within a thirtieth of the
// garment's diagonal. In the order of the vertices. Cost: O(n log n); O(edges) for a garment in one part.
std::vector<Overlap> find_overlaps(const Surface& surface);

}  // namespace rumple::base_cloth
