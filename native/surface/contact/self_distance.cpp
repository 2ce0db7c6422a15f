// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/contact/self_distance.h"

#include <algorithm>
#include <cmath>

#include "base/tolerances.h"
#include "surface/mesh/disjoint_sets.h"

namespace rumple {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

// Per vertex: the lowest vertex of its part. Empty if there is only one part.
std::vector<Index> parts_of(size_t vertices, const std::vector<std::array<Index, 3>>& triangles) {
    DisjointSets sets(static_cast<Index>(vertices));
    for (const auto& [a, b, c] : triangles) {
        sets.unite(a, b);
        sets.unite(b, c);
    }
    std::vector<Index> part = sets.roots();
    const auto in_first = [&](const auto& t) { return part[t[0]] == part[triangles[0][0]]; };
    if (std::ranges::all_of(triangles, in_first)) part.clear();
    return part;
}

}  // namespace

SelfContactMesh::SelfContactMesh(std::span<const Vec3> positions,
                                 const std::vector<std::array<Index, 3>>& triangles)
    : triangles_(triangles),
      corners_(positions.size(), triangles),
      hierarchy_(build_packets(centres_of(positions, triangles))),
      part_(parts_of(positions.size(), triangles)) {}

PosedSelfContactMesh::PosedSelfContactMesh(const SelfContactMesh& surface, std::span<const Vec3> positions)
    : surface_(surface),
      count_(positions.size()),
      positions_(to_rows(positions)),
      normals_(positions_, surface.triangles_, surface.corners_),
      packets_(surface.hierarchy_, positions_, surface.triangles_, normals_.of_face) {}

bool PosedSelfContactMesh::face_the_same_way(Index vertex, Index triangle) const {
    return glm::dot(normals_.of_face[triangle].vec(), normals_.of_vertex[vertex].vec()) > kFacingNormals;
}

SelfContactSide PosedSelfContactMesh::nearest(Index vertex, float reach, Index& found) const {
    const Vec3 p = positions_[vertex].vec(), normal = normals_.of_vertex[vertex].vec();
    const Vec3Lanes at(p), facing(normal);
    const bool several = !surface_.part_.empty();
    const float touching = squared_reach(kSamePlace * reach);
    float best = squared_reach(reach);
    found = kNone;
    Vec3 displacement(0.0f);
    const auto look_at = [&](const PosedPackets::Packet& packet,
                             const PacketHierarchy::Triangles& triangles) {
        LaneMask faces = dot(packet.normal, facing) <= all_lanes(kFacingNormals);
        for (int k = 0; several && k < kLanes; ++k) {
            if (triangles[k] != kNone && surface_.in_other_parts(vertex, triangles[k])) faces[k] = -1;
        }
        if (bits_of(faces) == 0) return;
        const ClosestOfFour closest = closest_of(packet, at);
        for_each_true(faces & (closest.squared <= all_lanes(best)), [&](int k) {
            if (closest.squared[k] > best) return;
            const Index t = triangles[k];
            const auto& corner = surface_.triangles_[t];
            if (corner[0] == vertex || corner[1] == vertex || corner[2] == vertex) return;
            // Parts that touch at this point were cut apart there, so the triangle is ignored.
            if (closest.squared[k] <= touching && surface_.in_other_parts(vertex, t)) return;
            if (closest.squared[k] == best && (found == kNone || t >= found)) return;
            best = closest.squared[k];
            found = t;
            displacement = closest.way.at(k);
        });
    };
    // Leaves out nodes without a triangle that faces the vertex. This is so for all flat cloth around it.
    const PosedPackets::NoneFaces none_faces{normal, kFacingNormals};
    packets_.search(p, best, several ? nullptr : &none_faces, look_at);
    if (found == kNone) return {};
    const float distance = std::sqrt(best);
    const Vec3 towards =
        distance > kSamePlace * reach ? displacement / distance : -normals_.of_face[found].vec();
    return {towards, distance, face_the_same_way(vertex, found) ? kFar : distance};
}

std::vector<SelfContactSide> PosedSelfContactMesh::facing(std::span<const float> reach) const {
    std::vector<SelfContactSide> out(reach.size());
    if (surface_.triangles_.empty()) return out;
    std::vector<Index> triangle(out.size(), kNone);
    for_each_index(out.size(), kLeastSearches, [&](size_t v) {
        if (reach[v] > 0.0f && normals_.of_vertex[v].vec() != Vec3(0.0f))
            out[v] = nearest(static_cast<Index>(v), reach[v], triangle[v]);
    });
    const std::vector<SelfContactSide> found = out;
    for (size_t v = 0; v < found.size(); ++v) {
        if (triangle[v] == kNone) continue;
        for (const Index u : surface_.triangles_[triangle[v]]) {
            if (found[v].distance >= out[u].distance) continue;
            out[u] = {-found[v].towards, found[v].distance, found[v].in_any_direction};
        }
    }
    return out;
}

std::vector<float> PosedSelfContactMesh::heights() const {
    const std::vector<std::array<Index, 3>>& triangles = surface_.triangles_;
    std::vector<float> of_corner(3 * triangles.size());
    for_each_four_shared(triangles.size(), [&](size_t first, size_t count) {
        const auto corner = [&](int i) {
            std::array<Row, kLanes> rows;
            for (size_t k = 0; k < count; ++k) rows[k] = positions_[triangles[first + k][i]];
            return columns(rows);
        };
        const Vec3Lanes a = corner(0), b = corner(1), c = corner(2);
        const Vec3Lanes side[3] = {c - b, a - c, b - a};  // opposite each corner
        const Vec3Lanes n = cross(side[0], side[1]);
        const Lanes twice_area = square_root(dot(n, n));
        for (int i = 0; i < 3; ++i) {
            const Lanes length = square_root(dot(side[i], side[i]));
            const Lanes height = length > all_lanes(kShortestEdge) ? twice_area / length : Lanes{};
            for (size_t k = 0; k < count; ++k) of_corner[3 * (first + k) + size_t(i)] = height[k];
        }
    });
    std::vector<float> out(count_, kFar);
    for_each_index(count_, kLeastSteps, [&](size_t v) {
        for (const Index c : surface_.corners_.of(v)) out[v] = std::min(out[v], of_corner[c]);
    });
    return out;
}

}  // namespace rumple
