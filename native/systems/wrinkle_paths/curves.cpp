// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_paths/curves.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/elementary.h"
#include "base/tolerances.h"
#include "surface/mesh/positions.h"
#include "systems/wrinkle_paths/context.h"

namespace rumple::wrinkle_paths {
namespace {

// Largest number of triangles between a smoothed point and its own triangle.
constexpr int kMostSteps = 32;

// Barycentric weights of a point projected to the plane of a triangle.
Vec3 weights_of(const PathSurface& surface, Index triangle, const Vec3& p) {
    const FlatTriangle& shape = surface.pose.base.shapes[triangle];
    if (!shape.has_area()) return {1.0f, 0.0f, 0.0f};
    const glm::dvec2 at = surface.to_flat(triangle, p);
    const double v = at.y / shape.y2, u = (at.x - v * shape.x2) / shape.x1;
    return {float(1.0 - u - v), float(u), float(v)};
}

// The place below a point, by a walk towards it from its segment's triangle. At a border the weights are
// clamped.
SurfacePoint place_of(const PathSurface& surface, Index triangle, const Vec3& p) {
    Vec3 weights = weights_of(surface, triangle, p);
    for (int step = 0; step < kMostSteps; ++step) {
        const Index least =
            weights.x < weights.y ? (weights.x < weights.z ? 0 : 2) : (weights.y < weights.z ? 1 : 2);
        if (weights[least] >= 0.0f) break;
        const Index twin = surface.model.triangles.net.twin[next_in_triangle(3 * triangle + least)];
        if (twin == kNone) break;
        triangle = triangle_of(twin);
        weights = weights_of(surface, triangle, p);
    }
    weights = glm::max(weights, 0.0f);
    weights /= weights.x + weights.y + weights.z;
    return {triangle, weights.y, weights.z};
}

// The surface without wrinkles below the fine mesh. The limit surface is approximated by PN triangles.
struct SmoothBase {
    const Model& model;
    const Pose& pose;
    std::vector<Vec3> normals, vertices;

    SmoothBase(const Model& of, const Pose& at)
        : model(of),
          pose(at),
          normals(vertex_normals(of.base, at.base.positions)),
          vertices(at.base.positions) {
        if (model.attachments.kind == AttachmentKind::kLimit)
            apply<Vec3>(model.vertex_limit, pose.base.positions, vertices);
    }
    Vec3 at(const SurfacePoint& place) const {
        if (model.attachments.kind == AttachmentKind::kLinear)
            return interpolate(model.base, place, pose.base.positions);
        Vec3 corner[3], normal[3];
        for (Index k = 0; k < 3; ++k) {
            const Index v = model.triangles.net.vertex[3 * place.triangle + k];
            corner[k] = vertices[v];
            normal[k] = normals[v];
        }
        return pn_triangle(corner, normal, place.b0, place.b1);
    }
    Vec3 normal_at(const SurfacePoint& place) const {
        return direction_of_normals(interpolate(model.base, place, normals));
    }
};

}  // namespace

RidingCurves ride(const Model& model, const Settings& settings, const Pose& pose, const State& state,
                  std::span<const Vec3> animated) {
    RidingCurves out{curves(model, settings, pose, state), {}, {}, {}};
    Curves& crests = out.curves;
    std::optional<Pose> moved;
    if (!animated.empty()) {
        check_frame(model.base, animated, "animated");
        moved = make_pose(model, animated);
    }
    const Pose& ridden = moved ? *moved : pose;
    const PathSurface surface{model, pose};
    const SmoothBase smooth(model, pose);
    for (size_t i = 0; i < crests.positions.size(); ++i) {
        const SurfacePoint place = place_of(surface, crests.triangle[i], crests.positions[i]);
        crests.height[i] *= hem_weight(model, settings, place);
        crests.positions[i] = smooth.at(place) + crests.height[i] * smooth.normal_at(place);
        out.weights.push_back({place.b0, place.b1});
        out.local_offset.push_back(ridden.frames[place.triangle].to_local(
            crests.positions[i] - interpolate(model.base, place, ridden.base.positions)));
        std::array<Index, 3> corners;
        for (Index k = 0; k < 3; ++k)
            corners[k] = model.base.display.corner_vertex[model.base.triangles[place.triangle].corner[k]];
        out.corners.push_back(corners);
    }
    return out;
}

std::vector<Ellipse> ellipses(const Model& model, const Pose& pose, const State& state, float size) {
    check_reference(model.base, state.reference);
    std::vector<Ellipse> out(model.triangles.rest.size());
    for (size_t t = 0; t < out.size(); ++t) {
        const Index* v = &model.triangles.net.vertex[3 * t];
        out[t].centre =
            (pose.base.positions[v[0]] + pose.base.positions[v[1]] + pose.base.positions[v[2]]) / 3.0f;
        const FlatTriangle& reference = state.reference.reference[t];
        const Stretch stretch = measure_stretch(reference, pose.base.shapes[t]);
        if (!stretch.defined) continue;
        const float around = reference.x1 + elementary::hypot(reference.x2, reference.y2) +
                             elementary::hypot(reference.x2 - reference.x1, reference.y2);
        const float radius = size * 2.0f * reference.area() / around;
        const Vec2 along = stretch.direction;
        out[t].compressed = radius / stretch.compression * pose.frames[t].to_object(Vec3(along, 0.0f));
        out[t].stretched = radius * stretch.stretch * pose.frames[t].to_object(Vec3(-along.y, along.x, 0.0f));
    }
    return out;
}

}  // namespace rumple::wrinkle_paths
