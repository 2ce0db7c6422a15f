// SPDX-License-Identifier: GPL-3.0-or-later
// The motion of a garment as a whole between two poses.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <span>

#include "base/array.h"

namespace rumple::base_cloth {

// A rotation about the garment's centre, and the displacement of the centre: object space, object units.
struct RigidMotion {
    glm::dquat turn{1.0, 0.0, 0.0, 0.0};
    glm::dvec3 centre{0.0};
    glm::dvec3 displacement{0.0};

    Vec3 of_direction(const Vec3& v) const { return Vec3(turn * glm::dvec3(v)); }
    Vec3 of_point(const Vec3& p) const {
        return Vec3(centre + displacement + turn * (glm::dvec3(p) - centre));
    }
};

// The rigid motion that fits the movement from `from` to `to` best (least squares, weighted by area).
//   area: per vertex, object units^2, >= 0; if all are 0: the identity. from, to: the same number of
//   vertices, in the same space, object units. Not checked.
// Equal poses give exactly the identity. Cost: O(vertices).
RigidMotion rigid_motion(std::span<const float> area, std::span<const Vec3> from, std::span<const Vec3> to);

// A fraction of a motion: of its rotation angle and of its displacement. fraction: 0 to 1.
RigidMotion part_of(const RigidMotion& motion, double fraction);

}  // namespace rumple::base_cloth
