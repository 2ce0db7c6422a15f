// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/pins.h"

#include <algorithm>
#include <limits>

#include "surface/cloth/garment_borders.h"
#include "surface/mesh/edge_graph.h"

namespace rumple {

using base_cloth::Border, base_cloth::Borders;

namespace {

// Radius of a border over the diagonal of its part: how firmly it is held. A wrist is at 0.02, the leg of
// trousers at 0.055, a short sleeve at 0.07, a hem at 0.17 and more.
constexpr float kWrist = 0.03f, kSleeve = 0.05f, kLoose = 0.09f;
constexpr float kSleeveHeld = 0.4f, kLegHeld = 0.01f;

// What is at most this share of the diagonal above the lowest border is a hem or a leg: held as a sleeve is,
// it could not ride up where a knee bends, and stood in folds above the foot. When it was not held at all, a
// foot went through the cloth in a jump.
constexpr float kLowest = 0.1f;

// Over this share of the part's diagonal the hold of a border fades out.
constexpr float kFade = 0.07f;

float held_by_width(float fraction, bool lowest) {
    const float sleeve = lowest ? kLegHeld : kSleeveHeld;
    if (fraction <= kWrist) return 1.0f;
    if (fraction <= kSleeve) return glm::mix(1.0f, sleeve, (fraction - kWrist) / (kSleeve - kWrist));
    return sleeve * std::clamp((kLoose - fraction) / (kLoose - kSleeve), 0.0f, 1.0f);
}

// Raises `follow` around a border, by the distance along the edges.
void hold(const Border& border, float firmly, float reach, const EdgeGraph& graph,
          std::vector<float>& follow) {
    std::vector<float> distance(graph.size(), std::numeric_limits<float>::max());
    shortest_paths(graph, border.vertices, reach, distance, [&](Index v) {
        const float t = 1.0f - distance[v] / reach;
        follow[v] = std::max(follow[v], firmly * t * t * (3.0f - 2.0f * t));
    });
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
