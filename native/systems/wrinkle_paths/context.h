// SPDX-License-Identifier: GPL-3.0-or-later
// One frame of the base, as the Wrinkle Paths use it. For this system and for the library's handles.
#pragma once

#include <span>
#include <vector>

#include "systems/wrinkle_paths/wrinkle_paths.h"

namespace rumple::wrinkle_paths {

Pose make_welded_pose(const Model& model, std::vector<Vec3> welded);

// What paths lie on: the triangles of the base in a pose.
struct PathSurface {
    const Model& model;
    const Pose& pose;

    // Corners of a triangle in its plane: (0, 0), u1, u2.
    glm::dvec2 corner(Index triangle, Index k) const {
        const FlatTriangle& shape = pose.base.shapes[triangle];
        return k == 0 ? glm::dvec2(0.0) : k == 1 ? glm::dvec2(shape.x1, 0.0) : glm::dvec2(shape.x2, shape.y2);
    }
    Vec3 vertex(Index half_edge) const { return pose.base.positions[model.triangles.net.vertex[half_edge]]; }
    glm::dvec2 to_flat(Index triangle, const Vec3& p) const {
        const Vec3 local = pose.frames[triangle].to_local(p - vertex(3 * triangle));
        return {local.x, local.y};
    }
};

// ... and what the shapes of folds depend on.
struct FoldContext : PathSurface {
    std::vector<float> compression{};  // per triangle: lambda~_min after the mask; 1 if unknown
    std::vector<float> widths{};       // State::width

    float width(Index triangle) const { return widths.empty() ? 1.0f : widths[triangle]; }
};

// ... and what starts and moves paths.
struct PathContext : FoldContext {
    std::vector<Stretch> stretch{};  // per triangle
    std::vector<float> activity{};   // per triangle, 0: shape unchanged recently, 1: moves

    Vec3 across(Index triangle) const {  // e_i of eq. 5.2: direction of strongest compression
        return pose.frames[triangle].to_object(Vec3(stretch[triangle].direction, 0.0f));
    }
};
// shapes: shapes of the triangles as the paths use them, smoothed in time.
PathContext make_context(const Model& model, const Settings& settings, const Paint& paint, const Pose& pose,
                         const std::vector<FlatTriangle>& shapes, const std::vector<FlatTriangle>& reference,
                         const std::vector<Stretch>& changes);

// The shapes of a pose, exponentially filtered with those in `state`. Squared lengths are filtered, not the
// axes: noise increases squared lengths only by its own square, but it would reduce the shorter axis by its
// full size every time.
std::vector<FlatTriangle> smoothed_shapes(const Settings& settings, double seconds, const State* state,
                                          const Pose& pose);

inline Index half_edge(const PathPoint& p) {
    return 3 * p.triangle + p.edge;
}

// The half-edge of the same edge in the triangle beyond it; kNone at an open border.
inline Index twin_of(const Model& model, const PathPoint& p) {
    return model.triangles.net.twin[half_edge(p)];
}

// The triangle of the segment from points[i] to points[i + 1].
inline Index segment_triangle(const Model& model, const std::vector<PathPoint>& points, size_t i) {
    return points[i].edge == kNone ? points[i].triangle : triangle_of(twin_of(model, points[i]));
}

// 0 at open borders, 1 from settings.hem_rings rings on. Factor on compression and height.
float hem_weight(const Model& model, const Settings& settings, Index vertex);
float hem_weight(const Model& model, const Settings& settings, const SurfacePoint& place);

}  // namespace rumple::wrinkle_paths
