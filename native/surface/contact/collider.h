// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces that cloth stays outside of: characters, props, other garments.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/array.h"
#include "surface/contact/triangle_packets.h"

namespace rumple {

// The triangles of all bodies and a bounding volume hierarchy over them. Built once, then immutable.
class Collider {
  public:
    // positions: (any pose), object units. triangles: counter-clockwise seen from outside.
    // rest: of the same vertices, where the cloth is modelled on them, or empty: it tells what may be under a
    // place of the cloth. Where it is not finite it is under any.
    // Throws InvalidInput: no triangle, an index out of range, a position that is not finite.
    // Cost: O(n log^2 n).
    Collider(std::span<const Vec3> positions, std::span<const std::array<Index, 3>> triangles,
             std::span<const Vec3> rest = {}, float worn_within = 0.0f);

    Index vertex_count() const { return vertex_count_; }
    Index triangle_count() const { return static_cast<Index>(triangles_.size()); }

    // Whether a triangle may be under cloth that is there at rest: where its middle is not farther than
    // `worn_within`, and its outer side does not face away from the cloth. The far side of an arm beside a
    // shirt does.
    bool may_be_under(Index triangle, const Vec3& worn_at) const;
    // Middle of a triangle at rest; nullptr where no rest is known.
    const Vec3* rest_of(Index triangle) const {
        return rest_centre_.empty() ? nullptr : &rest_centre_[triangle];
    }

  private:
    friend class PosedCollider;

    void mark_borders();
    void find_parts();

    Index vertex_count_ = 0;
    std::vector<std::array<Index, 3>> triangles_;
    CornersOfVertices corners_;
    std::vector<std::uint8_t> border_edges_;  // per triangle: bit k, the edge from corner k is a border
    std::vector<std::uint8_t> border_vertex_;
    std::vector<Index> part_;    // per triangle: the connected part of the bodies that it is of
    PacketHierarchy hierarchy_;  // of the triangles
    std::vector<Vec3> rest_centre_, rest_normal_;  // per triangle, or empty; unit or zero
    float worn_within_ = 0.0f;
};

// The nearest place of a body.
struct BodyContact {
    Index triangle = kNone;  // kNone: none within reach
    Vec3 point{0.0f};
    Vec3 normal{0.0f};      // interpolated, unit; on a border that of the cloth
    float distance = 0.0f;  // along the normal; negative inside
    float weight = 0.0f;    // 0..1: how far the body lies below the point, and not beside it
    float beside = 0.0f;    // distance across the normal, object units
    bool border = false;    // the body ends there
};

// The nearest place of a body in front of cloth: an arm beside a flank, a thigh beside the other.
struct BodyAhead {
    Index triangle = kNone;  // kNone: none within reach
    Vec3 point{0.0f};
    Vec3 normal{0.0f};  // interpolated, unit
};

// A collider in the pose of one frame.
class PosedCollider {
  public:
    // The collider must outlive it, the positions need not. Throws InvalidInput: another number of positions,
    // one that is not finite. Cost: O(triangles), about 10 ns each.
    PosedCollider(const Collider& collider, std::span<const Vec3> positions);

    // Whether these are its positions, to the bit.
    bool is_at(std::span<const Vec3> positions) const;

    // The nearest point of the body that faces the same way as the cloth (normal: unit, of the cloth). Bodies
    // are mostly deleted under clothes: on the border of such a hole the body has no side of its own, so the
    // cloth's counts. reach: object units, finite, its square too. hint: a triangle that is likely near, or
    // kNone; it makes it faster and changes nothing else. worn_at: where the cloth is at rest; nullptr: any
    // triangle may be under it. An arm that was animated into the flank of a shirt is not.
    BodyContact closest(const Vec3& p, const Vec3& normal, float reach, Index hint,
                        const Vec3* worn_at = nullptr) const;

    // The same of what may be under cloth that is at `worn_at` at rest and is known to lie on a triangle.
    // Where that one is far from it at rest the cloth hangs free: of what is near that one.
    BodyContact closest_around(const Vec3& p, const Vec3& normal, float reach, Index triangle,
                               const Vec3& worn_at) const {
        const bool known = triangle >= 0 && triangle < collider_.triangle_count();
        const bool is_free = known && !collider_.may_be_under(triangle, worn_at);
        return closest(p, normal, reach, triangle, is_free ? collider_.rest_of(triangle) : &worn_at);
    }

    // The same of all connected parts of the bodies but that of a triangle: skin inside a waistband.
    BodyContact closest_of_others(const Vec3& p, const Vec3& normal, float reach, Index triangle) const;

    // The nearest point of the body that faces the cloth, in front of it or at most so far behind. Where the
    // body ends nothing is found. reach, behind: object units, >= 0. Cost: about 1 us.
    BodyAhead ahead(const Vec3& p, const Vec3& normal, float reach, float behind) const;

  private:
    struct Best {
        float squared;
        Index triangle = kNone;
        Vec3 weights{0.0f};
    };

    // Its team's.
    PosedCollider(const Collider& collider, std::span<const Vec3> positions, const SolveTeam&);

    template <typename Counts>
    void look_at(const PosedPackets::Packet& packet, const PacketHierarchy::Triangles& triangles,
                 const Vec3& p, const Counts& counts, Best& best, const Vec3* worn_at = nullptr) const;
    BodyContact contact_at(const Best& best, const Vec3& p, const Vec3& normal) const;
    Vec3 point_of(const Best& best) const;
    Vec3 normal_of(const Best& best) const;
    bool on_border(Index triangle, const Vec3& weights) const;

    const Collider& collider_;
    std::vector<Row> positions_;
    TriangleNormals normals_;
    PosedPackets packets_;
};

}  // namespace rumple
