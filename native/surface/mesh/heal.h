// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh that is not an oriented manifold, as one that is: what is shown can be solved.
#pragma once

#include <array>
#include <vector>

#include "surface/mesh/topology.h"

namespace rumple {

// A copy of a mesh that build_surface() takes, and where its elements come from. The first vertices are the
// mesh's own; copies of some of them follow.
struct HealedMesh {
    PolygonMesh mesh;
    std::vector<Index> vertex_source;       // healed vertex -> vertex
    std::vector<Index> corner_source;       // healed corner -> corner
    std::vector<Index> polygon_source;      // healed polygon -> polygon
    std::vector<Index> triangle_corner;     // 3 per triangle of a healed polygon: healed corners
    std::vector<Index> turned;              // polygons, ascending, that are wound the other way
    std::vector<std::array<Index, 2>> cut;  // edges (a < b), ascending, at which some polygons were cut off
    std::vector<std::array<Index, 2>>
        doubled;                  // a polygon that was left out, ascending, and the one it lies on
    std::vector<Index> repeated;  // polygons, ascending, that use a vertex twice

    bool is_changed() const {
        return !(turned.empty() && cut.empty() && doubled.empty() && repeated.empty());
    }
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
// A mesh that is an oriented manifold and not inside out comes back as it is. Throws InvalidInput as
// build_surface() does. Cost: O(corners log corners).
HealedMesh heal_mesh(const SurfaceInput& input);

}  // namespace rumple
