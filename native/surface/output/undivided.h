// SPDX-License-Identifier: GPL-3.0-or-later
// The mesh that a mesh was made of by one subdivision, from its polygons alone.
#pragma once

#include <optional>
#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

struct Undivided {
    PolygonMesh mesh;           // without creases
    std::vector<Index> vertex;  // per vertex of `mesh`: that of the subdivided one
};

// Catmull and Clark 1978: every polygon becomes a quad at each of its corners, around a new vertex, and every
// edge has a new vertex. Other schemes that divide so (Blender's Simple) are alike. Of several answers, as a
// regular grid has, it is that with the lowest vertex of each part, which Blender writes first. Loose
// vertices have no part in it. None if some polygon is not of such a quad. Cost: O(corners x log corners).
std::optional<Undivided> undivided(const PolygonMesh& mesh);

}  // namespace rumple
