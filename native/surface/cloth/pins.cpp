// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/pins.h"

#include <algorithm>
#include <limits>

#include "surface/mesh/disjoint_sets.h"
#include "surface/mesh/edge_graph.h"
#include "surface/output/attachments.h"
#include "surface/query/bounds.h"

namespace rumple {
namespace {

// Radius of a border over the diagonal of its part: how firmly it is held. A wrist is at 0.02, the leg of
// trousers at 0.055, a short sleeve at 0.07, a hem at 0.17 and more.
constexpr float kWrist = 0.03f, kSleeve = 0.05f, kLoose = 0.09f;
constexpr float kSleeveHeld = 0.4f, kLegHeld = 0.01f;

// What is at most this share of the diagonal above the lowest border is a hem or a leg: held as a sleeve is,
// it could not ride up where a knee bends, and stood in folds above the foot. Free, a foot of a jump came
// through while the springs were soft.
constexpr float kLowest = 0.1f;

// A border as wide as this is the outline of a sheet (a flag, a cape, an open jacket), unless its part has
// another one that is at least so wide against it: shorts and short skirts are wide for their length, and
// their waistband is an opening. The sleeves of a jacket are a fifth of its outline, the armholes of a vest a
// third.
constexpr float kOutline = 0.25f, kOtherOpening = 0.45f;

// Over this share of the part's diagonal the hold of a border fades out.
constexpr float kFade = 0.07f;

// Borders that lie nearer to one another than this share of the garment's diagonal go together (a lining):
// none covers the other.
constexpr float kTogether = 1.0f / 300.0f;

// Share of its overlap with the border of a part below by which a hem may leave its place.
constexpr float kOfOverlap = 0.7f;

// Radius over the garment's diagonal: smaller borders are of buttons, buckles and eyelets.
constexpr float kButton = 1.0f / 80.0f;

constexpr float kFar = std::numeric_limits<float>::infinity();

struct Border {
    std::vector<Index> vertices;
    Index part = 0;
    float height = 0.0f;
    float radius = 0.0f;
    bool is_opening = false;
};

float held_by_width(float fraction, bool lowest) {
    const float sleeve = lowest ? kLegHeld : kSleeveHeld;
    if (fraction <= kWrist) return 1.0f;
    if (fraction <= kSleeve) return glm::mix(1.0f, sleeve, (fraction - kWrist) / (kSleeve - kWrist));
    return sleeve * std::clamp((kLoose - fraction) / (kLoose - kSleeve), 0.0f, 1.0f);
}

// Connected sets of vertices: the number of its set for every vertex that an edge in `chosen` has, else
// kNone.
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

// The connected parts of a garment, and their open borders.
struct Borders {
    Index parts = 0;
    std::vector<Index> part;      // per vertex
    std::vector<float> diagonal;  // of each part
    std::vector<Border> all;

    explicit Borders(const Surface& surface, const Vec3& up = Vec3(0.0f))
        : part(connected(
              surface, [](const Edge&) { return true; }, parts)),
          diagonal(diagonals(surface, part, parts)),
          all(collect_borders(surface, part, up)) {
        mark_openings(diagonal, all);
    }
};

// Raises `follow` around a border, by the distance along the edges.
void hold(const Border& border, float firmly, float reach, const EdgeGraph& graph,
          std::vector<float>& follow) {
    std::vector<float> distance(graph.size(), std::numeric_limits<float>::max());
    shortest_paths(graph, border.vertices, reach, distance, [&](Index v) {
        const float t = 1.0f - distance[v] / reach;
        follow[v] = std::max(follow[v], firmly * t * t * (3.0f - 2.0f * t));
    });
}

// The one of some borders that is nearest to a place, and how far away it is.
struct Nearest {
    const Border* border = nullptr;
    float away = kFar;

