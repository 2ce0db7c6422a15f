// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/contact/triangle_packets.h"

#include <algorithm>

#include "surface/query/hierarchy.h"

namespace rumple {
namespace {

constexpr float kInfinitelyFar = std::numeric_limits<float>::max();

// The grandchildren of a node of two children; a leaf stands for its own.
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
    std::vector<Index> node_of{0};  // of pairs, for every node of out
    for (size_t n = 0; n < node_of.size(); ++n) {
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
    return out;
}

PosedPackets::PosedPackets(const PacketHierarchy& hierarchy, std::span<const Vec3> positions,
                           std::span<const std::array<Index, 3>> triangles, std::span<const Vec3> normals)
    : hierarchy_(hierarchy), packets_(hierarchy.packets.size()), nodes_(hierarchy.nodes.size()) {
    struct Volume {
        Box place, normal;

        void add(const Volume& other) {
            place.add(other.place);
            normal.add(other.normal);
        }
    };
    std::vector<Volume> of_packet(packets_.size()), of_node(nodes_.size());
    for (size_t i = 0; i < packets_.size(); ++i) {
        for (int k = 0; k < kLanes; ++k) {
            const Index t = hierarchy.packets[i][k];
            if (t == kNone) {
                for (Vec3Lanes* corner : {&packets_[i].a, &packets_[i].b, &packets_[i].c})
                    corner->set(k, Vec3(kInfinitelyFar));
                continue;
            }
            const auto& [a, b, c] = triangles[t];
            packets_[i].a.set(k, positions[a]);
            packets_[i].b.set(k, positions[b]);
            packets_[i].c.set(k, positions[c]);
            packets_[i].normal.set(k, normals[t]);
            for (const Index v : {a, b, c}) of_packet[i].place.add(positions[v]);
            of_packet[i].normal.add(normals[t]);
        }
    }
    for (size_t n = nodes_.size(); n-- > 0;) {
        for (int k = 0; k < kLanes; ++k) {
            const Index child = hierarchy.nodes[n].child[k];
            Volume volume;
            if (child != PacketHierarchy::kEmpty) volume = child < 0 ? of_packet[-1 - child] : of_node[child];
            nodes_[n].places.set(k, volume.place);
            nodes_[n].normals.set(k, volume.normal);
            of_node[n].add(volume);
        }
    }
}

}  // namespace rumple
