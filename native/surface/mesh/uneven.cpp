// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/mesh/uneven.h"

#include <algorithm>
#include <vector>

namespace rumple {
namespace {

// Largest share of the area in narrow polygons of an even mesh.
constexpr double kNarrowShare = 0.1;

}  // namespace

bool is_uneven(const Surface& surface, float width) {
    const PolygonMesh& mesh = surface.welded;
    std::vector<double> areas(size_t(mesh.polygons()), 0.0);
    for (Index t = 0; t < Index(surface.triangles.size()); ++t) {
        const auto [a, b, c] = welded_vertices(surface, t);
        const std::vector<Vec3>& at = surface.positions_rest;
        areas[surface.triangles[t].polygon] += 0.5 * glm::length(glm::cross(at[b] - at[a], at[c] - at[a]));
    }
    double narrow = 0.0, whole = 0.0;
    for (Index p = 0; p < mesh.polygons(); ++p) {
        const Index size = mesh.polygon_size(p), *corner = &mesh.corner_vertex[mesh.polygon_start[p]];
        float longest = 0.0f;
        for (Index k = 0; k < size; ++k)
            longest = std::max(longest, glm::distance(surface.positions_rest[corner[k]],
                                                      surface.positions_rest[corner[(k + 1) % size]]));
        whole += areas[p];
        if ((size == 3 ? 2.0 : 1.0) * areas[p] < double(width) * longest) narrow += areas[p];
    }
    return whole > 0.0 && narrow / whole > kNarrowShare;
}

}  // namespace rumple
