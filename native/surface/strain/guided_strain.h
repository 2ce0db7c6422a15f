// SPDX-License-Identifier: GPL-3.0-or-later
// Where an artist wants folds to run along lines: what the systems read of a pose is turned, so that the
// strongest compression lies across the lines. Not in the papers: docs/folds_on_cloth.md, "Folds along lines
// that an artist draws".
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "surface/strain/bent_lines.h"

namespace rumple {

// Whether squares of its numbers are numbers. Of what is larger nothing is known.
inline bool has_squares(const Tensor2& tensor) {
    return tensor.xx + tensor.yy < 1e18f;
}

// F F^T of a deformation in the deformed plane, turned: its stretches stay, the smallest lies across `along`,
// which has the direction of the folds in that plane and a length of 0 (as it is) to 1.
Tensor2 turned(const Tensor2& left, const Vec2& along);

// Directions that were asked for, of every welded vertex. Built once at rest.
struct GuideLines {
    BentLinesModel around;
    std::vector<Vec2> along;  // in the tangent plane that `around` has, of length 0..1
};
// along: of the vertices as the artist has them, object space at rest, of length 0 (nothing is asked) to 1;
// either sign. Throws InvalidInput when they do not match the surface, are not finite or longer than 1.
std::shared_ptr<const GuideLines> build_guide_lines(const Surface& surface, std::span<const Vec3> along);
void check_along(const Surface& surface, std::span<const Vec3> along);

// Of a vertex in a pose; object space. Values of several vertices may be added and scaled.
struct GuidedStrain {
    Tensor3 as_is;   // (F F^T)^-1
    Tensor3 turned;  // the same, turned
    float weight = 0.0f;
    SpareCloth place;  // times the weight: no cloth to spare along the lines

    // Length at rest over that at rest for a system that reads the turned strain, of what lies along e.
    float rest_scale(const Vec3& e) const;
};
inline GuidedStrain operator*(float scale, const GuidedStrain& g) {
    return {scale * g.as_is, scale * g.turned, scale * g.weight, scale * g.place};
}
inline GuidedStrain operator+(const GuidedStrain& a, const GuidedStrain& b) {
    return {a.as_is + b.as_is, a.turned + b.turned, a.weight + b.weight, a.place + b.place};
}

// Per welded vertex. positions: deformed welded vertices. Where nothing is asked both tensors are the same to
// the bit. Cost: O(vertices).
std::vector<GuidedStrain> guided_strain(const GuideLines& guide, std::span<const Vec3> positions);

// What is spared where lines are asked for: nothing along them. Lines that bend count there no longer.
SpareCloth spared_along(const SpareCloth& spare, const GuidedStrain& guided);

}  // namespace rumple
