// SPDX-License-Identifier: GPL-3.0-or-later
// The number of edges from a vertex to the nearest open border. Values that fade towards hems depend on it.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/array.h"
#include "base/smooth_step.h"

namespace rumple {

// Per vertex the least number of edges to a border vertex; kNone if none can be reached. edges: pairs of
// vertices, in any order, duplicates allowed. on_border: per vertex. Cost: O(vertices + edges).
std::vector<Index> border_rings(std::span<const std::array<Index, 2>> edges,
                                const std::vector<bool>& on_border);

// 0 on open borders, 1 from ring hem_rings on, smooth between. hem_rings: >= 0; 0: 1 everywhere.
inline float hem_fade(Index ring, int hem_rings) {
    if (ring == kNone || ring >= hem_rings) return 1.0f;
    return smooth_step(0.0f, float(hem_rings), float(ring));
}

}  // namespace rumple
