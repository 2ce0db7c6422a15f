// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/contact/self_distance.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/tolerances.h"
#include "surface/contact/closest_point.h"

namespace rumple {
namespace {

constexpr Index kLeafTriangles = 4;

// Cosine between two normals: below it the surfaces face one another.
constexpr float kFacing = -0.1f;

// Share of the reach: nearer than this the way between two points says nothing, and a normal takes its place.
constexpr float kSamePlace = 1e-4f;

Vec3 unit_or_zero(const Vec3& v) {
    const float length = std::sqrt(glm::dot(v, v));
    return length > kShortestEdge * kShortestEdge ? v / length : Vec3(0.0f);
}

}  // namespace

OwnSurface::OwnSurface(std::span<const Vec3> positions, std::vector<std::array<Index, 3>> triangles)
    : triangles_(std::move(triangles)) {
    std::vector<Vec3> centre;
    for (const auto& t : triangles_)
        centre.push_back((positions[t[0]] + positions[t[1]] + positions[t[2]]) / 3.0f);
    std::vector<Index> order(triangles_.size());
    std::iota(order.begin(), order.end(), 0);
    nodes_.emplace_back();
    split(0, 0, static_cast<Index>(order.size()), centre, order);
    std::vector<std::array<Index, 3>> sorted;
    for (const Index t : order) sorted.push_back(triangles_[t]);
    triangles_ = std::move(sorted);
}

// Halves the triangles at the median of their centres along the longest axis: the depth is log2 of the count.
void OwnSurface::split(Index node, Index begin, Index end, std::span<const Vec3> centre,
                       std::vector<Index>& order) {
    if (end - begin <= kLeafTriangles) {
        nodes_[node] = {begin, end - begin};
        return;
    }
    Vec3 low(std::numeric_limits<float>::max()), high(std::numeric_limits<float>::lowest());
    for (Index i = begin; i < end; ++i) {
        low = glm::min(low, centre[order[i]]);
        high = glm::max(high, centre[order[i]]);
    }
    const Vec3 extent = high - low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const Index middle = begin + (end - begin) / 2;
    std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                     [&](Index s, Index t) {
                         const float x = centre[s][axis], y = centre[t][axis];
                         return x < y || (x == y && s < t);
                     });
    const Index left = static_cast<Index>(nodes_.size());
    nodes_[node] = {left, 0};
    nodes_.resize(nodes_.size() + 2);
    split(left, begin, middle, centre, order);
    split(left + 1, middle, end, centre, order);
}

PosedOwnSurface::PosedOwnSurface(const OwnSurface& surface, std::span<const Vec3> positions)
    : surface_(surface), positions_(positions) {
    normals_.assign(positions_.size(), Vec3(0.0f));
    for (const auto& t : surface_.triangles_) {
        const Vec3 n = glm::cross(positions_[t[1]] - positions_[t[0]], positions_[t[2]] - positions_[t[0]]);
        face_normals_.push_back(unit_or_zero(n));
        for (const Index v : t) normals_[v] += n;
    }
    for (Vec3& n : normals_) n = unit_or_zero(n);
    refit();
}

void PosedOwnSurface::refit() {
    boxes_.resize(surface_.nodes_.size());
    facings_.resize(surface_.nodes_.size());
    for (size_t i = boxes_.size(); i-- > 0;) {  // children before their parents
        const OwnSurface::Node& node = surface_.nodes_[i];
        for (Index t = node.first; t < node.first + node.count; ++t) {
            for (const Index v : surface_.triangles_[t]) boxes_[i].add(positions_[v]);
            facings_[i].add(face_normals_[t]);
        }
        if (node.count > 0 || surface_.triangles_.empty()) continue;
        for (const Index child : {node.first, node.first + 1}) {
            boxes_[i].add(boxes_[child]);
            facings_[i].add(facings_[child]);
        }
    }
}

