// SPDX-License-Identifier: GPL-3.0-or-later
// The clearance between the bare garment and the bodies under it.
#pragma once

#include <vector>

#include "surface/contact/collider.h"
#include "surface/mesh/topology.h"

namespace rumple {

struct ClearanceSettings {
    float thickness = 0.003f;  // of the cloth: how far it stays off a body, object units, >= 0
    // Clearance where no body is found, mostly because it was deleted; object units, >= 0
    float unknown = 0.01f;
    float reach = 0.06f;   // bodies farther away are ignored, object units, > 0
    float depth = 0.02f;   // cloth deeper inside a body is not pushed out, object units, > 0
    float spread = 0.06f;  // length over which clearance fades from bodies to `unknown`, object units, > 0
};

// The constant part, at rest: the sides of the welded mesh, by vertex.
struct ClearanceModel {
    std::vector<Index> start{0};
    std::vector<Index> neighbour;
    std::vector<float> inverse_square;  // 1 / rest length^2 of that side
    std::vector<Vec3> rest;             // position, per vertex
};
ClearanceModel build_clearance(const Surface& surface);

struct Clearance {
    // Per welded vertex: how far the cloth may move inwards from its place on the bare garment, along the
    // vertex normal, object units. Negative if the bare garment is inside the body and must move out.
    std::vector<float> inwards;
    float known = 0.0f;               // share of the vertices on faces that have a body under them
    std::vector<BodyContact> bodies;  // per welded vertex: the body under it; weight 0 at `reach`; or none
};

// Where no body is found, values are interpolated from the vertices around, so that the inner surface is
// smooth.
//   surface_points: of the vertices on the smooth bare garment; normals: unit. bodies: or none.
//   free: empty, or how far inwards each vertex may move where it hangs free of the body, else 0; object
//   units. A body is searched up to this distance. hints: the triangle found for every vertex in the frame
//   before (empty: none); receives those of this frame. They only make the search faster.
// Cost: about 0.5 us a vertex.
Clearance clearance(const ClearanceModel& model, const ClearanceSettings& settings,
                    std::span<const Vec3> surface_points, std::span<const Vec3> normals,
                    std::span<const float> free, const PosedCollider* bodies, std::vector<Index>& hints);

}  // namespace rumple
