// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/outer_side.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "base/solve_team.h"
#include "base/unit_vector.h"
#include "surface/contact/triangle_packets.h"
#include "surface/mesh/disjoint_sets.h"

namespace rumple {
namespace {

constexpr float kThickest = 0.02f;    // of the diagonal of the mesh
constexpr float kFacingAway = -0.5f;  // cosine between the normals of two sides, at most
constexpr float kBehind = 0.7f;  // least cosine between the direction to the other side and the inward normal
constexpr float kSmooth = 0.5f;  // least cosine between the normals of neighbours on one side
constexpr double kLeastInner = 0.3;    // least share of a part, and of the mesh, with modelled thickness
constexpr double kLeastOnOther = 0.7;  // least share of such a part's area that is opposite to its other side

struct Polygon {
    Vec3 centre{0.0f}, normal{0.0f};  // unit, or zero
    double area = 0.0;
    Index opposite = kNone;  // the polygon opposite to it
    float distance = 0.0f;   // to the opposite polygon
};

bool is_smooth(const Polygon& left, const Polygon& right) {
    return glm::dot(left.normal, right.normal) > kSmooth;
}

std::vector<std::array<Index, 3>> corners_of(const Surface& surface) {
    std::vector<std::array<Index, 3>> out;
    out.reserve(surface.triangles.size());
    for (Index t = 0; t < Index(surface.triangles.size()); ++t) out.push_back(welded_vertices(surface, t));
    return out;
}

float diagonal_of(const Surface& surface) {
    Vec3 low(std::numeric_limits<float>::max()), high(std::numeric_limits<float>::lowest());
    for (const Index v : surface.welded.corner_vertex) {
        low = glm::min(low, surface.positions_rest[v]);
        high = glm::max(high, surface.positions_rest[v]);
    }
    return glm::distance(low, high);
}

std::vector<Polygon> polygons_of(const Surface& surface, const std::vector<std::array<Index, 3>>& triangles) {
    std::vector<Polygon> out(surface.welded.polygons());
    std::vector<glm::dvec3> half(out.size(), glm::dvec3(0.0));
    for (size_t t = 0; t < triangles.size(); ++t) {
        const auto corner = [&](int i) { return glm::dvec3(surface.positions_rest[triangles[t][i]]); };
        half[surface.triangles[t].polygon] += 0.5 * glm::cross(corner(1) - corner(0), corner(2) - corner(0));
    }
    for (Index p = 0; p < Index(out.size()); ++p) {
        for (Index c = surface.welded.polygon_start[p]; c < surface.welded.polygon_start[p + 1]; ++c)
            out[p].centre += surface.positions_rest[surface.welded.corner_vertex[c]];
        out[p].centre /= float(surface.welded.polygon_size(p));
        out[p].area = glm::length(half[p]);
        out[p].normal = unit_or_zero(Vec3(half[p]), kSmallestArea);
    }
    return out;
}

// For every polygon, the nearest polygon behind it that faces the other way.
void find_opposites(const Surface& surface, const std::vector<std::array<Index, 3>>& triangles,
                    std::vector<Polygon>& polygons) {
    const std::vector<Row> rows = to_rows(surface.positions_rest);
    const TriangleNormals normals(rows, triangles, {surface.positions_rest.size(), triangles});
    const PacketHierarchy hierarchy = build_packets(centres_of(surface.positions_rest, triangles));
    const PosedPackets packets(hierarchy, rows, triangles, normals.of_face);
    const float reach = kThickest * diagonal_of(surface);
    const SolveTeam team(0, polygons.size(), kLeastSearches);
    for_each_index(polygons.size(), kLeastSearches, [&](size_t p) {
        Polygon& polygon = polygons[p];
        if (polygon.normal == Vec3(0.0f)) return;
        const Vec3Lanes at(polygon.centre), normal(polygon.normal);
        float best = squared_reach(reach);
        Index found = kNone;
        const auto look_at = [&](const PosedPackets::Packet& packet,
                                 const PacketHierarchy::Triangles& of_packet) {
            const ClosestOfFour closest = closest_of(packet, at);
            const Lanes inwards = Lanes{} - dot(closest.way, normal);
            const LaneMask lies_on = (dot(packet.normal, normal) <= all_lanes(kFacingAway)) &
                                     (inwards > Lanes{}) &
                                     (inwards * inwards >= all_lanes(kBehind * kBehind) * closest.squared) &
                                     (closest.squared <= all_lanes(best));
            for_each_true(lies_on, [&](int k) {
                if (closest.squared[k] > best) return;
                if (closest.squared[k] == best && (found == kNone || of_packet[k] >= found)) return;
                best = closest.squared[k];
                found = of_packet[k];
            });
        };
        const PosedPackets::NoneFaces none_faces{polygon.normal, kFacingAway};
        packets.search(polygon.centre, best, &none_faces, look_at);
        if (found == kNone) return;
        polygon.opposite = surface.triangles[found].polygon;
        polygon.distance = std::sqrt(best);
    });
}

// For every polygon with an opposite one, the lowest polygon of its side. For the others, the polygon itself.
std::vector<Index> sides_of(const Surface& surface, const std::vector<Polygon>& polygons) {
    DisjointSets sets(static_cast<Index>(polygons.size()));
    for (const Edge& e : surface.edges) {
        if (e.right == kNone) continue;
        const Polygon &left = polygons[e.left], &right = polygons[e.right];
        if (left.opposite != kNone && right.opposite != kNone && is_smooth(left, right))
            sets.unite(e.left, e.right);
    }
    return sets.roots();
}

// Pairs of opposite sides: one is the outer side, the other the inner side. A side is identified by its
// lowest polygon.
class SidesOfOthers {
  public:
    explicit SidesOfOthers(size_t polygons) : parent_(polygons), other_(polygons, false) {
        std::iota(parent_.begin(), parent_.end(), 0);
    }

