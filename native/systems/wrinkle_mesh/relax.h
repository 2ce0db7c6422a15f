// SPDX-License-Identifier: GPL-3.0-or-later
// The sweeps of the solver. Internal to the Wrinkle Mesh.
#pragma once

#include <span>

#include "systems/wrinkle_mesh/bounds.h"
#include "systems/wrinkle_mesh/pose.h"

namespace rumple::wrinkle_mesh {

// Gauss-Seidel colour by colour (section 4.1). Pairs of one colour share no vertex, so their order, the
// number of threads and how many are projected at a time cannot change a bit.
void relax_coloured(const Model& model, const Targets& targets, const Bounds& bounds, int iterations,
                    std::span<Vec3> positions);

// The printed solver: every constraint in turn, by the vertices it joins, on one thread.
void relax_in_order(const Model& model, const Targets& targets, const Bounds& bounds, int iterations,
                    std::span<Vec3> positions);

}  // namespace rumple::wrinkle_mesh
