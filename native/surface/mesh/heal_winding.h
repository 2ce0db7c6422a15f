// SPDX-License-Identifier: GPL-3.0-or-later
// The step of heal_mesh() that chooses the winding of the polygons.
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
    bool turned;  // both use the edge in the same direction: their windings are opposite
};

inline Index next_corner(const PolygonMesh& mesh, Index polygon, Index corner) {
    return corner + 1 < mesh.polygon_start[polygon + 1] ? corner + 1 : mesh.polygon_start[polygon];
}

// The polygon of every corner.
std::vector<Index> polygons_of_corners(const PolygonMesh& mesh);

// Twice the area of a polygon, along its normal (Newell).
glm::dvec3 area_vector(const HealedMesh& healed, std::span<const Vec3> positions, Index p);

// Which polygons to reverse, so that joined polygons have the same winding: that of the larger area of their
// part, or outwards if the part is inside out. Joints where this is impossible (a part with only one side)
// are removed. cut: receives their edges. seams: joints that are only used for the winding.
std::vector<bool> wind_polygons(const HealedMesh& healed, std::span<const Vec3> positions,
                                std::vector<Joint>& joints, const std::vector<Joint>& seams,
                                std::set<std::array<Index, 2>>& cut);

}  // namespace rumple
