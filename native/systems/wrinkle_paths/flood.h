// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles around one, walking outwards over edges: Gillette 2015, chapter 8. Inside this system only.
#pragma once

#include <vector>

#include "systems/wrinkle_paths/context.h"

namespace rumple::wrinkle_paths {

class TriangleFlood {
  public:
    explicit TriangleFlood(const PathContext& context) : context_(context) {}

    // found(t): of the triangle, and of every one that is reached from it over edges [a, b] of which
    // crosses(a, b) says so; each once. Ends where found() says true, and says whether it did.
    template <typename Crosses, typename Found>
    bool visit(Index triangle, const Crosses& crosses, const Found& found) {
        if (seen_.empty()) seen_.assign(context_.model.rest.size(), 0);
        front_.assign(1, triangle);
        seen_[triangle] = ++query_;
        while (!front_.empty()) {
            const Index t = front_.back();
            front_.pop_back();
            if (found(t)) return true;
            for (Index h = 3 * t; h < 3 * t + 3; ++h) {
                const Index twin = context_.model.net.twin[h];
                if (twin == kNone || seen_[triangle_of(twin)] == query_) continue;
                if (!crosses(context_.vertex(h), context_.vertex(next_in_triangle(h)))) continue;
                seen_[triangle_of(twin)] = query_;
                front_.push_back(triangle_of(twin));
            }
        }
        return false;
    }

  private:
    const PathContext& context_;
    std::vector<Index> seen_;  // per triangle: the last visit that came there
    std::vector<Index> front_;
    Index query_ = 0;
};

}  // namespace rumple::wrinkle_paths
