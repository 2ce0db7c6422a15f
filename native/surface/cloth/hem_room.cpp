// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/hem_room.h"

#include <algorithm>
#include <limits>

#include "base/smooth_step.h"
#include "surface/cloth/garment_borders.h"
#include "surface/output/attachments.h"
#include "surface/query/bounds.h"

namespace rumple::base_cloth {
namespace {

// Borders that lie nearer to one another than this share of the garment's diagonal go together (a lining):
// none covers the other.
constexpr float kTogether = 1.0f / 300.0f;

// Share of its overlap with the border below by which a hem may leave its place. The border has the rest.
constexpr float kOfOverlap = 0.7f;

// Radius over the garment's diagonal: smaller borders are of buttons, buckles and eyelets.
constexpr float kButton = 1.0f / 80.0f;

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

// From the hems on: a vertex has the room of each vertex of a hem of its part, and as much more as it is
// away.
std::vector<float> room_behind(const Surface& surface, const Hems& hems, std::span<const float> of_hem,
                               float most) {
    const std::vector<Vec3>& rest = surface.positions_rest;
    std::vector<float> room(rest.size(), kFar);
    for (const Hems::Hem& hem : hems.all) {
        for (const Index h : hem.vertices) {
            if (!(of_hem[h] < most)) continue;
            for (const Index v : hems.of_part[hem.part])
                room[v] = std::min(room[v], of_hem[h] + glm::distance(rest[v], rest[h]));
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
        if (border.radius >= kButton * diagonal) hems.all.push_back({border.vertices, border.part});
    return hems;
}

std::vector<float> room_over_parts(const Surface& surface, const Hems& hems,
                                   std::span<const Overlap> overlaps) {
    const std::vector<Vec3>& rest = surface.positions_rest;
    std::vector<bool> on_hem(rest.size(), false);
    for (const Hems::Hem& hem : hems.all)
        for (const Index v : hem.vertices) on_hem[v] = true;
    const std::vector<bool> is_lining = linings(hems, overlaps);
    std::vector<float> of_hem(rest.size(), kFar);
    for (const auto& [v, place, outer] : overlaps) {
        if (outer || !on_hem[v] || is_lining[hems.part[v]]) continue;
        const Vec3 above = interpolate(surface, place, rest);
        const Index covering = hems.part[welded_vertices(surface, place.triangle)[0]];
        const Hems::Hem* hem = hem_over(hems, covering, above, rest);
        if (!hem) continue;
        float overlap = kFar;
        for (const Index h : hem->vertices) {
            const float distance = glm::distance(above, rest[h]);
            of_hem[h] = std::min(of_hem[h], kOfOverlap * distance);
            overlap = std::min(overlap, distance);
        }
        of_hem[v] = std::min(of_hem[v], (1.0f - kOfOverlap) * overlap);
    }
    return room_behind(surface, hems, of_hem, kFar);
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
