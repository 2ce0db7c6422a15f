// SPDX-License-Identifier: GPL-3.0-or-later
// The static equilibrium of the energy of docs/base_cloth.md: Newton's method, each step by preconditioned conjugate
// gradients (Shewchuk 1994, B3).
#include "surface/cloth/base_cloth.h"

#include <algorithm>
#include <cmath>

#include "base/expect.h"
#include "base/tolerances.h"
#include "surface/attachments.h"
#include "surface/contact/closest_point.h"

namespace rumple::base_cloth {
namespace {

constexpr float kBeyondLimit = 10.0f;    // stiffness beyond the strain limit
constexpr float kWall = 15.0f;           // how much the pull back grows towards the edge of the room
constexpr float kPinned = 1e4f;          // follow of a pinned vertex, times that of a free one
constexpr float kContact = 2e4f;       // stiffness of the inner surface, 1/s^2
constexpr double kResidual = 0.05;     // conjugate gradients stop at this share of the force they began with
constexpr int kShortenings = 4;        // of a step that went too far

// The plane that stands for the inner surface near a vertex.
struct Plane {
    Vec3 point{0.0f};
    Vec3 normal{0.0f};
};

// One frame, as the solver sees it. Per welded vertex.
struct Pose {
    std::vector<Vec3> animated;
    std::vector<Vec3> normal;
    std::vector<TriangleFrame> frame;  // tangent frames: rigid motion carries them along
    std::vector<Vec3> inner;           // the inner surface: what cloth stays outside of
    std::vector<float> clearance;
    std::vector<float> length;  // of every spring
    std::vector<float> follow;  // 1/s^2
    std::vector<float> room;
};

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

Pose make_pose(const Model& model, const Settings& settings, const Paint& paint, std::span<const Vec3> positions,
               const PosedCollider* bodies, std::vector<Index>& body_hint) {
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
        pose.frame.push_back(to == kNone ? TriangleFrame{}
                                         : tangent_frame(pose.normal[v], pose.animated[to] - pose.animated[v]));
        const float pinned = painted(paint.follow, surface.representative[v], 0.0f);
        pose.follow.push_back(settings.follow * (1.0f + (kPinned - 1.0f) * pinned * pinned * pinned));
        pose.room.push_back(settings.room * painted(paint.room, surface.representative[v], 1.0f));
    }
    std::vector<Vec3> smooth(vertices);
    apply<Vec3>(model.limit, pose.animated, smooth);
    pose.clearance = clearance(model.clearance, settings.clearance, smooth, pose.normal, bodies, body_hint);
    for (size_t v = 0; v < vertices; ++v)
        pose.inner.push_back(pose.animated[v] - pose.clearance[v] * pose.normal[v]);
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
        return closest_weights(p, pose.inner[vertex(t, 0)], pose.inner[vertex(t, 1)], pose.inner[vertex(t, 2)]);
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
        for (Index k = model.near_start[from]; k < model.near_start[from + 1]; ++k) {
            const Index t = model.near_triangle[k];
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

inline float height_above(const Plane& plane, const Vec3& p) {
    return glm::dot(p - plane.point, plane.normal);
}

// ---------------------------------------------------------------- forces
// Force along a spring over its weight (towards the other end is positive), and its slope: figure 6 of the paper.
struct Tension {
    float force;
    float slope;
};
Tension tension(const Settings& settings, bool diagonal, float length, float rest) {
    const float longer = length - rest;
    if (longer > 0.0f) {
        const float k = diagonal ? settings.shear : settings.stretch;
        const float beyond = length - (1.0f + settings.strain_limit) * rest;
        if (beyond <= 0.0f) return {k * longer, k};
        return {k * longer + (kBeyondLimit - 1.0f) * k * beyond, kBeyondLimit * k};
    }
    if (diagonal) return {0.0f, 0.0f};
    const float folded = length - settings.compression_limit * rest;
    if (folded >= 0.0f) return {settings.compression * longer, settings.compression};
    return {settings.compression * longer + (settings.folded - settings.compression) * folded, settings.folded};
}

// The energy's Hessian, made positive definite: as the springs and vertices have it.
struct Hessian {
    struct Spring {
        Vec3 direction;
        float along;   // beyond `across`
        float across;
    };
    struct Vertex {
        float back;     // times identity
        Vec3 wall;      // times itself: the pull back grows along the way
        float contact;  // times normal x normal
    };
    std::vector<Spring> springs;
    std::vector<Vertex> vertices;
    std::vector<glm::mat3> inverse_diagonal;  // preconditioner: of the 3x3 blocks
};

struct Cloth {
    const Model& model;
    const Settings& settings;
    const Pose& pose;
    std::span<const Plane> planes;
};

// The forces at x; the Hessian too, where one is asked for.
void forces(const Cloth& cloth, std::span<const Vec3> x, std::span<Vec3> out, Hessian* hessian) {
    const auto& [model, settings, pose, planes] = cloth;
    for (size_t v = 0; v < x.size(); ++v) {
        const Vec3 away = x[v] - pose.animated[v];
        const float share = pose.room[v] > 0.0f ? glm::dot(away, away) / (pose.room[v] * pose.room[v]) : 0.0f;
        const float back = model.area[v] * pose.follow[v] * (1.0f + kWall * share * share);
        const float inward = -height_above(planes[v], x[v]);
        const float contact = inward > 0.0f ? model.area[v] * std::max(kContact, pose.follow[v]) : 0.0f;
        out[v] = model.area[v] * settings.gravity - back * away + contact * inward * planes[v].normal;
        if (!hessian) continue;
        const float growth = 4.0f * model.area[v] * pose.follow[v] * kWall * share;
        const Vec3 wall = share > 0.0f ? std::sqrt(growth) / pose.room[v] * away : Vec3(0.0f);
        hessian->vertices[v] = {back, wall, contact};
        hessian->inverse_diagonal[v] = glm::mat3(back) + glm::outerProduct(wall, wall) +
                                       contact * glm::outerProduct(planes[v].normal, planes[v].normal);
    }
    for (size_t s = 0; s < model.springs.size(); ++s) {
        const auto& [a, b, rest, weight, diagonal] = model.springs[s];
        const Vec3 way = x[b] - x[a];
        const float length = std::max(std::sqrt(glm::dot(way, way)), kShortestEdge);
        const Vec3 n = way / length;
        const Tension t = tension(settings, diagonal, length, settings.slack * rest);
        const float smooth = diagonal ? 0.0f : settings.smoothing;
        const Vec3 pull = weight * (t.force * n + smooth * (way - (pose.animated[b] - pose.animated[a])));
        out[a] += pull;
        out[b] -= pull;
        if (!hessian) continue;
        const float across = std::max(t.force / length, 0.0f);
        hessian->springs[s] = {n, weight * (t.slope - across), weight * (across + smooth)};
        const glm::mat3 block =
            glm::mat3(weight * (across + smooth)) + weight * (t.slope - across) * glm::outerProduct(n, n);
        hessian->inverse_diagonal[a] += block;
        hessian->inverse_diagonal[b] += block;
    }
    if (hessian) {
        for (glm::mat3& block : hessian->inverse_diagonal) block = glm::inverse(block);
    }
}

void multiply(const Cloth& cloth, const Hessian& hessian, std::span<const Vec3> p, std::span<Vec3> out) {
    for (size_t v = 0; v < p.size(); ++v) {
        const auto& [back, wall, contact] = hessian.vertices[v];
        const Vec3& n = cloth.planes[v].normal;
        out[v] = back * p[v] + glm::dot(wall, p[v]) * wall + contact * glm::dot(n, p[v]) * n;
    }
    for (size_t s = 0; s < hessian.springs.size(); ++s) {
        const Model::Spring& spring = cloth.model.springs[s];
        const auto& [n, along, across] = hessian.springs[s];
        const Vec3 d = p[spring.b] - p[spring.a];
        const Vec3 pull = across * d + along * glm::dot(n, d) * n;
        out[spring.a] -= pull;
        out[spring.b] += pull;
    }
}

double inner_product(std::span<const Vec3> a, std::span<const Vec3> b) {
    double sum = 0.0;
    for (size_t v = 0; v < a.size(); ++v) sum += double(glm::dot(a[v], b[v]));
    return sum;
}

// Solves Hessian step = force; returns the number of gradients.
int conjugate_gradients(const Cloth& cloth, const Hessian& hessian, std::span<const Vec3> force,
                        std::span<Vec3> step) {
    const size_t vertices = force.size();
    std::vector<Vec3> residual(force.begin(), force.end()), z(vertices), p(vertices), product(vertices);
    const auto precondition = [&] {
        for (size_t v = 0; v < vertices; ++v) z[v] = hessian.inverse_diagonal[v] * residual[v];
    };
    std::fill(step.begin(), step.end(), Vec3(0.0f));
    precondition();
    p = z;
    double now = inner_product(residual, z);
    const double enough = kResidual * kResidual * now;
    for (int i = 0; i < cloth.settings.gradients; ++i) {
        if (now <= enough || now <= 0.0) return i;
        multiply(cloth, hessian, p, product);
        const float alpha = static_cast<float>(now / inner_product(p, product));
        for (size_t v = 0; v < vertices; ++v) {
            step[v] += alpha * p[v];
            residual[v] -= alpha * product[v];
        }
        precondition();
        const double next = inner_product(residual, z);
        const float beta = static_cast<float>(next / now);
        for (size_t v = 0; v < vertices; ++v) p[v] = z[v] + beta * p[v];
        now = next;
    }
    return cloth.settings.gradients;
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

// One Newton step, shortened where it went too far: springs that are slack here and taut there are not in its Hessian.
// Returns the farthest way of a vertex.
float newton_step(const Cloth& cloth, std::span<Vec3> x, Report& report) {
    const size_t vertices = x.size();
    std::vector<Vec3> force(vertices), step(vertices), tried(vertices), there(vertices);
    Hessian hessian;
    hessian.springs.resize(cloth.model.springs.size());
    hessian.vertices.resize(vertices);
    hessian.inverse_diagonal.resize(vertices);
    forces(cloth, x, force, &hessian);
    report.gradients += conjugate_gradients(cloth, hessian, force, step);
    const double slope = inner_product(force, step);
    float share = 1.0f;
    for (int i = 0; i < kShortenings; ++i) {
        for (size_t v = 0; v < vertices; ++v) tried[v] = x[v] + share * step[v];
        forces(cloth, tried, there, nullptr);
        const double slope_there = inner_product(there, step);
        if (slope_there >= -0.1 * slope) break;
        share *= static_cast<float>(std::max(slope / (slope - slope_there), 0.1));
    }
    float farthest = 0.0f;
    for (size_t v = 0; v < vertices; ++v) {
        x[v] += share * step[v];
        farthest = std::max(farthest, share * glm::length(step[v]));
    }
    return farthest;
}

// ---------------------------------------------------------------- a frame
bool fits(const Model& model, const State* state) {
    return state && state->offset.size() == model.area.size() && state->length.size() == model.springs.size() &&
           state->clearance.size() == model.area.size();
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
    size_t touching = 0, taut = 0, known = 0;
    const size_t vertices = x.size();
    for (size_t v = 0; v < vertices; ++v) {
        const float way = glm::distance(x[v], pose.animated[v]);
        sum += way;
        out.report.offset_max = std::max(out.report.offset_max, way);
        touching += height_above(planes[v], x[v]) < kTouching * settings.room;
        known += v < out.state.body_hint.size() && out.state.body_hint[v] != kNone;
    }
    for (const Model::Spring& spring : model.springs)
        taut += glm::distance(x[spring.a], x[spring.b]) > settings.slack * spring.rest;
    out.report.offset_mean = static_cast<float>(sum / double(std::max<size_t>(vertices, 1)));
    out.report.touching = float(touching) / float(std::max<size_t>(vertices, 1));
    out.report.body_known = float(known) / float(std::max<size_t>(vertices, 1));
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

Result solve(const Model& model, const Settings& settings, const Paint& paint, std::span<const Vec3> positions,
             const PosedCollider* bodies, const State* before) {
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
            look_for_contacts(model, pose, x, out.state.contact_hint, planes);
        }
    }
    for (size_t v = 0; v < vertices; ++v) {
        out.state.offset.push_back(held ? before->offset[v] : pose.frame[v].to_local(x[v] - pose.animated[v]));
    }
    out.state.length = held ? before->length : pose.length;
    out.state.clearance = held ? before->clearance : pose.clearance;
    out.state.moved = out.report.moved;
    // The state keeps the equilibrium: what went on from a projected one would leave its balance in every frame.
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
