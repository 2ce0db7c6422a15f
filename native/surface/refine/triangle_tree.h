// SPDX-License-Identifier: GPL-3.0-or-later
// Closest points on the triangles of a surface at rest. Internal to surface.
#pragma once

#include "base/tolerances.h"
#include "surface/query/bounds.h"
#include "surface/query/hierarchy.h"
#include "surface/refine/refinement.h"

namespace rumple {

struct TrianglePoint {
    SurfacePoint place;
    double squared_distance = 0.0;
};

// The point of one triangle closest to p. A triangle with zero area consists of its edges.
TrianglePoint closest_point(const Surface& surface, Index triangle, const Vec3& p);

// A bounding volume hierarchy over all triangles: built in O(n log^2 n),
// asked in O(log n). The surface must outlive it.
class TriangleTree {
  public:
    explicit TriangleTree(const Surface& surface);

    // Ties go to the lowest triangle.
    TrianglePoint closest(const Vec3& p) const;
    // The closest accepted point within a distance; no triangle if there is none. skip(node): whether no
    // point of a node is accepted, for speed; wanted(Index): whether to test a triangle at all;
    // accept(TrianglePoint): whether its closest point is accepted.
    template <typename Skip, typename Wanted, typename Accept>
    TrianglePoint closest_within(const Vec3& p, double farthest, Skip&& skip, Wanted&& wanted,
                                 Accept&& accept) const;

    const Hierarchy& hierarchy() const { return hierarchy_; }  // of the triangles
    const Bounds& bounds(Index node) const { return bounds_[node]; }

  private:
    const Surface& surface_;
    Hierarchy hierarchy_;
    std::vector<Bounds> bounds_;  // per node
};

template <typename Skip, typename Wanted, typename Accept>
TrianglePoint TriangleTree::closest_within(const Vec3& p, double farthest, Skip&& skip, Wanted&& wanted,
                                           Accept&& accept) const {
    TrianglePoint best;
    best.squared_distance = farthest * farthest;
    const glm::dvec3 query(p);
    const auto distance = [&](Index node) { return squared_distance(bounds_[node], query); };
    visit_nearest_first(
        hierarchy_, distance,
        [&](Index node) { return distance(node) > best.squared_distance * (1.0 + kTieSlack) || skip(node); },
        [&](Index place) {
            const Index triangle = hierarchy_.order[place];
            if (!wanted(triangle)) return;
            const TrianglePoint point = closest_point(surface_, triangle, p);
            const bool tie = point.squared_distance == best.squared_distance;
            const bool lower = best.place.triangle == kNone || point.place.triangle < best.place.triangle;
            if ((point.squared_distance < best.squared_distance || (tie && lower)) && accept(point))
                best = point;
        });
    return best;
}

}  // namespace rumple
