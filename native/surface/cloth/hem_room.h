// SPDX-License-Identifier: GPL-3.0-or-later
// How far cloth may move without uncovering borders under its hem, like the waistband of trousers, or the
// border of deleted skin.
#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "surface/cloth/overlaps.h"
#include "surface/contact/collider.h"
#include "surface/mesh/topology.h"

namespace rumple::base_cloth {

// The open borders of a garment at rest, without those of buttons.
struct Hems {
    using Side = std::array<Index, 2>;  // welded; seen from outside, the cloth is on the left
    struct Hem {
        std::vector<Index> vertices;  // welded
        Index part;
        bool is_opening;  // as Border::is_opening
        std::vector<Side> sides{};
    };
    std::vector<Hem> all;
    std::vector<Index> part;                  // per welded vertex, or kNone (loose)
    std::vector<std::vector<Index>> of_part;  // the welded vertices of each connected part
    float together = 0.0f;  // borders nearer to each other than this move together, object units
};
Hems find_hems(const Surface& surface);

// One hem over the border of another part at rest.
struct HemOverlap {
    Index hem;                        // of Hems::all
    std::vector<Index> border{};      // welded vertices
    std::vector<Hems::Side> sides{};  // those with both ends among them
};
// overlaps: from find_overlaps().
std::vector<HemOverlap> find_hem_overlaps(const Surface& surface, const Hems& hems,
                                          std::span<const Overlap> overlaps);

// How far every welded vertex may move from its animated place, object units, so that a hem does not uncover
// the border of a part that it covers in this pose, and so that this border does not come out. Infinity
// without such a border.
//   positions, normals: welded, normals unit. most: rooms of this and more hold nothing.
// Cost: for each part that covers one O(vertices of borders x vertices).
std::vector<float> room_over_parts(const Surface& surface, const Hems& hems,
                                   std::span<const HemOverlap> overlaps, std::span<const Vec3> positions,
                                   std::span<const Vec3> normals,
                                   float most = std::numeric_limits<float>::infinity());

// The same for the borders of bodies in one frame: other garments, holes of a body. If there is skin inside a
// waistband, nothing is uncovered.
//   points: of the welded vertices, on the smooth bare garment. normals: unit. under: the body under each
//   vertex, within the reach, object units. unheld: the room of a vertex that covers nothing, object units,
//   so that the room changes gradually when a body comes or goes.
// Cost: as above if a body ends under a hem, and 1 us for every vertex near its end.
std::vector<float> room_over_bodies(const Surface& surface, const Hems& hems, const PosedCollider& bodies,
                                    std::span<const BodyContact> under, std::span<const Vec3> points,
                                    std::span<const Vec3> normals, float reach, float unheld);

}  // namespace rumple::base_cloth
