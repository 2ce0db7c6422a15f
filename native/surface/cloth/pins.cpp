// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/pins.h"

#include <algorithm>
#include <limits>

#include "surface/cloth/garment_borders.h"
#include "surface/cloth/overlaps.h"
#include "surface/mesh/edge_graph.h"

namespace rumple {

using base_cloth::Border, base_cloth::Borders;

namespace {

// Radius of a border / diagonal of its part. It decides how firmly the border is held. A wrist is at 0.02, a
// trouser leg at 0.055, a short sleeve at 0.07, a hem at 0.17 and more.
constexpr float kWrist = 0.03f, kSleeve = 0.05f, kLoose = 0.09f;
constexpr float kSleeveHeld = 0.4f, kLegHeld = 0.01f;

// Share of the diagonal: a border that is at most this much above the lowest border is a hem or a trouser
// leg. If it was held like a sleeve, it could not ride up when a knee bends, and made folds above the foot.
// If it was not held at all, a foot went through the cloth in a jump.
constexpr float kLowest = 0.1f;

// The outline of a hanging sheet is held from its highest point down to kUpperEnd of its diagonal, a garment
// without a border to kClosedEnd. What lies flat (a blanket), with a height of less than kHangs of the
// diagonal, has no upper end.
constexpr float kUpperEnd = 0.06f, kClosedEnd = 0.03f, kHangs = 0.25f;

// Least share of the vertices of a part that is sewn on which lie over or under another part. Of a belt with
// a thickness it is a half.
constexpr float kSewn = 0.4f;

// The hold of a border fades out over this share of the part's diagonal.
constexpr float kFade = 0.07f;

float held_by_width(float fraction, bool lowest) {
    const float sleeve = lowest ? kLegHeld : kSleeveHeld;
    if (fraction <= kWrist) return 1.0f;
    if (fraction <= kSleeve) return glm::mix(1.0f, sleeve, (fraction - kWrist) / (kSleeve - kWrist));
    return sleeve * std::clamp((kLoose - fraction) / (kLoose - kSleeve), 0.0f, 1.0f);
}

// Increases `follow` around vertices, depending on the distance along the edges.
void hold(std::span<const Index> vertices, float firmly, float reach, const EdgeGraph& graph,
          std::vector<float>& follow) {
    std::vector<float> distance(graph.size(), std::numeric_limits<float>::max());
    shortest_paths(graph, vertices, reach, distance, [&](Index v) {
        const float t = 1.0f - distance[v] / reach;
        follow[v] = std::max(follow[v], firmly * t * t * (3.0f - 2.0f * t));
    });
}

// The outline of a garment if more than half of the garment is this sheet; else nothing. Pockets are sheets
// too.
const Border* find_sheet(const Borders& borders) {
    std::vector<size_t> vertices(size_t(borders.parts), 0), outlines(vertices);
    for (const Index part : borders.part)
        if (part != kNone) ++vertices[size_t(part)];
    for (const Border& border : borders.all) ++outlines[size_t(border.part)];
    const auto found = std::ranges::find_if(borders.all, [&](const Border& border) {
        const size_t part = size_t(border.part);
        return !border.is_opening && outlines[part] == 1 && 2 * vertices[part] > borders.part.size();
    });
    return found == borders.all.end() ? nullptr : &*found;
}

// The vertices of a garment if more than half of them are a part without a border, as trousers of games whose
// ends are closed; else none.
std::vector<Index> find_closed(const Borders& borders) {
    std::vector<Index> vertices(size_t(borders.parts), 0);
    for (const Index part : borders.part)
        if (part != kNone) ++vertices[size_t(part)];
    for (const Border& border : borders.all) vertices[size_t(border.part)] = 0;
    std::vector<Index> out;
    for (size_t v = 0; v < borders.part.size(); ++v) {
        const Index part = borders.part[v];
        if (part != kNone && 2 * size_t(vertices[size_t(part)]) > borders.part.size())
            out.push_back(static_cast<Index>(v));
    }
    return out;
}

// Those of some vertices that hold the others, down to `end`; none if these lie flat. end: a share of the
// diagonal of their part.
std::vector<Index> find_upper_end(const Surface& surface, std::span<const Index> vertices, float end,
                                  float diagonal, const Vec3& up) {
    const auto height = [&](Index v) { return glm::dot(surface.positions_rest[v], up); };
    const auto [lowest, highest] = std::ranges::minmax_element(vertices, {}, height);
    std::vector<Index> upper;
    if (height(*highest) - height(*lowest) < kHangs * diagonal) return upper;
    for (const Index v : vertices)
        if (height(v) >= height(*highest) - end * diagonal) upper.push_back(v);
    return upper;
}

// Per welded vertex: how firmly it is held by the borders of its part.
std::vector<float> find_held(const Surface& surface, const Borders& borders, const Vec3& up) {
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
        if (size > 0.0f && firmly > 0.0f) hold(border.vertices, firmly, kFade * size, graph, follow);
    }
    const auto hold_upper_end = [&](std::span<const Index> vertices, float end) {
        const float size = borders.diagonal[borders.part[vertices.front()]];
        if (size <= 0.0f) return;
        hold(find_upper_end(surface, vertices, end, size, up), 1.0f, kFade * size, graph, follow);
    };
    if (const Border* sheet = find_sheet(borders)) hold_upper_end(sheet->vertices, kUpperEnd);
    const std::vector<Index> closed = find_closed(borders);
    if (!closed.empty()) hold_upper_end(closed, kClosedEnd);
    return follow;
}

// Per part of the garment: find_sewn_on().
std::vector<bool> sewn_on(const Surface& surface, const Borders& borders, std::span<const float> held) {
    std::vector<Index> vertices(size_t(borders.parts), 0), covered(vertices);
    std::vector<bool> sewn(vertices.size(), true);
    for (size_t v = 0; v < held.size(); ++v) {
        if (borders.part[v] == kNone) continue;
        ++vertices[size_t(borders.part[v])];
        if (held[v] > 0.0f) sewn[size_t(borders.part[v])] = false;
    }
    if (borders.parts < 2 || std::ranges::find(sewn, true) == sewn.end())
        return std::vector<bool>(sewn.size(), false);
    Index last = kNone;  // a vertex may have a place under it and one over it
    for (const base_cloth::Overlap& overlap : base_cloth::find_overlaps(surface)) {
        if (overlap.vertex != last) ++covered[size_t(borders.part[overlap.vertex])];
        last = overlap.vertex;
    }
    for (size_t p = 0; p < sewn.size(); ++p)
        sewn[p] = sewn[p] && float(covered[p]) >= kSewn * float(vertices[p]);
    return sewn;
}

}  // namespace

