// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_mesh/pose.h"

#include <string>

#include "base/expect.h"
#include "base/smooth_step.h"
#include "surface/mesh/positions.h"

namespace rumple::wrinkle_mesh {
namespace {

// s of a pair. Cloth that is pulled taut has nothing to spare along the pull, and folds across it (tension
// field theory: Wagner 1929): where the base is taut along the pair, s is what the base has itself.
float pre_stretch(const Settings& settings, float paint, float strain) {
    const float s = 1.0f + (settings.prestretch - 1.0f) * paint;
    if (settings.taut_range <= 0.0f) return s;
    return glm::mix(s, std::min(s, settings.slack),
                    smooth_step(settings.slack - settings.taut_range, settings.slack, strain));
}

// The length that a pair is asked to keep in this pose. The paper asks for s l0
// always; we give in to a part of the stretch of the base and to a small compression, and make no more cloth
// from a collapsed base than compression_limit allows.
float target_length(const Settings& settings, float s, float rest, float at_attachments) {
    float target = s * rest;
    target += settings.stretch_relief * std::max(at_attachments - target, 0.0f);
    target -= std::clamp(target - at_attachments, 0.0f, settings.buckling_threshold * target);
    return std::min(target, settings.compression_limit * at_attachments);
}

// A body is looked for within so many fine edges around a vertex.
constexpr float kBodyReach = 2.0f;

// How far a vertex may go inwards over a body; `unknown` where the body says nothing. A border of the body
// stays below the cloth between its vertices: within an edge of it, as over skin; farther away at 45 degrees.
float gap_above(const BodyContact& body, float thickness, float edge, float unknown) {
    const float above = body.distance - thickness;
    if (!body.border) return glm::mix(unknown, above, body.weight);
    const float cone = std::min(above + std::max(body.beside - edge, 0.0f), unknown);
    return glm::mix(unknown, cone, smooth_step(-edge, -0.5f * edge, body.distance));
}

// How far every vertex may go inwards. Attachments inside a body are put out of it first.
void keep_outside(const Model& model, const Input& input, Pose& pose) {
    if (input.gap.empty()) return;
    expect_count("gap", input.gap.size(), model.base.display.vertex_count, "values");
    if (input.bodies)
        expect_count("body_hint", input.body_hint.size(), model.base.display.vertex_count, "values");
    pose.gap.assign(pose.attachment.size(), 0.0f);
    if (input.bodies) pose.body.assign(pose.attachment.size(), kNone);
    const std::vector<float> gaps = gaps_at(model.base, model.attachments, input.gap);
    const size_t queries = input.bodies ? pose.attachment.size() : 0;
    for_each_index(pose.attachment.size(), threads_for_queries(input.threads, queries), [&](size_t v) {
        const SurfacePoint& place = model.attachments.places[v];
        if (place.triangle == kNone) return;
        float gap = gaps[v];
        const Index hint = input.bodies ? hint_at(model.base, place.triangle, input.body_hint) : kNone;
        if (hint != kNone) {
            const float reach = kBodyReach * model.local_edge[v] + input.thickness;
            const BodyContact body = input.bodies->closest(pose.attachment[v], pose.normal[v], reach, hint);
            if (body.triangle != kNone) gap = gap_above(body, input.thickness, model.local_edge[v], gap);
            pose.body[v] = body.triangle;
        }
        if (gap < 0.0f) pose.attachment[v] -= gap * pose.normal[v];
        pose.gap[v] = std::max(gap, 0.0f);
    });
}

}  // namespace

TriangleFrame smooth_frame(const TriangleFrame& triangle, const Vec3& interpolated_normal) {
    const float normal_length = glm::length(interpolated_normal);
    if (normal_length < kShortestNormal) return triangle;
    TriangleFrame frame;
    frame.normal = interpolated_normal / normal_length;
    const Vec3 tangent = triangle.tangent - glm::dot(triangle.tangent, frame.normal) * frame.normal;
    const float tangent_length = glm::length(tangent);
    if (tangent_length < kShortestNormal) return triangle;
    frame.tangent = tangent / tangent_length;
    frame.bitangent = glm::cross(frame.normal, frame.tangent);
    return frame;
}

void check(const Model& model, const Paint& paint) {
    const auto fits = [&](const char* name, const std::vector<float>& values) {
        if (values.empty() || values.size() == model.attached.size()) return;
        throw InvalidInput(std::string("paint.") + name + ": expected " +
                           std::to_string(model.attached.size()) +
                           " values, one per solved vertex, or none, got " + std::to_string(values.size()));
    };
    fits("radius", paint.radius);
    fits("prestretch", paint.prestretch);
    fits("bending", paint.bending);
    fits("inside", paint.inside);
}

void check(const Model& model, const State& state) {
    if (state.offset.size() == model.attached.size()) return;
    throw InvalidInput("state: expected " + std::to_string(model.attached.size()) + " offsets, got " +
                       std::to_string(state.offset.size()));
}

Pose make_pose(const Model& model, const Input& input) {
    check_frame(model.base, input.positions);
    Pose pose;
    pose.base.resize(model.base.welded.vertex_count);
    weld_positions(model.base, input.positions, pose.base);
    pose.base_normals.resize(pose.base.size());
    vertex_normals(model.base, pose.base, pose.base_normals);
    pose.frames.resize(model.base.triangles.size());
    triangle_frames(model.base, pose.base, pose.frames);
    for (const TriangleFrame& frame : pose.frames) pose.collapsed += frame.normal == Vec3(0.0f);
    const size_t vertices = model.attached.size();
    pose.attachment.resize(vertices);
    attach(model.base, model.attachments, pose.base, pose.base_normals, pose.attachment, 0, vertices);
    pose.normal.resize(vertices);
    for (size_t v = 0; v < vertices; ++v) {
        const SurfacePoint& place = model.attachments.places[v];
        const Vec3 normal = interpolate(model.base, place, pose.base_normals);
        const float length = glm::length(normal);
        pose.normal[v] = length > kShortestNormal ? normal / length : Vec3(0.0f);
        if (!model.rest_offset.empty()) {
            pose.attachment[v] +=
                smooth_frame(pose.frames[place.triangle], normal).to_object(model.rest_offset[v]);
        }
    }
    keep_outside(model, input, pose);
    return pose;
}

OffsetFrames::OffsetFrames(const Model& model, const Settings& settings, const Input& input, const Pose& pose)
    : model_(model),
      pose_(pose),
      world_(settings.offset_space == OffsetSpace::kWorld),
      world_from_object_(input.world_from_object),
      object_from_world_(glm::inverse(input.world_from_object)) {
    if (!world_) return;
    for (int column = 0; column < 3; ++column) {
        if (!is_finite(world_from_object_[column]) || !is_finite(object_from_world_[column]))
            throw InvalidInput("world_from_object: it has no inverse, or is not finite");
    }
}

Vec3 OffsetFrames::stored(size_t v, const Vec3& offset) const {
    if (world_) return world_from_object_ * offset;
    return pose_.frames[model_.attachments.places[v].triangle].to_local(offset);
}

Vec3 OffsetFrames::in_object(size_t v, const Vec3& stored) const {
    if (world_) return object_from_world_ * stored;
    return pose_.frames[model_.attachments.places[v].triangle].to_object(stored);
}

std::vector<float> attachment_radii(const Model& model, const Settings& settings, const Paint& paint) {
    std::vector<float> radii(model.local_edge.size());
    for (size_t v = 0; v < radii.size(); ++v) {
        float fade = 1.0f;
        if (settings.hem_rings > 0 && model.boundary_ring[v] != kNone) {
            const float x = std::min(1.0f, float(model.boundary_ring[v]) / float(settings.hem_rings));
            fade = x * x * (3.0f - 2.0f * x);
        }
        radii[v] = settings.radius * model.local_edge[v] * painted(paint.radius, v) * fade;
    }
    return radii;
}

std::vector<float> pair_lengths(const Model& model, std::span<const Vec3> positions) {
    std::vector<float> lengths;
    if (positions.empty()) return lengths;
    lengths.reserve(model.distance.size() + model.bending.size());
    for (const Pairs* pairs : {&model.distance, &model.bending}) {
        for (size_t i = 0; i < pairs->size(); ++i) {
            lengths.push_back(glm::distance(positions[pairs->a[i]], positions[pairs->b[i]]));
        }
    }
    return lengths;
}

Targets make_targets(const Model& model, const Settings& settings, const Paint& paint,
                     std::span<const float> lengths, std::span<const float> unwrinkled,
                     const std::vector<float>& rest_scales) {
    Targets targets;
    const auto both = [](const std::vector<float>& values, Index a, Index b) {
        return 0.5f * (painted(values, a) + painted(values, b));
    };
    const auto fill = [&](const Pairs& pairs, size_t first, std::vector<float>& out) {
        for (size_t i = 0; i < pairs.size(); ++i) {
            const float rest = scale_of(rest_scales, first + i) * pairs.rest[i];
            const float strain =
                unwrinkled.empty() ? 0.0f : unwrinkled[first + i] / std::max(rest, kShortestEdge);
            const float s = pre_stretch(settings, both(paint.prestretch, pairs.a[i], pairs.b[i]), strain);
            out.push_back(target_length(settings, s, rest, lengths[first + i]));
        }
    };
    fill(model.distance, 0, targets.distance);
    fill(model.bending, model.distance.size(), targets.bending);
    for (size_t i = 0; i < model.bending.size(); ++i) {
        targets.stiffness.push_back(settings.bending *
                                    both(paint.bending, model.bending.a[i], model.bending.b[i]));
    }
    return targets;
}

LengthError length_error(const Pairs& pairs, std::span<const float> target, std::span<const Vec3> positions) {
    double sum = 0.0;
    LengthError error;
    for (size_t i = 0; i < pairs.size(); ++i) {
        const float wanted = std::max(target[i], kShortestEdge);
        const float relative =
            std::abs(glm::distance(positions[pairs.a[i]], positions[pairs.b[i]]) - target[i]) / wanted;
        if (target[i] < kShortestEdge) continue;  // a collapsed pair asks for nothing
        sum += double(relative) * relative;
        error.largest = std::max(error.largest, relative);
    }
    error.rms = pairs.size() ? static_cast<float>(std::sqrt(sum / double(pairs.size()))) : 0.0f;
    return error;
}

}  // namespace rumple::wrinkle_mesh
