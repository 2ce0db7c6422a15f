// SPDX-License-Identifier: GPL-3.0-or-later
// A bounding volume hierarchy: the grouping of items. The caller keeps the volumes, so that a surface that
// deforms computes new volumes and keeps its hierarchy. Internal to surface.
#pragma once

#include <utility>
#include <vector>

#include "base/array.h"

namespace rumple {

struct Hierarchy {
    struct Node {
        Index first;  // leaf: its first item in `order`; else: the left child, followed by the right one
        Index count;  // items of a leaf; 0 for an inner node
    };
    std::vector<Node> nodes;   // children after their parents
    std::vector<Index> order;  // items, leaf by leaf
};

// Halves the items by their centres (finite) along the longest axis, rounded to full leaves. The tree is
// balanced, so its depth is log2 of the count. Without items it is one empty leaf. Cost: O(n log^2 n).
Hierarchy build_hierarchy(std::span<const Vec3> centres);

// Computes the volume of every node. Volume: its default is empty, and add(Volume) makes it enclose another
// volume. add_item(volume, place) makes it enclose the item order[place].
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

// Visits items, near nodes first. distance(node): the order of two nodes. skip(node): whether the node is
// left out; called when its turn comes. look_at(place): visits the item order[place].
template <typename Distance, typename Skip, typename LookAt>
void visit_nearest_first(const Hierarchy& hierarchy, Distance&& distance, Skip&& skip, LookAt&& look_at) {
    Index stack[64];  // at most one sibling per level waits, and the depth is log2 of the number of items
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
        const Index node = stack[--top];
        if (skip(node)) continue;
        const auto [first, count] = hierarchy.nodes[node];
        for (Index place = first; place < first + count; ++place) look_at(place);
        if (count > 0 || hierarchy.order.empty()) continue;
        // The nearer child goes on the stack last, so it is visited first.
        const bool left_first = distance(first) <= distance(first + 1);
        stack[top++] = first + (left_first ? 1 : 0);
        stack[top++] = first + (left_first ? 0 : 1);
    }
}

}  // namespace rumple
