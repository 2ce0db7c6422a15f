// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/contact/collider.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "base/expect.h"
#include "base/tolerances.h"
#include "base/unit_vector.h"
#include "surface/mesh/disjoint_sets.h"
#include "surface/mesh/positions.h"

namespace rumple {
namespace {

// Cosine: least value between the normals of the cloth and of the side of a body that the cloth lies on.
constexpr float kFacing = 0.1f;

// Cosine between the direction to the body and its normal: the body is beside the point up to kBeside, and
// below it from kAbove on.
constexpr float kBeside = 0.6f;
constexpr float kAbove = 0.85f;

// How far cloth at rest may be behind the plane of a triangle that is under it. The first is a share of their
// distance, because bodies are round. The second is a share of worn_within, because cloth may be modelled
// partly inside a body.
constexpr float kBehind = 0.25f, kDeep = 0.125f;

// The boxes of a body with fewer triangles are computed in a tenth of a millisecond on one thread.
constexpr size_t kTrianglesForTeam = 5'000;

// Barycentric weight: a closest point lies on an edge if the weight of the opposite corner is smaller.
constexpr float kOnEdge = 1e-4f;

std::vector<Row> checked(const Collider& collider, std::span<const Vec3> positions) {
    expect_count("body positions", positions.size(), size_t(collider.vertex_count()), "vertices");
    check_coordinates("body positions", positions);
    return to_rows(positions);
}

}  // namespace

Collider::Collider(std::span<const Vec3> positions, std::span<const std::array<Index, 3>> triangles,
                   std::span<const Vec3> rest, float worn_within)
    : vertex_count_(static_cast<Index>(positions.size())),
      triangles_(triangles.begin(), triangles.end()),
      worn_within_(worn_within) {
    if (triangles_.empty()) throw InvalidInput("body: expected at least one triangle, got none");
    check_coordinates("body positions", positions);
    for (size_t t = 0; t < triangles_.size(); ++t) {
        for (const Index v : triangles_[t]) {
            if (v >= 0 && v < vertex_count_) continue;
            throw InvalidInput("body triangles: triangle " + std::to_string(t) + " names vertex " +
                               std::to_string(v) + " of " + std::to_string(vertex_count_));
        }
    }
    if (!rest.empty()) {
        expect_count("rest", rest.size(), positions.size(), "vertices");
        expect_within("worn_within", worn_within, 0.0, kFarthestCoordinate);
        rest_centre_ = centres_of(rest, triangles_);
        for (const auto& [a, b, c] : triangles_)
            rest_normal_.push_back(
                unit_or_zero(glm::cross(rest[b] - rest[a], rest[c] - rest[a]), kSmallestArea));
    }
    corners_ = {positions.size(), triangles_};
    hierarchy_ = build_packets(centres_of(positions, triangles_));
    mark_borders();
    find_parts();
}

void Collider::mark_borders() {
    struct Side {
        Index a, b, triangle;
        int k;
    };
    std::vector<Side> sides;
    for (Index t = 0; t < triangle_count(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const Index a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
            sides.push_back({std::min(a, b), std::max(a, b), t, k});
        }
    }
    const auto edge = [](const Side& s) { return std::pair(s.a, s.b); };
    std::sort(sides.begin(), sides.end(), [&](const Side& s, const Side& t) {
        return std::tuple(s.a, s.b, s.triangle) < std::tuple(t.a, t.b, t.triangle);
    });
    border_edges_.assign(triangles_.size(), 0);
    border_vertex_.assign(vertex_count_, 0);
    for (size_t i = 0, next; i < sides.size(); i = next) {
        for (next = i + 1; next < sides.size() && edge(sides[next]) == edge(sides[i]);) ++next;
        if (next > i + 1) continue;
        border_edges_[sides[i].triangle] |= static_cast<std::uint8_t>(1 << sides[i].k);
        border_vertex_[sides[i].a] = border_vertex_[sides[i].b] = 1;
    }
}

// A triangle whose position at rest is not finite may be under any cloth.
bool Collider::may_be_under(Index triangle, const Vec3& worn_at) const {
    if (rest_centre_.empty()) return true;
    const Vec3 apart = worn_at - rest_centre_[triangle];
    const float distance = glm::length(apart);
    const float behind = -glm::dot(apart, rest_normal_[triangle]);
    return !(distance > worn_within_ || behind > kBehind * distance + kDeep * worn_within_);
}

void Collider::find_parts() {
    DisjointSets sets(vertex_count_);
    for (const auto& [a, b, c] : triangles_) {
        sets.unite(a, b);
        sets.unite(a, c);
    }
    for (const auto& triangle : triangles_) part_.push_back(sets.find(triangle[0]));
}

PosedCollider::PosedCollider(const Collider& collider, std::span<const Vec3> positions)
    : PosedCollider(collider, positions, SolveTeam(0, collider.triangles_.size(), kTrianglesForTeam)) {}

PosedCollider::PosedCollider(const Collider& collider, std::span<const Vec3> positions, const SolveTeam&)
    : collider_(collider),
      positions_(checked(collider, positions)),
      normals_(positions_, collider.triangles_, collider.corners_),
      packets_(collider.hierarchy_, positions_, collider.triangles_, normals_.of_face) {}

bool PosedCollider::is_at(std::span<const Vec3> positions) const {
    if (positions.size() != size_t(collider_.vertex_count())) return false;
    for (size_t v = 0; v < positions.size(); ++v)
        if (glm::floatBitsToUint(positions[v]) != glm::floatBitsToUint(positions_[v].vec())) return false;
    return true;
}

bool PosedCollider::on_border(Index triangle, const Vec3& weights) const {
    const std::uint8_t edges = collider_.border_edges_[triangle];
    for (int k = 0; k < 3; ++k) {
        if ((edges >> k & 1) && weights[(k + 2) % 3] < kOnEdge) return true;
        if (weights[k] > 1.0f - kOnEdge && collider_.border_vertex_[collider_.triangles_[triangle][k]])
            return true;
    }
    return false;
}

Vec3 PosedCollider::point_of(const Best& best) const {
    const auto& t = collider_.triangles_[best.triangle];
    return mixed(best.weights, positions_[t[0]].vec(), positions_[t[1]].vec(), positions_[t[2]].vec());
}

Vec3 PosedCollider::normal_of(const Best& best) const {
    const auto& t = collider_.triangles_[best.triangle];
    const std::vector<Row>& normal = normals_.of_vertex;
    return unit_or_zero(mixed(best.weights, normal[t[0]].vec(), normal[t[1]].vec(), normal[t[2]].vec()),
                        kSmallestArea);
}

// Takes the nearest triangle, and the lowest one of equally near triangles, so that the order of the search
// does not matter. counts(packet): which of its triangles are allowed.
template <typename Counts>
void PosedCollider::look_at(const PosedPackets::Packet& packet, const PacketHierarchy::Triangles& triangles,
                            const Vec3& p, const Counts& counts, Best& best, const Vec3* worn_at) const {
    const LaneMask counting = counts(packet);
    if (bits_of(counting) == 0) return;
    const ClosestOfFour found = closest_of(packet, Vec3Lanes(p));
    for_each_true(counting & (found.squared <= all_lanes(best.squared)), [&](int k) {
        if (found.squared[k] > best.squared) return;
        if (found.squared[k] == best.squared && triangles[k] >= best.triangle) return;
        if (worn_at && !collider_.may_be_under(triangles[k], *worn_at)) return;
        const float v = found.at.v[k], w = found.at.w[k];
        best = {found.squared[k], triangles[k], {1.0f - v - w, v, w}};
    });
}

BodyContact PosedCollider::closest(const Vec3& p, const Vec3& normal, float reach, Index hint,
                                   const Vec3* worn_at) const {
    const Vec3Lanes facing(normal);
    const auto counts = [&](const PosedPackets::Packet& packet) {
        return LaneMask(dot(packet.normal, facing) >= all_lanes(kFacing));
    };
    Best best{squared_reach(reach)};
    const auto look = [&](const PosedPackets::Packet& packet, const PacketHierarchy::Triangles& triangles) {
        look_at(packet, triangles, p, counts, best, worn_at);
    };
    if (hint >= 0 && hint < collider_.triangle_count()) packets_.look_around(hint, look);
    packets_.search(p, best.squared, nullptr, look);
    return contact_at(best, p, normal);
}

BodyContact PosedCollider::closest_of_others(const Vec3& p, const Vec3& normal, float reach,
                                             Index triangle) const {
    const Vec3Lanes facing(normal);
    const Index left_out = collider_.part_[triangle];
    Best best{squared_reach(reach)};
    const auto look = [&](const PosedPackets::Packet& packet, const PacketHierarchy::Triangles& triangles) {
        LaneMask others{};
        for (size_t k = 0; k < kLanes; ++k)
            if (triangles[k] != kNone && collider_.part_[triangles[k]] != left_out) others[k] = -1;
        const auto counts = [&](const PosedPackets::Packet& each) {
            return LaneMask(dot(each.normal, facing) >= all_lanes(kFacing)) & others;
        };
        look_at(packet, triangles, p, counts, best);
    };
    packets_.search(p, best.squared, nullptr, look);
    return contact_at(best, p, normal);
}

BodyContact PosedCollider::contact_at(const Best& best, const Vec3& p, const Vec3& normal) const {
    BodyContact contact;
    if (best.triangle == kNone) return contact;
    contact.triangle = best.triangle;
    contact.point = point_of(best);
    contact.border = on_border(best.triangle, best.weights);
    contact.normal = contact.border ? normal : normal_of(best);
    const Vec3 to = p - contact.point;
    const float length = std::sqrt(glm::dot(to, to));
    contact.distance = glm::dot(to, contact.normal);
    contact.beside = glm::length(to - contact.distance * contact.normal);
    const float cosine = (std::abs(contact.distance) + kOnBody) / (length + kOnBody);
    contact.weight = std::clamp((cosine - kBeside) / (kAbove - kBeside), 0.0f, 1.0f);
    return contact;
}

BodyAhead PosedCollider::ahead(const Vec3& p, const Vec3& normal, float reach, float behind) const {
    Best best{squared_reach(reach)};
    const Vec3Lanes at(p), facing(normal);
    const auto counts = [&](const PosedPackets::Packet& packet) {
        return LaneMask((dot(packet.normal, facing) <= all_lanes(kFacingNormals)) &
                        (dot(at - packet.a, packet.normal) >= all_lanes(-behind)));
    };
    const PosedPackets::NoneFaces none_faces{normal, kFacingNormals};
    packets_.search(p, best.squared, &none_faces,
                    [&](const PosedPackets::Packet& packet, const PacketHierarchy::Triangles& triangles) {
                        look_at(packet, triangles, p, counts, best);
                    });
    if (best.triangle == kNone || on_border(best.triangle, best.weights)) return {};
    return {best.triangle, point_of(best), normal_of(best)};
}

}  // namespace rumple
