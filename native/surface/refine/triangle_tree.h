// SPDX-License-Identifier: GPL-3.0-or-later
// Closest points on the triangles of a surface at rest. Internal to surface.
#pragma once

#include "surface/query/bounds.h"
#include "surface/query/hierarchy.h"
#include "surface/refine/refinement.h"

namespace rumple {

struct TrianglePoint {
    SurfacePoint place;
    double squared_distance = 0.0;
};

// The point of one triangle closest to p. A triangle of zero area is its edges.
TrianglePoint closest_point(const Surface& surface, Index triangle, const Vec3& p);

// A bounding volume hierarchy over all triangles: built in O(n log^2 n),
// asked in O(log n). The surface must outlive it.
class TriangleTree {
  public:
    explicit TriangleTree(const Surface& surface);

    // Ties go to the lowest triangle.
    TrianglePoint closest(const Vec3& p) const;

  private:
    const Surface& surface_;
    Hierarchy hierarchy_;         // of the triangles
    std::vector<Bounds> bounds_;  // per node
};

}  // namespace rumple
