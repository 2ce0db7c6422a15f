// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/garment_borders.h"

#include <algorithm>
#include <limits>

#include "surface/mesh/disjoint_sets.h"

namespace rumple::base_cloth {
namespace {

// Radius of a border / diagonal of its part. A border of at least kOutline is the outline of a sheet (a flag,
// a cape, an open jacket), unless its part has another border whose radius is at least kOtherOpening of its
// own. Shorts and short skirts are wide for their length, and their waistband is an opening. The sleeves of a
// jacket are a fifth of its outline, the armholes of a vest a third.
constexpr float kOutline = 0.25f, kOtherOpening = 0.45f;

// Connected sets of vertices: for every vertex of an edge in `chosen` the number of its set, else kNone.
template <typename Chosen>
std::vector<Index> connected(const Surface& surface, Chosen&& chosen, Index& count) {
    DisjointSets sets(surface.welded.vertex_count);
    std::vector<bool> used(surface.welded.vertex_count, false);
    for (const Edge& edge : surface.edges) {
        if (!chosen(edge)) continue;
        sets.unite(edge.a, edge.b);
        used[edge.a] = used[edge.b] = true;
    }
    std::vector<Index> number(surface.welded.vertex_count, kNone),
        of_root(surface.welded.vertex_count, kNone);
    count = 0;
    for (Index v = 0; v < surface.welded.vertex_count; ++v) {
        if (!used[v]) continue;
        Index& root = of_root[sets.find(v)];
        if (root == kNone) root = count++;
        number[v] = root;
    }
    return number;
}

std::vector<Border> collect_borders(const Surface& surface, std::span<const Index> part, const Vec3& up) {
    Index count = 0;
    const std::vector<Index> of = connected(
        surface, [](const Edge& e) { return e.right == kNone; }, count);
    std::vector<Border> borders(count);
    for (Index v = 0; v < surface.welded.vertex_count; ++v) {
        if (of[v] != kNone) borders[of[v]].vertices.push_back(v);
    }
    for (Border& border : borders) {
        Vec3 centre(0.0f);
        for (const Index v : border.vertices) centre += surface.positions_rest[v];
        centre /= float(border.vertices.size());
        for (const Index v : border.vertices)
            border.radius += glm::distance(surface.positions_rest[v], centre);
        border.radius /= float(border.vertices.size());
        border.height = glm::dot(centre, up);
        border.part = part[border.vertices.front()];
    }
    return borders;
}

std::vector<float> diagonals(const Surface& surface, std::span<const Index> part, Index parts) {
    std::vector<Vec3> low(parts, Vec3(std::numeric_limits<float>::max()));
    std::vector<Vec3> high(parts, Vec3(std::numeric_limits<float>::lowest()));
    for (size_t v = 0; v < part.size(); ++v) {
        if (part[v] == kNone) continue;
        low[part[v]] = glm::min(low[part[v]], surface.positions_rest[v]);
        high[part[v]] = glm::max(high[part[v]], surface.positions_rest[v]);
    }
    std::vector<float> out;
    out.reserve(parts);
    for (Index p = 0; p < parts; ++p) out.push_back(glm::length(high[p] - low[p]));
    return out;
}

void mark_openings(std::span<const float> diagonal, std::vector<Border>& borders) {
    struct Widest {
        float radius = 0.0f, next = 0.0f;
    };
    std::vector<Widest> of_part(diagonal.size());
    for (const Border& border : borders) {
        Widest& widest = of_part[size_t(border.part)];
        widest.next = std::max(widest.next, std::min(widest.radius, border.radius));
        widest.radius = std::max(widest.radius, border.radius);
    }
    for (Border& border : borders) {
        const Widest& widest = of_part[size_t(border.part)];
        const float other = border.radius < widest.radius ? widest.radius : widest.next;
        border.is_opening = border.radius < kOutline * diagonal[size_t(border.part)] ||
                            other >= kOtherOpening * border.radius;
    }
}

}  // namespace

Borders::Borders(const Surface& surface, const Vec3& up)
    : part(connected(
          surface, [](const Edge&) { return true; }, parts)),
      diagonal(diagonals(surface, part, parts)),
      all(collect_borders(surface, part, up)) {
    mark_openings(diagonal, all);
}

}  // namespace rumple::base_cloth
