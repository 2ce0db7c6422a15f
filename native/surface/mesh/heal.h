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

// In this order:
//   repeated  the second use of a vertex in a polygon becomes a vertex of its own, and so do all vertices of
//   a
//             polygon that has those of another one in another order;
//   doubled   of polygons over the same vertices in the same order, or the reverse of it, only the first is
//   kept; cut       where an edge has more than two polygons, those two stay joined that continue one another
//   best,
//             then the next two: the cut of Gueziec, Taubin, Lazarus and Horn 2001, chosen by the angle;
//   turned    within a part, polygons are wound as the larger area of it is, also across seams that will be
//             welded. A part with one side only (Moebius) is cut where its ends meet. A tube or a bag that
//             faces inwards is turned as a whole: what is worn under a garment lies behind its faces;
//   then vertices are split into their fans along all cuts.
// A mesh that is an oriented manifold and not inside out comes back as it is. Throws InvalidInput as
// build_surface() does. Cost: O(corners log corners).
HealedMesh heal_mesh(const SurfaceInput& input);

}  // namespace rumple
