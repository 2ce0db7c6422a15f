// SPDX-License-Identifier: GPL-3.0-or-later
// Swing: the base cloth with inertia. Implicit (backward) Euler (Baraff and Witkin 1998) as the least of an
// energy (Gast et al. 2015): every time step adds the square of the way off where inertia would
// take the cloth to the energy of base_cloth.h. docs/base_cloth.md has the formulas.
#pragma once

#include "surface/cloth/base_cloth.h"

namespace rumple::base_cloth {

// From the object space of the frame before to that of this one, where the object itself moved.
struct Placement {
    glm::mat3 matrix{1.0f};
    Vec3 shift{0.0f};

    Vec3 of_point(const Vec3& p) const { return matrix * p + shift; }
};

struct Swing {
    float seconds = 1.0f / 24.0f;    // since the frame before, >= 0
    float longest_step = 1.0f / 60;  // of time, s, > 0: the same at all frame rates gives the same motion
    int newton_steps = 4;            // of every time step, >= 1
    float damping = 10.0f;           // of the velocity beside the animated one, 1/s, >= 0
    float locomotion = 0.2f;         // share of the garment's motion as a whole that the inertia feels, 0..1
    float drag = 0.0f;  // density of the air x coefficient / (2 mass per area), 1/object unit, >= 0
    Vec3 wind{0.0f};    // of the air, object space, object units / s
    Placement placement{};
    // Of what differs from vertex to vertex, per display vertex; each may be empty. Object space, object
    // units.
    std::span<const Vec3> air{};   // velocity of the air beside `wind`, / s
    std::span<const Vec3> push{};  // acceleration, / s^2
    std::span<const Vec2>
        resist{};  // x: taken from the velocity, 1/s; y: times its length, 1/object unit; >= 0
};

// Throws InvalidInput naming the first setting out of its range. vertices: display vertices of the cloth.
void check(const Swing& swing, size_t vertices);

// The same state, which swing() does not hold: for other settings than it was solved with.
State activated(State state);

// One frame. As solve(); without a state that swings it is the equilibrium of the pose, with no velocity.
// Cost: about 0.7 of that of solve() from a state, for each time step.
Result swing(const Model& model, const Settings& settings, const Swing& swing, const Paint& paint,
             std::span<const Vec3> positions, const PosedCollider* bodies, const State* state);

}  // namespace rumple::base_cloth
