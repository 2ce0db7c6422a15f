// SPDX-License-Identifier: GPL-3.0-or-later
// Bases for the Wrinkle Field, and poses for them.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "systems/wrinkle_field/wrinkle_field.h"
#include "tests/meshes.h"

namespace rumple::tests {

using Pose3 = std::vector<Vec3>;

// The square of figure 15: side 1 m, 148 triangles, strongly irregular; 91 vertices, 32 of them on the
// border.
inline MeshData irregular_square() {
    constexpr Index n = 8;
    std::mt19937 random(1);
    const auto uniform = [&](float low, float high) {
        return low + (high - low) * static_cast<float>(random() % 10001) / 10000.0f;
    };
    MeshData mesh;
    for (Index j = 0; j <= n; ++j) {
        for (Index i = 0; i <= n; ++i) {
            const float x = i % n == 0 ? 0.0f : uniform(-0.3f, 0.3f),
                        y = j % n == 0 ? 0.0f : uniform(-0.3f, 0.3f);
            mesh.positions.push_back(Vec3(float(i) + x, float(j) + y, 0.0f) / float(n));
        }
    }
    std::vector<std::array<Index, 3>> triangles;
    for (Index j = 0; j < n; ++j) {
        for (Index i = 0; i < n; ++i) {
            const Index a = i + j * (n + 1), b = a + 1, c = b + n + 1, d = c - 1;
            const bool rising = random() % 2 == 0;
            triangles.push_back(rising ? std::array{a, b, c} : std::array{a, b, d});
            triangles.push_back(rising ? std::array{a, c, d} : std::array{b, c, d});
        }
    }
    for (int k = 0; k < 10; ++k) {  // a vertex more in the middle of every twelfth triangle
        const auto [a, b, c] = triangles[12 * k];
        const Index v = static_cast<Index>(mesh.positions.size());
        mesh.positions.push_back((mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) / 3.0f);
        triangles[12 * k] = {a, b, v};
        triangles.push_back({b, c, v});
        triangles.push_back({c, a, v});
    }
    for (const auto& [a, b, c] : triangles) mesh.add_polygon({a, b, c});
    return mesh;
}

// The same mesh with its vertices in another order: vertex v becomes order[v].
inline MeshData reordered(const MeshData& mesh, const std::vector<Index>& order) {
    MeshData out = mesh;
    for (size_t v = 0; v < order.size(); ++v) out.positions[order[v]] = mesh.positions[v];
    for (Index& v : out.corner_vertex) v = order[v];
    return out;
}

inline std::vector<Index> shuffled(size_t count) {
    std::vector<Index> order(count);
    std::iota(order.begin(), order.end(), 0);
    std::mt19937 random(7);
    for (size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random() % i]);
    return order;
}

template <typename Move>
Pose3 moved(const MeshData& mesh, Move&& move) {
    Pose3 pose = mesh.positions;
    for (Vec3& p : pose) p = move(p);
    return pose;
}

inline Pose3 scaled(const MeshData& mesh, const Vec3& factors) {
    return moved(mesh, [&](const Vec3& p) { return factors * p; });
}

inline Vec3 turned_and_shifted(const Vec3& p) {
    const Vec3 axis = glm::normalize(Vec3(1, 2, 3));
    const float c = std::cos(1.1f), s = std::sin(1.1f);
    return c * p + s * glm::cross(axis, p) + (1.0f - c) * glm::dot(axis, p) * axis + Vec3(0.5f, -0.25f, 1.0f);
}

// A base with its field.
struct Field {
    MeshData mesh;
    std::shared_ptr<const wrinkle_field::Model> model;
    wrinkle_field::Settings settings;
    wrinkle_field::Paint paint;

    explicit Field(MeshData data, const wrinkle_field::Plan& plan = {}, bool weld = true)
        : mesh(std::move(data)), model(wrinkle_field::build(tests::build(mesh, weld), plan)) {}

    wrinkle_field::Waves estimate_waves(const Pose3& pose, std::span<const Vec2> before = {}) const {
        return wrinkle_field::estimate_waves(*model, settings, paint, pose, before);
    }
    wrinkle_field::State solve(const Pose3& pose, const wrinkle_field::State* before = nullptr,
                               wrinkle_field::Report* report = nullptr) const {
        wrinkle_field::Report unused;
        return wrinkle_field::solve(*model, settings, paint, make_pose(*model, pose), before,
                                    report ? *report : unused);
    }
    wrinkle_field::Picture show(const Pose3& pose, const wrinkle_field::State& state,
                                const wrinkle_field::Profile& profile = wrinkle_field::sine(),
                                std::span<const float> gap = {}) const {
        return wrinkle_field::show(*model, shown_waves(pose, state, profile), profile, pose, state, gap);
    }
    wrinkle_field::Waves shown_waves(const Pose3& pose, const wrinkle_field::State& state,
                                     const wrinkle_field::Profile& profile = wrinkle_field::sine()) const {
        return wrinkle_field::shown_waves(*model, settings, profile, paint, pose, state);
    }
    // k of a welded vertex in rest space.
    Vec3 direction(const wrinkle_field::Waves& waves, size_t v) const {
        return waves.direction[v].x * model->tangent_rest[v] +
               waves.direction[v].y * model->bitangent_rest[v];
    }
};

inline float phase_between(float a, float b) {
    return std::abs(formulas::wrapped(a - b));
}

}  // namespace rumple::tests
