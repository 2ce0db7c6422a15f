// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/strain/deformation.h"

#include <cmath>

#include "base/formulas.h"
#include "base/solve_team.h"
#include "base/tolerances.h"
#include "base/unit_vector.h"

namespace rumple {
namespace {

void add_scaled(Tensor2& sum, const Tensor2& t, float weight) {
    sum.xx += weight * t.xx;
    sum.xy += weight * t.xy;
    sum.yy += weight * t.yy;
}

struct Corners {
    Vec3 p[3];
};

Corners corners_of(const Surface& surface, std::span<const Vec3> positions, const Triangle& triangle) {
    Corners out;
    for (int k = 0; k < 3; ++k) out.p[k] = positions[surface.welded.corner_vertex[triangle.corner[k]]];
    return out;
}

// Columns: the two edges from corner 0, in the triangle's frame.
glm::mat2 edges_in_frame(const Corners& c, const SurfaceFrame& frame) {
    const Vec3 e1 = c.p[1] - c.p[0];
    const Vec3 e2 = c.p[2] - c.p[0];
    return {Vec2(glm::dot(e1, frame.tangent), glm::dot(e1, frame.bitangent)),
            Vec2(glm::dot(e2, frame.tangent), glm::dot(e2, frame.bitangent))};
}

// The vector v after the smallest rotation from one unit normal to another.
Vec3 tilt(const Vec3& v, const Vec3& from, const Vec3& to) {
    const Vec3 axis = glm::cross(from, to);
    const float cosine = glm::dot(from, to);
    if (cosine < kOppositeNormals) return v;  // half a turn: every axis is equally good
    return cosine * v + glm::cross(axis, v) + axis * (glm::dot(axis, v) / (1.0f + cosine));
}

// The rotation from components in the triangle's frame to components in the vertex's frame.
Vec2 turn_between(const SurfaceFrame& triangle, const Vec3& vertex_normal, const Vec3& vertex_tangent) {
    const Vec3 carried = tilt(triangle.tangent, triangle.normal, vertex_normal);
    const Vec3 vertex_bitangent = glm::cross(vertex_normal, vertex_tangent);
    const Vec2 turn(glm::dot(carried, vertex_tangent), glm::dot(carried, vertex_bitangent));
    const float length = glm::length(turn);
    return length > 0.0f ? turn / length : Vec2(1.0f, 0.0f);
}

// Per welded vertex: its corners, as triangle x 3 + corner.
std::vector<std::vector<Index>> corners_at_vertices(const Surface& surface) {
    std::vector<std::vector<Index>> out(surface.welded.vertex_count);
    for (Index t = 0; t < static_cast<Index>(surface.triangles.size()); ++t) {
        for (Index k = 0; k < 3; ++k) out[welded_vertices(surface, t)[k]].push_back(3 * t + k);
    }
    return out;
}

// The frame of a vertex, and the weights and rotations of its corners. frames, area: of the triangles.
void add_vertex(std::span<const Index> corners, std::span<const SurfaceFrame> frames,
                std::span<const float> area, StretchModel& model) {
    Vec3 normal_sum(0.0f);
    float area_sum = 0.0f;
    for (const Index corner : corners) {
        normal_sum += area[corner / 3] * frames[corner / 3].normal;
        area_sum += area[corner / 3];
    }
    const float length = glm::length(normal_sum);
    const Vec3 normal = length > 0.0f ? normal_sum / length : Vec3(0, 0, 1);
    const Vec3 tangent = formulas::any_tangent(normal);
    model.vertex_tangent.push_back(tangent);
    for (const Index corner : corners) {
        const Index t = corner / 3;
        if (area[t] <= 0.0f) continue;
        const Vec2 turn = turn_between(frames[t], normal, tangent);
        model.triangle_transport[corner] = turn;
        model.corners.push_back({t, area[t] / area_sum, turn});
    }
    model.corner_start.push_back(static_cast<Index>(model.corners.size()));
}

}  // namespace

Tensor2 rotated(const Tensor2& t, const Vec2& turn) {
    const float c = turn.x;
    const float s = turn.y;
    return {c * c * t.xx - 2.0f * c * s * t.xy + s * s * t.yy, c * s * (t.xx - t.yy) + (c * c - s * s) * t.xy,
            s * s * t.xx + 2.0f * c * s * t.xy + c * c * t.yy};
}

Principal principal(const Tensor2& t) {
    const float mean = 0.5f * (t.xx + t.yy);
    const float half_difference = 0.5f * (t.xx - t.yy);
    const float radius = std::sqrt(half_difference * half_difference + t.xy * t.xy);
    Principal out{mean - radius, mean + radius, {1.0f, 0.0f}};
    if (radius <= 0.0f) return out;
    // The longer of the two columns of T - large I: the eigenvector without cancellation.
    const Vec2 a(t.xx - out.large, t.xy);
    const Vec2 b(t.xy, t.yy - out.large);
    const Vec2 direction = glm::dot(a, a) > glm::dot(b, b) ? a : b;
    const float length = glm::length(direction);
    if (length > 0.0f) out.small_direction = direction / length;
    return out;
}

StretchModel build_stretch(const Surface& surface) {
    const size_t triangles = surface.triangles.size();
    StretchModel model;
    std::vector<SurfaceFrame> frames(triangles);
    std::vector<float> area(triangles);
    model.inverse_rest.assign(triangles, glm::mat2(0.0f));
    for (size_t t = 0; t < triangles; ++t) {
        const Corners c = corners_of(surface, surface.positions_rest, surface.triangles[t]);
        frames[t] = triangle_frame(c.p[0], c.p[1], c.p[2]);
        const glm::mat2 edges = edges_in_frame(c, frames[t]);
        area[t] = 0.5f * glm::determinant(edges);
        if (area[t] > 0.0f) model.inverse_rest[t] = glm::inverse(edges);
    }
    model.triangle_transport.assign(3 * triangles, Vec2(1.0f, 0.0f));
    model.corner_start.push_back(0);
    for (const std::vector<Index>& corners : corners_at_vertices(surface))
        add_vertex(corners, frames, area, model);
    return model;
}

std::vector<Tensor2> at_vertices(const StretchModel& model, std::span<const Tensor2> of_triangles) {
    std::vector<Tensor2> tensors(model.corner_start.size() - 1);
    for (size_t v = 0; v < tensors.size(); ++v) {
        for (Index k = model.corner_start[v]; k < model.corner_start[v + 1]; ++k) {
            const StretchModel::Corner& corner = model.corners[k];
            add_scaled(tensors[v], rotated(of_triangles[corner.triangle], corner.transport), corner.weight);
        }
    }
    return tensors;
}

void measure_stretch(const Surface& surface, const StretchModel& model, std::span<const Vec3> positions,
                     std::span<const SurfacePoint> places, StretchField& out) {
    const size_t triangles = surface.triangles.size();
    std::vector<Tensor2> triangle_tensor(triangles);
    std::vector<glm::mat2x3> gradient(triangles);  // F: rest frame of the triangle -> object space
    for_each_index(triangles, kLeastSteps, [&](size_t t) {
        const Corners c = corners_of(surface, positions, surface.triangles[t]);
        gradient[t] = glm::mat2x3(c.p[1] - c.p[0], c.p[2] - c.p[0]) * model.inverse_rest[t];
        const glm::mat2 metric = glm::transpose(gradient[t]) * gradient[t];  // F^T F
        triangle_tensor[t] = {metric[0][0], metric[0][1], metric[1][1]};
    });
    const std::vector<Tensor2> vertex_tensor = at_vertices(model, triangle_tensor);
    out.minimum.resize(places.size());
    out.maximum.resize(places.size());
    out.direction.resize(places.size());
    for_each_index(places.size(), kLeastSteps, [&](size_t i) {
        const SurfacePoint& place = places[i];
        if (place.triangle == kNone) {
            out.minimum[i] = out.maximum[i] = 1.0f;
            out.direction[i] = Vec3(0.0f);
            return;
        }
        const std::array<float, 3> weights = place.weights();
        Tensor2 sum;
        for (int k = 0; k < 3; ++k) {
            const Index v = welded_vertices(surface, place.triangle)[k];
            const Vec2 turn = model.triangle_transport[3 * place.triangle + k];
            add_scaled(sum, rotated(vertex_tensor[v], {turn.x, -turn.y}), weights[k]);
        }
        const Principal p = principal(sum);
        out.minimum[i] = std::sqrt(std::max(p.small, 0.0f));
        out.maximum[i] = std::sqrt(std::max(p.large, 0.0f));
        out.direction[i] = unit_or_zero(gradient[place.triangle] * p.small_direction, kShortestEdge);
    });
}

}  // namespace rumple
