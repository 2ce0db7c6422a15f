// SPDX-License-Identifier: GPL-3.0-or-later
// A bounding volume hierarchy: which items lie together. Its volumes are of the one who asks, so that a
// surface that deforms gets new ones and keeps its hierarchy. Internal to surface.
#pragma once

#include <utility>
#include <vector>

#include "base/array.h"

namespace rumple {

struct Hierarchy {
    struct Node {
        Index first;  // leaf: first of order; else: the left child, the right one follows it
        Index count;  // items of a leaf; 0 for an inner node
    };
    std::vector<Node> nodes;   // children after their parents
    std::vector<Index> order;  // items, leaf by leaf
};

// Halves the items by their centres (finite) along the longest axis, rounded to full leaves: always balanced,
// so the depth is log2 of the count. Without items it is one empty leaf. Cost: O(n log^2 n).
Hierarchy build_hierarchy(std::span<const Vec3> centres);

// The volume of every node. Volume: its default is empty, add(Volume) makes it enclose another one.
// add_item(volume, place): makes it enclose the item at a place of order.
template <typename Volume, typename AddItem>
std::vector<Volume> volumes_of(const Hierarchy& hierarchy, AddItem&& add_item) {
    std::vector<Volume> volumes(hierarchy.nodes.size());
    for (size_t i = volumes.size(); i-- > 0;) {
        const auto [first, count] = hierarchy.nodes[i];
        for (Index place = first; place < first + count; ++place) add_item(volumes[i], place);
        if (count > 0 || i + 1 == volumes.size()) continue;  // the last node is a leaf
        volumes[i].add(volumes[first]);
        volumes[i].add(volumes[first + 1]);
    }
    return volumes;
}

// Looks at items, those of near nodes first. distance(node): what orders two nodes. skip(node): whether none
// of its items is looked for, asked when the node's turn comes. look_at(place): of order.
template <typename Distance, typename Skip, typename LookAt>
void visit_nearest_first(const Hierarchy& hierarchy, Distance&& distance, Skip&& skip, LookAt&& look_at) {
    Index stack[64];  // at most one sibling a level waits, and the depth is log2 of the items
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
        const Index node = stack[--top];
        if (skip(node)) continue;
        const auto [first, count] = hierarchy.nodes[node];
        for (Index place = first; place < first + count; ++place) look_at(place);
        if (count > 0 || hierarchy.order.empty()) continue;
        // The nearer child is looked at first, so it goes on the stack last.
        const bool left_first = distance(first) <= distance(first + 1);
        stack[top++] = first + (left_first ? 1 : 0);
        stack[top++] = first + (left_first ? 0 : 1);
    }
}

}  // namespace rumple
