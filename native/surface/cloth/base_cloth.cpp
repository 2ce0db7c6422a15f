// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/base_cloth.h"

#include <algorithm>
#include <cmath>

#include "base/expect.h"
#include "base/tolerances.h"
#include "surface/attachments.h"
#include "surface/cloth/equilibrium.h"
#include "surface/contact/closest_point.h"

namespace rumple::base_cloth {
namespace {

constexpr float kPinned = 1e4f;   // follow of a pinned vertex, times that of a free one
constexpr int kContactEvery = 2;  // warm Newton steps between two looks for the nearest inner surface

TriangleFrame tangent_frame(const Vec3& normal, const Vec3& towards) {
    TriangleFrame frame;
    frame.normal = normal;
    const Vec3 tangent = towards - glm::dot(towards, normal) * normal;
    const float length = glm::length(tangent);
    if (length < kShortestEdge) return {};
    frame.tangent = tangent / length;
    frame.bitangent = glm::cross(normal, frame.tangent);
    return frame;
}

float painted(const std::vector<float>& values, Index display_vertex, float unpainted) {
    return values.empty() ? unpainted : values[display_vertex];
}

void enclose_triangles(const Surface& surface, Pose& pose) {
    pose.ball.reserve(surface.triangles.size());
    for (const Triangle& triangle : surface.triangles) {
        const auto at = [&](int k) -> const Vec3& {
            return pose.inner[surface.welded.corner_vertex[triangle.corner[k]]];
        };
        const Vec3 centre = (at(0) + at(1) + at(2)) / 3.0f;
        float square = 0.0f;
        for (int k = 0; k < 3; ++k) square = std::max(square, glm::dot(at(k) - centre, at(k) - centre));
        pose.ball.push_back({centre, std::sqrt(square)});
    }
}

Pose make_pose(const Model& model, const Settings& settings, const Paint& paint,
               std::span<const Vec3> positions, const PosedCollider* bodies, std::vector<Index>& body_hint) {
    const Surface& surface = model.surface;
    expect_count("positions", positions.size(), surface.display.vertex_count, "vertices");
    expect_finite("positions", positions, "vertex");
    const size_t vertices = surface.welded.vertex_count;
    Pose pose;
    pose.animated.resize(vertices);
    weld_positions(surface, positions, pose.animated);
    pose.normal.resize(vertices);
    vertex_normals(surface, pose.animated, pose.normal);
    for (size_t v = 0; v < vertices; ++v) {
        const Index to = model.frame_to[v];
        pose.frame.push_back(to == kNone
                                 ? TriangleFrame{}
                                 : tangent_frame(pose.normal[v], pose.animated[to] - pose.animated[v]));
        const float pinned = painted(paint.follow, surface.representative[v], 0.0f);
        pose.follow.push_back(settings.follow * (1.0f + (kPinned - 1.0f) * pinned * pinned * pinned));
        pose.room.push_back(settings.room * painted(paint.room, surface.representative[v], 1.0f));
    }
    std::vector<Vec3> smooth(vertices);
    apply<Vec3>(model.limit, pose.animated, smooth);
    Clearance found = clearance(model.clearance, settings.clearance, smooth, pose.normal, bodies, body_hint);
    pose.clearance = std::move(found.inwards);
    pose.body_known = found.known;
    for (size_t v = 0; v < vertices; ++v)
        pose.inner.push_back(pose.animated[v] - pose.clearance[v] * pose.normal[v]);
    enclose_triangles(model.surface, pose);
    pose.length.reserve(model.springs.size());
    for (const Model::Spring& spring : model.springs)
        pose.length.push_back(glm::distance(pose.animated[spring.a], pose.animated[spring.b]));
    return pose;
}

// ---------------------------------------------------------------- contact
// The point of the inner surface nearest to p, found by walking from triangle to triangle.
Plane nearest_plane(const Model& model, const Pose& pose, const Vec3& p, Index& triangle) {
    const auto vertex = [&](Index t, int k) {
        return model.surface.welded.corner_vertex[model.surface.triangles[t].corner[k]];
    };
    const auto weights_of = [&](Index t) {
        return closest_weights(p, pose.inner[vertex(t, 0)], pose.inner[vertex(t, 1)],
                               pose.inner[vertex(t, 2)]);
    };
    const auto mix = [&](Index t, const Vec3& w, const std::vector<Vec3>& values) {
        return w.x * values[vertex(t, 0)] + w.y * values[vertex(t, 1)] + w.z * values[vertex(t, 2)];
    };
    Index best = triangle;
    Vec3 weights = weights_of(best);
    Vec3 to = p - mix(best, weights, pose.inner);
    float least = glm::dot(to, to);
    for (Index from = kNone; from != best;) {
        from = best;
        for (Index k = model.near.start[from]; k < model.near.start[from + 1]; ++k) {
            const Index t = model.near.triangle[k];
            const Vec3 from_centre = p - pose.ball[t].centre;
            const float farther = std::sqrt(least) + pose.ball[t].radius;
            if (glm::dot(from_centre, from_centre) > farther * farther) continue;
            const Vec3 w = weights_of(t);
            to = p - mix(t, w, pose.inner);
            const float squared = glm::dot(to, to);
            if (squared >= least) continue;
            least = squared;
            best = t;
            weights = w;
        }
    }
    triangle = best;
    const Vec3 normal = mix(best, weights, pose.normal);
    const float length = glm::length(normal);
    return {mix(best, weights, pose.inner), length > kShortestNormal ? normal / length : Vec3(0.0f)};
}

void look_for_contacts(const Model& model, const Pose& pose, std::span<const Vec3> positions,
                       std::vector<Index>& hints, std::vector<Plane>& planes) {
    for (size_t v = 0; v < positions.size(); ++v) {
        if (hints[v] != kNone) planes[v] = nearest_plane(model, pose, positions[v], hints[v]);
    }
}

// Stays outside of the inner surface and within the room around the animated place.
void project(const Pose& pose, const Plane& plane, size_t v, Vec3& p) {
    const float height = height_above(plane, p);
    if (height < 0.0f) p -= height * plane.normal;
    const Vec3 away = p - pose.animated[v];
    const float length = std::sqrt(glm::dot(away, away));
    const float most = std::max(pose.room[v], -pose.clearance[v]);  // the way out of a body is always free
    if (length > most) p = pose.animated[v] + away * (most / length);
}

// ---------------------------------------------------------------- a frame
bool fits(const Model& model, const State* state) {
    return state && state->offset.size() == model.area.size() &&
           state->length.size() == model.springs.size() && state->clearance.size() == model.area.size();
}

// Whether the pose is the one that the state was solved for, but for rounding: then it stays to the bit.
bool holds(const Model& model, const Settings& settings, const Pose& pose, const State& state) {
    if (state.moved > kStillCloth * settings.room) return false;
    for (size_t s = 0; s < model.springs.size(); ++s) {
        if (std::abs(pose.length[s] - state.length[s]) > kHeldStrain * model.springs[s].rest) return false;
    }
    for (size_t v = 0; v < pose.clearance.size(); ++v) {
        if (std::abs(pose.clearance[v] - state.clearance[v]) > kHeldStrain * settings.room) return false;
    }
    return true;
}

void describe(const Model& model, const Settings& settings, const Pose& pose, std::span<const Vec3> x,
              std::span<const Plane> planes, Result& out) {
    double sum = 0.0;
    size_t touching = 0, taut = 0;
    const size_t vertices = x.size();
    for (size_t v = 0; v < vertices; ++v) {
        const float way = glm::distance(x[v], pose.animated[v]);
        sum += way;
        out.report.offset_max = std::max(out.report.offset_max, way);
        touching += height_above(planes[v], x[v]) < kTouching * settings.room;
    }
    for (const Model::Spring& spring : model.springs)
        taut += glm::distance(x[spring.a], x[spring.b]) > settings.slack * spring.rest;
    out.report.offset_mean = static_cast<float>(sum / double(std::max<size_t>(vertices, 1)));
    out.report.touching = float(touching) / float(std::max<size_t>(vertices, 1));
    out.report.body_known = pose.body_known;
    out.report.taut = float(taut) / float(std::max<size_t>(model.springs.size(), 1));
}

}  // namespace

void check(const Settings& settings) {
    expect_within("stretch", settings.stretch, 1e-9, 1e12);
    expect_within("strain_limit", settings.strain_limit, 0.0, 1e3);
    expect_within("shear", settings.shear, 0.0, 1e12);
    expect_within("compression", settings.compression, 0.0, 1e12);
    expect_within("compression_limit", settings.compression_limit, 0.0, 1.0);
    expect_within("folded", settings.folded, 0.0, 1e12);
    expect_within("smoothing", settings.smoothing, 0.0, 1e12);
    expect_within("slack", settings.slack, 1e-3, 1e3);
    expect_within("follow", settings.follow, 1e-6, 1e9);
    expect_within("room", settings.room, 0.0, 1e9);
    expect_within("thickness", settings.clearance.thickness, 0.0, 1e9);
    expect_within("unknown", settings.clearance.unknown, 0.0, 1e9);
    expect_within("reach", settings.clearance.reach, 1e-9, 1e9);
    expect_within("depth", settings.clearance.depth, 1e-9, 1e9);
    expect_within("spread", settings.clearance.spread, 1e-9, 1e9);
    expect_within("steps", settings.steps, 0, 1e6);
    expect_within("start_steps", settings.start_steps, 0, 1e6);
    expect_within("gradients", settings.gradients, 0, 1e6);
}

Result solve(const Model& model, const Settings& settings, const Paint& paint,
             std::span<const Vec3> positions, const PosedCollider* bodies, const State* before) {
    check(settings);
    if (!fits(model, before)) before = nullptr;
    const size_t vertices = model.area.size();
    Result out;
    if (before) out.state.body_hint = before->body_hint;
    const Pose pose = make_pose(model, settings, paint, positions, bodies, out.state.body_hint);
    out.state.contact_hint = before ? before->contact_hint : model.triangle_of;
    std::vector<Vec3> x = pose.animated;
    for (size_t v = 0; before && v < vertices; ++v) x[v] += pose.frame[v].to_object(before->offset[v]);
    std::vector<Plane> planes(vertices);
    look_for_contacts(model, pose, x, out.state.contact_hint, planes);
    const bool held = before && holds(model, settings, pose, *before);
    if (!held) {
        out.report.steps = before ? settings.steps : settings.start_steps;
        for (int i = 0; i < out.report.steps; ++i) {
            out.report.moved = newton_step({model, settings, pose, planes}, x, out.report);
            const int every = before ? kContactEvery : 1;
            if (i % every == every - 1 || i + 1 == out.report.steps)
                look_for_contacts(model, pose, x, out.state.contact_hint, planes);
        }
    }
    for (size_t v = 0; v < vertices; ++v) {
        out.state.offset.push_back(held ? before->offset[v]
                                        : pose.frame[v].to_local(x[v] - pose.animated[v]));
    }
    out.state.length = held ? before->length : pose.length;
    out.state.clearance = held ? before->clearance : pose.clearance;
    out.state.moved = out.report.moved;
    // The state keeps the equilibrium: what went on from a projected one would leave its balance in every
    // frame.
    for (size_t v = 0; v < vertices; ++v) project(pose, planes[v], v, x[v]);
    describe(model, settings, pose, x, planes, out);
    for (size_t v = 0; v < model.surface.welded_of.size(); ++v) {
        const Index welded = model.surface.welded_of[v];
        out.positions.push_back(x[welded]);
        out.gap.push_back(std::max(height_above(planes[welded], x[welded]), 0.0f));
        if (bodies) out.body_hint.push_back(out.state.body_hint[welded]);
    }
    return out;
}

}  // namespace rumple::base_cloth