    // Does nothing if it is already known whether both are the same side.
    void lie_on_one_another(Index a, Index b) {
        const auto [root_a, a_is_other] = find(a);
        const auto [root_b, b_is_other] = find(b);
        if (root_a == root_b) return;
        const bool differ = a_is_other == b_is_other;
        parent_[std::max(root_a, root_b)] = std::min(root_a, root_b);
        other_[std::max(root_a, root_b)] = differ;
    }
    // The lowest side that it is connected with, and whether it is opposite to that.
    std::pair<Index, bool> find(Index side) const {
        bool is_other = false;
        for (; parent_[side] != side; side = parent_[side]) is_other = is_other != other_[side];
        return {side, is_other};
    }

  private:
    std::vector<Index> parent_;
    std::vector<bool> other_;  // whether it is opposite to its parent
};

// For every polygon with an opposite one: whether it belongs to the smaller one of the two sides. A side that
// is mostly opposite to itself, as in a narrow tube, is an outer side.
std::vector<bool> inner_sides(const std::vector<Polygon>& polygons, const std::vector<Index>& side) {
    std::map<std::pair<Index, Index>, double> on;  // per two sides: area opposite to the other side
    for (size_t p = 0; p < polygons.size(); ++p) {
        const Index opposite = polygons[p].opposite;
        if (opposite != kNone) on[std::minmax(side[p], side[opposite])] += polygons[p].area;
    }
    std::vector<std::pair<double, std::pair<Index, Index>>> pairs;  // the largest first
    pairs.reserve(on.size());
    for (const auto& [pair, area] : on) pairs.emplace_back(-area, pair);
    std::ranges::sort(pairs);
    SidesOfOthers sides(polygons.size());
    std::vector<bool> lies_on_itself(polygons.size(), false);
    for (const auto& [area, pair] : pairs) {
        const auto [a, b] = pair;
        if (a == b)
            lies_on_itself[a] = true;  // unless a larger area of it is opposite to other sides
        else if (!lies_on_itself[a] && !lies_on_itself[b])
            sides.lie_on_one_another(a, b);
    }
    std::vector<double> excess(polygons.size(),
                               0.0);  // of the side that has the lowest polygon over the other
    for (size_t p = 0; p < polygons.size(); ++p) {
        if (polygons[p].opposite == kNone) continue;
        const auto [lowest, is_other] = sides.find(side[p]);
        excess[lowest] += is_other ? -polygons[p].area : polygons[p].area;
    }
    std::vector<bool> out(polygons.size(), false);
    for (size_t p = 0; p < polygons.size(); ++p) {
        if (polygons[p].opposite == kNone) continue;
        const auto [lowest, is_other] = sides.find(side[p]);
        out[p] = is_other == (excess[lowest] >= 0.0);
    }
    return out;
}

enum class Side : char { kUnknown, kOuter, kInner };

// A polygon without an opposite one belongs to the side from which it continues smoothly. If there are
// several, it is the nearest.
void spread(const Surface& surface, const std::vector<Polygon>& polygons, std::vector<Side>& side) {
    std::vector<std::vector<Index>> beside(polygons.size());
    for (const Edge& e : surface.edges) {
        if (e.right == kNone || !is_smooth(polygons[e.left], polygons[e.right])) continue;
        beside[e.left].push_back(e.right);
        beside[e.right].push_back(e.left);
    }
    std::vector<Index> reached;  // breadth first
    for (size_t p = 0; p < side.size(); ++p)
        if (side[p] != Side::kUnknown) reached.push_back(static_cast<Index>(p));
    for (size_t i = 0; i < reached.size(); ++i) {
        for (const Index p : beside[reached[i]]) {
            if (side[p] != Side::kUnknown) continue;
            side[p] = side[reached[i]];
            reached.push_back(p);
        }
    }
}

std::vector<Side> sides_by_area(const Surface& surface, const std::vector<Polygon>& polygons) {
    const std::vector<bool> inner = inner_sides(polygons, sides_of(surface, polygons));
    std::vector<Side> side(polygons.size(), Side::kUnknown);
    for (size_t p = 0; p < polygons.size(); ++p)
        if (polygons[p].opposite != kNone) side[p] = inner[p] ? Side::kInner : Side::kOuter;
    spread(surface, polygons, side);
    return side;
}

// For every polygon, the lowest polygon of its part.
std::vector<Index> parts_of(const Surface& surface) {
    DisjointSets sets(surface.welded.polygons());
    for (const Edge& e : surface.edges)
        if (e.right != kNone) sets.unite(e.left, e.right);
    return sets.roots();
}

float median_thickness(const std::vector<Polygon>& polygons, const std::vector<bool>& outer) {
    std::vector<std::pair<float, double>> found;  // distance, area
    double half = 0.0;
    for (size_t p = 0; p < polygons.size(); ++p) {
        if (outer[p] || polygons[p].opposite == kNone) continue;
        found.emplace_back(polygons[p].distance, polygons[p].area);
        half += 0.5 * polygons[p].area;
    }
    std::ranges::sort(found);
    for (const auto& [distance, area] : found)
        if ((half -= area) <= 0.0) return distance;
    return 0.0f;
}

}  // namespace

OuterSide outer_side(const Surface& surface) {
    const auto triangles = corners_of(surface);
    std::vector<Polygon> polygons = polygons_of(surface, triangles);
    find_opposites(surface, triangles, polygons);
    const std::vector<Side> side = sides_by_area(surface, polygons);
    const std::vector<Index> part = parts_of(surface);
    std::vector<double> area(polygons.size(), 0.0), inner(area), on_other(area);  // per part
    double whole = 0.0, whole_inner = 0.0;
    for (size_t p = 0; p < polygons.size(); ++p) {
        area[part[p]] += polygons[p].area;
        if (side[p] == Side::kInner) inner[part[p]] += polygons[p].area;
        if (polygons[p].opposite != kNone) on_other[part[p]] += polygons[p].area;
        whole += polygons[p].area;
    }
    OuterSide out{std::vector<bool>(polygons.size(), true)};
    for (size_t p = 0; p < polygons.size(); ++p) {
        const Index of = part[p];
        if (inner[of] < kLeastInner * area[of] || on_other[of] < kLeastOnOther * area[of]) continue;
        out.polygons[p] = side[p] == Side::kOuter;
        if (side[p] == Side::kInner) whole_inner += polygons[p].area;
    }
    if (whole_inner < kLeastInner * whole) return {std::vector<bool>(polygons.size(), true)};
    out.thickness = median_thickness(polygons, out.polygons);
    return out;
}

}  // namespace rumple
