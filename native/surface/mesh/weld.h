// SPDX-License-Identifier: GPL-3.0-or-later
// Joins the vertices that a game mesh was split into at its seams. Internal to surface.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

// Which vertices become one: class_of[v] is the lowest vertex of v's class.
//
// A seam is a pair of boundary edges that lie on one another (both ends within
// kWeldDistance) and run in opposite directions, as the two sides of a cut do.
// It joins edges, not points, so parts that only touch stay separate: two sleeves that meet in a point, or
// the layers of a double cloth that face the same way. If three or more boundary edges are at the same place,
// or if joining would make an edge non-manifold, a polygon degenerate or two polygons equal, the seams there
// stay open, and a warning names the first vertex.
struct Weld {
    std::vector<Index> class_of;
    std::vector<std::string> warnings;
};

// The corners that begin two boundary edges at the same place, with any directions.
std::vector<std::array<Index, 2>> find_seams(const PolygonMesh& mesh, std::span<const Vec3> positions);

Weld find_weld(const PolygonMesh& mesh, std::span<const Vec3> positions);

}  // namespace rumple
