// SPDX-License-Identifier: GPL-3.0-or-later
// Swing: the base cloth with inertia. Implicit (backward) Euler (Baraff and Witkin 1998) as the minimum of an
// energy (Gast et al. 2015): every time step adds to the energy of base_cloth.h the squared distance from
// where inertia alone would take the cloth. docs/base_cloth.md has the formulas.
#pragma once

#include "surface/cloth/base_cloth.h"

namespace rumple::base_cloth {

// From the object space of the frame before to this one's, if the object itself moved.
struct Placement {
    glm::mat3 matrix{1.0f};
    Vec3 shift{0.0f};

    Vec3 of_point(const Vec3& p) const { return matrix * p + shift; }
};

struct Swing {
    float seconds = 1.0f / 24.0f;  // time since the frame before, >= 0
    // Longest time step, s, > 0: the same value gives the same motion at any frame rate
    float longest_step = 1.0f / 60;
    int newton_steps = 4;     // for every time step, >= 1
    float damping = 10.0f;    // damping of the velocity relative to the animated one, 1/s, >= 0
    float locomotion = 0.2f;  // share of the garment's overall motion that causes inertia, 0..1
    float drag = 0.0f;        // density of the air x coefficient / (2 mass per area), 1/object unit, >= 0
    Vec3 wind{0.0f};          // velocity of the air, object space, object units / s
    Placement placement{};
    // Values per display vertex; each may be empty. Object space, object units.
    std::span<const Vec3> air{};     // velocity of the air in addition to `wind`, / s
    std::span<const Vec3> push{};    // acceleration, / s^2
    std::span<const Vec2> resist{};  // x: linear drag, 1/s; y: quadratic drag, 1/object unit; >= 0
};

// Throws InvalidInput naming the first setting out of its range. vertices: display vertices of the cloth.
void check(const Swing& swing, size_t vertices);

// The same state, but the cloth is not asleep. Use it before a solve with other settings.
State activated(State state);

// Solves one frame like solve(). Without a state with inertia the result is the equilibrium of the pose, with
// zero velocity. Cost: about 0.7 of solve() from a state, for each time step.
Result solve_swing(const Model& model, const Settings& settings, const Swing& swing, const Paint& paint,
                   std::span<const Vec3> positions, const PosedCollider* bodies, const State* state);

}  // namespace rumple::base_cloth
