// SPDX-License-Identifier: GPL-3.0-or-later
// Shortest paths along the edges of a surface at rest. Internal to surface.
#pragma once

#include <functional>
#include <queue>
#include <utility>
#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

struct Neighbour {
    Index vertex;
    float length;  // object units
};
using EdgeGraph = std::vector<std::vector<Neighbour>>;  // per welded vertex

inline void connect(const Surface& surface, Index a, Index b, EdgeGraph& graph) {
    const float length = glm::distance(surface.positions_rest[a], surface.positions_rest[b]);
    graph[a].push_back({b, length});
    graph[b].push_back({a, length});
}

// Shortest paths from some vertices (Dijkstra 1959). It lowers `distance` wherever a path is shorter than the
// given value. reached(vertex) is called in the order of distance; of equal ones the lowest number is first.
// farthest: longer paths are not followed. Cost: O(log vertices) for each vertex that is reached.
template <typename Reached>
void shortest_paths(const EdgeGraph& graph, std::span<const Index> from, float farthest,
                    std::span<float> distance, Reached&& reached) {
    using Step = std::pair<float, Index>;
    std::priority_queue<Step, std::vector<Step>, std::greater<>> steps;
    for (const Index v : from) steps.push({distance[v] = 0.0f, v});
    while (!steps.empty()) {
        const auto [travelled, v] = steps.top();
        steps.pop();
        if (travelled > distance[v] || travelled > farthest) continue;
        reached(v);
        for (const auto& [to, length] : graph[v]) {
            if (travelled + length < distance[to]) steps.push({distance[to] = travelled + length, to});
        }
    }
}

}  // namespace rumple
