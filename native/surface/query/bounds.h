// SPDX-License-Identifier: GPL-3.0-or-later
// Axis-aligned boxes, in doubles. Internal to surface.
#pragma once

#include <limits>

#include "base/array.h"

namespace rumple {

struct Bounds {
    glm::dvec3 low{std::numeric_limits<double>::infinity()};
    glm::dvec3 high{-std::numeric_limits<double>::infinity()};

    void include(const glm::dvec3& p) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    void add(const Bounds& other) {
        low = glm::min(low, other.low);
        high = glm::max(high, other.high);
    }
};

inline double squared_distance(const Bounds& box, const glm::dvec3& p) {
    const glm::dvec3 outside = glm::max(glm::max(box.low - p, p - box.high), glm::dvec3(0.0));
    return glm::dot(outside, outside);
}

// 0, 1 or 2; the first of equal ones.
inline int longest_axis(const Vec3& extent) {
    return extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
}

// In the unit of the positions; 0 without positions.
inline double bounding_diagonal(std::span<const Vec3> positions) {
    Bounds box;
    for (const Vec3& p : positions) box.include(glm::dvec3(p));
    return positions.empty() ? 0.0 : glm::length(box.high - box.low);
}

}  // namespace rumple
