// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/free_hems.h"

#include <algorithm>

#include "base/smooth_step.h"
#include "surface/mesh/edge_graph.h"

namespace rumple::base_cloth {
namespace {

constexpr float kHolds =
    0.1f;  // of painted follow: it counts by its cube, and this pulls harder than springs

}  // namespace
std::vector<NearHem> find_near_hems(const Surface& surface, const Hems& hems) {
    EdgeGraph graph(surface.welded.vertex_count);
    for (const Edge& edge : surface.edges) connect(surface, edge.a, edge.b, graph);
    std::vector<NearHem> near(graph.size());
    std::vector<Index> of_hems;
    for (const Hems::Hem& hem : hems.all)
        for (const Index v : hem.vertices) of_hems.push_back(near[v].vertex = v);
    std::vector<float> distance(graph.size(), std::numeric_limits<float>::infinity());
    shortest_paths(graph, of_hems, std::numeric_limits<float>::infinity(), distance, [&](Index v) {
        near[v].distance = distance[v];
        for (const auto& [before, length] : graph[v])
            if (near[v].vertex == kNone && distance[before] + length == distance[v])
                near[v].vertex = near[before].vertex;
    });
    return near;
}

float share_of_smoothing(const NearHem& near, float free, float held, float reach) {
    if (near.vertex == kNone) return 1.0f;
    const float away = smooth_step(0.0f, reach, near.distance), holds = smooth_step(0.0f, kHolds, held);
    return glm::mix(free, 1.0f, std::max(holds, away));
}

}  // namespace rumple::base_cloth
