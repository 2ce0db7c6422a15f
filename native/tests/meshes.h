// SPDX-License-Identifier: GPL-3.0-or-later
// Makers of small meshes. All faces are wound counterclockwise seen from outside
// (cube, tube) or from above (grid); triangles are fans.
#pragma once

#include <array>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <random>
#include <vector>

#include "surface/mesh/topology.h"

namespace rumple::tests {

struct MeshData {
    std::vector<Vec3> positions;
    std::vector<Index> polygon_start{0};
    std::vector<Index> corner_vertex;
    std::vector<Index> triangle_corner;

    void add_polygon(std::initializer_list<Index> vertices) {
        const Index begin = polygon_start.back();
        corner_vertex.insert(corner_vertex.end(), vertices);
        polygon_start.push_back(static_cast<Index>(corner_vertex.size()));
        for (Index k = 1; k + 1 < static_cast<Index>(vertices.size()); ++k) {
            triangle_corner.insert(triangle_corner.end(), {begin, begin + k, begin + k + 1});
        }
    }
    SurfaceInput input(bool weld_seams = true) const {
        return {positions, polygon_start, corner_vertex, triangle_corner, weld_seams};
    }
};

inline Surface build(const MeshData& mesh, bool weld_seams = true) {
    return build_surface(mesh.input(weld_seams));
}

// nx by ny square faces of side `size` metres in the plane z = 0, from the
// origin. Vertex (i, j) is i + j (nx + 1), face (i, j) is i + j nx and begins at
// vertex (i, j), as does its diagonal.
inline MeshData grid(Index nx, Index ny, float size) {
    MeshData mesh;
    for (Index j = 0; j <= ny; ++j) {
        for (Index i = 0; i <= nx; ++i) mesh.positions.push_back(size * Vec3(i, j, 0));
    }
    for (Index j = 0; j < ny; ++j) {
        for (Index i = 0; i < nx; ++i) {
            const Index v = i + j * (nx + 1);
            mesh.add_polygon({v, v + 1, v + nx + 2, v + nx + 1});
        }
    }
    return mesh;
}

// Adds the quads of another mesh, moved.
inline void add_part(MeshData& mesh, const MeshData& part, const Vec3& move) {
    const Index first = static_cast<Index>(mesh.positions.size());
    for (const Vec3& p : part.positions) mesh.positions.push_back(p + move);
    for (size_t k = 0; k < part.corner_vertex.size(); k += 4) {
        const Index* corner = &part.corner_vertex[k];
        mesh.add_polygon({first + corner[0], first + corner[1], first + corner[2], first + corner[3]});
    }
}

// A tube around the x axis, open at both ends: `around` >= 3 faces in a ring,
// `along` rings over `length` metres. Vertex (i, j) is i + j around, j along x.
inline MeshData tube(Index around, Index along, float radius, float length) {
    MeshData mesh;
    for (Index j = 0; j <= along; ++j) {
        for (Index i = 0; i < around; ++i) {
            const double angle = 2.0 * std::numbers::pi * i / around;
            const float y = static_cast<float>(std::cos(angle)), z = static_cast<float>(std::sin(angle));
            mesh.positions.push_back({length * j / along, radius * y, radius * z});
        }
    }
    for (Index j = 0; j < along; ++j) {
        for (Index i = 0; i < around; ++i) {
            const Index next = (i + 1) % around, v = j * around, w = v + around;
            mesh.add_polygon({v + i, v + next, w + next, w + i});
        }
    }
    return mesh;
}

// The cube [-1, 1]^3: vertex index = x + 2 y + 4 z with 1 for the positive side.
inline MeshData cube() {
    MeshData mesh;
    for (Index v = 0; v < 8; ++v) {
        mesh.positions.push_back(2.0f * Vec3(v & 1, (v >> 1) & 1, v >> 2) - 1.0f);
    }
    for (const auto& f : {std::array<Index, 4>{0, 2, 3, 1},
                          {4, 5, 7, 6},
                          {0, 1, 5, 4},
                          {2, 6, 7, 3},
                          {0, 4, 6, 2},
                          {1, 3, 7, 5}}) {
        mesh.add_polygon({f[0], f[1], f[2], f[3]});
    }
    return mesh;
}

// Every face with vertices of its own, as a game mesh split at all its seams.
inline MeshData split_at_seams(const MeshData& mesh) {
    MeshData split = mesh;
    split.positions.clear();
    for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c) {
        split.positions.push_back(mesh.positions[mesh.corner_vertex[c]]);
        split.corner_vertex[c] = static_cast<Index>(c);
    }
    return split;
}

inline MeshData seam_split_cube() {
    return split_at_seams(cube());
}

// The same surface with every triangle a face.
inline MeshData triangulated(const MeshData& mesh) {
    MeshData result;
    result.positions = mesh.positions;
    for (std::size_t k = 0; k < mesh.triangle_corner.size(); k += 3) {
        const auto vertex = [&](std::size_t i) { return mesh.corner_vertex[mesh.triangle_corner[k + i]]; };
        result.add_polygon({vertex(0), vertex(1), vertex(2)});
    }
    return result;
}

// Every vertex moved by up to `amount` metres in each coordinate.
inline MeshData shaken(MeshData mesh, float amount, unsigned seed) {
    std::mt19937 random(seed);  // its sequence is the same everywhere, unlike the distributions
    const auto next = [&] { return amount * (static_cast<float>(random() % 20001) / 10000.0f - 1.0f); };
    for (Vec3& p : mesh.positions) {
        const float x = next(), y = next(), z = next();
        p += Vec3(x, y, z);
    }
    return mesh;
}

// Two meshes of quads in one; the second one is moved.
inline MeshData with_part(MeshData mesh, const MeshData& part, const Vec3& shift) {
    const Index first = static_cast<Index>(mesh.positions.size());
    for (const Vec3& p : part.positions) mesh.positions.push_back(p + shift);
    for (size_t c = 0; c < part.corner_vertex.size(); c += 4) {
        const Index* v = &part.corner_vertex[c];
        mesh.add_polygon({first + v[0], first + v[1], first + v[2], first + v[3]});
    }
    return mesh;
}

}  // namespace rumple::tests
