// SPDX-License-Identifier: GPL-3.0-or-later
// Flood fill over triangles across edges: Gillette 2015, chapter 8. Only used inside this system.
#pragma once

#include <vector>

#include "systems/wrinkle_paths/context.h"

namespace rumple::wrinkle_paths {

class TriangleFlood {
  public:
    explicit TriangleFlood(const PathSurface& surface) : surface_(surface) {}

    // Calls found(t) once for the triangle, and for every triangle reached from it over edges [a, b] for
    // which crosses(a, b) is true. Stops if found() returns true. Returns whether it did.
    template <typename Crosses, typename Found>
    bool visit(Index triangle, const Crosses& crosses, const Found& found) {
        if (seen_.empty()) seen_.assign(surface_.model.triangles.rest.size(), 0);
        front_.assign(1, triangle);
        seen_[triangle] = ++query_;
        while (!front_.empty()) {
            const Index t = front_.back();
            front_.pop_back();
            if (found(t)) return true;
            for (Index h = 3 * t; h < 3 * t + 3; ++h) {
                const Index twin = surface_.model.triangles.net.twin[h];
                if (twin == kNone || seen_[triangle_of(twin)] == query_) continue;
                if (!crosses(surface_.vertex(h), surface_.vertex(next_in_triangle(h)))) continue;
                seen_[triangle_of(twin)] = query_;
                front_.push_back(triangle_of(twin));
            }
        }
        return false;
    }

  private:
    const PathSurface& surface_;
    std::vector<Index> seen_;  // per triangle: number of the last query that reached it
    std::vector<Index> front_;
    Index query_ = 0;
};

}  // namespace rumple::wrinkle_paths
