// SPDX-License-Identifier: GPL-3.0-or-later
// The shared code of contact with bodies and of contact of the cloth with itself: boxes and normals of
// triangles in a pose. Internal to contact.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "base/array.h"
#include "base/solve_team.h"
#include "base/tolerances.h"
#include "base/unset_vector.h"

namespace rumple {

struct Box {
    Row low{all_lanes(std::numeric_limits<float>::max())};
    Row high{all_lanes(std::numeric_limits<float>::lowest())};

    void add(const Box& other) {
        low.xyz = least(low.xyz, other.low.xyz);
        high.xyz = most(high.xyz, other.high.xyz);
    }
    void add(const Row& p) { add(Box{p, p}); }
};

// unit_or_zero() of base/unit_vector.h, with the same bits.
inline Vec3Lanes unit_or_zero(const Vec3Lanes& v, float least) {
    const Lanes length = square_root(dot(v, v));
    const Vec3Lanes unit{v.x / length, v.y / length, v.z / length};
    return choose(length > all_lanes(least), unit, {});
}

// The corners at every vertex, in the order of triangles. Corner k of triangle t is 3 t + k. Built once.
struct CornersOfVertices {
    std::vector<Index> start;  // vertices + 1
    std::vector<Index> corner;

    CornersOfVertices() = default;
    CornersOfVertices(size_t vertices, std::span<const std::array<Index, 3>> triangles)
        : start(vertices + 1, 0), corner(3 * triangles.size()) {
        for (const auto& t : triangles)
            for (const Index v : t) ++start[v + 1];
        for (size_t v = 0; v < vertices; ++v) start[v + 1] += start[v];
        std::vector<Index> next(start.begin(), start.end() - 1);
        for (size_t t = 0; t < triangles.size(); ++t)
            for (size_t k = 0; k < 3; ++k) corner[next[triangles[t][k]]++] = static_cast<Index>(3 * t + k);
    }
    std::span<const Index> of(size_t vertex) const {
        return std::span(corner).subspan(start[vertex], start[vertex + 1] - start[vertex]);
    }
};

// Unit normals, or zero without area.
struct TriangleNormals {
    UnsetVector<Row> of_face;
    std::vector<Row> of_vertex;  // mean weighted by area

    // positions: from to_rows().
    TriangleNormals(std::span<const Row> positions, std::span<const std::array<Index, 3>> triangles,
                    const CornersOfVertices& corners)
        : of_face(in_fours(triangles.size())), of_vertex(positions.size()) {
        for_each_four_shared(triangles.size(), [&](size_t first, size_t count) {
            std::array<std::array<Row, kLanes>, 3> corner;
            for (size_t k = 0; k < count; ++k)
                for (int i = 0; i < 3; ++i) corner[i][k] = positions[triangles[first + k][i]];
            const Vec3Lanes a = columns(corner[0]), b = columns(corner[1]), c = columns(corner[2]);
            store_rows(cross(b - a, c - a), four_from(of_face, first));
        });
        for_each_index(corners.start.size() - 1, kLeastSteps, [&](size_t v) {
            for (const Index c : corners.of(v)) of_vertex[v].xyz += of_face[c / 3].xyz;
        });
        make_unit(of_face);
        make_unit(of_vertex);
    }

  private:
    // The number of rows is a multiple of four.
    static void make_unit(std::span<Row> rows) {
        for_each_four_shared(rows.size(), [&](size_t first, size_t) {
            const std::span<Row, kLanes> four = four_from(rows, first);
            store_rows(unit_or_zero(columns(four), kSmallestArea), four);
        });
    }
};

// The middle of every triangle.
inline std::vector<Vec3> centres_of(std::span<const Vec3> positions,
                                    std::span<const std::array<Index, 3>> triangles) {
    std::vector<Vec3> out;
    for (const auto& t : triangles)
        out.push_back((positions[t[0]] + positions[t[1]] + positions[t[2]]) / 3.0f);
    return out;
}

}  // namespace rumple
