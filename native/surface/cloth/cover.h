// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps the smooth surface of the base cloth off bodies. Even if all vertices are outside of a body, the
// smooth surface may pass through it between them. It is for systems that do not handle bodies themselves.
#pragma once

#include <vector>

#include "surface/contact/collider.h"
#include "surface/output/attachments.h"

namespace rumple {

// The tested points of the smooth surface: the vertices, and the middles of sides and polygons.
struct CoverModel {
    Attachments samples;
};
CoverModel build_cover(const Surface& surface);

struct CoverSettings {
    float thickness = 0.003f;  // distance of the smooth surface from a body, object units, >= 0
    float depth = 0.02f;  // cloth deeper inside a body is hidden there on purpose, and not pushed out; object
                          // units, > 0
};

struct Cover {
    // How far every display vertex of the base must move outwards along its normal, object units. The
    // vertices of a triangle move as far as its deepest sample needs. This is done twice, because the smooth
    // surface moves less than its cage.
    std::vector<Vec3> lifts;
    // How far the surface around every display vertex may move inwards then, object units: 0 where it was
    // lifted, kFarthestCoordinate where no body was found.
    std::vector<float> room;
};

//   positions: per display vertex. hints: a triangle of the bodies near each vertex; kNone: no body is
//   searched. Throws InvalidInput if they do not match the surface, or if a setting is out of its range.
// Cost: about 1 us a sample with a hint.
Cover cover_over(const Surface& surface, const CoverModel& model, const CoverSettings& settings,
                 const PosedCollider& bodies, std::span<const Vec3> positions, std::span<const Index> hints);

}  // namespace rumple
