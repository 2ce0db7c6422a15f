// SPDX-License-Identifier: GPL-3.0-or-later
// The step of heal_mesh() that decides which way the polygons face.
#pragma once

#include <array>
#include <set>
#include <span>
#include <vector>

#include "surface/mesh/heal.h"

namespace rumple {

// Two polygons that stay joined at an edge, by the corners that begin it.
struct Joint {
    Index corner[2];
    bool turned;  // both run along the edge the same way: one of them is wound the other way
};

inline Index next_corner(const PolygonMesh& mesh, Index polygon, Index corner) {
    return corner + 1 < mesh.polygon_start[polygon + 1] ? corner + 1 : mesh.polygon_start[polygon];
}

// The polygon of every corner.
std::vector<Index> polygons_of_corners(const PolygonMesh& mesh);

// Twice the area of a polygon, along its normal (Newell).
glm::dvec3 area_vector(const HealedMesh& healed, std::span<const Vec3> positions, Index p);

// Which polygons to turn so that joined ones are wound alike, and as the larger area of their part, or
// outwards where the part is inside out. Joints at which that cannot be (a part with one side only) are
// removed; cut: gets their edges. seams: joints that count for the winding alone.
std::vector<bool> wind_polygons(const HealedMesh& healed, std::span<const Vec3> positions,
                                std::vector<Joint>& joints, const std::vector<Joint>& seams,
                                std::set<std::array<Index, 2>>& cut);

}  // namespace rumple
