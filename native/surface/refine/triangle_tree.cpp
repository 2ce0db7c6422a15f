// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/refine/triangle_tree.h"

#include <algorithm>
#include <cassert>
#include <limits>

#include "base/tolerances.h"
#include "surface/query/segment.h"

namespace rumple {
namespace {

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

// Weights of b and c for the closest point on the three edges.
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

// Weights of b and c for the closest point: the perpendicular foot if it is inside, otherwise a point on an
// edge.
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

TriangleTree::TriangleTree(const Surface& surface) : surface_(surface) {
    assert(!surface.triangles.empty());
    std::vector<Bounds> boxes(surface.triangles.size());
    std::vector<Vec3> centres;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const Corners t = corners_of(surface, static_cast<Index>(i));
        for (const glm::dvec3& x : {t.a, t.b, t.c}) boxes[i].include(x);
        centres.emplace_back(0.5 * (boxes[i].low + boxes[i].high));
    }
    hierarchy_ = build_hierarchy(centres);
    bounds_ = volumes_of<Bounds>(
        hierarchy_, [&](Bounds& bounds, Index place) { bounds.add(boxes[hierarchy_.order[place]]); });
}

TrianglePoint TriangleTree::closest(const Vec3& p) const {
    return closest_within(
        p, std::numeric_limits<double>::infinity(), [](Index) { return false; }, [](Index) { return true; },
        [](const TrianglePoint&) { return true; });
}

}  // namespace rumple
