// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_paths/walk.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/elementary.h"
#include "base/tolerances.h"
#include "surface/query/segment.h"

namespace rumple::wrinkle_paths {
namespace {

using glm::dvec2;

double cross(const dvec2& a, const dvec2& b) {
    return a.x * b.y - a.y * b.x;
}

float distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
    return glm::distance(p, a + closest_on_segment(a, b, p) * (b - a));
}

struct Exit {
    Index edge = kNone;
    double distance = std::numeric_limits<double>::infinity();  // along the direction
    double along_edge = 0.0;
};

// Where a line from `at` leaves a triangle. It cannot leave by its entry edge.
Exit leave(const PathSurface& surface, Index triangle, const dvec2& at, const dvec2& direction, Index entry) {
    Exit out;
    for (Index k = 0; k < 3; ++k) {
        const dvec2 from = surface.corner(triangle, k), edge = surface.corner(triangle, (k + 1) % 3) - from;
        const double outward = cross(direction, edge);  // > 0: the inside is to the left of every edge
        if (k == entry || outward <= 0.0) continue;
        const double distance = std::max(cross(from - at, edge) / outward, 0.0);
        if (distance >= out.distance) continue;
        out = {k, distance, cross(from - at, direction) / outward};
    }
    return out;
}

// A direction transferred over an edge by unfolding: its components along and across the edge stay the same.
dvec2 unfolded(const PathSurface& surface, const dvec2& direction, Index triangle, Index edge, Index twin) {
    const auto unit_edge = [&](Index t, Index k) {
        return glm::normalize(surface.corner(t, (k + 1) % 3) - surface.corner(t, k));
    };
    const dvec2 from = unit_edge(triangle, edge), to = unit_edge(triangle_of(twin), twin % 3);
    const double along = glm::dot(direction, from), outward = cross(direction, from);
    return -along * to + std::abs(outward) * dvec2(-to.y, to.x);
}

double angle_to(const dvec2& from, const dvec2& to) {
    return elementary::atan2(cross(from, to), glm::dot(from, to));
}

// The direction at right angles to the compression, oriented like `ahead`; or `ahead` itself if the
// compression gives no reliable direction. inward: direction into the triangle at its entry edge.
dvec2 turned(const PathContext& context, Index triangle, const dvec2& ahead, const dvec2& inward) {
    const Stretch& s = context.stretch[triangle];
    const bool even = s.compression * s.stretch < 1.0f + kEvenStretch;
    if (even || context.model.quality[triangle] < kSliver) return ahead;
    dvec2 direction(-s.direction.y, s.direction.x);
    if (glm::dot(direction, ahead) < 0.0) direction = -direction;
    if (glm::dot(direction, inward) > kShallow) return direction;
    direction = glm::normalize(direction + ahead);
    return glm::dot(direction, inward) > kShallow ? direction : ahead;
}

// The distance along [at, at + distance direction] to the first crossing with other segments of the triangle;
// `distance` if there is none.
double distance_to_crossing(const PathSurface& surface, const WalkLimits& limits, Index triangle,
                            const dvec2& at, const dvec2& direction, double distance) {
    if (!limits.others) return distance;
    double nearest = distance;
    limits.others->in_triangle(triangle, [&](const SegmentMap::Segment& s) {
        double fraction = 0.0;
        const dvec2 a = surface.to_flat(triangle, s.a), b = surface.to_flat(triangle, s.b);
        if (segments_cross(at, at + distance * direction, a, b, fraction))
            nearest = std::min(nearest, fraction * distance);
    });
    return nearest;
}

}  // namespace

bool segments_cross(const dvec2& a, const dvec2& b, const dvec2& c, const dvec2& d, double& fraction) {
    const dvec2 ab = b - a, cd = d - c;
    const double area = cross(ab, cd);
    if (area == 0.0) return false;
    const double s = cross(c - a, cd) / area, t = cross(c - a, ab) / area;
    if (s < 0.0 || s > 1.0 || t < 0.0 || t > 1.0) return false;
    fraction = s;
    return true;
}

Vec3 position(const PathSurface& surface, const PathPoint& p) {
    if (p.edge == kNone) {
        const Vec3 a = surface.vertex(3 * p.triangle);
        return a + p.at.x * (surface.vertex(3 * p.triangle + 1) - a) +
               p.at.y * (surface.vertex(3 * p.triangle + 2) - a);
    }
    const Index h = half_edge(p);
    return glm::mix(surface.vertex(h), surface.vertex(next_in_triangle(h)), p.at.x);
}

std::vector<Vec3> positions(const PathSurface& surface, const std::vector<PathPoint>& points) {
    std::vector<Vec3> out(points.size());
    std::transform(points.begin(), points.end(), out.begin(),
                   [&](const PathPoint& p) { return position(surface, p); });
    return out;
}

float length(const PathSurface& surface, const std::vector<PathPoint>& points) {
    const std::vector<Vec3> at = positions(surface, points);
    float sum = 0.0f;
    for (size_t i = 0; i + 1 < at.size(); ++i) sum += glm::distance(at[i], at[i + 1]);
    return sum;
}

