// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/contact/triangle_packets.h"

#include <algorithm>

#include "surface/query/hierarchy.h"

namespace rumple {
namespace {

// With fewer nodes the work is done before another thread has started.
constexpr size_t kLeastNodes = 500;

constexpr float kInfinitelyFar = std::numeric_limits<float>::max();

// The grandchildren of a node with two children. A leaf takes the place of its own children.
std::vector<Index> grandchildren(const Hierarchy& hierarchy, Index node) {
    std::vector<Index> out{node};
    for (int generation = 0; generation < 2; ++generation) {
        std::vector<Index> next;
        for (const Index n : out) {
            const auto [first, count] = hierarchy.nodes[n];
            if (count == 0) next.insert(next.end(), {first, first + 1});
            if (count > 0) next.push_back(n);
        }
        out = std::move(next);
    }
    return out;
}

}  // namespace

PacketHierarchy build_packets(std::span<const Vec3> centres) {
    PacketHierarchy out;
    if (centres.empty()) return out;
    out.packet_of.resize(centres.size());
    const Hierarchy pairs = build_hierarchy(centres);
    std::vector<Index> node_of{0};  // for every node of `out`: its node in the hierarchy of pairs
    for (size_t n = 0, level_end = 0; n < node_of.size(); ++n) {
        if (n == level_end) {
            out.level_start.push_back(static_cast<Index>(n));
            level_end = node_of.size();
        }
        PacketHierarchy::Node node;
        node.child.fill(PacketHierarchy::kEmpty);
        int k = 0;
        for (const Index child : grandchildren(pairs, node_of[n])) {
            const auto [first, count] = pairs.nodes[child];
            if (count == 0) {
                node.child[k++] = static_cast<Index>(node_of.size());
                node_of.push_back(child);
                continue;
            }
            const Index packet = static_cast<Index>(out.packets.size());
            node.child[k++] = -1 - packet;
            out.packets.emplace_back().fill(kNone);
            std::copy_n(pairs.order.begin() + first, count, out.packets.back().begin());
            for (Index place = first; place < first + count; ++place)
                out.packet_of[pairs.order[place]] = packet;
        }
        out.nodes.push_back(node);
    }
    out.level_start.push_back(static_cast<Index>(out.nodes.size()));
    return out;
}

PosedPackets::PosedPackets(const PacketHierarchy& hierarchy, std::span<const Row> positions,
                           std::span<const std::array<Index, 3>> triangles, std::span<const Row> normals)
    : hierarchy_(hierarchy), packets_(hierarchy.packets.size()), nodes_(hierarchy.nodes.size()) {
    UnsetVector<Volume> of_packet(packets_.size()), of_node(nodes_.size());
    for_each_index(packets_.size(), kLeastSteps, [&](size_t packet) {
        of_packet[packet] = place_packet(packet, positions, triangles, normals);
    });
    for (size_t level = hierarchy.level_start.size(); level-- > 1;) {
        const auto first = size_t(hierarchy.level_start[level - 1]),
                   end = size_t(hierarchy.level_start[level]);
        for_each_index(end - first, kLeastNodes,
                       [&](size_t i) { of_node[first + i] = place_node(first + i, of_packet, of_node); });
    }
}

PosedPackets::Volume PosedPackets::place_packet(size_t packet, std::span<const Row> positions,
                                                std::span<const std::array<Index, 3>> triangles,
                                                std::span<const Row> normals) {
    Volume volume;
    std::array<Row, kLanes> corner[3], normal;
    for (int k = 0; k < kLanes; ++k) {
        const Index t = hierarchy_.packets[packet][k];
        for (int i = 0; i < 3; ++i)
            corner[i][k] = t == kNone ? Row(all_lanes(kInfinitelyFar)) : positions[triangles[t][i]];
        if (t == kNone) continue;
        normal[k] = normals[t];
        for (int i = 0; i < 3; ++i) volume.place.add(corner[i][k]);
        volume.normal.add(normal[k]);
    }
    packets_[packet] = {columns(corner[0]), columns(corner[1]), columns(corner[2]), columns(normal)};
    return volume;
}

PosedPackets::Volume PosedPackets::place_node(size_t node, std::span<const Volume> of_packet,
                                              std::span<const Volume> of_node) {
    Volume volume;
    std::array<Volume, kLanes> of_child;
    for (int k = 0; k < kLanes; ++k) {
        const Index child = hierarchy_.nodes[node].child[k];
        if (child == PacketHierarchy::kEmpty) continue;
        of_child[k] = child < 0 ? of_packet[-1 - child] : of_node[child];
        volume.place.add(of_child[k].place);
        volume.normal.add(of_child[k].normal);
    }
    const auto boxes = [&](Box Volume::*box) {
        std::array<Row, kLanes> low, high;
        for (int k = 0; k < kLanes; ++k) {
            low[k] = (of_child[k].*box).low;
            high[k] = (of_child[k].*box).high;
        }
        return Boxes{columns(low), columns(high)};
    };
    nodes_[node] = {boxes(&Volume::place), std::bit_cast<LaneMask>(hierarchy_.nodes[node].child),
                    boxes(&Volume::normal)};
    return volume;
}

}  // namespace rumple
