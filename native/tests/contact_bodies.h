// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies for tests of contact: triangles, and poses of them; and random vectors.
#pragma once

#include <array>
#include <memory>
#include <numbers>
#include <vector>

#include "base/random.h"
#include "surface/contact/collider.h"
#include "tests/meshes.h"

namespace rumple::tests {

// Numbers in [-1, 1], one after the other.
class Random {
  public:
    explicit Random(std::uint32_t seed) : seed_(seed) {}
    float next() { return noise(seed_, count_++); }
    Vec3 vector() {
        const float x = next(), y = next(), z = next();
        return {x, y, z};
    }
    Vec3 direction() {
        for (;;) {
            const Vec3 v = vector();
            const float length = glm::length(v);
            if (length > 0.1f && length < 1.0f) return v / length;
        }
    }

  private:
    std::uint32_t seed_, count_ = 0;
};

struct Body {
    std::vector<Vec3> positions;
    std::vector<std::array<Index, 3>> triangles;

    Collider collider() const { return Collider(positions, triangles); }
};

inline Body body_of(const MeshData& mesh) {
    Body body{mesh.positions, {}};
    const auto vertex = [&](size_t i) { return mesh.corner_vertex[mesh.triangle_corner[i]]; };
    for (size_t k = 0; k < mesh.triangle_corner.size(); k += 3)
        body.triangles.push_back({vertex(k), vertex(k + 1), vertex(k + 2)});
    return body;
}

// A sphere around the origin, of rings of triangles around z; every vertex moved outwards by up to `bumps`
// radii. The lowest `open` rings are left out: a hole.
inline Body sphere(Index rings, Index around, float radius, float bumps = 0.0f, Index open = 0) {
    Body body;
    const auto add = [&](double polar, double angle) {
        const Vec3 way(std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle), std::cos(polar));
        const auto v = static_cast<std::uint32_t>(body.positions.size());
        body.positions.push_back(radius * (1.0f + bumps * noise(5, v)) * way);
    };
    const double pi = std::numbers::pi;
    add(0.0, 0.0);
    for (Index j = 1; j < rings; ++j) {
        for (Index i = 0; i < around; ++i) add(pi * j / rings, 2.0 * pi * i / around);
    }
    add(pi, 0.0);
    const auto at = [&](Index j, Index i) {
        if (j == 0) return Index(0);
        return j == rings ? 1 + (rings - 1) * around : 1 + (j - 1) * around + i % around;
    };
    for (Index j = 0; j < rings - open; ++j) {
        for (Index i = 0; i < around; ++i) {
            if (j + 1 < rings || open > 0)
                body.triangles.push_back({at(j, i), at(j + 1, i), at(j + 1, i + 1)});
            if (j > 0) body.triangles.push_back({at(j, i), at(j + 1, i + 1), at(j, i + 1)});
        }
    }
    return body;
}

// A plane across z at that height that faces down, wider than half a metre about (x, y) = (0.15, 0.15).
inline Body ceiling(float height) {
    Body body;
    for (const auto& [x, y] : {std::pair{-0.5f, -0.5f}, {-0.5f, 0.8f}, {0.8f, 0.8f}, {0.8f, -0.5f}})
        body.positions.push_back({x, y, height});
    body.triangles = {{0, 1, 2}, {0, 2, 3}};
    return body;
}

}  // namespace rumple::tests
