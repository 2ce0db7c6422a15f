// SPDX-License-Identifier: GPL-3.0-or-later
// What bodies and cloth share where they touch: boxes and normals of triangles in a pose. Internal to
// contact.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "base/array.h"
#include "base/tolerances.h"

namespace rumple {

struct Box {
    Vec3 low{std::numeric_limits<float>::max()};
    Vec3 high{std::numeric_limits<float>::lowest()};

    void add(const Box& other) {
        low = glm::min(low, other.low);
        high = glm::max(high, other.high);
    }
    void add(const Vec3& p) { add(Box{p, p}); }
};

inline Vec3 unit_or_zero(const Vec3& v) {
    const float length = std::sqrt(glm::dot(v, v));
    return length > kShortestEdge * kShortestEdge ? v / length : Vec3(0.0f);
}

// Unit, or zero where there is no area.
struct TriangleNormals {
    std::vector<Vec3> of_face;
    std::vector<Vec3> of_vertex;  // weighted by area

    TriangleNormals(std::span<const Vec3> positions, std::span<const std::array<Index, 3>> triangles)
        : of_vertex(positions.size(), Vec3(0.0f)) {
        of_face.reserve(triangles.size());
        for (const auto& t : triangles) {
            const Vec3 n = glm::cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]);
            of_face.push_back(unit_or_zero(n));
            for (const Index v : t) of_vertex[v] += n;
        }
        for (Vec3& n : of_vertex) n = unit_or_zero(n);
    }
};

// The middle of every triangle.
inline std::vector<Vec3> centres_of(std::span<const Vec3> positions,
                                    std::span<const std::array<Index, 3>> triangles) {
    std::vector<Vec3> out;
    for (const auto& t : triangles)
        out.push_back((positions[t[0]] + positions[t[1]] + positions[t[2]]) / 3.0f);
    return out;
}

}  // namespace rumple
