// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/overlaps.h"

#include <algorithm>

#include "base/tolerances.h"
#include "surface/mesh/disjoint_sets.h"
#include "surface/mesh/positions.h"
#include "surface/output/attachments.h"
#include "surface/query/bounds.h"
#include "surface/refine/triangle_tree.h"

namespace rumple::base_cloth {
namespace {

constexpr double kReach = 1.0 / 30.0;  // of the garment's diagonal

// Cosines: parts face the same way, and one is above the other, not beside it.
constexpr float kSameWay = 0.5f, kAbove = 0.7f;

// Per welded vertex: the lowest vertex of its part.
std::vector<Index> parts_of(const Surface& surface) {
    DisjointSets sets(surface.welded.vertex_count);
    for (const Edge& edge : surface.edges) sets.unite(edge.a, edge.b);
    std::vector<Index> parts;
    for (Index v = 0; v < surface.welded.vertex_count; ++v) parts.push_back(sets.find(v));
    return parts;
}

bool has_several(const Surface& surface, const std::vector<Index>& part) {
    const auto of = [&](const Triangle& t) { return part[surface.welded.corner_vertex[t.corner[0]]]; };
    return std::ranges::any_of(surface.triangles,
                               [&](const Triangle& t) { return of(t) != of(surface.triangles[0]); });
}

}  // namespace

std::vector<Overlap> find_overlaps(const Surface& surface) {
    const std::vector<Index> part = parts_of(surface);
    if (!has_several(surface, part)) return {};
    const std::vector<Vec3>& rest = surface.positions_rest;
    std::vector<Vec3> normals(rest.size());
    vertex_normals(surface, rest, normals);
    const TriangleTree tree(surface);
    const double reach = kReach * bounding_diagonal(rest);
    std::vector<Overlap> overlaps;
    for (Index v = 0; v < surface.welded.vertex_count; ++v) {
        for (const bool outer : {true, false}) {
            const TrianglePoint found = tree.closest_within(rest[v], reach, [&](const TrianglePoint& point) {
                const Triangle& triangle = surface.triangles[point.place.triangle];
                if (part[surface.welded.corner_vertex[triangle.corner[0]]] == part[v]) return false;
                const Vec3 down = interpolate(surface, point.place, rest) - rest[v];
                const Vec3 normal = interpolate(surface, point.place, normals);
                const float along = glm::dot(down, normals[v]) * (outer ? -1.0f : 1.0f);
                return glm::dot(normal, normals[v]) > kSameWay * glm::length(normal) &&
                       along > kAbove * glm::length(down) && along > kShortestEdge;
            });
            if (found.place.triangle != kNone) overlaps.push_back({v, found.place, outer});
        }
    }
    return overlaps;
}

}  // namespace rumple::base_cloth
