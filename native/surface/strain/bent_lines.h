// SPDX-License-Identifier: GPL-3.0-or-later
// The bending of lines along the surface in a pose, if they are straight on the surface at rest: their
// geodesic curvature. Cloth is pulled taut along straight lines, so no fold runs along a line that bends. Not
// from the papers: docs/folds_on_cloth.md, "No folds along lines that bend".
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "surface/mesh/topology.h"
#include "surface/strain/deformation.h"

namespace rumple {

// A symmetric 3x3 tensor in object space.
struct Tensor3 {
    Vec3 diagonal{0.0f};      // xx, yy, zz
    Vec3 off_diagonal{0.0f};  // yz, zx, xy

    // Adds scale v v^T.
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

// Depends only on the rest pose: for every vertex, the weights that fit a quadratic function to the vertices
// around it.
struct BentLinesModel {
    struct Around {
        Index vertex;
        // The weights of its displacement from the vertex in the first and second derivatives x, y, xx, xy,
        // yy. The axes are in the vertex's tangent plane at rest: any_tangent() of the normal, and the cross
        // product of the normal with it.
        std::array<float, 5> weight;
    };
    std::vector<Index> start{0};  // per welded vertex, into around
    std::vector<Around> around;
};

// Cost: O(vertices).
BentLinesModel build_bent_lines(const Surface& surface);

// The images of the two axes of a vertex's tangent plane at rest in a pose: F. Zero if it is unknown.
struct FirstDerivatives {
    Vec3 x{0.0f}, y{0.0f};
};
FirstDerivatives first_derivatives(const BentLinesModel& model, std::span<const Vec3> positions,
                                   size_t vertex);

// The cloth that a vertex has to spare: e . all e, for a direction e along the surface. without_place is its
// part across lines that bend, for which no fold is possible. Values of several vertices may be added and
// scaled.
struct SpareCloth {
    Tensor3 all;
    Tensor3 without_place;

    // The share, 0..1, of the folds across e that are not possible. Their crests are at right angles to e. e:
    // of any length but 0.
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

// Per welded vertex, the sum for both directions of principal stretch. Across lines that bend on radii of up
// to `radius` (object units, >= 0) no fold is possible; on four times this radius and more every fold is
// possible. positions: deformed welded vertices. At rest, and after a rigid motion, every fold is possible.
// Cost: O(vertices).
std::vector<SpareCloth> spare_cloth(const Surface& surface, const BentLinesModel& model,
                                    std::span<const Vec3> positions, float radius);

}  // namespace rumple
