// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/query/hierarchy.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "surface/query/bounds.h"

namespace rumple {
namespace {

constexpr Index kLeafItems = 4;

// About half of a count, so that leaves, and groups of four leaves, are full. A search of a leaf that is not
// full costs as much as of a full one.
Index left_of(Index count) {
    constexpr Index kLeavesOfNode = 4;
    const Index whole = count > 2 * kLeavesOfNode * kLeafItems ? kLeavesOfNode * kLeafItems : kLeafItems;
    return (count / 2 + whole / 2) / whole * whole;
}

void split(Index node, Index begin, Index end, std::span<const Vec3> centres, Hierarchy& out) {
    if (end - begin <= kLeafItems) {
        // nth_element does not define their order, and standard libraries differ.
        std::sort(out.order.begin() + begin, out.order.begin() + end);
        out.nodes[node] = {begin, end - begin};
        return;
    }
    Vec3 low(std::numeric_limits<float>::max()), high(std::numeric_limits<float>::lowest());
    for (Index i = begin; i < end; ++i) {
        low = glm::min(low, centres[out.order[i]]);
        high = glm::max(high, centres[out.order[i]]);
    }
    const int axis = longest_axis(high - low);
    const Index middle = begin + left_of(end - begin);
    std::nth_element(out.order.begin() + begin, out.order.begin() + middle, out.order.begin() + end,
                     [&](Index s, Index t) {
                         const float x = centres[s][axis], y = centres[t][axis];
                         return x < y || (x == y && s < t);
                     });
    const Index left = static_cast<Index>(out.nodes.size());
    out.nodes[node] = {left, 0};
    out.nodes.resize(out.nodes.size() + 2);
    split(left, begin, middle, centres, out);
    split(left + 1, middle, end, centres, out);
}

}  // namespace

Hierarchy build_hierarchy(std::span<const Vec3> centres) {
    Hierarchy out;
    out.order.resize(centres.size());
    std::iota(out.order.begin(), out.order.end(), 0);
    out.nodes.emplace_back();
    split(0, 0, static_cast<Index>(centres.size()), centres, out);
    return out;
}

}  // namespace rumple
