// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/strain/flat_triangle.h"

#include <algorithm>
#include <cmath>

#include "base/tolerances.h"

namespace rumple {
namespace {

using glm::dmat2;
using glm::dvec2;

// F = [[xx, xy], [0, yy]] between two shapes with area.
struct Gradient {
    double xx, xy, yy;
};

Gradient gradient(const FlatTriangle& from, const FlatTriangle& to) {
    const double xx = double(to.x1) / from.x1;
    return {xx, (to.x2 - xx * from.x2) / from.y2, double(to.y2) / from.y2};
}

// F = A diag(small, large) B^T between two shapes with area, from F F^T = A diag(small^2, large^2) A^T.
struct Svd {
    double small = 1.0;
    double large = 1.0;
    dvec2 a_small{1.0, 0.0};  // first column of A; the second is at right angles to it
};

Svd decompose(const FlatTriangle& from, const FlatTriangle& to) {
    const Gradient f = gradient(from, to);
    const double xx = f.xx * f.xx + f.xy * f.xy, xy = f.xy * f.yy, yy = f.yy * f.yy;  // F F^T
    const double half = 0.5 * (xx - yy);
    const double radius = std::sqrt(half * half + xy * xy);
    Svd out;
    out.large = std::sqrt(0.5 * (xx + yy) + radius);
    out.small = f.xx * f.yy / out.large;  // from the determinant, without cancellation if it is small
    if (radius <= kSameStretch * out.large * out.large) return out;
    // The longer column of F F^T - large^2 I is the eigenvector of the smaller one.
    const double square = out.large * out.large;
    const dvec2 a(xx - square, xy), b(xy, yy - square);
    out.a_small = glm::normalize(glm::dot(a, a) > glm::dot(b, b) ? a : b);
    return out;
}

// The shape with the squared lengths |u1|^2 and |u2|^2 and the dot product u1.u2.
FlatTriangle from_gram(double g00, double g01, double g11) {
    const double x1 = std::sqrt(g00), x2 = g01 / x1;
    return {float(x1), float(x2), float(std::sqrt(std::max(g11 - x2 * x2, 0.0)))};
}

// [u1, u2], scaled by `along` in the direction `axis` and by `across` at right angles to it.
FlatTriangle scaled(const FlatTriangle& shape, const dvec2& axis, double along, double across) {
    const dvec2 u1(shape.x1, 0.0), u2(shape.x2, shape.y2), side(-axis.y, axis.x);
    const dvec2 v1(along * glm::dot(axis, u1), across * glm::dot(side, u1));
    const dvec2 v2(along * glm::dot(axis, u2), across * glm::dot(side, u2));
    const double x1 = glm::length(v1);
    return {float(x1), float(glm::dot(v1, v2) / x1), float(along * across * shape.x1 * shape.y2 / x1)};
}

}  // namespace

FlatTriangle flatten(const Vec3& p0, const Vec3& p1, const Vec3& p2) {
    const glm::dvec3 u1 = glm::dvec3(p1) - glm::dvec3(p0), u2 = glm::dvec3(p2) - glm::dvec3(p0);
    const double twice_area = glm::length(glm::cross(u1, u2));
    const double longest = std::max({glm::dot(u1, u1), glm::dot(u2, u2), glm::dot(u2 - u1, u2 - u1)});
    if (longest < double(kShortestEdge) * kShortestEdge || twice_area <= kZeroArea * longest) return {};
    const double x1 = glm::length(u1);
    return {float(x1), float(glm::dot(u1, u2) / x1), float(twice_area / x1)};
}

FlatTriangle between(const FlatTriangle& a, const FlatTriangle& b, float fraction) {
    if (!a.has_area()) return b;
    if (!b.has_area()) return a;
    const auto mix = [&](double x, double y) { return (1.0 - fraction) * x + fraction * y; };
    const auto square = [](double x) { return x * x; };
    return from_gram(mix(square(a.x1), square(b.x1)), mix(double(a.x1) * a.x2, double(b.x1) * b.x2),
                     mix(square(a.x2) + square(a.y2), square(b.x2) + square(b.y2)));
}

Stretch measure_stretch(const FlatTriangle& reference, const FlatTriangle& current) {
    if (!reference.has_area() || !current.has_area()) return {};
    const Svd svd = decompose(reference, current);
    Stretch out;
    out.compression = float(std::min(1.0 / svd.small, double(kMostCompression)));
    out.stretch = float(std::min(svd.large, double(kMostCompression)));
    out.direction = Vec2(svd.a_small);
    out.defined = true;
    return out;
}

Tensor2 metric(const FlatTriangle& from, const FlatTriangle& to) {
    if (!from.has_area() || !to.has_area()) return {1.0f, 0.0f, 1.0f};
    const Gradient f = gradient(from, to);
    return {float(f.xx * f.xx), float(f.xx * f.xy), float(f.xy * f.xy + f.yy * f.yy)};
}

dvec2 rotation(const FlatTriangle& from, const FlatTriangle& to) {
    if (!from.has_area() || !to.has_area()) return {1.0, 0.0};
    const Gradient f = gradient(from, to);
    return glm::normalize(dvec2(f.xx + f.yy, -f.xy));
}

FlatTriangle relaxed(const FlatTriangle& reference, const FlatTriangle& current, float fraction) {
    if (!reference.has_area()) return current;
    if (!current.has_area()) return reference;
    const Svd svd = decompose(reference, current);
    const auto towards_one = [&](double sigma) { return (1.0 - fraction) * sigma + fraction; };
    // A^T [u1, u2], then Sigma'^-1. B rotates the result as a whole, which does not change its shape.
    return scaled(current, svd.a_small, 1.0 / towards_one(svd.small), 1.0 / towards_one(svd.large));
}

FlatTriangle capped(const FlatTriangle& reference, const FlatTriangle& rest, float most) {
    if (!reference.has_area() || !rest.has_area()) return reference;
    const Svd svd = decompose(rest, reference);
    if (svd.large <= most) return reference;
    return scaled(reference, svd.a_small, std::min(most / svd.small, 1.0), most / svd.large);
}

}  // namespace rumple
