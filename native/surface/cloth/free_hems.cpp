// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/free_hems.h"

#include <algorithm>

#include "base/smooth_step.h"
#include "surface/cloth/smooth_normals.h"
#include "surface/mesh/edge_graph.h"
#include "surface/mesh/normals.h"

namespace rumple::base_cloth {
namespace {

// Of painted follow: it counts by its cube, and this pulls harder than springs.
constexpr float kHolds = 0.1f;

// Sine of the angle by which cloth is folded inwards: from the first on it is unfolded, from the second on
// wholly.
constexpr float kFoldedFrom = 0.1f, kFolded = 0.35f;

// Share of the reach from which on the effect fades out.
constexpr float kFades = 0.7f;

// Number of times that the displacements are averaged with those of neighbours: folds begin and end sharply.
constexpr int kAverages = 10;

// A normal, the direction across it and `along`, and the direction in the surface nearest to `along`; zero if
// there is none.
glm::mat3 surface_frame(const Vec3& normal, const Vec3& along) {
    const Vec3 across = glm::cross(normal, along);
    const float length = glm::length(across);
    if (!(length > 0.0f)) return glm::mat3(0.0f);
    return {normal, across / length, glm::cross(across / length, normal)};
}

// The first vertex at least `reach` from hems, going farther and farther; kNone if there is none.
Index above_hem(std::span<const NearHem> near, Index from, float reach) {
    while (from != kNone && near[from].distance < reach) from = near[from].farther;
    return from == kNone || near[from].farther == kNone ? kNone : from;
}

}  // namespace

std::vector<NearHem> find_near_hems(const Surface& surface, const Hems& hems) {
    EdgeGraph graph(surface.welded.vertex_count);
    for (const Edge& edge : surface.edges) connect(surface, edge.a, edge.b, graph);
    std::vector<NearHem> near(graph.size());
    std::vector<Index> of_hems;
    for (const Hems::Hem& hem : hems.all) {
        if (!hem.is_opening) continue;
        for (const Index v : hem.vertices) of_hems.push_back(near[v].vertex = v);
    }
    std::vector<float> distance(graph.size(), std::numeric_limits<float>::infinity());
    shortest_paths(graph, of_hems, std::numeric_limits<float>::infinity(), distance, [&](Index v) {
        near[v].distance = distance[v];
        for (const auto& [before, length] : graph[v])
            if (near[v].vertex == kNone && distance[before] + length == distance[v])
                near[v].vertex = near[before].vertex;
    });
    const std::vector<Vec3>& rest = surface.positions_rest;
    const std::vector<Vec3> normals = vertex_normals(surface, rest);
    for (size_t v = 0; v < near.size(); ++v) {
        float farthest = near[v].distance;
        for (const auto& [to, length] : graph[v]) {
            if (!(near[to].distance > farthest)) continue;
            farthest = near[to].distance;
            near[v].farther = to;
        }
        if (near[v].farther != kNone)
            near[v].frame = surface_frame(normals[v], rest[near[v].farther] - rest[v]);
    }
    return near;
}

float share_of_smoothing(const NearHem& near, float free, float held, float reach) {
    if (near.vertex == kNone) return 1.0f;
    const float away = smooth_step(0.0f, reach, near.distance), holds = smooth_step(0.0f, kHolds, held);
    return glm::mix(free, 1.0f, std::max(holds, away));
}

void unfold_hems(const Surface& surface, std::span<const NearHem> near, std::span<const float> held,
                 float reach, std::span<Vec3> animated) {
    const std::vector<Vec3>& rest = surface.positions_rest;
    const std::vector<Vec3> normals = vertex_normals(surface, animated);
    std::vector<Vec3> unfold(animated.size(), Vec3(0.0f));
    std::vector<float> share(animated.size(), 0.0f);
    bool folded = false;
    for (size_t v = 0; v < animated.size(); ++v) {
        if (near[v].vertex == kNone || !(near[v].distance < reach)) continue;
        share[v] = (1.0f - smooth_step(0.0f, kHolds, held[v])) *
                   (1.0f - smooth_step(kFades * reach, reach, near[v].distance));
        const Index above = above_hem(near, static_cast<Index>(v), reach);
        if (share[v] <= 0.0f || above == kNone) continue;
        const Vec3 towards = animated[near[above].farther] - animated[above], way = rest[v] - rest[above];
        const Vec3 unfolded = animated[above] + surface_frame(normals[above], towards) *
                                                    (glm::transpose(near[above].frame) * way);
        const float inwards = glm::dot(unfolded - animated[v], normals[above]);
        unfold[v] = smooth_step(kFoldedFrom, kFolded, inwards / glm::length(way)) * (unfolded - animated[v]);
        folded = folded || unfold[v] != Vec3(0.0f);
    }
    if (!folded) return;
    average_with_neighbours(surface, kAverages, share, unfold);
    for (size_t v = 0; v < animated.size(); ++v) animated[v] += unfold[v];
}

}  // namespace rumple::base_cloth
