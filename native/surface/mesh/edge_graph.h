// SPDX-License-Identifier: GPL-3.0-or-later
// Ways along the edges of a surface at rest. Internal to surface.
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
using EdgeGraph = std::vector<std::vector<Neighbour>>;  // of every welded vertex

inline void connect(const Surface& surface, Index a, Index b, EdgeGraph& graph) {
    const float length = glm::distance(surface.positions_rest[a], surface.positions_rest[b]);
    graph[a].push_back({b, length});
    graph[b].push_back({a, length});
}

// Dijkstra 1959: the shortest ways from some vertices to all that are nearer than `distance` says, which is
// lowered to them. reached(vertex): in the order of the ways, lowest number first of equals.
// farthest: longer ways are not followed. Cost: O(log vertices) for each that is reached.
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
