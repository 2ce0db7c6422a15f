// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/mesh/triangle_net.h"

#include <algorithm>

#include "surface/mesh/edge_key.h"

namespace rumple {

TriangleNet build_net(const Surface& surface) {
    TriangleNet net;
    std::vector<std::pair<EdgeKey, Index>> uses;
    for (const Triangle& triangle : surface.triangles) {
        for (int k = 0; k < 3; ++k) {
            uses.emplace_back(edge_key(surface, triangle, k), static_cast<Index>(net.vertex.size()));
            net.vertex.push_back(surface.welded.corner_vertex[triangle.corner[k]]);
        }
    }
    std::sort(uses.begin(), uses.end());
    net.twin.assign(net.vertex.size(), kNone);
    for (size_t i = 0; i + 1 < uses.size(); ++i) {
        if (uses[i].first != uses[i + 1].first) continue;
        net.twin[uses[i].second] = uses[i + 1].second;
        net.twin[uses[i + 1].second] = uses[i].second;
    }
    return net;
}

}  // namespace rumple
