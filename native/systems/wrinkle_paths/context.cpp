// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_paths/context.h"

#include <algorithm>
#include <cmath>

#include "base/smooth_step.h"
#include "base/tolerances.h"
#include "surface/mesh/border_rings.h"
#include "surface/mesh/positions.h"

namespace rumple::wrinkle_paths {

Pose make_pose(const Model& model, std::span<const Vec3> positions) {
    check_frame(model.base, positions);
    return make_welded_pose(model, weld_positions(model.base, positions));
}

Pose make_welded_pose(const Model& model, std::vector<Vec3> welded) {
    Pose pose{flat_pose(model.triangles.net, std::move(welded)), {}, 0};
    pose.frames = triangle_frames(model.base, pose.base.positions);
    for (const FlatTriangle& shape : pose.base.shapes) pose.collapsed += !shape.has_area();
    return pose;
}

std::vector<Stretch> stretches(const Model& model, const State& state,
                               std::span<const Vec3> welded_positions) {
    const FlatPose pose = flat_pose(model.triangles.net, {welded_positions.begin(), welded_positions.end()});
    std::vector<Stretch> out;
    for (size_t t = 0; t < pose.shapes.size(); ++t)
        out.push_back(measure_stretch(state.reference.reference[t], pose.shapes[t]));
    return out;
}

float hem_weight(const Model& model, const Settings& settings, Index vertex) {
    return hem_fade(model.border_ring[vertex], settings.hem_rings);
}

float hem_weight(const Model& model, const Settings& settings, const SurfacePoint& place) {
    return place.interpolate([&](Index k) {
        return hem_weight(model, settings, model.triangles.net.vertex[3 * place.triangle + k]);
    });
}

namespace {

// The share of a triangle's folds that are possible, because the lines along them are straight enough.
float share_with_place(const Model& model, const std::vector<SpareCloth>& spare, Index triangle,
                       const Vec3& across) {
    if (spare.empty()) return 1.0f;
    const auto at = [&](Index k) { return spare[model.triangles.net.vertex[3 * triangle + k]]; };
    return 1.0f - (at(0) + at(1) + at(2)).share_without_place(across);
}

// The direction painted for every triangle, in the plane of its shape in this pose (u1 along x), length 0..1.
std::vector<Vec2> asked_along(const Model& model, const Paint& paint, const Pose& pose) {
    std::vector<Vec2> out(paint.along.empty() ? 0 : model.triangles.rest.size(), Vec2(0.0f));
    for (size_t t = 0; t < out.size(); ++t) {
        const FlatTriangle &rest = model.triangles.rest[t], &now = pose.base.shapes[t];
        if (!rest.has_area() || !now.has_area()) continue;
        const auto vertex = [&](size_t k) { return model.triangles.net.vertex[3 * t + k]; };
        Vec3 sum(0.0f);
        for (size_t k = 0; k < 3; ++k) {
            const Vec3& asked = paint.along[model.base.representative[vertex(k)]];
            sum += glm::dot(sum, asked) < 0.0f ? -asked : asked;  // a line without orientation
        }
        const auto at = [&](size_t k) { return model.base.positions_rest[vertex(k)]; };
        const SurfaceFrame frame = triangle_frame(at(0), at(1), at(2));
        const Vec2 line(glm::dot(sum, frame.tangent), glm::dot(sum, frame.bitangent));
        const float second = line.y / rest.y2, first = (line.x - second * rest.x2) / rest.x1;
        const Vec2 posed(first * now.x1 + second * now.x2, second * now.y2);
        const float length = glm::length(posed);
        if (length > 0.0f) out[t] = std::min(glm::length(line) / 3.0f, 1.0f) / length * posed;
    }
    return out;
}

void turn_along(const Vec2& along, Stretch& stretch) {
    if (!stretch.defined || along == Vec2(0.0f)) return;
    const float small = 1.0f / (stretch.compression * stretch.compression),
                large = stretch.stretch * stretch.stretch;
    const Vec2& e = stretch.direction;
    const Principal p = principal(turned({small * e.x * e.x + large * e.y * e.y, (small - large) * e.x * e.y,
                                          small * e.y * e.y + large * e.x * e.x},
                                         along));
    stretch.compression = std::min(
        1.0f / std::sqrt(std::max(p.small, 1.0f / (kMostCompression * kMostCompression))), kMostCompression);
    stretch.stretch = std::min(std::sqrt(p.large), kMostCompression);
    stretch.direction = p.small_direction;
}

}  // namespace

PathContext make_context(const Model& model, const Settings& settings, const Paint& paint, const Pose& pose,
                         const std::vector<FlatTriangle>& shapes, const std::vector<FlatTriangle>& reference,
                         const std::vector<Stretch>& changes) {
    PathContext context{{{model, pose}}};
    std::vector<SpareCloth> spare;
    if (settings.bend_radius > 0.0f)
        spare = spare_cloth(model.base, model.bent_lines, pose.base.positions, settings.bend_radius);
    const std::vector<Vec2> along = asked_along(model, paint, pose);
    for (size_t t = 0; t < reference.size(); ++t) {
        context.stretch.push_back(pose.base.shapes[t].has_area() ? measure_stretch(reference[t], shapes[t])
                                                                 : Stretch{});
        if (!along.empty()) turn_along(along[t], context.stretch[t]);
        float mask = 0.0f;
        for (const Index corner : model.base.triangles[t].corner) {
            const float painted =
                paint.mask.empty() ? 1.0f : paint.mask[model.base.display.corner_vertex[corner]];
            mask += painted * hem_weight(model, settings, model.base.welded.corner_vertex[corner]) / 3.0f;
        }
        if (!paint.width.empty()) {
            float sum = 0.0f;
            for (const Index corner : model.base.triangles[t].corner)
                sum += paint.width[model.base.display.corner_vertex[corner]];
            context.widths.push_back(std::clamp(sum / 3.0f, kLeastWidth, 1.0f));
        }
        const float strain = std::max(changes[t].compression, changes[t].stretch) - 1.0f;
        context.activity.push_back(smooth_step(kHeldChange, kFreeChange, strain));
        const float place = share_with_place(model, spare, Index(t), context.across(Index(t)));
        mask *= along.empty() ? place : glm::mix(place, 1.0f, glm::length(along[t]));
        context.compression.push_back(1.0f + mask * (context.stretch[t].compression - 1.0f));
    }
    return context;
}

std::vector<FlatTriangle> smoothed_shapes(const Settings& settings, double seconds, const State* state,
                                          const Pose& pose) {
    std::vector<FlatTriangle> shapes = pose.base.shapes;
    if (!state) return shapes;
    const float fraction = fraction_of(seconds, settings.smoothing);
    for (size_t t = 0; t < shapes.size(); ++t) shapes[t] = between(state->shapes[t], shapes[t], fraction);
    return shapes;
}

}  // namespace rumple::wrinkle_paths
