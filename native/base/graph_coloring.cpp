// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/graph_coloring.h"

#include <cassert>

#include "base/stop.h"

namespace rumple {

std::vector<Index> color_constraints(Index vertex_count, std::span<const Index> pairs_a,
                                     std::span<const Index> pairs_b) {
    assert(pairs_a.size() == pairs_b.size());
    std::vector<std::vector<Index>> colors_at(vertex_count);  // colours in use at each vertex
    std::vector<Index> color(pairs_a.size());
    std::vector<Index> taken_for;  // per colour: the last constraint that may not have this colour
    for (std::size_t i = 0; i < color.size(); ++i) {
        stop_if_asked(i);
        const Index self = static_cast<Index>(i);
        const Index ends[2] = {pairs_a[i], pairs_b[i]};
        for (Index v : ends) {
            assert(v >= 0 && v < vertex_count);
            for (Index c : colors_at[v]) taken_for[c] = self;
        }
        Index free = 0;
        while (free < static_cast<Index>(taken_for.size()) && taken_for[free] == self) ++free;
        if (free == static_cast<Index>(taken_for.size())) taken_for.push_back(kNone);
        color[i] = free;
        for (Index v : ends) colors_at[v].push_back(free);
    }
    return color;
}

}  // namespace rumple
