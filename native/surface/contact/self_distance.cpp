// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/contact/self_distance.h"

#include <algorithm>
#include <cmath>

#include "base/tolerances.h"
#include "surface/query/closest_point.h"

namespace rumple {

OwnSurface::OwnSurface(std::span<const Vec3> positions, const std::vector<std::array<Index, 3>>& triangles)
    : hierarchy_(build_hierarchy(centres_of(positions, triangles))) {
    for (const Index t : hierarchy_.order) triangles_.push_back(triangles[t]);
}

PosedOwnSurface::PosedOwnSurface(const OwnSurface& surface, std::span<const Vec3> positions)
    : surface_(surface),
      positions_(positions),
      normals_(positions, surface.triangles_),
      boxes_(volumes_of<Box>(surface.hierarchy_,
                             [&](Box& box, Index t) {
                                 for (const Index v : surface.triangles_[t]) box.add(positions[v]);
                             })),
      facings_(
          volumes_of<Box>(surface.hierarchy_, [&](Box& box, Index t) { box.add(normals_.of_face[t]); })) {}

OwnSide PosedOwnSurface::nearest(Index vertex, float reach, Index& found) const {
    const Vec3 p = positions_[vertex], normal = normals_.of_vertex[vertex];
    float best = reach * reach;
    found = kNone;
    Vec3 displacement(0.0f);
    const auto look_at = [&](Index t) {
        if (glm::dot(normals_.of_face[t], normal) > kFacingNormals) return;
        const auto& corner = surface_.triangles_[t];
        if (corner[0] == vertex || corner[1] == vertex || corner[2] == vertex) return;
        const Vec3 &a = positions_[corner[0]], &b = positions_[corner[1]], &c = positions_[corner[2]];
        const Vec3 w = closest_weights(p, a, b, c);
        const Vec3 to = w.x * a + w.y * b + w.z * c - p;
        const float squared = glm::dot(to, to);
        if (squared > best || (squared == best && (found == kNone || t >= found))) return;
        best = squared;
        found = t;
        displacement = to;
    };
    // No triangle of the node faces the vertex: so it is with all that lies flat around it.
    const auto faces_away = [&](Index node) { return facings_[node].least_along(normal) > kFacingNormals; };
    visit_nearest_first(
        surface_.hierarchy_, [&](Index node) { return boxes_[node].squared_distance(p); },
        [&](Index node) { return boxes_[node].squared_distance(p) > best || faces_away(node); }, look_at);
    if (found == kNone) return {};
    const float distance = std::sqrt(best);
    const Vec3 towards = distance > kSamePlace * reach ? displacement / distance : -normals_.of_face[found];
    return {towards, distance, glm::dot(towards, normal) > 0.0f};
}

std::vector<OwnSide> PosedOwnSurface::facing(std::span<const float> reach) const {
    std::vector<OwnSide> out(positions_.size());
    if (surface_.triangles_.empty()) return out;
    std::vector<Index> triangle(positions_.size(), kNone);
    for (size_t v = 0; v < out.size(); ++v) {
        if (reach[v] > 0.0f && normals_.of_vertex[v] != Vec3(0.0f))
            out[v] = nearest(static_cast<Index>(v), reach[v], triangle[v]);
    }
    const std::vector<OwnSide> found = out;
    for (size_t v = 0; v < found.size(); ++v) {
        if (triangle[v] == kNone) continue;
        for (const Index u : surface_.triangles_[triangle[v]]) {
            if (found[v].distance >= out[u].distance) continue;
            const bool outside = glm::dot(found[v].towards, normals_.of_vertex[u]) < 0.0f;
            out[u] = {-found[v].towards, found[v].distance, outside};
        }
    }
    return out;
}

std::vector<float> PosedOwnSurface::heights() const {
    std::vector<float> out(positions_.size(), std::numeric_limits<float>::infinity());
    for (const auto& t : surface_.triangles_) {
        const Vec3 side[3] = {positions_[t[2]] - positions_[t[1]], positions_[t[0]] - positions_[t[2]],
                              positions_[t[1]] - positions_[t[0]]};  // opposite of each corner
        const Vec3 n = glm::cross(side[0], side[1]);
        const float twice_area = std::sqrt(glm::dot(n, n));
        for (int k = 0; k < 3; ++k) {
            const float length = std::sqrt(glm::dot(side[k], side[k]));
            out[t[k]] = std::min(out[t[k]], length > kShortestEdge ? twice_area / length : 0.0f);
        }
    }
    return out;
}

}  // namespace rumple
