// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/pose.h"

#include <algorithm>
#include <cmath>

#include "base/expect.h"
#include "base/tolerances.h"
#include "surface/mesh/positions.h"
#include "surface/output/attachments.h"
#include "surface/query/closest_point.h"

namespace rumple::base_cloth {
namespace {

constexpr float kPinned = 4e6f;  // follow of a pinned vertex, 1/s^2: 2.5 um under gravity

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
    pose.ball.clear();
    pose.ball.reserve(surface.triangles.size());
    for (Index t = 0; t < static_cast<Index>(surface.triangles.size()); ++t) {
        const auto [a, b, c] = welded_vertices(surface, t);
        const Vec3 centre = (pose.inner[a] + pose.inner[b] + pose.inner[c]) / 3.0f;
        float square = 0.0f;
        for (const Index v : {a, b, c}) {
            const Vec3 from_centre = pose.inner[v] - centre;
            square = std::max(square, glm::dot(from_centre, from_centre));
        }
        pose.ball.push_back({centre, std::sqrt(square)});
    }
}

// ---------------------------------------------------------------- contact
// The point of the inner surface nearest to p, found by walking from triangle to triangle.
Plane nearest_plane(const Model& model, const Pose& pose, const Vec3& p, Index& triangle) {
    const auto weights_of = [&](Index t) {
        const auto [a, b, c] = welded_vertices(model.surface, t);
        return closest_weights(p, pose.inner[a], pose.inner[b], pose.inner[c]);
    };
    const auto mix = [&](Index t, const Vec3& w, const std::vector<Vec3>& values) {
        const auto [a, b, c] = welded_vertices(model.surface, t);
        return w.x * values[a] + w.y * values[b] + w.z * values[c];
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
            if (!(squared < least)) continue;  // what is no number is no way: the walk ends
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

// Of every vertex the plane that keeps it before a body in front: an arm beside a flank. The animated garment
// is never behind it, so that cloth that has to come out of both sides has a place.
void look_ahead(const Settings& settings, const PosedCollider* bodies, Pose& pose) {
    pose.ahead.assign(pose.animated.size(), {Vec3(0.0f), Vec3(0.0f)});
    pose.ahead_height = pose.room;
    if (!bodies) return;
    const float thickness = settings.clearance.thickness;
    for (size_t v = 0; v < pose.ahead.size(); ++v) {
        const Vec3& a = pose.animated[v];
        const BodyAhead body = bodies->ahead(a, pose.normal[v], pose.room[v] + thickness, thickness);
        if (body.triangle == kNone) continue;
        pose.ahead_height[v] = std::max(glm::dot(a - body.point, body.normal) - thickness, 0.0f);
        pose.ahead[v] = {a - pose.ahead_height[v] * body.normal, body.normal};
    }
}

// Stays outside of the inner surface, before what is ahead, and within the room around the animated place.
void project(const Pose& pose, const Plane& plane, size_t v, Vec3& p) {
    const float below = height_above(pose.ahead[v], p);
    if (below < 0.0f) p -= below * pose.ahead[v].normal;
    const float height = height_above(plane, p);
    if (height < 0.0f) p -= height * plane.normal;
    const Vec3 away = p - pose.animated[v];
    const float length = std::sqrt(glm::dot(away, away));
    const float most = pose.farthest(v);
    if (length > most) p = pose.animated[v] + away * (most / length);
}

void describe(const Model& model, const Settings& settings, const Pose& pose, std::span<const Vec3> x,
              std::span<const Plane> planes, Result& out) {
    double sum = 0.0;
    size_t touching = 0, taut = 0;
    const size_t vertices = x.size();
    for (size_t v = 0; v < vertices; ++v) {
        const float moved = glm::distance(x[v], pose.animated[v]);
        sum += moved;
        out.report.offset_max = std::max(out.report.offset_max, moved);
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

bool matches(const Model& model, const State& state) {
    return state.length.size() == model.springs.size() && state.clearance.size() == model.area.size() &&
           state.ahead_height.size() == model.area.size();
}

Pose make_pose(const Model& model, const Settings& settings, const Paint& paint,
               std::span<const Vec3> positions, const PosedCollider* bodies, std::vector<Index>& body_hint) {
    const Surface& surface = model.surface;
    check_frame(surface, positions);
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
        pose.follow.push_back(settings.follow + (kPinned - settings.follow) * pinned * pinned * pinned);
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
    look_ahead(settings, bodies, pose);
    pose.length.reserve(model.springs.size());
    for (const Model::Spring& spring : model.springs)
        pose.length.push_back(glm::distance(pose.animated[spring.a], pose.animated[spring.b]));
    return pose;
}

void move_to(const Model& model, const Pose& pose, std::vector<Vec3> animated, Pose& moved) {
    for (size_t v = 0; v < animated.size(); ++v) {
        const Vec3 displacement = animated[v] - pose.animated[v];
        moved.inner[v] = pose.inner[v] + displacement;
        moved.ahead[v].point = pose.ahead[v].point + displacement;
    }
    moved.animated = std::move(animated);
    enclose_triangles(model.surface, moved);
}

void look_for_contacts(const Model& model, const Pose& pose, std::span<const Vec3> positions,
                       std::vector<Index>& hints, std::vector<Plane>& planes) {
    for (size_t v = 0; v < positions.size(); ++v) {
        if (hints[v] != kNone) planes[v] = nearest_plane(model, pose, positions[v], hints[v]);
    }
}

void finish(const Model& model, const Settings& settings, const Pose& pose, std::span<const Plane> planes,
            bool has_bodies, std::span<Vec3> x, Result& out) {
    for (size_t v = 0; v < x.size(); ++v) project(pose, planes[v], v, x[v]);
    describe(model, settings, pose, x, planes, out);
    for (const Index welded : model.surface.welded_of) {
        out.positions.push_back(x[welded]);
        out.gap.push_back(std::max(height_above(planes[welded], x[welded]), 0.0f));
        if (has_bodies) out.body_hint.push_back(out.state.body_hint[welded]);
    }
}

}  // namespace rumple::base_cloth
