// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/contact/collider.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <tuple>

#include "base/expect.h"
#include "base/tolerances.h"
#include "surface/contact/closest_point.h"

namespace rumple {
namespace {

constexpr Index kLeafTriangles = 4;

// Cosine: cloth lies on the side of a body that faces the same way.
constexpr float kFacing = 0.1f;

// Cosine between the way to the body and its normal: from beside it to above it.
constexpr float kBeside = 0.6f;
constexpr float kAbove = 0.85f;

// Share of a triangle: a closest point this near to an edge lies on it.
constexpr float kOnEdge = 1e-4f;

Vec3 unit_or_zero(const Vec3& v) {
    const float length = std::sqrt(glm::dot(v, v));
    return length > kShortestEdge * kShortestEdge ? v / length : Vec3(0.0f);
}

}  // namespace

Collider::Collider(std::span<const Vec3> positions, std::span<const std::array<Index, 3>> triangles)
    : vertex_count_(static_cast<Index>(positions.size())), triangles_(triangles.begin(), triangles.end()) {
    if (triangles_.empty()) throw InvalidInput("body: expected at least one triangle, got none");
    expect_finite("body positions", positions, "vertex");
    for (size_t t = 0; t < triangles_.size(); ++t) {
        for (const Index v : triangles_[t]) {
            if (v >= 0 && v < vertex_count_) continue;
            throw InvalidInput("body triangles: triangle " + std::to_string(t) + " names vertex " +
                               std::to_string(v) + " of " + std::to_string(vertex_count_));
        }
    }
    std::vector<Vec3> centre;
    for (const auto& t : triangles_)
        centre.push_back((positions[t[0]] + positions[t[1]] + positions[t[2]]) / 3.0f);
    order_.resize(triangles_.size());
    std::iota(order_.begin(), order_.end(), 0);
    nodes_.emplace_back();
    split(0, 0, triangle_count(), centre);
    mark_borders();
}

// Halves the triangles at the median of their centres along the longest axis: the depth is log2 of the count.
void Collider::split(Index node, Index begin, Index end, std::span<const Vec3> centre) {
    if (end - begin <= kLeafTriangles) {
        nodes_[node] = {begin, end - begin};
        return;
    }
    Vec3 low(std::numeric_limits<float>::max()), high(std::numeric_limits<float>::lowest());
    for (Index i = begin; i < end; ++i) {
        low = glm::min(low, centre[order_[i]]);
        high = glm::max(high, centre[order_[i]]);
    }
    const Vec3 extent = high - low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const Index middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](Index s, Index t) {
                         const float x = centre[s][axis], y = centre[t][axis];
                         return x < y || (x == y && s < t);
                     });
    const Index left = static_cast<Index>(nodes_.size());
    nodes_[node] = {left, 0};
    nodes_.resize(nodes_.size() + 2);
    split(left, begin, middle, centre);
    split(left + 1, middle, end, centre);
}

void Collider::mark_borders() {
    struct Side {
        Index a, b, triangle;
        int k;
    };
    std::vector<Side> sides;
    for (Index t = 0; t < triangle_count(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const Index a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
            sides.push_back({std::min(a, b), std::max(a, b), t, k});
        }
    }
    const auto edge = [](const Side& s) { return std::pair(s.a, s.b); };
    std::sort(sides.begin(), sides.end(), [&](const Side& s, const Side& t) {
        return std::tuple(s.a, s.b, s.triangle) < std::tuple(t.a, t.b, t.triangle);
    });
    border_edges_.assign(triangles_.size(), 0);
    border_vertex_.assign(vertex_count_, 0);
    for (size_t i = 0, next; i < sides.size(); i = next) {
        for (next = i + 1; next < sides.size() && edge(sides[next]) == edge(sides[i]);) ++next;
        if (next > i + 1) continue;
        border_edges_[sides[i].triangle] |= static_cast<std::uint8_t>(1 << sides[i].k);
        border_vertex_[sides[i].a] = border_vertex_[sides[i].b] = 1;
    }
}

PosedCollider::PosedCollider(const Collider& collider, std::span<const Vec3> positions)
    : collider_(collider), positions_(positions.begin(), positions.end()) {
    expect_count("body positions", positions.size(), size_t(collider.vertex_count_), "vertices");
    expect_finite("body positions", positions, "vertex");
    normals_.assign(positions_.size(), Vec3(0.0f));
    for (const auto& t : collider_.triangles_) {
        const Vec3 n = glm::cross(positions_[t[1]] - positions_[t[0]], positions_[t[2]] - positions_[t[0]]);
        face_normals_.push_back(unit_or_zero(n));
        for (const Index v : t) normals_[v] += n;
    }
    for (Vec3& n : normals_) n = unit_or_zero(n);
    refit();
}