OwnSide PosedOwnSurface::nearest(Index vertex, float reach, Index& found) const {
    const Vec3 p = positions_[vertex], normal = normals_[vertex];
    float best = reach * reach;
    found = kNone;
    Vec3 way(0.0f);
    const auto look_at = [&](Index t) {
        if (glm::dot(face_normals_[t], normal) > kFacing) return;
        const auto& corner = surface_.triangles_[t];
        if (corner[0] == vertex || corner[1] == vertex || corner[2] == vertex) return;
        const Vec3 &a = positions_[corner[0]], &b = positions_[corner[1]], &c = positions_[corner[2]];
        const Vec3 w = closest_weights(p, a, b, c);
        const Vec3 to = w.x * a + w.y * b + w.z * c - p;
        const float squared = glm::dot(to, to);
        if (squared > best || (squared == best && (found == kNone || t >= found))) return;
        best = squared;
        found = t;
        way = to;
    };
    const auto squared_distance = [&](Index node) {
        const Box& box = boxes_[node];
        const Vec3 outside = glm::max(glm::max(box.low - p, p - box.high), Vec3(0.0f));
        return glm::dot(outside, outside);
    };
    // No triangle of the node faces the vertex: so it is with all that lies flat around it.
    const auto faces_away = [&](Index node) {
        const Vec3 least = glm::min(normal * facings_[node].low, normal * facings_[node].high);
        return least.x + least.y + least.z > kFacing;
    };
    Index stack[64];  // at most one sibling a level waits, and the depth is log2 of the triangles
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
        const Index i = stack[--top];
        if (squared_distance(i) > best || faces_away(i)) continue;
        const OwnSurface::Node& node = surface_.nodes_[i];
        for (Index t = node.first; t < node.first + node.count; ++t) look_at(t);
        if (node.count > 0) continue;
        // The nearer child is looked at first, so it goes on the stack last.
        const bool left_first = squared_distance(node.first) <= squared_distance(node.first + 1);
        stack[top++] = node.first + (left_first ? 1 : 0);
        stack[top++] = node.first + (left_first ? 0 : 1);
    }
    if (found == kNone) return {};
    const float distance = std::sqrt(best);
    const Vec3 towards = distance > kSamePlace * reach ? way / distance : -face_normals_[found];
    return {towards, distance, glm::dot(towards, normal) > 0.0f};
}

std::vector<OwnSide> PosedOwnSurface::facing(std::span<const float> reach) const {
    std::vector<OwnSide> out(positions_.size());
    if (surface_.triangles_.empty()) return out;
    std::vector<Index> triangle(positions_.size(), kNone);
    for (size_t v = 0; v < out.size(); ++v) {
        if (reach[v] > 0.0f && normals_[v] != Vec3(0.0f))
            out[v] = nearest(static_cast<Index>(v), reach[v], triangle[v]);
    }
    const std::vector<OwnSide> found = out;
    for (size_t v = 0; v < found.size(); ++v) {
        if (triangle[v] == kNone) continue;
        for (const Index u : surface_.triangles_[triangle[v]]) {
            if (found[v].distance >= out[u].distance) continue;
            const bool outside = glm::dot(found[v].towards, normals_[u]) < 0.0f;
            out[u] = {-found[v].towards, found[v].distance, outside};
        }
    }
    return out;
}

std::vector<float> PosedOwnSurface::heights() const {
    std::vector<float> out(positions_.size(), std::numeric_limits<float>::infinity());
    for (const auto& t : surface_.triangles_) {
        const Vec3 side[3] = {positions_[t[2]] - positions_[t[1]], positions_[t[0]] - positions_[t[2]],
                              positions_[t[1]] - positions_[t[0]]};  // opposite of each corner
        const Vec3 n = glm::cross(side[0], side[1]);
        const float twice_area = std::sqrt(glm::dot(n, n));
        for (int k = 0; k < 3; ++k) {
            const float length = std::sqrt(glm::dot(side[k], side[k]));
            out[t[k]] = std::min(out[t[k]], length > kShortestEdge ? twice_area / length : 0.0f);
        }
    }
    return out;
}

}  // namespace rumple
