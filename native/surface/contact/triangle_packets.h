// SPDX-License-Identifier: GPL-3.0-or-later
// The triangles of a surface in packets of four, and a hierarchy with four children per node over them. Four
// boxes, or four triangles, are tested at once. Internal to contact.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/solve_team.h"
#include "base/tolerances.h"
#include "base/unset_vector.h"
#include "surface/contact/posed_triangles.h"
#include "surface/query/closest_point.h"

namespace rumple {

// The square of a search distance. It is below infinity, the distance of lanes without a triangle.
inline float squared_reach(float reach) {
    return std::min(reach * reach, std::numeric_limits<float>::max());
}

// The grouping of triangles. Built once at rest, then immutable.
struct PacketHierarchy {
    static constexpr Index kEmpty = std::numeric_limits<Index>::min();
    struct Node {
        std::array<Index, kLanes> child;  // a node; -1 - packet; or kEmpty
    };
    using Triangles = std::array<Index, kLanes>;  // of a packet; kNone in lanes without a triangle
    std::vector<Node> nodes;                      // level by level from the root; none without triangles
    std::vector<Index> level_start;               // levels + 1: the first node of every level
    std::vector<Triangles> packets;
    std::vector<Index> packet_of;  // per triangle
};

// Groups triangles by their centres (finite, object units). Cost: O(n log^2 n).
PacketHierarchy build_packets(std::span<const Vec3> centres);

// The packets in the pose of one frame.
class PosedPackets {
  public:
    struct Packet {
        Vec3Lanes a, b, c, normal;  // corners; unit normal, or zero. An empty lane is infinitely far
    };

    // normals: of the triangles, unit or zero. Cost: about 10 ns per triangle.
    PosedPackets(const PacketHierarchy& hierarchy, std::span<const Row> positions,
                 std::span<const std::array<Index, 3>> triangles, std::span<const Row> normals);

    // A filter: it leaves out a node if none of its triangles has a normal whose dot product with `direction`
    // is at most `most`.
    struct NoneFaces {
        Vec3 direction;
        float most;
    };

    // Calls look_at(packet, its triangles) for the packet of a triangle.
    template <typename LookAt>
    void look_around(Index triangle, LookAt&& look_at) const {
        const Index packet = hierarchy_.packet_of[triangle];
        look_at(packets_[packet], hierarchy_.packets[packet]);
    }

    // Calls look_at(packet, its triangles) for packets within a squared distance, near ones first. best: the
    // best squared distance so far, which look_at decreases. none_faces: filter of nodes, or nullptr.
    template <typename LookAt>
    void search(const Vec3& p, const float& best, const NoneFaces* none_faces, LookAt&& look_at) const;

  private:
    struct Boxes {
        Vec3Lanes low, high;

        Lanes squared_distance(const Vec3Lanes& p) const;
        Lanes least_along(const Vec3Lanes& direction) const;
    };
    struct alignas(64) Node {
        Boxes places;    // of the children; the box of an empty one is infinitely far
        LaneMask child;  // as in PacketHierarchy
        Boxes normals;
    };
    struct Volume {  // of a packet, or of all packets below a node
        Box place, normal;
    };

    // Fill in a packet, or a node from the volumes of its children, and return its volume.
    Volume place_packet(size_t packet, std::span<const Row> positions,
                        std::span<const std::array<Index, 3>> triangles, std::span<const Row> normals);
    Volume place_node(size_t node, std::span<const Volume> of_packet, std::span<const Volume> of_node);

