// SPDX-License-Identifier: GPL-3.0-or-later
// A coarse cloth that is outside a body at its vertices may pass through it between them, where its smooth
// surface cuts a corner. For what lies on the base cloth and knows no bodies itself.
#pragma once

#include <vector>

#include "surface/contact/collider.h"
#include "surface/output/attachments.h"

namespace rumple {

// Points of the smooth surface that are looked at: the vertices, and the middles of sides and polygons.
struct CoverModel {
    Attachments samples;
};
CoverModel build_cover(const Surface& surface);

struct CoverSettings {
    float thickness = 0.003f;  // that the smooth surface is to stay off a body, object units, >= 0
    float depth = 0.02f;       // what is deeper inside a body stays there: it is hidden, object units, > 0
};

// How every vertex of the base, as the artist has it, has to move: outwards along its normal, object units.
// The vertices of a triangle rise by what its deepest sample needs; twice, for the smooth surface rises less
// than its cage.
//   positions: of the base's vertices as the artist has them. hints: a triangle of the bodies near each, or
//   kNone: none is looked for there. Throws InvalidInput when they do not match the surface, or a setting is
//   out of its range.
// Cost: about 1 us a sample with a hint.
std::vector<Vec3> lifts_over(const Surface& surface, const CoverModel& model, const CoverSettings& settings,
                             const PosedCollider& bodies, std::span<const Vec3> positions,
                             std::span<const Index> hints);

}  // namespace rumple
