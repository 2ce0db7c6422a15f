// SPDX-License-Identifier: GPL-3.0-or-later
// The least energy of docs/base_cloth.md: Newton's method, each step by preconditioned conjugate gradients
// (Shewchuk 1994, B3).
#include "surface/cloth/equilibrium.h"

#include <algorithm>
#include <cmath>

#include "base/tolerances.h"

namespace rumple::base_cloth {
namespace {

constexpr float kBeyondLimit = 10.0f;  // stiffness beyond the strain limit
constexpr float kWall = 15.0f;         // how much the pull back grows towards the edge of the room
constexpr float kContact = 2e4f;       // stiffness of the inner surface, 1/s^2
constexpr double kResidual = 0.05;     // conjugate gradients stop at this share of the force they began with
constexpr int kShortenings = 4;        // of a step that went too far

// Force along a spring over its weight (towards the other end is positive), and its slope: figure 6 of the
// paper.
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
    return {settings.compression * longer + (settings.folded - settings.compression) * folded,
            settings.folded};
}

// The energy's Hessian, made positive definite: as the springs and vertices have it.
struct Hessian {
    struct Spring {
        Vec3 direction;
        float along;  // beyond `across`
        float across;
    };
    struct Vertex {
        float back;     // times identity
        Vec3 wall;      // times itself: the pull back grows along the way
        float contact;  // times normal x normal, of what is worn under it
        float ahead;    // the same of what is ahead
    };
    std::vector<Spring> springs;
    std::vector<Vertex> vertices;
    std::vector<glm::mat3> inverse_diagonal;  // preconditioner: of the 3x3 blocks
};

// A vertex without area, of no polygon or of flat ones, has neither weight nor force: it stays.
glm::mat3 inverse_or_nothing(const glm::mat3& block) {
    const glm::mat3 inverse = glm::inverse(block);
    const Vec3 sum = inverse[0] + inverse[1] + inverse[2];
    return std::isfinite(sum.x + sum.y + sum.z) ? inverse : glm::mat3(0.0f);
}

// The forces at x; the Hessian too, where one is asked for.
void forces(const Cloth& cloth, std::span<const Vec3> x, std::span<Vec3> out, Hessian* hessian) {
    const auto& [model, settings, pose, planes, inertia] = cloth;
    for (size_t v = 0; v < x.size(); ++v) {
        const Vec3 away = x[v] - pose.animated[v];
        const float room_used =
            pose.room[v] > 0.0f ? glm::dot(away, away) / (pose.room[v] * pose.room[v]) : 0.0f;
        const float back = model.area[v] * pose.follow[v] * (1.0f + kWall * room_used * room_used);
        const float firm = model.area[v] * std::max(kContact, pose.follow[v]);
        const float inward = -height_above(planes[v], x[v]), beyond = -height_above(pose.ahead[v], x[v]);
        const float contact = inward > 0.0f ? firm : 0.0f, ahead = beyond > 0.0f ? firm : 0.0f;
        out[v] = model.area[v] * settings.gravity - back * away + contact * inward * planes[v].normal +
                 ahead * beyond * pose.ahead[v].normal;
        if (inertia) out[v] += inertia->push[v] - inertia->resist[v] * (x[v] - inertia->from[v]);
        if (!hessian) continue;
        const float growth = 4.0f * model.area[v] * pose.follow[v] * kWall * room_used;
        const Vec3 wall = room_used > 0.0f ? std::sqrt(growth) / pose.room[v] * away : Vec3(0.0f);
        hessian->vertices[v] = {back, wall, contact, ahead};
        hessian->inverse_diagonal[v] = glm::mat3(back) + glm::outerProduct(wall, wall) +
                                       contact * glm::outerProduct(planes[v].normal, planes[v].normal) +
                                       ahead * glm::outerProduct(pose.ahead[v].normal, pose.ahead[v].normal);
        if (inertia) hessian->inverse_diagonal[v] += inertia->resist[v];
    }
    for (size_t s = 0; s < model.springs.size(); ++s) {
        const auto& [a, b, rest, weight, diagonal] = model.springs[s];
        const Vec3 displacement = x[b] - x[a];
        const float length = std::max(std::sqrt(glm::dot(displacement, displacement)), kShortestEdge);
        const Vec3 n = displacement / length;
        const Tension t = tension(settings, diagonal, length, settings.slack * rest);
        const float smooth = diagonal ? 0.0f : settings.smoothing;
        const Vec3 pull =
            weight * (t.force * n + smooth * (displacement - (pose.animated[b] - pose.animated[a])));
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
        for (glm::mat3& block : hessian->inverse_diagonal) block = inverse_or_nothing(block);
    }
}

void multiply(const Cloth& cloth, const Hessian& hessian, std::span<const Vec3> p, std::span<Vec3> out) {
    for (size_t v = 0; v < p.size(); ++v) {
        const auto& [back, wall, contact, ahead] = hessian.vertices[v];
        const Vec3 &n = cloth.planes[v].normal, &m = cloth.pose.ahead[v].normal;
        out[v] = back * p[v] + glm::dot(wall, p[v]) * wall + contact * glm::dot(n, p[v]) * n +
                 ahead * glm::dot(m, p[v]) * m;
        if (cloth.inertia) out[v] += cloth.inertia->resist[v] * p[v];
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

}  // namespace

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
    float fraction = 1.0f;
    for (int i = 0; i < kShortenings; ++i) {
        for (size_t v = 0; v < vertices; ++v) tried[v] = x[v] + fraction * step[v];
        forces(cloth, tried, there, nullptr);
        const double slope_there = inner_product(there, step);
        if (slope_there >= -0.1 * slope) break;
        fraction *= static_cast<float>(std::max(slope / (slope - slope_there), 0.1));
    }
    float farthest = 0.0f;
    for (size_t v = 0; v < vertices; ++v) {
        x[v] += fraction * step[v];
        farthest = std::max(farthest, fraction * glm::length(step[v]));
    }
    return farthest;
}

}  // namespace rumple::base_cloth