    Nearest(std::span<const Border> borders, const Vec3& place, std::span<const Vec3> rest) {
        for (const Border& each : borders) {
            for (const Index v : each.vertices) {
                const float distance = glm::distance(place, rest[v]);
                if (distance < away) border = &each;
                away = std::min(away, distance);
            }
        }
    }
};

// Of every part whether most of it lies under others: a lining, a second layer. Its borders go with theirs.
std::vector<bool> linings(const Borders& borders, std::span<const base_cloth::Overlap> overlaps) {
    std::vector<Index> under(size_t(borders.parts), 0);  // less those that are not
    for (const auto& [v, place, outer] : overlaps)
        if (!outer) under[size_t(borders.part[v])] += 2;
    for (const Index part : borders.part)
        if (part != kNone) --under[size_t(part)];
    std::vector<bool> out;
    for (const Index more : under) out.push_back(more > 0);
    return out;
}

// By how much every vertex of a hem overlaps the border of another part that the hem covers; else kFar.
std::vector<float> overlap_of_hems(const Surface& surface, const Borders& borders,
                                   std::span<const base_cloth::Overlap> overlaps) {
    const std::vector<Vec3>& rest = surface.positions_rest;
    const float diagonal = static_cast<float>(bounding_diagonal(rest));
    std::vector<std::vector<Border>> hems(size_t(borders.parts));  // of each part
    std::vector<bool> on_hem(rest.size(), false);
    for (const Border& border : borders.all) {
        if (border.radius < kButton * diagonal) continue;
        hems[border.part].push_back(border);
        for (const Index v : border.vertices) on_hem[v] = true;
    }
    const std::vector<bool> is_lining = linings(borders, overlaps);
    std::vector<float> overlap(rest.size(), kFar);
    for (const auto& [v, place, outer] : overlaps) {
        if (outer || !on_hem[v] || is_lining[size_t(borders.part[v])]) continue;
        const Vec3 above = interpolate(surface, place, rest);
        const Index covering = borders.part[welded_vertices(surface, place.triangle)[0]];
        const Nearest hem(hems[covering], above, rest);
        if (!hem.border || hem.away <= kTogether * diagonal) continue;
        for (const Index h : hem.border->vertices)
            overlap[h] = std::min(overlap[h], glm::distance(above, rest[h]));
    }
    return overlap;
}

}  // namespace

std::vector<float> suggest_follow(const Surface& surface, const Vec3& up) {
    const Borders borders(surface, up);
    std::vector<float> highest(borders.parts, std::numeric_limits<float>::lowest());
    std::vector<float> lowest(borders.parts, std::numeric_limits<float>::max());
    for (const Border& border : borders.all) {
        highest[border.part] = std::max(highest[border.part], border.height);
        lowest[border.part] = std::min(lowest[border.part], border.height);
    }
    EdgeGraph graph(surface.welded.vertex_count);
    for (const Edge& edge : surface.edges) connect(surface, edge.a, edge.b, graph);
    std::vector<float> follow(surface.welded.vertex_count, 0.0f);
    for (const Border& border : borders.all) {
        const float size = borders.diagonal[border.part];
        const bool top = border.height == highest[border.part] && border.is_opening;
        const bool low = border.height <= lowest[border.part] + kLowest * size;
        const float firmly = top ? 1.0f : held_by_width(border.radius / size, low);
        if (size > 0.0f && firmly > 0.0f) hold(border, firmly, kFade * size, graph, follow);
    }
    std::vector<float> out;
    for (const Index welded : surface.welded_of) out.push_back(follow[welded]);
    return out;
}

std::vector<float> room_to_cover(const Surface& surface, std::span<const base_cloth::Overlap> overlaps) {
    const std::vector<Vec3>& rest = surface.positions_rest;
    std::vector<float> room(rest.size(), kFar);
    if (overlaps.empty()) return room;
    const Borders borders(surface);
    const std::vector<float> overlap = overlap_of_hems(surface, borders, overlaps);
    std::vector<std::vector<Index>> vertices(size_t(borders.parts));  // of each part
    for (Index v = 0; v < surface.welded.vertex_count; ++v)
        if (borders.part[v] != kNone) vertices[borders.part[v]].push_back(v);
    for (Index h = 0; h < surface.welded.vertex_count; ++h) {
        if (overlap[h] == kFar) continue;
        for (const Index v : vertices[borders.part[h]])
            room[v] = std::min(room[v], kOfOverlap * overlap[h] + glm::distance(rest[v], rest[h]));
    }
    return room;
}

Index count_openings(const Surface& surface) {
    const Borders borders(surface);
    std::vector<bool> has_opening(borders.parts, false);
    for (const Border& border : borders.all) {
        if (border.is_opening) has_opening[border.part] = true;
    }
    return static_cast<Index>(
        std::ranges::count_if(borders.all, [&](const Border& b) { return has_opening[b.part]; }));
}

}  // namespace rumple
