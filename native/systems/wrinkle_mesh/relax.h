// SPDX-License-Identifier: GPL-3.0-or-later
// The sweeps of the solver. Internal to the Wrinkle Mesh.
#pragma once

#include <span>

#include "systems/wrinkle_mesh/bounds.h"
#include "systems/wrinkle_mesh/pose.h"

namespace rumple::wrinkle_mesh {

// Gauss-Seidel (section 4.1): first within all blocks of rows, then between consecutive blocks, each colour
// by colour. Pairs that are swept at the same time share no vertex. So neither the number of threads nor the
// number of pairs per step changes a bit.
void relax_by_blocks(const Model& model, const Targets& targets, const Bounds& bounds, int iterations,
                     std::span<Vec3> positions);

// The solver as in the paper: every constraint in turn, in the order of its vertices, on one thread.
void relax_in_order(const Model& model, const Targets& targets, const Bounds& bounds, int iterations,
                    std::span<Vec3> positions);

}  // namespace rumple::wrinkle_mesh
