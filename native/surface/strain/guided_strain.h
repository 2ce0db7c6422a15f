// SPDX-License-Identifier: GPL-3.0-or-later
// Folds along lines that an artist draws. The strain that the systems read from a pose is rotated, so that
// the strongest compression is across the lines. Not from the papers: docs/folds_on_cloth.md, "Folds along
// lines that an artist draws".
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "surface/strain/bent_lines.h"

namespace rumple {

// Whether the squares of its numbers are finite. A larger tensor counts as unknown.
inline bool has_squares(const Tensor2& tensor) {
    return tensor.xx + tensor.yy < 1e18f;
}

// F F^T of a deformation in the deformed plane, rotated. Its stretches do not change, and the smallest one is
// across `along`. `along` has the direction of the folds in this plane, and a length of 0 (no rotation) to 1.
Tensor2 turned(const Tensor2& left, const Vec2& along);

// The painted directions at every welded vertex. Built once at rest.
struct GuideLines {
    BentLinesModel around;
    std::vector<Vec2> along;  // in the tangent plane of `around`, length 0..1
};
// along: at the vertices as the artist has them, object space at rest, length 0 (no direction) to 1; both
// signs mean the same. Throws InvalidInput if they do not match the surface, are not finite, or are longer
// than 1.
std::shared_ptr<const GuideLines> build_guide_lines(const Surface& surface, std::span<const Vec3> along);
void check_along(const Surface& surface, std::span<const Vec3> along);

// Of a vertex in a pose, in object space. Values of several vertices may be added and scaled.
struct GuidedStrain {
    Tensor3 as_is;   // (F F^T)^-1
    Tensor3 turned;  // the same, rotated
    float weight = 0.0f;
    SpareCloth place;  // times the weight: no cloth to spare along the lines

    // Rest length along e for a system that reads the rotated strain / actual rest length.
    float rest_scale(const Vec3& e) const;
};
inline GuidedStrain operator*(float scale, const GuidedStrain& g) {
    return {scale * g.as_is, scale * g.turned, scale * g.weight, scale * g.place};
}
inline GuidedStrain operator+(const GuidedStrain& a, const GuidedStrain& b) {
    return {a.as_is + b.as_is, a.turned + b.turned, a.weight + b.weight, a.place + b.place};
}

// Per welded vertex. positions: deformed welded vertices. Without a painted direction both tensors are
// exactly equal. Cost: O(vertices).
std::vector<GuidedStrain> guided_strain(const GuideLines& guide, std::span<const Vec3> positions);

// The cloth to spare with painted directions: none along the lines. Lines that bend have no effect there.
SpareCloth spared_along(const SpareCloth& spare, const GuidedStrain& guided);

}  // namespace rumple
