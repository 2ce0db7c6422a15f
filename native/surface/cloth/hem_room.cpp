// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/hem_room.h"

#include <algorithm>
#include <limits>
#include <map>

#include "base/smooth_step.h"
#include "surface/cloth/garment_borders.h"
#include "surface/mesh/normals.h"
#include "surface/output/attachments.h"
#include "surface/query/bounds.h"
#include "surface/query/segment.h"

namespace rumple::base_cloth {
namespace {

// Borders that lie nearer to one another than this share of the garment's diagonal go together (a lining):
// none covers the other.
constexpr float kTogether = 1.0f / 300.0f;

// Share of its overlap with the border below by which a hem may leave its place. The border has the rest.
constexpr float kOfOverlap = 0.7f;

// A hem that stands off what it covers hides less of it from an eye below the hem. The overlap is shortened
// by this share of the distance between both, measured off the surface.
constexpr float kSeenFromBelow = 0.5f;

// Borders farther apart than this, measured off the surface in units of Hems::together, do not count as one
// over the other: what they are farther apart is added to the overlap.
constexpr float kApart = 10.0f;

// Radius over the garment's diagonal: smaller borders are of buttons, buckles and eyelets.
constexpr float kButton = 1.0f / 80.0f;

// How much more room a vertex has for each object unit from a hem. It is how much longer cloth above a hem
// may become that stays while the cloth farther up leaves.
constexpr float kStretchedByRoom = 0.15f;

constexpr float kFar = std::numeric_limits<float>::infinity();

// The hem of a part that is nearest to a place at rest; none where that is nearer than what goes together.
const Hems::Hem* hem_over(const Hems& hems, Index part, const Vec3& place, std::span<const Vec3> rest) {
    const Hems::Hem* nearest = nullptr;
    float away = kFar;
    for (const Hems::Hem& hem : hems.all) {
        if (hem.part != part) continue;
        for (const Index v : hem.vertices) {
            const float distance = glm::distance(place, rest[v]);
            if (distance < away) nearest = &hem;
            away = std::min(away, distance);
        }
    }
    return away > hems.together ? nearest : nullptr;
}

// For every welded vertex, the index of its hem, or kNone.
std::vector<Index> hems_of_vertices(const Hems& hems) {
    std::vector<Index> out(hems.part.size(), kNone);
    for (Index k = 0; k < static_cast<Index>(hems.all.size()); ++k)
        for (const Index v : hems.all[k].vertices) out[v] = k;
    return out;
}

// The two ends of a border edge, in the order of its polygon's corners.
Hems::Side directed(const Surface& surface, const Edge& edge) {
    const Index begin = surface.welded.polygon_start[edge.left],
                size = surface.welded.polygon_size(edge.left);
    for (Index k = 0; k < size; ++k) {
        const Index from = surface.welded.corner_vertex[begin + k],
                    to = surface.welded.corner_vertex[begin + (k + 1) % size];
        if (from == edge.b && to == edge.a) return {edge.b, edge.a};
    }
    return {edge.a, edge.b};
}

// The border edge nearest to a place, and how far the place lies behind it, along the surface, as an eye
// below the hem sees it. It is 0 if the place lies in front of the edge, uncovered. A place beside the end of
// the line is not uncovered.
struct Behind {
    float distance = kFar;
    Hems::Side side{};
};
Behind behind(std::span<const Hems::Side> line, const Vec3& place, std::span<const Vec3> positions,
              std::span<const Vec3> normals, float apart) {
    Behind found;
    float nearest = kFar;
    for (const Hems::Side& side : line) {
        const Vec3 &a = positions[side[0]], &b = positions[side[1]];
        const float s = closest_on_segment(a, b, place);
        const Vec3 way = glm::mix(a, b, s) - place;
        const float squared = glm::dot(way, way);
        if (!(squared < nearest)) continue;
        nearest = squared;
        const Vec3 normal = direction_of_normals(glm::mix(normals[side[0]], normals[side[1]], s));
        const float height = std::abs(glm::dot(way, normal));
        const Vec3 along = way - glm::dot(way, normal) * normal, outwards = glm::cross(b - a, normal);
        const float size = glm::length(along) * glm::length(outwards);
        const float share = size > 0.0f ? smooth_step(-0.5f, 0.0f, glm::dot(along, outwards) / size) : 0.0f;
        const float seen = std::max(glm::length(along) - kSeenFromBelow * std::min(height, apart), 0.0f);
        found = {share * seen + std::max(height - apart, 0.0f), side};
    }
    return found;
}

// From the hems on: a vertex has the room of each vertex of a hem of its part, and more by its distance.
std::vector<float> room_behind(const Surface& surface, const Hems& hems, std::span<const float> of_hem,
                               float most) {
    const std::vector<Vec3>& rest = surface.positions_rest;
    std::vector<float> room(rest.size(), kFar);
    for (const Hems::Hem& hem : hems.all) {
        for (const Index h : hem.vertices) {
            if (!(of_hem[h] < most)) continue;
            for (const Index v : hems.of_part[hem.part])
                room[v] = std::min(room[v], of_hem[h] + kStretchedByRoom * glm::distance(rest[v], rest[h]));
        }
    }
    return room;
}

// Of every part whether most of it lies under others: a lining, a second layer. Its borders go with theirs.
std::vector<bool> linings(const Hems& hems, std::span<const Overlap> overlaps) {
    std::vector<Index> under(hems.of_part.size(), 0);
    for (const auto& [v, place, outer] : overlaps)
        if (!outer) ++under[hems.part[v]];
    std::vector<bool> out;
    for (size_t p = 0; p < under.size(); ++p) out.push_back(2 * size_t(under[p]) > hems.of_part[p].size());
    return out;
}

// 0..1: whether there is a body under a vertex.
float lies_over(const BodyContact& body) {
    return body.triangle == kNone ? 0.0f : body.weight;
}

}  // namespace

Hems find_hems(const Surface& surface) {
    const Borders borders(surface);
    Hems hems;
    hems.part = borders.part;
    std::vector<Vec3> joined;  // without loose vertices: skin in the same mesh, and strays
    for (Index v = 0; v < surface.welded.vertex_count; ++v)
        if (hems.part[v] != kNone) joined.push_back(surface.positions_rest[v]);
    const float diagonal = static_cast<float>(bounding_diagonal(joined));
    hems.together = kTogether * diagonal;
    hems.of_part.resize(size_t(borders.parts));
    for (Index v = 0; v < surface.welded.vertex_count; ++v)
        if (hems.part[v] != kNone) hems.of_part[hems.part[v]].push_back(v);
    for (const Border& border : borders.all)
        if (border.radius >= kButton * diagonal)
            hems.all.push_back({border.vertices, border.part, border.is_opening});
    const std::vector<Index> border_of = hems_of_vertices(hems);
    for (const Edge& edge : surface.edges)
        if (edge.right == kNone && border_of[edge.a] != kNone)
            hems.all[border_of[edge.a]].sides.push_back(directed(surface, edge));
    return hems;
}

std::vector<HemOverlap> find_hem_overlaps(const Surface& surface, const Hems& hems,
                                          std::span<const Overlap> overlaps) {
    const std::vector<Vec3>& rest = surface.positions_rest;
    const std::vector<Index> border_of = hems_of_vertices(hems);
    const std::vector<bool> is_lining = linings(hems, overlaps);
    std::map<std::pair<Index, Index>, HemOverlap> found;  // of the hem above and the border below
    for (const auto& [v, place, outer] : overlaps) {
        if (outer || border_of[v] == kNone || is_lining[hems.part[v]]) continue;
        const Index covering = hems.part[welded_vertices(surface, place.triangle)[0]];
        const Hems::Hem* hem = hem_over(hems, covering, interpolate(surface, place, rest), rest);
        if (!hem) continue;
        const auto above = static_cast<Index>(hem - hems.all.data());
        found.try_emplace({above, border_of[v]}, HemOverlap{above}).first->second.border.push_back(v);
    }
    std::vector<HemOverlap> out;
    for (auto& [pair, of_pair] : found) {
        HemOverlap& overlap = of_pair;
        const auto covered = [&](Index v) { return std::ranges::binary_search(overlap.border, v); };
        for (const Hems::Side& side : hems.all[pair.second].sides)
            if (covered(side[0]) && covered(side[1])) overlap.sides.push_back(side);
        out.push_back(std::move(overlap));
    }
    return out;
}

std::vector<float> room_over_parts(const Surface& surface, const Hems& hems,
                                   std::span<const HemOverlap> overlaps, std::span<const Vec3> positions,
                                   std::span<const Vec3> normals, float most) {
    std::vector<float> of_hem(surface.positions_rest.size(), kFar);
    const auto hold = [&](Index v, float room) { of_hem[v] = std::min(of_hem[v], room); };
    const float apart = kApart * hems.together;
    for (const HemOverlap& overlap : overlaps) {
        const Hems::Hem& hem = hems.all[overlap.hem];
        for (const Index v : overlap.border) {
            const Behind hem_beyond = behind(hem.sides, positions[v], positions, normals, apart);
            hold(v, (1.0f - kOfOverlap) * hem_beyond.distance);
            for (const Index h : hem_beyond.side) hold(h, kOfOverlap * hem_beyond.distance);
        }
        if (overlap.sides.empty()) continue;
        for (const Index h : hem.vertices) {
            const Behind end = behind(overlap.sides, positions[h], positions, normals, apart);
            hold(h, kOfOverlap * end.distance);
            for (const Index v : end.side) hold(v, (1.0f - kOfOverlap) * end.distance);
        }
    }
    return room_behind(surface, hems, of_hem, most);
}

std::vector<float> room_over_bodies(const Surface& surface, const Hems& hems, const PosedCollider& bodies,
                                    std::span<const BodyContact> under, std::span<const Vec3> points,
                                    std::span<const Vec3> normals, float reach, float unheld) {
    const std::vector<Vec3>& rest = surface.positions_rest;
    std::vector<float> bare(rest.size(), -1.0f);  // whether nothing is beside the border, or not looked for
    const auto is_bare = [&](Index v) {
        if (bare[v] < 0.0f)
            bare[v] =
                1.0f - lies_over(bodies.closest_of_others(points[v], normals[v], reach, under[v].triangle));
        return bare[v];
    };
    std::vector<float> of_hem(rest.size(), kFar);
    // Along the side from a vertex with a body under it to one that is beside the border of the body.
    const auto look_along = [&](Index from, Index to) {
        const BodyContact& beside = under[to];
        if (!beside.border) return;
        const Vec3 side = points[to] - points[from];
        const float share = glm::dot(beside.point - points[from], side) / glm::dot(side, side);
        if (!(share < 1.0f)) return;  // no number: a side without a length
        float ends = lies_over(under[from]) * smooth_step(0.0f, hems.together, beside.beside);
        if (ends == 0.0f || (ends *= is_bare(to)) == 0.0f) return;
        const Vec3 end = glm::mix(rest[from], rest[to], std::max(share, 0.0f));
        const Hems::Hem* hem = hem_over(hems, hems.part[from], end, rest);
        if (!hem) return;
        for (const Index h : hem->vertices) {
            const float held = ends * lies_over(under[h]);
            if (held == 0.0f) continue;
            const float room = kOfOverlap * glm::distance(end, rest[h]) + (1.0f - held) * unheld;
            of_hem[h] = std::min(of_hem[h], room);
        }
    };
    for (const Edge& edge : surface.edges) {
        look_along(edge.a, edge.b);
        look_along(edge.b, edge.a);
    }
    return room_behind(surface, hems, of_hem, unheld);
}

}  // namespace rumple::base_cloth
