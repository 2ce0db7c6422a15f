// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/mesh/normals.h"

#include "base/solve_team.h"
#include "base/tolerances.h"

namespace rumple {

void vertex_normals(const Surface& surface, std::span<const Vec3> positions, std::span<Vec3> normals) {
    for (Vec3& n : normals) n = Vec3(0.0f);
    for (Index t = 0; t < static_cast<Index>(surface.triangles.size()); ++t) {
        const std::array<Index, 3> v = welded_vertices(surface, t);
        const Vec3 twice_area =
            glm::cross(positions[v[1]] - positions[v[0]], positions[v[2]] - positions[v[0]]);
        for (int k = 0; k < 3; ++k) normals[v[k]] += twice_area;
    }
    for (Vec3& n : normals) n = unit_or_zero(n, kSmallestArea);
}

std::vector<Vec3> vertex_normals(const Surface& surface, std::span<const Vec3> positions) {
    std::vector<Vec3> normals(positions.size());
    vertex_normals(surface, positions, normals);
    return normals;
}

SurfaceFrame triangle_frame(const Vec3& p0, const Vec3& p1, const Vec3& p2) {
    const Vec3 e1 = p1 - p0;
    const Vec3 n = glm::cross(e1, p2 - p0);
    const float e1_length = glm::length(e1);
    const float n_length = glm::length(n);
    if (e1_length < kShortestEdge || n_length < kSmallestArea) return {};
    SurfaceFrame frame;
    frame.tangent = e1 / e1_length;
    frame.normal = n / n_length;
    frame.bitangent = glm::cross(frame.normal, frame.tangent);
    return frame;
}

void triangle_frames(const Surface& surface, std::span<const Vec3> positions,
                     std::span<SurfaceFrame> frames) {
    for_each_index(frames.size(), kLeastSteps, [&](size_t t) {
        const Index* corner = surface.triangles[t].corner;
        const auto at = [&](int k) { return positions[surface.welded.corner_vertex[corner[k]]]; };
        frames[t] = triangle_frame(at(0), at(1), at(2));
    });
}

std::vector<SurfaceFrame> triangle_frames(const Surface& surface, std::span<const Vec3> positions) {
    std::vector<SurfaceFrame> frames(surface.triangles.size());
    triangle_frames(surface, positions, frames);
    return frames;
}

}  // namespace rumple
