// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/mesh/border_rings.h"

namespace rumple {

std::vector<Index> border_rings(std::span<const std::array<Index, 2>> edges,
                                const std::vector<bool>& on_border) {
    std::vector<std::vector<Index>> neighbours(on_border.size());
    for (const auto& [a, b] : edges) {
        neighbours[a].push_back(b);
        neighbours[b].push_back(a);
    }
    std::vector<Index> ring(on_border.size(), kNone), reached;  // breadth first
    for (size_t v = 0; v < on_border.size(); ++v) {
        if (!on_border[v]) continue;
        ring[v] = 0;
        reached.push_back(Index(v));
    }
    for (size_t i = 0; i < reached.size(); ++i) {
        const Index from = reached[i];
        for (const Index to : neighbours[from]) {
            if (ring[to] != kNone) continue;
            ring[to] = ring[from] + 1;
            reached.push_back(to);
        }
    }
    return ring;
}

}  // namespace rumple
