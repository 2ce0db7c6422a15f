// SPDX-License-Identifier: GPL-3.0-or-later
// A base with its fine mesh, and poses for it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "systems/wrinkle_mesh/wrinkle_mesh.h"
#include "tests/meshes.h"

namespace rumple::tests {

using Pose3 = std::vector<Vec3>;

// Metres: roundings of single precision on bodies of about a metre.
inline constexpr float kRounding = 2e-6f;

// Every position moved.
template <typename Move>
Pose3 each_moved(Pose3 pose, Move&& move) {
    for (Vec3& p : pose) p = move(p);
    return pose;
}

struct Cloth {
    MeshData mesh;
    std::shared_ptr<const wrinkle_mesh::Model> model;

    explicit Cloth(MeshData data, Index level = 2, AttachmentKind kind = AttachmentKind::kLimit,
                   Index steps = 0)
        : mesh(std::move(data)) {
        wrinkle_mesh::Source source;
        source.level = level;
        model = wrinkle_mesh::build(tests::build(mesh), source, kind, steps);
    }
    Cloth(MeshData data, const wrinkle_mesh::Source& source, AttachmentKind kind, Index steps = 0)
        : mesh(std::move(data)), model(wrinkle_mesh::build(tests::build(mesh), source, kind, steps)) {}

    wrinkle_mesh::State solve(const Pose3& pose, const wrinkle_mesh::Settings& settings,
                              const wrinkle_mesh::State* before = nullptr,
                              wrinkle_mesh::Report* report = nullptr) const {
        wrinkle_mesh::Report unused;
        return wrinkle_mesh::solve(*model, settings, {}, {pose}, before, report ? *report : unused);
    }
    wrinkle_mesh::Picture show(const Pose3& pose, const wrinkle_mesh::Settings& settings,
                               const wrinkle_mesh::State& state) const {
        wrinkle_mesh::Picture picture;
        wrinkle_mesh::show(*model, settings, {pose}, state, picture);
        return picture;
    }

    template <typename Move>
    Pose3 moved(Move&& move) const {
        return each_moved(mesh.positions, move);
    }
    // The base squeezed along x and bent about z.
    Pose3 squeezed(float factor, float bend = 0.0f) const {
        return moved([=](Vec3 p) {
            p.x *= factor;
            const float angle = bend * p.x;
            return Vec3(p.x * std::cos(angle) - p.y * std::sin(angle),
                        p.x * std::sin(angle) + p.y * std::cos(angle), p.z);
        });
    }
    Pose3 sheared(float amount) const {
        return moved(
            [=](const Vec3& p) { return p + Vec3(amount * p.y, 0.5f * amount * p.x, amount * p.x); });
    }
    // Everything beyond x = at turned about the y axis there: a hinge, which an elbow without weights would
    // be.
    Pose3 folded(float at, float angle) const {
        return moved([=](const Vec3& p) {
            if (p.x <= at) return p;
            const float x = p.x - at;
            return Vec3(at + x * std::cos(angle) - p.z * std::sin(angle), p.y,
                        x * std::sin(angle) + p.z * std::cos(angle));
        });
    }
};

inline float largest(const std::vector<Vec3>& vectors) {
    float most = 0.0f;
    for (const Vec3& v : vectors) most = std::max(most, glm::length(v));
    return most;
}

inline bool all_finite(const std::vector<Vec3>& vectors) {
    return std::all_of(vectors.begin(), vectors.end(), [](const Vec3& v) {
        return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    });
}

template <typename T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

inline bool same_bits(const wrinkle_mesh::State& a, const wrinkle_mesh::State& b) {
    return same_bits(a.offset, b.offset) && same_bits(a.solved_length, b.solved_length);
}

}  // namespace rumple::tests
