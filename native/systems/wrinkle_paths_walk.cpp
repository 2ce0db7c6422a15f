// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_paths_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/elementary.h"
#include "base/tolerances.h"

namespace rumple::wrinkle_paths {
namespace {

using glm::dvec2;

double cross(const dvec2& a, const dvec2& b) {
    return a.x * b.y - a.y * b.x;
}

float distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
    const Vec3 ab = b - a;
    const float square = glm::dot(ab, ab);
    const float share = square > 0.0f ? std::clamp(glm::dot(p - a, ab) / square, 0.0f, 1.0f) : 0.0f;
    return glm::distance(p, a + share * ab);
}

struct Exit {
    Index edge = kNone;
    double way = std::numeric_limits<double>::infinity();  // along the direction
    double along_edge = 0.0;
};

// Where a line from `at` leaves a triangle, not by the edge it came in by.
Exit leave(const Ground& ground, Index triangle, const dvec2& at, const dvec2& direction, Index entry) {
    Exit out;
    for (Index k = 0; k < 3; ++k) {
        const dvec2 from = ground.corner(triangle, k), edge = ground.corner(triangle, (k + 1) % 3) - from;
        const double outward = cross(direction, edge);  // > 0: the inside lies to the left of every edge
        if (k == entry || outward <= 0.0) continue;
        const double way = std::max(cross(from - at, edge) / outward, 0.0);
        if (way >= out.way) continue;
        out = {k, way, cross(from - at, direction) / outward};
    }
    return out;
}

// A direction carried over an edge by unfolding: what it has along and across the edge stays.
dvec2 unfolded(const Ground& ground, const dvec2& direction, Index triangle, Index edge, Index twin) {
    const auto unit_edge = [&](Index t, Index k) {
        return glm::normalize(ground.corner(t, (k + 1) % 3) - ground.corner(t, k));
    };
    const dvec2 from = unit_edge(triangle, edge), to = unit_edge(triangle_of(twin), twin % 3);
    const double along = glm::dot(direction, from), outward = cross(direction, from);
    return -along * to + std::abs(outward) * dvec2(-to.y, to.x);
}

double angle_to(const dvec2& from, const dvec2& to) {
    return elementary::atan2(cross(from, to), glm::dot(from, to));
}

// At right angles to the compression, in the sense of `ahead`; `ahead` itself where there is no direction
// worth following. inward: of the triangle, at the edge it is entered by.
dvec2 turned(const Ground& ground, Index triangle, const dvec2& ahead, const dvec2& inward) {
    const Stretch& s = ground.stretch[triangle];
    const bool even = s.compression * s.stretch < 1.0f + kEvenStretch;
    if (even || ground.model.quality[triangle] < kSliver) return ahead;
    dvec2 direction(-s.direction.y, s.direction.x);
    if (glm::dot(direction, ahead) < 0.0) direction = -direction;
    if (glm::dot(direction, inward) > kShallow) return direction;
    direction = glm::normalize(direction + ahead);
    return glm::dot(direction, inward) > kShallow ? direction : ahead;
}

// The nearest crossing of [at, at + way direction] with other segments of the triangle; way where there is
// none.
double way_to_crossing(const Ground& ground, const WalkLimits& limits, Index triangle, const dvec2& at,
                       const dvec2& direction, double way) {
    if (!limits.others) return way;
    double nearest = way;
    limits.others->in_triangle(triangle, [&](const SegmentMap::Segment& s) {
        double share = 0.0;
        const dvec2 a = ground.to_flat(triangle, s.a), b = ground.to_flat(triangle, s.b);
        if (segments_cross(at, at + way * direction, a, b, share)) nearest = std::min(nearest, share * way);
    });
    return nearest;
}

}  // namespace

bool segments_cross(const dvec2& a, const dvec2& b, const dvec2& c, const dvec2& d, double& share) {
    const dvec2 ab = b - a, cd = d - c;
    const double area = cross(ab, cd);
    if (area == 0.0) return false;
    const double s = cross(c - a, cd) / area, t = cross(c - a, ab) / area;
    if (s < 0.0 || s > 1.0 || t < 0.0 || t > 1.0) return false;
    share = s;
    return true;
}

Vec3 position(const Ground& ground, const PathPoint& p) {
    if (p.edge == kNone) {
        const Vec3 a = ground.vertex(3 * p.triangle);
        return a + p.at.x * (ground.vertex(3 * p.triangle + 1) - a) +
               p.at.y * (ground.vertex(3 * p.triangle + 2) - a);
    }
    const Index h = half_edge(p);
    return glm::mix(ground.vertex(h), ground.vertex(next_in_triangle(h)), p.at.x);
}

std::vector<Vec3> positions(const Ground& ground, const std::vector<PathPoint>& points) {
    std::vector<Vec3> out;
    for (const PathPoint& p : points) out.push_back(position(ground, p));
    return out;
}

float length(const Ground& ground, const std::vector<PathPoint>& points) {
    const std::vector<Vec3> at = positions(ground, points);
    float sum = 0.0f;
    for (size_t i = 0; i + 1 < at.size(); ++i) sum += glm::distance(at[i], at[i + 1]);
    return sum;
}

float weighted_compression(const Ground& ground, Index triangle) {
    const float weight = std::min(1.0f, 2.0f * ground.model.quality[triangle]);
    return 1.0f + weight * (ground.compression[triangle] - 1.0f);
}

