// SPDX-License-Identifier: GPL-3.0-or-later
// How far cloth may move so that no hem lays bare what ends under it: the waistband of other trousers, skin
// that was deleted further up.
#pragma once

#include <span>
#include <vector>

#include "surface/cloth/overlaps.h"
#include "surface/contact/collider.h"
#include "surface/mesh/topology.h"

namespace rumple::base_cloth {

// The open borders of a garment at rest, without those of buttons.
struct Hems {
    struct Hem {
        std::vector<Index> vertices;  // welded
        Index part;
    };
    std::vector<Hem> all;
    std::vector<Index> part;                  // per welded vertex, or kNone (loose)
    std::vector<std::vector<Index>> of_part;  // the welded vertices of each connected part
    float together = 0.0f;  // borders that lie nearer to one another go together, object units
};
Hems find_hems(const Surface& surface);

// How far every welded vertex may leave its animated place, object units, so that a hem does not lay bare the
// border of a part that it covers at rest, nor that border come out of it. Infinity where there is none.
// overlaps: of find_overlaps(). Cost: of each part O(vertices of borders x vertices), where it covers one.
std::vector<float> room_over_parts(const Surface& surface, const Hems& hems,
                                   std::span<const Overlap> overlaps);

// The same for the borders of bodies in one frame: other garments, holes of a body. Where there is skin
// inside of a waistband, nothing is laid bare.
//   points: of the welded vertices, on the smooth bare garment; normals: unit; under: what is under each,
//   within the reach, object units. unheld: the room of a vertex that covers nothing, object units: so a body
//   that comes or goes takes it or gives it little by little.
// Cost: as above, where a body ends under a hem, and 1 us for every vertex beside its end.
std::vector<float> room_over_bodies(const Surface& surface, const Hems& hems, const PosedCollider& bodies,
                                    std::span<const BodyContact> under, std::span<const Vec3> points,
                                    std::span<const Vec3> normals, float reach, float unheld);

}  // namespace rumple::base_cloth
