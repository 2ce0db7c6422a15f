// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/untangle.h"

#include <algorithm>

#include "surface/mesh/normals.h"
#include "surface/mesh/positions.h"

namespace rumple {
namespace {

// Length / rest length. Where skinning tears the animation, a point may stick out of it by many edges. The
// cloth has drawn it in, and the displacement around it would put it back.
constexpr float kMostStretched = 2.0f;

// Per triangle: whether it faces away from the surface around it, which is that of its vertices and their
// neighbours.
std::vector<bool> turned_over(const Surface& surface, std::span<const Vec3> positions) {
    const std::vector<Vec3> of_vertex = vertex_normals(surface, positions);
    std::vector<Vec3> around = of_vertex;
    for (const Edge& edge : surface.edges) {
        around[edge.a] += of_vertex[edge.b];
        around[edge.b] += of_vertex[edge.a];
    }
    std::vector<bool> turned(surface.triangles.size());
    for (Index t = 0; t < static_cast<Index>(turned.size()); ++t) {
        const auto [a, b, c] = welded_vertices(surface, t);
        const Vec3 normal = glm::cross(positions[b] - positions[a], positions[c] - positions[a]);
        turned[t] = glm::dot(normal, around[a] + around[b] + around[c]) < 0.0f;
    }
    return turned;
}

// Per vertex: whether a triangle around it is turned over in the cloth only.
std::vector<bool> tangled_vertices(const Surface& surface, const std::vector<bool>& in_animation,
                                   std::span<const Vec3> positions, bool& any) {
    const std::vector<bool> turned = turned_over(surface, positions);
    std::vector<bool> tangled(positions.size(), false);
    any = false;
    for (size_t t = 0; t < turned.size(); ++t) {
        if (!turned[t] || in_animation[t]) continue;
        any = true;
        for (const Index v : welded_vertices(surface, static_cast<Index>(t))) tangled[v] = true;
    }
    return tangled;
}

// Gives the chosen vertices the mean displacement of their neighbours.
void smooth_displacements(const Surface& surface, const std::vector<bool>& chosen,
                          std::vector<Vec3>& displacement) {
    std::vector<Vec3> sum(displacement.size(), Vec3(0.0f));
    std::vector<float> count(displacement.size(), 0.0f);
    for (const Edge& edge : surface.edges) {
        sum[edge.a] += displacement[edge.b];
        sum[edge.b] += displacement[edge.a];
        count[edge.a] += 1.0f;
        count[edge.b] += 1.0f;
    }
    for (size_t v = 0; v < displacement.size(); ++v)
        if (chosen[v] && count[v] > 0.0f) displacement[v] = sum[v] / count[v];
}

// Puts moved vertices back into the cloth where an edge has become longer than kMostStretched and than in the
// cloth.
void put_back_stretched(const Surface& surface, std::span<const Vec3> cloth, std::vector<Vec3>& at,
                        std::vector<bool>& moved) {
    for (bool again = true; again;) {
        again = false;
        for (const Edge& edge : surface.edges) {
            const auto length = [&](std::span<const Vec3> p) { return glm::distance(p[edge.a], p[edge.b]); };
            if (!moved[edge.a] && !moved[edge.b]) continue;
            if (length(at) <= std::max(kMostStretched * length(surface.positions_rest), length(cloth)))
                continue;
            for (const Index v : {edge.a, edge.b}) {
                at[v] = cloth[v];
                moved[v] = false;
            }
            again = true;
        }
    }
}

}  // namespace

std::vector<Vec3> untangled(const Surface& surface, std::span<const Vec3> animated,
                            std::span<const Vec3> positions) {
    check_frame(surface, animated, "animated");
    check_frame(surface, positions);
    const std::vector<Vec3> from = weld_positions(surface, animated);
    const std::vector<Vec3> cloth = weld_positions(surface, positions);
    std::vector<Vec3> at = cloth, displacement(at.size());
    for (size_t v = 0; v < at.size(); ++v) displacement[v] = at[v] - from[v];
    const std::vector<bool> in_animation = turned_over(surface, from);
    std::vector<bool> moved(at.size(), false);
    for (int pass = 0; pass < kUntanglePasses; ++pass) {
        bool any = false;
        const std::vector<bool> tangled = tangled_vertices(surface, in_animation, at, any);
        if (!any) break;
        smooth_displacements(surface, tangled, displacement);
        for (size_t v = 0; v < at.size(); ++v) {
            if (!tangled[v]) continue;
            at[v] = from[v] + displacement[v];
            moved[v] = true;
        }
    }
    put_back_stretched(surface, cloth, at, moved);
    std::vector<Vec3> out(positions.begin(), positions.end());
    for (size_t v = 0; v < out.size(); ++v)
        if (moved[surface.welded_of[v]]) out[v] = at[surface.welded_of[v]];
    return out;
}

}  // namespace rumple
