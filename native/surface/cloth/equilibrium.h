// SPDX-License-Identifier: GPL-3.0-or-later
// Minimises the energy of the base cloth in a frame. Internal to the base cloth.
#pragma once

#include <vector>

#include "surface/cloth/pose.h"

namespace rumple::base_cloth {

// The energy that a time step of implicit Euler adds (swing.cpp), per vertex: 1/2 (x - from) . resist (x -
// from) - push . (x - from).
struct Inertia {
    std::vector<Vec3> from;
    std::vector<Vec3> push;
    std::vector<glm::mat3> resist;  // symmetric, positive definite
};

// The energy that Newton's method minimises.
struct NewtonProblem {
    const Model& model;
    const Settings& settings;
    const Pose& pose;
    std::span<const Plane> planes;
    const Inertia* inertia = nullptr;  // none: the equilibrium
    // A Newton step is shortened if the energy after it rises more than this many times as steeply as it fell
    // before.
    double overshoot = 0.1;
};

// One Newton step. It may be too long, because springs that are slack before it and taut after it are not in
// its Hessian. Returns the largest movement of a vertex in the full step.
float newton_step(const NewtonProblem& problem, std::span<Vec3> x, Report& report);

// The team for a frame of this model.
SolveTeam team_for(const Model& model);

// solve() for an existing pose (base_cloth.cpp). body_hint: from make_pose(). before: of this model, or none.
Result solve_pose(const Model& model, const Settings& settings, const Pose& pose, bool has_bodies,
                  std::vector<Index> body_hint, const State* before);

}  // namespace rumple::base_cloth