float weighted_compression(const FoldContext& context, Index triangle) {
    const float weight = std::min(1.0f, 2.0f * context.model.quality[triangle]);
    return 1.0f + weight * (context.compression[triangle] - 1.0f);
}

dvec2 flat_in(const PathSurface& surface, Index triangle, const PathPoint& p) {
    const auto along = [&](Index k, double fraction) {
        return glm::mix(surface.corner(triangle, k), surface.corner(triangle, (k + 1) % 3), fraction);
    };
    if (p.edge == kNone)
        return double(p.at.x) * surface.corner(triangle, 1) + double(p.at.y) * surface.corner(triangle, 2);
    if (p.triangle == triangle) return along(p.edge, p.at.x);
    return along(twin_of(surface.model, p) % 3, 1.0 - p.at.x);
}

PathPoint inside(const PathSurface& surface, Index triangle, const dvec2& at) {
    const dvec2 u1 = surface.corner(triangle, 1), u2 = surface.corner(triangle, 2);
    const double y = std::clamp(at.y / u2.y, 0.0, 1.0);
    const double x = std::clamp((at.x - y * u2.x) / u1.x, 0.0, 1.0 - y);
    return {triangle, kNone, Vec2(float(x), float(y))};
}

std::vector<PathPoint> reversed(const Model& model, const std::vector<PathPoint>& points) {
    std::vector<PathPoint> out(points.rbegin(), points.rend());
    for (PathPoint& p : out) {
        if (p.edge == kNone) continue;
        const Index twin = twin_of(model, p);
        p = {triangle_of(twin), twin % 3, Vec2(1.0f - p.at.x, 0.0f)};
    }
    return out;
}

void SegmentMap::add(const std::vector<PathPoint>& points) {
    const std::vector<Vec3> at = positions(surface_, points);
    for (size_t i = 0; i + 1 < points.size(); ++i) {
        const Index triangle = segment_triangle(surface_.model, points, i);
        segments_.push_back({at[i], at[i + 1], first_[triangle]});
        first_[triangle] = static_cast<Index>(segments_.size()) - 1;
    }
}

bool SegmentMap::has_near(Index triangle, const Vec3& p, float radius) const {
    const auto is_near = [&](const Vec3& a, const Vec3& b) { return distance_to_segment(p, a, b) <= radius; };
    return flood_.visit(triangle, is_near, [&](Index t) {
        for (Index s = first_[t]; s != kNone; s = segments_[s].next) {
            if (is_near(segments_[s].a, segments_[s].b)) return true;
        }
        return false;
    });
}

double turning(const PathSurface& surface, const std::vector<PathPoint>& points) {
    double sum = 0.0;
    for (size_t i = 1; i + 1 < points.size(); ++i) {
        const Index t = points[i].triangle, twin = twin_of(surface.model, points[i]);
        const Index next = triangle_of(twin);
        const dvec2 before = flat_in(surface, t, points[i]) - flat_in(surface, t, points[i - 1]);
        const dvec2 after = flat_in(surface, next, points[i + 1]) - flat_in(surface, next, points[i]);
        if (!surface.pose.base.shapes[t].has_area() || !surface.pose.base.shapes[next].has_area()) continue;
        sum += angle_to(unfolded(surface, before, t, points[i].edge, twin), after);
    }
    return sum;
}

Walk walk(const PathContext& context, Index triangle, dvec2 at, dvec2 direction, const WalkLimits& limits,
          std::vector<Index>& visited) {
    Walk out;
    out.turned = limits.turned;
    const auto end = [&](const dvec2& where) {
        out.points.push_back(inside(context, triangle, where));
        return out;
    };
    Index entry = kNone;
    while (true) {
        const Exit exit = leave(context, triangle, at, direction, entry);
        if (exit.edge == kNone) return end(at);
        const double left = limits.length - out.length;
        const double distance = distance_to_crossing(context, limits, triangle, at, direction, exit.distance);
        out.length += float(std::min(distance, left));
        if (left <= distance) return end(at + left * direction);
        if (distance < exit.distance) return end(at + distance * direction);
        at += distance * direction;
        const Index twin = context.model.triangles.net.twin[3 * triangle + exit.edge];
        if (twin == kNone) return end(at);
        const Index next = triangle_of(twin);
        if (context.compression[next] < limits.compression) return end(at);
        if (std::find(visited.begin(), visited.end(), next) != visited.end()) return end(at);
        const dvec2 ahead = unfolded(context, direction, triangle, exit.edge, twin);
        const dvec2 from = context.corner(next, twin % 3), to = context.corner(next, (twin + 1) % 3);
        const dvec2 edge = glm::normalize(to - from);
        const dvec2 onwards = turned(context, next, ahead, dvec2(-edge.y, edge.x));
        out.turned += angle_to(ahead, onwards);
        if (std::abs(out.turned) > kMostTurn) return end(at);
        const double fraction = std::clamp(exit.along_edge, kEdgeMargin, 1.0 - kEdgeMargin);
        out.points.push_back({triangle, exit.edge, Vec2(float(fraction), 0.0f)});
        direction = onwards;
        at = glm::mix(from, to, 1.0 - fraction);
        entry = twin % 3;
        triangle = next;
        visited.push_back(next);
    }
}

}  // namespace rumple::wrinkle_paths
