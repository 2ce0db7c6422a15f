// SPDX-License-Identifier: GPL-3.0-or-later
// Normals of a surface at its vertices, and frames of its triangles.
#pragma once

#include <span>
#include <vector>

#include "base/tolerances.h"
#include "base/unit_vector.h"
#include "surface/mesh/topology.h"

namespace rumple {

// Unit normals of the welded vertices, weighted by triangle area; zero where
// every triangle around a vertex has collapsed. Cost: O(triangles).
void vertex_normals(const Surface& surface, std::span<const Vec3> positions, std::span<Vec3> normals);

std::vector<Vec3> vertex_normals(const Surface& surface, std::span<const Vec3> positions);

// Normalises a sum or mean of unit normals: unit length, or zero if they cancel out.
inline Vec3 direction_of_normals(const Vec3& sum) {
    return unit_or_zero(sum, kShortestNormal);
}

// An orthonormal frame of the surface: two axes in its plane, and its normal. Zero vectors (never NaN) where
// there is none.
struct SurfaceFrame {
    Vec3 tangent{0.0f};
    Vec3 bitangent{0.0f};
    Vec3 normal{0.0f};

    Vec3 to_object(const Vec3& local) const {
        return local.x * tangent + local.y * bitangent + local.z * normal;
    }
    Vec3 to_local(const Vec3& object) const {
        return {glm::dot(object, tangent), glm::dot(object, bitangent), glm::dot(object, normal)};
    }
};

// The frame with this unit normal whose tangent points towards a direction, projected by Gram-Schmidt. Zero
// vectors if what is left of the direction is not longer than `least`.
inline SurfaceFrame frame_towards(const Vec3& normal, const Vec3& direction, float least) {
    const Vec3 projected = direction - glm::dot(direction, normal) * normal;
    const float length = glm::length(projected);
    if (!(length > least)) return {};
    const Vec3 tangent = projected / length;
    return {tangent, glm::cross(normal, tangent), normal};
}

// The tangent is along the first edge. Zero for a collapsed triangle.
SurfaceFrame triangle_frame(const Vec3& p0, const Vec3& p1, const Vec3& p2);

// The frame of every triangle of the deformed base. Cost: O(triangles).
void triangle_frames(const Surface& surface, std::span<const Vec3> positions, std::span<SurfaceFrame> frames);
std::vector<SurfaceFrame> triangle_frames(const Surface& surface, std::span<const Vec3> positions);

}  // namespace rumple
