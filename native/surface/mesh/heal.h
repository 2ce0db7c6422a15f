// SPDX-License-Identifier: GPL-3.0-or-later
// Heals meshes: makes an oriented manifold from any mesh, so that it can be solved.
#pragma once

#include <array>
#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

// A healed copy of a mesh, which build_surface() accepts, and where its elements come from. It begins with
// the vertices of the mesh. Copies of some of them follow.
struct HealedMesh {
    PolygonMesh mesh;
    std::vector<Index> vertex_source;       // healed vertex -> vertex
    std::vector<Index> corner_source;       // healed corner -> corner
    std::vector<Index> polygon_source;      // healed polygon -> polygon
    std::vector<Index> triangle_corner;     // 3 per triangle of a healed polygon: healed corners
    std::vector<Index> turned;              // polygons, ascending, whose winding was reversed
    std::vector<std::array<Index, 2>> cut;  // edges (a < b), ascending, at which some polygons were cut off
    // A polygon that was left out, ascending, and the polygon below it
    std::vector<std::array<Index, 2>> doubled;
    std::vector<Index> repeated;  // polygons, ascending, that use a vertex twice
};

// The steps, in this order:
// - Repeated: a vertex's second use in a polygon becomes a new vertex; so do all vertices of a polygon that
//   uses another one's vertices in another order.
// - Doubled: of polygons over the same vertices in the same or the reverse order, only the first is kept.
// - Cut: an edge of more than two polygons keeps as one pair the two that continue each other best, then the
//   next two (Gueziec, Taubin, Lazarus and Horn 2001; chosen by angle).
// - Turned: within a part, polygons are wound like the side of larger area, across seams that will be welded,
//   too. A part with one side only (Moebius) is cut where its ends meet. A tube or a bag that faces inwards
//   is turned as a whole: what is worn under a garment lies behind its faces.
// - Vertices are split into fans along all cuts.
// An oriented manifold that is not inside out is returned unchanged. Throws InvalidInput like
// build_surface(). Cost: O(corners log corners).
HealedMesh heal_mesh(const SurfaceInput& input);

}  // namespace rumple
