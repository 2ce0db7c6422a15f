// SPDX-License-Identifier: GPL-3.0-or-later
// How far the bare garment stands off what is worn under it.
#pragma once

#include <vector>

#include "surface/contact/collider.h"
#include "surface/mesh/topology.h"

namespace rumple {

struct ClearanceSettings {
    float thickness = 0.003f;  // of the cloth: how far it stays off a body, object units, >= 0
    float unknown = 0.01f;  // taken where no body is found: mostly because it was deleted, object units, >= 0
    float reach = 0.06f;    // bodies farther away do not count, object units, > 0
    float depth = 0.02f;    // a garment that is deeper inside a body stays there, object units, > 0
    float spread = 0.06f;   // over this length what is known fades to `unknown`, object units, > 0
};

// What is fixed at rest: the sides of the welded mesh, by vertex.
struct ClearanceModel {
    std::vector<Index> start{0};
    std::vector<Index> neighbour;
    std::vector<float> inverse_square;  // 1 / rest length^2 of that side
    std::vector<Vec3> rest;             // position, per vertex
};
ClearanceModel build_clearance(const Surface& surface);

struct Clearance {
    // Per welded vertex: how far the cloth may go inwards from its place on the bare garment, along the
    // vertex normal, object units; negative where the bare garment is inside the body and has to come out.
    std::vector<float> inwards;
    float known = 0.0f;               // share of the vertices on faces that have a body under them
    std::vector<BodyContact> bodies;  // per welded vertex: what is under it; weight 0 at `reach`. Or none
};

// Where no body is found it is filled in from the vertices around, so that the inner surface has no seam.
//   surface_points: of the vertices on the smooth bare garment; normals: unit. bodies: or none.
//   free: empty, or how far inwards each vertex may go where it hangs free of the body, else 0, object units:
//   it looks for a body so far, and may go so far where there is none.
//   hints: the triangle found for every vertex in the frame before (empty: none); gets those of this frame.
//   They make it faster and change nothing else.
// Cost: about 0.5 us a vertex.
Clearance clearance(const ClearanceModel& model, const ClearanceSettings& settings,
                    std::span<const Vec3> surface_points, std::span<const Vec3> normals,
                    std::span<const float> free, const PosedCollider* bodies, std::vector<Index>& hints);

}  // namespace rumple
