// SPDX-License-Identifier: GPL-3.0-or-later
// The closest point of a triangle. One formula for one point and for four at a time.
#pragma once

#include "base/array.h"

namespace rumple {

// The weights of the second and the third corner. The weight of the first is 1 minus both.
template <typename Real>
struct ClosestPoint {
    Real v, w;
};

// Uses the Voronoi regions of the triangle. Source: Ericson 2005, Real-Time Collision Detection, 5.1.5. Real:
// float, or Lanes. d1 .. d6: dot products of the sides ab and ac with the vectors from a, b and c to the
// point. For a triangle without area it returns any of its points.
template <typename Real>
ClosestPoint<Real> closest_point(const Real& d1, const Real& d2, const Real& d3, const Real& d4,
                                 const Real& d5, const Real& d6) {
    const Real zero = d1 - d1, one = zero + 1.0f;
    const Real va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    Real v = vb, w = vc, of = va + vb + vc;  // inside
    // The book's regions in reverse order. The book takes the first region that contains the point; here the
    // last one overwrites the others.
    const auto take = [&](const auto& region, const Real& new_v, const Real& new_w, const Real& new_of) {
        v = region ? new_v : v;
        w = region ? new_w : w;
        of = region ? new_of : of;
    };
    const Real d43 = d4 - d3, d56 = d5 - d6;
    take((va <= zero) & (d43 >= zero) & (d56 >= zero), d56, d43, d43 + d56);          // side bc
    take((vb <= zero) & (d2 >= zero) & (d6 <= zero), zero, d2, d2 - d6);              // side ac
    take((d6 >= zero) & (d5 <= d6), zero, one, one);                                  // corner c
    take((vc <= zero) & (d1 >= zero) & (d3 <= zero) & (d1 > d3), d1, zero, d1 - d3);  // side ab
    take((d3 >= zero) & (d4 <= d3), one, zero, one);                                  // corner b
    take((d1 <= zero) & (d2 <= zero), zero, zero, one);                               // corner a
    of = of == zero ? one : of;
    return {v / of, w / of};
}

// The same as weights of the three corners, with sum 1. Vector: Vec3, or Vec3Lanes.
template <typename Vector>
Vector closest_weights(const Vector& p, const Vector& a, const Vector& b, const Vector& c) {
    const Vector ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const auto [v, w] =
        closest_point(dot(ab, ap), dot(ac, ap), dot(ab, bp), dot(ac, bp), dot(ab, cp), dot(ac, cp));
    return {1.0f - v - w, v, w};
}

// The weighted sum of three corners.
template <typename Vector>
Vector mixed(const Vector& weights, const Vector& a, const Vector& b, const Vector& c) {
    return weights.x * a + weights.y * b + weights.z * c;
}

}  // namespace rumple
