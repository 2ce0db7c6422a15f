// SPDX-License-Identifier: GPL-3.0-or-later
// Cloth that swings, frame by frame.
#pragma once

#include "surface/cloth/swing.h"
#include "tests/base_cloth_rig.h"

namespace rumple::tests {

// Nothing acts on it: no gravity, no pull back worth the name, no contact.
inline base_cloth::Settings in_empty_space() {
    base_cloth::Settings settings;
    settings.gravity = Vec3(0.0f);
    soften(settings);
    settings.follow = 2e-6f;
    settings.smoothing = 0.0f;
    settings.room = 1e3f;
    settings.clearance.unknown = 100.0f;
    settings.most_cg_iterations = 300;
    return settings;
}

// Solved to the end, without losses but those of implicit Euler.
inline base_cloth::Swing exactly(float seconds, float longest_step) {
    base_cloth::Swing swing;
    swing.seconds = seconds;
    swing.longest_step = longest_step;
    swing.newton_steps = 20;
    swing.damping = 0.0f;
    return swing;
}

// A garment that is played.
struct Swinging {
    const Garment& garment;
    base_cloth::Settings settings;
    base_cloth::Swing swing;
    base_cloth::Paint paint;
    base_cloth::Result now;

    Swinging(const Garment& worn, const base_cloth::Settings& how, const base_cloth::Swing& swings,
             const Points& pose, base_cloth::Paint painted = {})
        : garment(worn), settings(how), swing(swings), paint(std::move(painted)) {
        now = base_cloth::solve_swing(*garment.model, settings, swing, paint, pose, nullptr, nullptr);
    }

    const base_cloth::Result& play(const Points& pose) {
        now = base_cloth::solve_swing(*garment.model, settings, swing, paint, pose, nullptr, &now.state);
        return now;
    }
    const base_cloth::Motion& motion() const { return now.state.motion; }
    // To be changed: what was at rest is so no more.
    base_cloth::Motion& disturbed() {
        now.state = base_cloth::activated(std::move(now.state));
        return now.state.motion;
    }

    double kinetic_energy() const {
        double sum = 0.0;
        for (size_t v = 0; v < now.state.motion.velocity.size(); ++v) {
            const glm::dvec3 velocity(now.state.motion.velocity[v]);
            sum += 0.5 * double(garment.model->area[v]) * glm::dot(velocity, velocity);
        }
        return sum;
    }
};

}  // namespace rumple::tests
