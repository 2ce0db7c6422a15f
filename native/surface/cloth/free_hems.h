// SPDX-License-Identifier: GPL-3.0-or-later
// Hems that nothing holds. Internal to the base cloth.
#pragma once

#include <limits>
#include <vector>

#include "surface/cloth/hem_room.h"

namespace rumple::base_cloth {

// The vertex of an opening's hem nearest to a vertex, along the edges at rest. The outline of a sheet does
// not count: a cape has bones of its own, and a torn edge no body in it.
struct NearHem {
    Index vertex = kNone;                                     // kNone: its part has no opening
    float distance = std::numeric_limits<float>::infinity();  // object units
    // The neighbour that is farthest from hems, if it is farther than the vertex itself
    Index farther = kNone;
    glm::mat3 frame{0.0f};  // at rest: the normal, across, along the surface towards `farther`
};

// Per welded vertex. Cost: O(log vertices) each.
std::vector<NearHem> find_near_hems(const Surface& surface, const Hems& hems);

// Share of Settings::smoothing at a vertex. A foot tilts the hem of the leg that is skinned to it, and the
// direction that this gives its springs is none of cloth that hangs: one side of the hem was pulled up, the
// other one crushed. free: share at a hem that nothing holds, 0..1. held: painted follow of the hem there,
// 0..1. reach: distance from which on the share is 1, object units, > 0.
float share_of_smoothing(const NearHem& near, float free, float held, float reach);

// Skinning may fold the cloth above a hem inwards: hips take the hem of a shirt with them when the chest
// bends forward. Such cloth moves towards the place where it goes on as at rest from the cloth above it.
// near, held: per welded vertex; held: 0..1, 1 where it stays. reach: how far above a hem cloth may be
// folded, object units, > 0. animated: object space. Cost: O(vertices).
void unfold_hems(const Surface& surface, std::span<const NearHem> near, std::span<const float> held,
                 float reach, std::span<Vec3> animated);

}  // namespace rumple::base_cloth
