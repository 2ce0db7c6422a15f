// SPDX-License-Identifier: GPL-3.0-or-later
// How many edges lie between a vertex and the nearest open border: what fades towards hems goes by that.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/array.h"
#include "base/smooth_step.h"

namespace rumple {

// Per vertex the fewest edges to one on a border; kNone where none can be reached. edges: pairs of vertices,
// in any order, some may be there twice. on_border: of every vertex. Cost: O(vertices + edges).
std::vector<Index> border_rings(std::span<const std::array<Index, 2>> edges,
                                const std::vector<bool>& on_border);

// 0 on open borders, 1 from ring hem_rings on, smooth between. hem_rings: >= 0; 0: 1 everywhere.
inline float hem_fade(Index ring, int hem_rings) {
    if (ring == kNone || ring >= hem_rings) return 1.0f;
    return smooth_step(0.0f, float(hem_rings), float(ring));
}

}  // namespace rumple