void PosedCollider::refit() {
    boxes_.resize(collider_.nodes_.size());
    for (size_t i = boxes_.size(); i-- > 0;) {  // children before their parents
        const Collider::Node& node = collider_.nodes_[i];
        Box& box = boxes_[i];
        if (node.count == 0) {
            const Box &left = boxes_[node.first], &right = boxes_[node.first + 1];
            box = {glm::min(left.low, right.low), glm::max(left.high, right.high)};
            continue;
        }
        box = {Vec3(std::numeric_limits<float>::max()), Vec3(std::numeric_limits<float>::lowest())};
        for (Index k = node.first; k < node.first + node.count; ++k) {
            for (const Index v : collider_.triangles_[collider_.order_[k]]) {
                box.low = glm::min(box.low, positions_[v]);
                box.high = glm::max(box.high, positions_[v]);
            }
        }
    }
}

float PosedCollider::squared_distance(const Box& box, const Vec3& p) {
    const Vec3 outside = glm::max(glm::max(box.low - p, p - box.high), Vec3(0.0f));
    return glm::dot(outside, outside);
}

bool PosedCollider::on_border(Index triangle, const Vec3& weights) const {
    const std::uint8_t edges = collider_.border_edges_[triangle];
    for (int k = 0; k < 3; ++k) {
        if ((edges >> k & 1) && weights[(k + 2) % 3] < kOnEdge) return true;
        if (weights[k] > 1.0f - kOnEdge && collider_.border_vertex_[collider_.triangles_[triangle][k]])
            return true;
    }
    return false;
}

void PosedCollider::look_at(Index triangle, const Vec3& p, const Vec3& normal, Best& best) const {
    if (glm::dot(face_normals_[triangle], normal) < kFacing) return;
    const auto& t = collider_.triangles_[triangle];
    const Vec3 w = closest_weights(p, positions_[t[0]], positions_[t[1]], positions_[t[2]]);
    const Vec3 to = p - (w.x * positions_[t[0]] + w.y * positions_[t[1]] + w.z * positions_[t[2]]);
    const float squared = glm::dot(to, to);
    if (squared > best.squared || (squared == best.squared && triangle >= best.triangle)) return;
    best = {squared, triangle, w};
}

BodyContact PosedCollider::closest(const Vec3& p, const Vec3& normal, float reach, Index hint) const {
    Best best{reach * reach};
    if (hint >= 0 && hint < collider_.triangle_count()) look_at(hint, p, normal, best);
    Index stack[64];  // at most one sibling a level waits, and the depth is log2 of the triangles
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
        const Index i = stack[--top];
        if (squared_distance(boxes_[i], p) > best.squared) continue;
        const Collider::Node& node = collider_.nodes_[i];
        for (Index k = node.first; k < node.first + node.count; ++k)
            look_at(collider_.order_[k], p, normal, best);
        if (node.count > 0) continue;
        // The nearer child is looked at first, so it goes on the stack last.
        const bool left_first =
            squared_distance(boxes_[node.first], p) <= squared_distance(boxes_[node.first + 1], p);
        stack[top++] = node.first + (left_first ? 1 : 0);
        stack[top++] = node.first + (left_first ? 0 : 1);
    }
    BodyContact contact;
    if (best.triangle == kNone) return contact;
    const auto& t = collider_.triangles_[best.triangle];
    const Vec3& w = best.weights;
    contact.triangle = best.triangle;
    contact.point = w.x * positions_[t[0]] + w.y * positions_[t[1]] + w.z * positions_[t[2]];
    contact.border = on_border(best.triangle, w);
    contact.normal = contact.border
                         ? normal
                         : unit_or_zero(w.x * normals_[t[0]] + w.y * normals_[t[1]] + w.z * normals_[t[2]]);
    const Vec3 to = p - contact.point;
    const float length = std::sqrt(glm::dot(to, to));
    contact.distance = glm::dot(to, contact.normal);
    contact.beside = glm::length(to - contact.distance * contact.normal);
    const float cosine = (std::abs(contact.distance) + kOnBody) / (length + kOnBody);
    contact.weight = std::clamp((cosine - kBeside) / (kAbove - kBeside), 0.0f, 1.0f);
    return contact;
}

}  // namespace rumple
