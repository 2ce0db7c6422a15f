// SPDX-License-Identifier: GPL-3.0-or-later
// How much lines that run straight over the surface at rest bend along it in a pose: their geodesic
// curvature. Cloth is pulled taut along straight lines, so no fold runs along one that bends. Not in the
// papers: docs/folds_on_cloth.md, "No folds along lines that bend".
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "surface/mesh/topology.h"
#include "surface/strain/deformation.h"

namespace rumple {

// A symmetric 3x3 tensor of object space.
struct Tensor3 {
    Vec3 diagonal{0.0f};      // xx, yy, zz
    Vec3 off_diagonal{0.0f};  // yz, zx, xy

    // scale times v v^T
    void add(float scale, const Vec3& v) {
        diagonal += scale * v * v;
        off_diagonal += scale * Vec3(v.y * v.z, v.z * v.x, v.x * v.y);
    }
};
// v . T v
inline float quadratic(const Tensor3& t, const Vec3& v) {
    return glm::dot(t.diagonal, v * v) +
           2.0f * glm::dot(t.off_diagonal, Vec3(v.y * v.z, v.z * v.x, v.x * v.y));
}
inline Tensor3 operator*(float scale, const Tensor3& tensor) {
    return {scale * tensor.diagonal, scale * tensor.off_diagonal};
}
inline Tensor3 operator+(const Tensor3& a, const Tensor3& b) {
    return {a.diagonal + b.diagonal, a.off_diagonal + b.off_diagonal};
}

// What the rest pose fixes: of every vertex, the weights that make a quadratic of the vertices around it.
struct BentLinesModel {
    struct Around {
        Index vertex;
        // Of its displacement from the vertex in the first and second derivatives: x, y, xx, xy, yy of the
        // vertex's tangent plane at rest. Its axes are any_tangent() of the normal, and the cross product of
        // the normal with that.
        std::array<float, 5> weight;
    };
    std::vector<Index> start{0};  // per welded vertex, into around
    std::vector<Around> around;
};

// Cost: O(vertices).
BentLinesModel build_bent_lines(const Surface& surface);

// Where the two axes of its tangent plane at rest went, of a vertex in a pose: F. Zero where nothing is
// known.
struct FirstDerivatives {
    Vec3 x{0.0f}, y{0.0f};
};
FirstDerivatives first_derivatives(const BentLinesModel& model, std::span<const Vec3> positions,
                                   size_t vertex);

// How much cloth a vertex has to spare: e . all e, for a direction e along the surface, and the part of it
// across lines that bend, which has no place. Values of several vertices may be added and scaled.
struct SpareCloth {
    Tensor3 all;
    Tensor3 without_place;

    // 0..1: of the folds across e, whose crests run at right angles to it. e: of any length but 0.
    float share_without_place(const Vec3& e) const {
        const float whole = quadratic(all, e);
        return whole > 0.0f ? std::clamp(quadratic(without_place, e) / whole, 0.0f, 1.0f) : 0.0f;
    }
};
inline SpareCloth operator*(float scale, const SpareCloth& cloth) {
    return {scale * cloth.all, scale * cloth.without_place};
}
inline SpareCloth operator+(const SpareCloth& a, const SpareCloth& b) {
    return {a.all + b.all, a.without_place + b.without_place};
}

// Per welded vertex, of both directions of principal stretch. Cloth has no place across lines that bend on
// radii of up to `radius`, object units, >= 0; all of it has on four times that and more. positions: deformed
// welded vertices. At rest, and moved rigidly, all has a place. Cost: O(vertices).
std::vector<SpareCloth> spare_cloth(const Surface& surface, const BentLinesModel& model,
                                    std::span<const Vec3> positions, float radius);

}  // namespace rumple
