// SPDX-License-Identifier: GPL-3.0-or-later
// The sweeps of the solver. Internal to the Wrinkle Mesh.
#pragma once

#include <span>

#include "systems/wrinkle_mesh/bounds.h"
#include "systems/wrinkle_mesh/pose.h"

namespace rumple::wrinkle_mesh {

// Gauss-Seidel (section 4.1): all blocks of rows, then what lies between two of them, each colour by colour.
// What is swept at the same time shares no vertex, so neither the number of threads nor how many pairs are
// projected at a time can change a bit.
void relax_by_blocks(const Model& model, const Targets& targets, const Bounds& bounds, int iterations,
                     std::span<Vec3> positions);

// The printed solver: every constraint in turn, by the vertices it joins, on one thread.
void relax_in_order(const Model& model, const Targets& targets, const Bounds& bounds, int iterations,
                    std::span<Vec3> positions);

}  // namespace rumple::wrinkle_mesh