    const PacketHierarchy& hierarchy_;
    UnsetVector<Packet> packets_;
    UnsetVector<Node> nodes_;
};

// The vectors to the closest points of four triangles.
struct ClosestOfFour {
    ClosestPoint<Lanes> at;
    Vec3Lanes way;  // from the point to the closest points
    Lanes squared;  // squared lengths
};
inline ClosestOfFour closest_of(const PosedPackets::Packet& t, const Vec3Lanes& p) {
    const Vec3Lanes ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a, bp = p - t.b, cp = p - t.c;
    ClosestOfFour out;
    out.at = closest_point(dot(ab, ap), dot(ac, ap), dot(ab, bp), dot(ac, bp), dot(ab, cp), dot(ac, cp));
    out.way = out.at.v * ab + out.at.w * ac - ap;
    out.squared = dot(out.way, out.way);
    return out;
}

inline Lanes PosedPackets::Boxes::squared_distance(const Vec3Lanes& p) const {
    const auto outside = [](const Lanes& lowest, const Lanes& highest, const Lanes& x) {
        return most(most(lowest - x, x - highest), Lanes{});
    };
    const Vec3Lanes way{outside(low.x, high.x, p.x), outside(low.y, high.y, p.y),
                        outside(low.z, high.z, p.z)};
    return dot(way, way);
}

inline Lanes PosedPackets::Boxes::least_along(const Vec3Lanes& direction) const {
    return least(direction.x * low.x, direction.x * high.x) +
           least(direction.y * low.y, direction.y * high.y) +
           least(direction.z * low.z, direction.z * high.z);
}

// A waiting child: the bits of its squared distance, followed by the bits of the child; 0 for none. The
// distance is at least 0, so its bits have the same order as its value.
using WaitingChild = uint64_t;
using WaitingChildren = std::array<WaitingChild, kLanes>;
inline WaitingChildren waiting_children(const Lanes& squared, const LaneMask& child, const LaneMask& open) {
    static_assert(std::endian::native == std::endian::little);
    const LaneMask far = std::bit_cast<LaneMask>(squared) & open, which = child & open;
    return std::bit_cast<WaitingChildren>(std::array{__builtin_shufflevector(which, far, 0, 4, 1, 5),
                                                     __builtin_shufflevector(which, far, 2, 6, 3, 7)});
}
inline float squared_of(WaitingChild waiting) {
    return std::bit_cast<float>(static_cast<uint32_t>(waiting >> 32));
}
inline Index child_of(WaitingChild waiting) {
    return static_cast<Index>(static_cast<uint32_t>(waiting));
}

// Puts the open children on a stack, the nearest last, and returns their number. Writes kLanes entries. It
// selects and sorts without branches: whether a box is near is practically random, and a mispredicted branch
// costs more than the box. No child is the root, so no entry of a waiting child is 0.
inline int push_nearest_last(const Lanes& squared, const LaneMask& child, const LaneMask& open,
                             WaitingChild* top) {
    constexpr std::array<std::uint8_t, 16> kTrue{0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};  // bits set
    WaitingChildren waiting = waiting_children(squared, child, open);
    const auto larger_first = [&](int i, int j) {
        const WaitingChild a = waiting[i], b = waiting[j];
        waiting[i] = std::max(a, b);
        waiting[j] = std::min(a, b);
    };
    larger_first(0, 1);
    larger_first(2, 3);
    larger_first(0, 2);
    larger_first(1, 3);
    larger_first(1, 2);
    std::copy(waiting.begin(), waiting.end(), top);
    return kTrue[bits_of(open)];
}

template <typename LookAt>
void PosedPackets::search(const Vec3& p, const float& best, const NoneFaces* none_faces,
                          LookAt&& look_at) const {
    constexpr int kMostWaiting = 64;  // three siblings per level; the depth is log4 of the packets
    WaitingChild stack[kMostWaiting];
    int top = 0;
    // Distances are rounded, also relative to the size of p. Among equal distances the lowest triangle must
    // be found in any order of the search: (sqrt(best) + rounding)^2 <= (1 + s) best + (1 + 1 / s)
    // rounding^2.
    const float rounding = kPlaceRounding * (std::abs(p.x) + std::abs(p.y) + std::abs(p.z));
    const float always = (1.0f + 1.0f / kPacketTieSlack) * rounding * rounding;
    if (!nodes_.empty()) stack[top++] = 0;
    const Vec3Lanes at(p), direction(none_faces ? none_faces->direction : Vec3(0.0f));
    while (top > 0) {
        const WaitingChild nearest = stack[--top];
        const Index child = child_of(nearest);
        // Keeps it below infinity, the distance of empty children.
        const float far =
            std::min((1.0f + kPacketTieSlack) * best + always, std::numeric_limits<float>::max());
        if (squared_of(nearest) > far) continue;
        if (child < 0) {
            look_at(packets_[-1 - child], hierarchy_.packets[-1 - child]);
            continue;
        }
        const Node& node = nodes_[child];
        const Lanes distance = node.places.squared_distance(at);
        LaneMask open = distance <= all_lanes(far);
        if (none_faces) open &= node.normals.least_along(direction) <= all_lanes(none_faces->most);
        assert(top + kLanes <= kMostWaiting);
        top += push_nearest_last(distance, node.child, open, &stack[top]);
    }
}

}  // namespace rumple