std::vector<float> suggest_follow(const Surface& surface, const Vec3& up) {
    const Borders borders(surface, up);
    std::vector<float> held = find_held(surface, borders, up);
    const std::vector<bool> sewn = sewn_on(surface, borders, held);
    if (!find_sheet(borders))
        for (size_t v = 0; v < held.size(); ++v)
            if (borders.part[v] != kNone && sewn[size_t(borders.part[v])]) held[v] = 1.0f;
    std::vector<float> out;
    for (const Index welded : surface.welded_of) out.push_back(held[welded]);
    return out;
}

std::vector<bool> find_sewn_on(const Surface& surface, const Vec3& up) {
    const Borders borders(surface, up);
    const std::vector<bool> sewn = sewn_on(surface, borders, find_held(surface, borders, up));
    std::vector<bool> out;
    for (Index p = 0; p < surface.welded.polygons(); ++p) {
        const Index corner = surface.welded.corner_vertex[surface.welded.polygon_start[p]];
        out.push_back(sewn[size_t(borders.part[corner])]);
    }
    return out;
}

Index count_openings(const Surface& surface) {
    const Borders borders(surface);
    std::vector<Index> of_part(size_t(borders.parts), 0);
    std::vector<bool> has_opening(of_part.size(), false);
    for (const Border& border : borders.all) {
        ++of_part[border.part];
        if (border.is_opening) has_opening[border.part] = true;
    }
    Index most = 0;
    for (size_t p = 0; p < of_part.size(); ++p)
        if (has_opening[p]) most = std::max(most, of_part[p]);
    return most;
}

}  // namespace rumple
