// SPDX-License-Identifier: GPL-3.0-or-later
// The search for the least energy of the base cloth in a frame. Internal to the base cloth.
#pragma once

#include <vector>

#include "surface/cloth/pose.h"

namespace rumple::base_cloth {

// What a time step of implicit Euler adds to the energy (swing.cpp): per vertex half of
// (x - from) . resist (x - from) - push . (x - from).
struct Inertia {
    std::vector<Vec3> from;
    std::vector<Vec3> push;
    std::vector<glm::mat3> resist;  // symmetric, positive definite
};

struct Cloth {
    const Model& model;
    const Settings& settings;
    const Pose& pose;
    std::span<const Plane> planes;
    const Inertia* inertia = nullptr;  // none: the equilibrium
    // A Newton step is shortened where the energy behind it rises so many times as steeply as it fell before.
    double overshoot = 0.1;
};

// One Newton step. Springs that are slack before it and taut behind it are not in its Hessian, so it may go
// too far. Returns the farthest way of a vertex, had it not been shortened.
float newton_step(const Cloth& cloth, std::span<Vec3> x, Report& report);

// Of a frame of this model.
SolveTeam team_for(const Model& model);

// solve() in a pose that is made (base_cloth.cpp). body_hint: that make_pose() found. before: of this model,
// or none.
Result solve_pose(const Model& model, const Settings& settings, const Pose& pose, bool has_bodies,
                  std::vector<Index> body_hint, const State* before);

}  // namespace rumple::base_cloth
