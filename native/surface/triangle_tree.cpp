// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/triangle_tree.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <numeric>

#include "base/tolerances.h"

namespace rumple {
namespace {

constexpr Index kLeafTriangles = 4;

struct Corners {
    glm::dvec3 a, b, c;
};

Corners corners_of(const Surface& surface, Index t) {
    const Triangle& triangle = surface.triangles[t];
    const auto x = [&](int k) {
        return glm::dvec3(surface.positions_rest[surface.welded.corner_vertex[triangle.corner[k]]]);
    };
    return {x(0), x(1), x(2)};
}

// The parameter of the point of segment a + s (b - a), 0 <= s <= 1, closest to p.
double closest_on_segment(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& p) {
    const glm::dvec3 ab = b - a;
    const double square = glm::dot(ab, ab);
    return square > 0.0 ? std::clamp(glm::dot(p - a, ab) / square, 0.0, 1.0) : 0.0;
}

// Weights of b and c of the closest point on the three edges.
glm::dvec2 closest_on_edges(const Corners& t, const glm::dvec3& p) {
    const double ab = closest_on_segment(t.a, t.b, p);
    const double bc = closest_on_segment(t.b, t.c, p);
    const double ca = closest_on_segment(t.c, t.a, p);
    const glm::dvec2 candidates[3] = {{ab, 0.0}, {1.0 - bc, bc}, {0.0, 1.0 - ca}};
    glm::dvec2 best(0.0);
    double least = std::numeric_limits<double>::infinity();
    for (const glm::dvec2& w : candidates) {
        const glm::dvec3 d = t.a + w.x * (t.b - t.a) + w.y * (t.c - t.a) - p;
        if (glm::dot(d, d) < least) {
            least = glm::dot(d, d);
            best = w;
        }
    }
    return best;
}

// Weights of b and c of the closest point: the foot of the perpendicular where
// it falls inside, else a point of an edge.
glm::dvec2 closest_weights(const Corners& t, const glm::dvec3& p) {
    const glm::dvec3 ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a;
    const glm::dvec3 n = glm::cross(ab, ac);
    const double square = glm::dot(n, n);
    if (square > 0.0) {
        const glm::dvec2 w(glm::dot(glm::cross(ap, ac), n) / square,
                           glm::dot(glm::cross(ab, ap), n) / square);
        if (w.x >= 0.0 && w.y >= 0.0 && w.x + w.y <= 1.0) return w;
    }
    return closest_on_edges(t, p);
}

}  // namespace

TrianglePoint closest_point(const Surface& surface, Index triangle, const Vec3& p) {
    const Corners t = corners_of(surface, triangle);
    const glm::dvec2 w = closest_weights(t, glm::dvec3(p));
    const glm::dvec3 d = t.a + w.x * (t.b - t.a) + w.y * (t.c - t.a) - glm::dvec3(p);
    return {{triangle, static_cast<float>(w.x), static_cast<float>(w.y)}, glm::dot(d, d)};
}

TriangleTree::TriangleTree(const Surface& surface) : surface_(surface), order_(surface.triangles.size()) {
    assert(!order_.empty());
    std::iota(order_.begin(), order_.end(), 0);
    std::vector<Bounds> boxes(order_.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const Corners t = corners_of(surface, static_cast<Index>(i));
        for (const glm::dvec3& x : {t.a, t.b, t.c}) boxes[i].include(x);
    }
    nodes_.emplace_back();
    split(0, 0, static_cast<Index>(order_.size()), boxes);
}

// Halves the triangles at the median of their centres along the longest axis:
// always balanced, so the depth is log2 of the count whatever the mesh.
void TriangleTree::split(Index node, Index begin, Index end, const std::vector<Bounds>& boxes) {
    Bounds bounds, centres;
    const auto centre = [&](Index t) { return 0.5 * (boxes[t].low + boxes[t].high); };
    for (Index i = begin; i < end; ++i) {
        bounds.include(boxes[order_[i]].low);
        bounds.include(boxes[order_[i]].high);
        centres.include(centre(order_[i]));
    }
    nodes_[node].bounds = bounds;
    if (end - begin <= kLeafTriangles) {
        nodes_[node].first = begin;
        nodes_[node].count = end - begin;
        return;
    }
    const glm::dvec3 extent = centres.high - centres.low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const Index middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](Index s, Index t) {
                         const double x = centre(s)[axis], y = centre(t)[axis];
                         return x < y || (x == y && s < t);
                     });
    const Index left = static_cast<Index>(nodes_.size());
    nodes_[node].first = left;
    nodes_.resize(nodes_.size() + 2);
    split(left, begin, middle, boxes);
    split(left + 1, middle, end, boxes);
}

TrianglePoint TriangleTree::closest(const Vec3& p) const {
    TrianglePoint best;
    best.squared_distance = std::numeric_limits<double>::infinity();
    const glm::dvec3 query(p);
    Index stack[64];  // at most one sibling a level waits, and the depth is log2 of the triangles
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
        const Node& node = nodes_[stack[--top]];
        if (squared_distance(node.bounds, query) > best.squared_distance * (1.0 + kTieSlack)) continue;
        for (Index i = node.first; i < node.first + node.count; ++i) {
            const TrianglePoint point = closest_point(surface_, order_[i], p);
            const bool tie = point.squared_distance == best.squared_distance;
            if (point.squared_distance < best.squared_distance ||
                (tie && point.place.triangle < best.place.triangle)) {
                best = point;
            }
        }
        if (node.count > 0) continue;
        // The nearer child is looked at first, so it goes on the stack last.
        const double left = squared_distance(nodes_[node.first].bounds, query);
        const double right = squared_distance(nodes_[node.first + 1].bounds, query);
        stack[top++] = left <= right ? node.first + 1 : node.first;
        stack[top++] = left <= right ? node.first : node.first + 1;
    }
    return best;
}

}  // namespace rumple
