// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces that cloth must stay outside of: characters, props, other garments.
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
    // positions: in any pose, object units. triangles: counter-clockwise if seen from outside.
    // rest: the positions of the same vertices when the cloth was modelled on them, or empty. It decides
    // which triangles may be under a place of the cloth. A triangle whose position is not finite may be under
    // any place.
    // Throws InvalidInput if there is no triangle, an index is out of range, or a position is not finite.
    // Cost: O(n log^2 n).
    Collider(std::span<const Vec3> positions, std::span<const std::array<Index, 3>> triangles,
             std::span<const Vec3> rest = {}, float worn_within = 0.0f);

    Index vertex_count() const { return vertex_count_; }
    Index triangle_count() const { return static_cast<Index>(triangles_.size()); }

    // Whether a triangle may be under cloth that has this position at rest. The triangle's middle must not be
    // farther than `worn_within`, and its outer side must not face away from the cloth. The far side of an
    // arm beside a shirt faces away.
    bool may_be_under(Index triangle, const Vec3& worn_at) const;
    // The middle of a triangle at rest; nullptr if the positions at rest are unknown.
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
    std::vector<std::uint8_t> border_edges_;  // per triangle: bit k: the edge from corner k is a border
    std::vector<std::uint8_t> border_vertex_;
    std::vector<Index> part_;    // per triangle: the connected part of the bodies that it belongs to
    PacketHierarchy hierarchy_;  // of the triangles
    std::vector<Vec3> rest_centre_, rest_normal_;  // per triangle, or empty; unit or zero
    float worn_within_ = 0.0f;
};

// The nearest place of a body.
struct BodyContact {
    Index triangle = kNone;  // kNone: none within reach
    Vec3 point{0.0f};
    Vec3 normal{0.0f};      // interpolated, unit; on a border the normal of the cloth
    float distance = 0.0f;  // along the normal; negative inside
    float weight = 0.0f;    // 0..1: 1 if the body is below the point, 0 if it is beside it
    float beside = 0.0f;    // distance across the normal, object units
    bool border = false;    // whether the body ends there
};

// The nearest place of a body in front of cloth: an arm beside the trunk, or a thigh beside the other thigh.
struct BodyAhead {
    Index triangle = kNone;  // kNone: none within reach
    Vec3 point{0.0f};
    Vec3 normal{0.0f};  // interpolated, unit
};

// A collider in the pose of one frame.
class PosedCollider {
  public:
    // The collider must outlive it, but the positions need not. Throws InvalidInput if the number of
    // positions is wrong, or if one is not finite. Cost: O(triangles), about 10 ns each.
    PosedCollider(const Collider& collider, std::span<const Vec3> positions);

    // Whether these positions are exactly the positions of this pose.
    bool is_at(std::span<const Vec3> positions) const;

    // The nearest point of the body that faces the same way as the cloth (normal: of the cloth, unit). Bodies
    // are often deleted under clothes. On the border of such a hole the cloth's normal is used, because the
    // body has no side there. reach: object units, finite, and its square too. hint: a triangle that is
    // probably near, or kNone; it only makes the search faster. worn_at: position of the cloth at rest; with
    // nullptr any triangle may be under it. Because of worn_at, an arm that the animation moves into the side
    // of a shirt does not count as a body under it.
    BodyContact closest(const Vec3& p, const Vec3& normal, float reach, Index hint,
                        const Vec3* worn_at = nullptr) const;

    // The same for cloth that is at `worn_at` at rest and is known to lie on a triangle. If this triangle is
    // far from the cloth at rest, the cloth hangs free, and the triangle's position at rest replaces worn_at.
    BodyContact closest_around(const Vec3& p, const Vec3& normal, float reach, Index triangle,
                               const Vec3& worn_at) const {
        const bool known = triangle >= 0 && triangle < collider_.triangle_count();
        const bool is_free = known && !collider_.may_be_under(triangle, worn_at);
        return closest(p, normal, reach, triangle, is_free ? collider_.rest_of(triangle) : &worn_at);
    }

    // The same, but without the connected part of the bodies that contains a triangle. For example, it finds
    // the skin inside a waistband.
    BodyContact closest_of_others(const Vec3& p, const Vec3& normal, float reach, Index triangle) const;

    // The nearest point of the body that faces the cloth and is in front of it, or behind it by at most
    // `behind`. Nothing is found if that point is on a border of the body. reach, behind: object units, >= 0.
    // Cost: about 1 us.
    BodyAhead ahead(const Vec3& p, const Vec3& normal, float reach, float behind) const;

  private:
    struct Best {
        float squared;
        Index triangle = kNone;
        Vec3 weights{0.0f};
    };

    // The SolveTeam is the team of this construction.
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
