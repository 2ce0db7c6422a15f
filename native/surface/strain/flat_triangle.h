// SPDX-License-Identifier: GPL-3.0-or-later
// Shapes of triangles in their own planes, and the stretch from one shape to another: Gillette 2015, section
// 4.1.1.
#pragma once

#include <cmath>

#include "base/tolerances.h"
#include "surface/strain/deformation.h"

namespace rumple {

// The shape of a triangle in its own plane: edge vectors u1 = (x1, 0) and u2 = (x2, y2), object units. All
// are zero if the area is too small to be reliable.
struct FlatTriangle {
    float x1 = 0.0f;
    float x2 = 0.0f;
    float y2 = 0.0f;

    bool has_area() const { return y2 > 0.0f; }
    float area() const { return 0.5f * x1 * y2; }
    // Whether flatten() can give it: no negative lengths, and nothing larger than the distance of two
    // coordinates.
    bool is_sound() const {
        const float most = 4.0f * kFarthestCoordinate;
        return x1 >= 0.0f && x1 <= most && std::abs(x2) <= most && y2 >= 0.0f && y2 <= most;
    }
};
FlatTriangle flatten(const Vec3& p0, const Vec3& p1, const Vec3& p2);

// Interpolates between two shapes. Squared lengths are interpolated, so that a rotation alone never shrinks a
// triangle. fraction: of b, 0..1. If one shape has no area, the result is the other one.
FlatTriangle between(const FlatTriangle& a, const FlatTriangle& b, float fraction);

// Eigenvalues of U (eq. 4.2), and the direction that is e_i in the thesis.
struct Stretch {
    float compression = 1.0f;  // lambda~_min = 1 / lambda_min, at most kMostCompression
    float stretch = 1.0f;      // lambda_max, at most kMostCompression
    Vec2 direction{1.0f,
                   0.0f};  // of strongest compression, unit, in the current triangle's plane (u1 along x)
    bool defined = false;  // false: a triangle without area, whose stretch is unknown
};

// F = [u1, u2] [u1', u2']^-1 (eq. 4.1) in frames in the planes.
Stretch measure_stretch(const FlatTriangle& reference, const FlatTriangle& current);

// F^T F of the map from one shape to another, in the plane of the first. It is exactly the identity if the
// shapes are equal. It is also the identity if one has no area, because then nothing is known.
Tensor2 metric(const FlatTriangle& from, const FlatTriangle& to);

// (cos, sin) of the rotation R in F = R U (polar decomposition); none if one shape has no area. Both shapes
// have u1 along x, so a shear still contains a rotation.
glm::dvec2 rotation(const FlatTriangle& from, const FlatTriangle& to);

// The reference of a compressed triangle after its eigenvalues have moved towards 1 by `fraction` (section
// 4.2): Sigma' = (1 - fraction) Sigma + fraction I, and [u1', u2'] = B Sigma'^-1 A^T [u1, u2].
FlatTriangle relaxed(const FlatTriangle& reference, const FlatTriangle& current, float fraction);

// The shape nearest to `reference` whose stretches relative to `rest` are at most `most`.
FlatTriangle capped(const FlatTriangle& reference, const FlatTriangle& rest, float most);

}  // namespace rumple
