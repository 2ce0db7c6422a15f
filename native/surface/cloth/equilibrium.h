// SPDX-License-Identifier: GPL-3.0-or-later
// One frame of the base cloth and the search for its equilibrium. Internal to the base cloth.
#pragma once

#include <vector>

#include "surface/cloth/base_cloth.h"
#include "surface/deformation.h"

namespace rumple::base_cloth {

// The plane that stands for the inner surface near a vertex.
struct Plane {
    Vec3 point{0.0f};
    Vec3 normal{0.0f};
};

inline float height_above(const Plane& plane, const Vec3& p) {
    return glm::dot(p - plane.point, plane.normal);
}

// One frame, as the solver sees it. Per welded vertex.
struct Pose {
    std::vector<Vec3> animated;
    std::vector<Vec3> normal;
    std::vector<TriangleFrame> frame;  // tangent frames: rigid motion carries them along
    std::vector<Vec3> inner;           // the inner surface: what cloth stays outside of
    struct Ball {
        Vec3 centre;
        float radius;
    };
    std::vector<Ball> ball;  // around every triangle of the inner surface
    std::vector<float> clearance;
    float body_known = 0.0f;    // share of the vertices that have a body under them
    std::vector<float> length;  // of every spring
    std::vector<float> follow;  // 1/s^2
    std::vector<float> room;
};

struct Cloth {
    const Model& model;
    const Settings& settings;
    const Pose& pose;
    std::span<const Plane> planes;
};

// One Newton step, shortened where it went too far: springs that are slack here and taut there are not in its
// Hessian. Returns the farthest way of a vertex.
float newton_step(const Cloth& cloth, std::span<Vec3> x, Report& report);

}  // namespace rumple::base_cloth
