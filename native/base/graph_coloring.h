// SPDX-License-Identifier: GPL-3.0-or-later
// Graph colouring: constraints that share no vertex may be solved at the same time.
#pragma once

#include <span>
#include <vector>

#include "base/array.h"

namespace rumple {

// Returns a colour (from 0, without gaps) for every constraint between pairs_a[i] and pairs_b[i], so that no
// two constraints of one colour share a vertex. First fit in the given order, so the same input gives the
// same colours. If no vertex has more than d constraints, a constraint meets at most 2 (d - 1) others, so
// there are at most 2 d - 1 colours (Vizing: no colouring has fewer than d). Cost: O(constraints x d).
std::vector<Index> color_constraints(Index vertex_count, std::span<const Index> pairs_a,
                                     std::span<const Index> pairs_b);

}  // namespace rumple