dvec2 flat_in(const Ground& ground, Index triangle, const PathPoint& p) {
    const auto along = [&](Index k, double share) {
        return glm::mix(ground.corner(triangle, k), ground.corner(triangle, (k + 1) % 3), share);
    };
    if (p.edge == kNone)
        return double(p.at.x) * ground.corner(triangle, 1) + double(p.at.y) * ground.corner(triangle, 2);
    if (p.triangle == triangle) return along(p.edge, p.at.x);
    return along(ground.model.net.twin[half_edge(p)] % 3, 1.0 - p.at.x);
}

PathPoint inside(const Ground& ground, Index triangle, const dvec2& at) {
    const dvec2 u1 = ground.corner(triangle, 1), u2 = ground.corner(triangle, 2);
    const double y = std::clamp(at.y / u2.y, 0.0, 1.0);
    const double x = std::clamp((at.x - y * u2.x) / u1.x, 0.0, 1.0 - y);
    return {triangle, kNone, Vec2(float(x), float(y))};
}

std::vector<PathPoint> reversed(const Model& model, const std::vector<PathPoint>& points) {
    std::vector<PathPoint> out(points.rbegin(), points.rend());
    for (PathPoint& p : out) {
        if (p.edge == kNone) continue;
        const Index twin = model.net.twin[half_edge(p)];
        p = {triangle_of(twin), twin % 3, Vec2(1.0f - p.at.x, 0.0f)};
    }
    return out;
}

void SegmentMap::add(const std::vector<PathPoint>& points) {
    const std::vector<Vec3> at = positions(ground_, points);
    for (size_t i = 0; i + 1 < points.size(); ++i) {
        const Index triangle = segment_triangle(ground_.model, points, i);
        segments_.push_back({at[i], at[i + 1], first_[triangle]});
        first_[triangle] = static_cast<Index>(segments_.size()) - 1;
    }
}

bool SegmentMap::has_near(Index triangle, const Vec3& p, float radius) const {
    if (seen_.empty()) seen_.assign(first_.size(), kNone);
    front_.assign(1, triangle);
    seen_[triangle] = ++query_;
    while (!front_.empty()) {
        const Index t = front_.back();
        front_.pop_back();
        for (Index s = first_[t]; s != kNone; s = segments_[s].next) {
            if (distance_to_segment(p, segments_[s].a, segments_[s].b) <= radius) return true;
        }
        for (Index h = 3 * t; h < 3 * t + 3; ++h) {
            const Index twin = ground_.model.net.twin[h];
            if (twin == kNone || seen_[triangle_of(twin)] == query_) continue;
            if (distance_to_segment(p, ground_.vertex(h), ground_.vertex(next_in_triangle(h))) > radius)
                continue;
            seen_[triangle_of(twin)] = query_;
            front_.push_back(triangle_of(twin));
        }
    }
    return false;
}

double turning(const Ground& ground, const std::vector<PathPoint>& points) {
    double sum = 0.0;
    for (size_t i = 1; i + 1 < points.size(); ++i) {
        const Index t = points[i].triangle, twin = ground.model.net.twin[half_edge(points[i])];
        const Index next = triangle_of(twin);
        const dvec2 before = flat_in(ground, t, points[i]) - flat_in(ground, t, points[i - 1]);
        const dvec2 after = flat_in(ground, next, points[i + 1]) - flat_in(ground, next, points[i]);
        if (!ground.pose.shapes[t].has_area() || !ground.pose.shapes[next].has_area()) continue;
        sum += angle_to(unfolded(ground, before, t, points[i].edge, twin), after);
    }
    return sum;
}

Walk walk(const Ground& ground, Index triangle, dvec2 at, dvec2 direction, const WalkLimits& limits,
          std::vector<Index>& visited) {
    Walk out;
    out.turned = limits.turned;
    const auto end = [&](const dvec2& where) {
        out.points.push_back(inside(ground, triangle, where));
        return out;
    };
    Index entry = kNone;
    while (true) {
        const Exit exit = leave(ground, triangle, at, direction, entry);
        if (exit.edge == kNone) return end(at);
        const double left = limits.length - out.length;
        const double way = way_to_crossing(ground, limits, triangle, at, direction, exit.way);
        out.length += float(std::min(way, left));
        if (left <= way) return end(at + left * direction);
        if (way < exit.way) return end(at + way * direction);
        at += way * direction;
        const Index twin = ground.model.net.twin[3 * triangle + exit.edge];
        if (twin == kNone) return end(at);
        const Index next = triangle_of(twin);
        if (ground.compression[next] < limits.compression) return end(at);
        if (std::find(visited.begin(), visited.end(), next) != visited.end()) return end(at);
        const dvec2 ahead = unfolded(ground, direction, triangle, exit.edge, twin);
        const dvec2 from = ground.corner(next, twin % 3), to = ground.corner(next, (twin + 1) % 3);
        const dvec2 edge = glm::normalize(to - from);
        const dvec2 onwards = turned(ground, next, ahead, dvec2(-edge.y, edge.x));
        out.turned += angle_to(ahead, onwards);
        if (std::abs(out.turned) > kMostTurn) return end(at);
        const double share = std::clamp(exit.along_edge, kEdgeMargin, 1.0 - kEdgeMargin);
        out.points.push_back({triangle, exit.edge, Vec2(float(share), 0.0f)});
        direction = onwards;
        at = glm::mix(from, to, 1.0 - share);
        entry = twin % 3;
        triangle = next;
        visited.push_back(next);
    }
}

}  // namespace rumple::wrinkle_paths
