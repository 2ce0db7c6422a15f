// SPDX-License-Identifier: GPL-3.0-or-later
// A coarse mesh that becomes cloth, poses for it, and the energy that it comes to rest in.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "surface/cloth/base_cloth.h"
#include "surface/output/attachments.h"
#include "tests/contact_bodies.h"
#include "tests/meshes.h"

namespace rumple::tests {

using Points = std::vector<Vec3>;

struct Garment {
    MeshData mesh;
    std::shared_ptr<const base_cloth::Model> model;

    explicit Garment(MeshData data) : mesh(std::move(data)), model(base_cloth::build(tests::build(mesh))) {}

    base_cloth::Result solve(const base_cloth::Settings& settings, const Points& pose,
                             const base_cloth::State* state = nullptr, const base_cloth::Paint& paint = {},
                             const PosedCollider* bodies = nullptr) const {
        return base_cloth::solve(*model, settings, paint, pose, bodies, state);
    }

    // Solves the same pose until it is held: how many frames that took, or -1 when `most` were not enough.
    int settle(const base_cloth::Settings& settings, const Points& pose, base_cloth::Result& result,
               const base_cloth::Paint& paint = {}, const PosedCollider* bodies = nullptr,
               int most = 15) const {
        for (int frame = 1; frame <= most; ++frame) {
            result = solve(settings, pose, &result.state, paint, bodies);
            if (result.report.steps == 0) return frame;
        }
        return -1;
    }

    template <typename Move>
    Points moved(Move&& move) const {
        Points pose = mesh.positions;
        for (Vec3& p : pose) p = move(p);
        return pose;
    }
    // Squeezed along x, bent about y, sheared: every edge becomes longer or shorter.
    Points crumpled(float squeeze, float bend, float shear) const {
        return moved([=](Vec3 p) {
            const float x = squeeze * p.x + shear * p.y, angle = bend * x;
            return Vec3(x * std::cos(angle) - p.z * std::sin(angle), p.y,
                        x * std::sin(angle) + p.z * std::cos(angle));
        });
    }
};

inline std::vector<MeshData> garment_meshes() {
    return {tube(16, 10, 0.1f, 0.5f), grid(9, 7, 0.04f), triangulated(tube(12, 8, 0.1f, 0.4f))};
}

inline base_cloth::Settings weightless() {
    base_cloth::Settings settings;
    settings.gravity = Vec3(0.0f);
    return settings;
}

// Held a little by its animation, and pulled along z, m/s^2.
inline base_cloth::Settings falling(float gravity) {
    base_cloth::Settings settings;
    settings.follow = 20.0f;
    settings.gravity = {0.0f, 0.0f, gravity};
    return settings;
}

// Contact and the edge of the room are far away: nothing but the energy decides.
inline base_cloth::Settings without_contact() {
    base_cloth::Settings settings;
    settings.room = 0.08f;
    settings.clearance.unknown = 0.09f;
    return settings;
}

// Springs that float32 can balance to a share of 1e-5: for laws about what the solver is handed, not about
// it.
inline void soften(base_cloth::Settings& s) {
    s.stretch = 50.0f;
    s.shear = 5.0f;
    s.compression = 0.3f;
    s.folded = s.smoothing = s.hem_share = 1.0f;
}

// Of one spring over its weight: figure 6 of the paper, and the strain limit.
inline double spring_energy(const base_cloth::Settings& s, bool diagonal, double firm, double length,
                            double rest) {
    const auto half_square = [](double x) { return 0.5 * x * x; };
    if (length > rest) {
        const double k = diagonal ? s.shear : s.stretch;
        const double beyond = std::max(length - (1.0 + double(s.strain_limit)) * rest, 0.0);
        return k * half_square(length - rest) + 9.0 * k * half_square(beyond);
    }
    if (diagonal) return 0.0;
    const double folded = std::min(length - double(s.compression_limit) * rest, 0.0);
    return firm * (s.compression * half_square(length - rest) +
                   (double(s.folded) - double(s.compression)) * half_square(folded));
}

// The factor of compression, folded and smoothing that a spring has.
inline double compression_scale(const base_cloth::Settings& s, const base_cloth::Model::Spring& spring) {
    const double tight = std::min(double(s.tube_radius) * double(spring.curvature), 1.0);
    return std::max(tight * tight * tight * tight, double(s.flat_share));
}

// Share of smoothing that a spring has beside this one, with nothing painted: less near hems.
inline double of_smoothing(const base_cloth::Model& model, const base_cloth::Settings& s,
                           const base_cloth::Model::Spring& spring) {
    const auto share = [&](Index v) {
        return base_cloth::share_of_smoothing(model.near_hems[v], s.hem_share, 0.0f, 1.4f * s.tube_radius);
    };
    return double(std::min(share(spring.a), share(spring.b)));
}

// The energy of cloth that touches nothing, with nothing painted: springs, smoothing, follow, gravity. x,
// animated: per vertex (a mesh without seams).
inline double energy(const base_cloth::Model& model, const base_cloth::Settings& s, const Points& animated,
                     const std::vector<glm::dvec3>& x) {
    double sum = 0.0;
    Points normals(x.size());
    vertex_normals(model.surface, animated, normals);
    const double share = s.slide_room > s.room ? double(s.room) / double(s.slide_room) : 1.0;
    for (size_t v = 0; v < x.size(); ++v) {
        const glm::dvec3 away = x[v] - glm::dvec3(animated[v]), n(normals[v]);
        const glm::dvec3 counted = share * away + (1.0 - share) * glm::dot(n, away) * n;
        const double d2 = glm::dot(away, away), used2 = glm::dot(counted, counted),
                     room2 = double(s.room) * double(s.room);
        const double back = 0.5 * d2 + 15.0 / 6.0 * used2 * used2 * used2 / (room2 * room2);
        sum += double(model.area[v]) * (s.follow * back - glm::dot(glm::dvec3(s.gravity), away));
    }
    for (const base_cloth::Model::Spring& spring : model.springs) {
        const glm::dvec3 way = x[spring.b] - x[spring.a];
        const glm::dvec3 along = glm::normalize(glm::dvec3(animated[spring.b] - animated[spring.a]));
        const glm::dvec3 turned = way - glm::dot(along, way) * along;
        const double hang = glm::dot(glm::dvec3(s.hang), along);
        const double slack = 1.0 + (double(s.slack) - 1.0) * (1.0 - hang * hang);
        const double firm = compression_scale(s, spring);
        double e = spring_energy(s, spring.diagonal, firm, glm::length(way), slack * double(spring.rest));
        const double smoothing = double(s.smoothing) * firm * of_smoothing(model, s, spring);
        if (!spring.diagonal) e += 0.5 * smoothing * glm::dot(turned, turned);
        sum += spring.weight * e;
    }
    return sum;
}

inline std::vector<glm::dvec3> in_double(const Points& points) {
    return {points.begin(), points.end()};
}

inline float farthest(const Points& a, const Points& b) {
    float most = 0.0f;
    for (size_t v = 0; v < a.size(); ++v) most = std::max(most, glm::distance(a[v], b[v]));
    return most;
}

template <typename T>
bool equal_bits(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

inline bool equal_bits(const base_cloth::Result& a, const base_cloth::Result& b) {
    return equal_bits(a.positions, b.positions) && equal_bits(a.gap, b.gap) &&
           equal_bits(a.state.offset, b.state.offset) && equal_bits(a.state.length, b.state.length) &&
           equal_bits(a.state.clearance, b.state.clearance);
}

}  // namespace rumple::tests
