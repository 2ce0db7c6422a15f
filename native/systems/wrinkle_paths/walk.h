// SPDX-License-Identifier: GPL-3.0-or-later
// Walks over the triangles, and search for near segments: Gillette 2015, sections 5.1 and 8.2. Internal to
// wrinkle_paths.
#pragma once

#include "systems/wrinkle_paths/context.h"
#include "systems/wrinkle_paths/flood.h"

namespace rumple::wrinkle_paths {

Vec3 position(const PathSurface& surface, const PathPoint& p);
std::vector<Vec3> positions(const PathSurface& surface, const std::vector<PathPoint>& points);
float length(const PathSurface& surface, const std::vector<PathPoint>& points);

// The compression of a triangle, weighted by its quality. Thin triangles are not reliable, but have a fifth
// of all compression.
float weighted_compression(const FoldContext& context, Index triangle);

// A point of a path in the plane of a triangle that it lies on.
glm::dvec2 flat_in(const PathSurface& surface, Index triangle, const PathPoint& p);
// A point inside a triangle (weights are held within it).
PathPoint inside(const PathSurface& surface, Index triangle, const glm::dvec2& at);
// The same points from the other end.
std::vector<PathPoint> reversed(const Model& model, const std::vector<PathPoint>& points);

// Segments of paths by the triangle they lie in.
class SegmentMap {
  public:
    explicit SegmentMap(const PathSurface& surface)
        : surface_(surface), first_(surface.model.triangles.rest.size(), kNone), flood_(surface) {}

    void add(const std::vector<PathPoint>& points);

    struct Segment {
        Vec3 a, b;
        Index next;
    };
    // visit(segment) for those in one triangle.
    template <typename Visit>
    void in_triangle(Index triangle, Visit&& visit) const {
        for (Index s = first_[triangle]; s != kNone; s = segments_[s].next) visit(segments_[s]);
    }

    // Whether a segment lies within `radius`, through space, of a point of a triangle; over triangles that
    // are reached without leaving that ball.
    bool has_near(Index triangle, const Vec3& p, float radius) const;

  private:
    const PathSurface& surface_;
    std::vector<Index> first_;  // per triangle
    std::vector<Segment> segments_;
    mutable TriangleFlood flood_;  // temporary data of queries
};

// The limits of a walk.
struct WalkLimits {
    float compression = 1.0f;            // it enters no triangle with less compression
    float length = 0.0f;                 // it ends after this length, object units
    const SegmentMap* others = nullptr;  // it ends where it meets one of these
    double turned = 0.0;  // turn of the path that it continues, radians to the left; it ends at kMostTurn
};

// Section 5.1: from `at` in a triangle in `direction` (unit, in its plane), then in every triangle at right
// angles to its compression.
struct Walk {
    std::vector<PathPoint> points;  // edge points and, last, the end
    float length = 0.0f;
    double turned = 0.0;
};
// visited: triangles that it must not enter; it adds those it enters.
Walk walk(const PathContext& context, Index triangle, glm::dvec2 at, glm::dvec2 direction,
          const WalkLimits& limits, std::vector<Index>& visited);

// How far a path turns to the left from its first to its last segment, radians.
double turning(const PathSurface& surface, const std::vector<PathPoint>& points);

// Whether [a, b] and [c, d] cross. fraction: receives the position of the crossing, 0 at a, 1 at b.
bool segments_cross(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d,
                    double& fraction);

}  // namespace rumple::wrinkle_paths
