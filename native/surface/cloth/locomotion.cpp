// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/locomotion.h"

#include <algorithm>
#include <cmath>

#include "base/elementary.h"

namespace rumple::base_cloth {
namespace {

constexpr int kTurns = 60;                   // most iterations; a rotation by 20 degrees takes four
constexpr double kTurned = 1e-9;             // radians: the iteration ends below this
constexpr double kNoDivisionByZero = 1e-30;  // object units^4: far below any sum but 0

// axis: unit.
glm::dquat turn_about(const glm::dvec3& axis, double angle) {
    return {elementary::cos(0.5 * angle), elementary::sin(0.5 * angle) * axis};
}

// The rotation in a sum of outer products `to x from`: M. Mueller, J. Bender, N. Chentanez and M. Macklin, "A
// Robust Method to Extract the Rotational Part of Deformations", MIG 2016. It starts from the identity, so
// that there is no rotation about an axis that the sum does not determine (cloth along a line).
glm::dquat rotation_of(const glm::dmat3& sum) {
    glm::dquat turn(1.0, 0.0, 0.0, 0.0);
    for (int i = 0; i < kTurns; ++i) {
        const glm::dmat3 r = glm::mat3_cast(turn);
        glm::dvec3 axis(0.0);
        double along = 0.0;
        for (int k = 0; k < 3; ++k) {
            axis += glm::cross(r[k], sum[k]);
            along += glm::dot(r[k], sum[k]);
        }
        axis /= std::abs(along) + kNoDivisionByZero;
        const double angle = glm::length(axis);
        if (angle < kTurned) break;
        turn = glm::normalize(turn_about(axis / angle, angle) * turn);
    }
    return turn;
}

}  // namespace

RigidMotion rigid_motion(std::span<const float> area, std::span<const Vec3> from, std::span<const Vec3> to) {
    RigidMotion out;
    glm::dvec3 centre_to(0.0);
    double sum = 0.0;
    for (size_t v = 0; v < area.size(); ++v) {
        sum += double(area[v]);
        out.centre += double(area[v]) * glm::dvec3(from[v]);
        centre_to += double(area[v]) * glm::dvec3(to[v]);
    }
    if (sum <= 0.0) return {};
    out.centre /= sum;
    centre_to /= sum;
    out.displacement = centre_to - out.centre;
    glm::dmat3 products(0.0);
    for (size_t v = 0; v < area.size(); ++v) {
        products += glm::outerProduct(double(area[v]) * (glm::dvec3(to[v]) - centre_to),
                                      glm::dvec3(from[v]) - out.centre);
    }
    out.turn = rotation_of(products);
    return out;
}

RigidMotion part_of(const RigidMotion& motion, double fraction) {
    RigidMotion out = motion;
    out.displacement *= fraction;
    // The shorter of the two rotations.
    const glm::dquat turn = motion.turn.w < 0.0 ? -motion.turn : motion.turn;
    const glm::dvec3 axis(turn.x, turn.y, turn.z);
    const double sine = glm::length(axis);
    const double angle = 2.0 * elementary::atan2(sine, turn.w) * fraction;
    out.turn = sine > 0.0 ? turn_about(axis / sine, angle) : glm::dquat(1.0, 0.0, 0.0, 0.0);
    return out;
}

}  // namespace rumple::base_cloth
