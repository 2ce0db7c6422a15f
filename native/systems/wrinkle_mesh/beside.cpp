// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_mesh/beside.h"

#include "base/smooth_step.h"
#include "surface/mesh/normals.h"

namespace rumple::wrinkle_mesh {
namespace {

// Unit: edges of the coarse mesh. Vertices within kNear of it move fully with it, vertices beyond kFar do not
// move, unless they follow their neighbours.
constexpr float kNear = 1.0f, kFar = 2.0f;

// Unit: edges of the coarse mesh. Vertices that lie within kBeside of it at rest lie beside it in every pose,
// vertices beyond kApart follow their neighbours.
constexpr float kBeside = 0.15f, kApart = 0.5f;

// Passes in which vertices that are not beside it follow their neighbours.
constexpr int kPasses = 8;

// Corrections of the vertices until the smooth surface passes where they should be.
constexpr int kCorrections = 6;

// A tangent that is shorter than this share of the side to the neighbour has no direction.
constexpr float kUpright = 0.1f;

// The frame of a vertex: its normal, and a tangent towards a neighbour. Zero where these are parallel.
TriangleFrame frame_at(std::span<const Vec3> positions, std::span<const Vec3> normals, Index v, Index along) {
    TriangleFrame frame;
    if (along == kNone) return frame;
    const Vec3 side = positions[along] - positions[v];
    const Vec3 tangent = side - glm::dot(side, normals[v]) * normals[v];
    const float length = glm::length(tangent);
    if (!(length > kUpright * glm::length(side))) return frame;
    frame.normal = normals[v], frame.tangent = tangent / length;
    frame.bitangent = glm::cross(frame.normal, frame.tangent);
    return frame;
}

// For the vertices with a share below 1: what is left of it, shared out among their neighbours.
void find_neighbours(const Surface& base, Beside& beside) {
    std::vector<std::vector<Index>> around(base.positions_rest.size());
    for (const Edge& e : base.edges) around[e.a].push_back(e.b), around[e.b].push_back(e.a);
    for (Index v = 0; v < Index(around.size()); ++v) {
        beside.along.push_back(around[v].empty() ? kNone : around[v].front());
        if (beside.share[v] >= 1.0f || around[v].empty()) continue;
        beside.partly.push_back(v);
        for (const Index other : around[v])
            beside.from_neighbours.add(other, (1.0f - beside.share[v]) / float(around[v].size()));
        beside.from_neighbours.end_row();
    }
}

// Vertices with a share below 1 take over from their neighbours what is left of it. own: of every vertex.
std::vector<Vec3> following(const Beside& beside, const std::vector<Vec3>& own) {
    std::vector<Vec3> out = own;
    const SparseRows& rows = beside.from_neighbours;
    for (int pass = 0; pass < kPasses; ++pass) {
        for (Index r = 0; r < rows.rows(); ++r) {
            const Index v = beside.partly[r];
            out[v] = beside.share[v] * own[v];
            for (Index k = rows.start[r]; k < rows.start[r + 1]; ++k)
                out[v] += rows.weight[k] * out[rows.index[k]];
        }
    }
    return out;
}

// The ways of vertices by which their smooth surface goes the given ways. Each correction leaves about half
// of the error.
std::vector<Vec3> cage_of(const SparseRows& smooth, const std::vector<Vec3>& ways) {
    std::vector<Vec3> cage = ways, reached(ways.size());
    for (int i = 0; i < kCorrections; ++i) {
        apply<Vec3>(smooth, cage, reached);
        for (size_t v = 0; v < ways.size(); ++v) cage[v] += ways[v] - reached[v];
    }
    return cage;
}

}  // namespace

float share_beside(float distance, float edge) {
    return 1.0f - smooth_step(kBeside * edge, kApart * edge, distance);
}

SparseRows scaled(const SparseRows& rows, std::span<const float> factor) {
    SparseRows out;
    for (Index r = 0; r < rows.rows(); ++r) {
        for (Index k = rows.start[r]; factor[r] > 0.0f && k < rows.start[r + 1]; ++k)
            out.add(rows.index[k], factor[r] * rows.weight[k]);
        out.end_row();
    }
    return out;
}

Beside find_beside(const Surface& dense, SparseRows smooth, const SparseRows& nearest,
                   std::span<const float> distance, std::span<const Vec3> finest_rest, float edge) {
    Beside out;
    std::vector<float> moved;
    for (const float d : distance) {
        out.share.push_back(share_beside(d, edge));
        moved.push_back(1.0f - smooth_step(kNear * edge, kFar * edge, d));
    }
    out.moves = scaled(nearest, moved);
    out.smooth = std::move(smooth);
    out.nearest = scaled(nearest, out.share);
    find_neighbours(dense, out);
    const std::vector<Vec3>& rest = dense.positions_rest;
    std::vector<Vec3> passed(rest.size()), beside(rest.size());
    apply<Vec3>(out.smooth, rest, passed);
    apply<Vec3>(out.nearest, finest_rest, beside);
    const std::vector<Vec3> normals = vertex_normals(dense, rest);
    for (Index v = 0; v < Index(rest.size()); ++v) {
        const TriangleFrame frame = frame_at(rest, normals, v, out.along[v]);
        out.way.push_back(frame.to_local(out.share[v] * passed[v] - beside[v]));
    }
    return out;
}

std::vector<Vec3> ways_beside(const Beside& beside, const Surface& dense, std::span<const Vec3> animated,
                              std::span<const Vec3> finest) {
    const std::vector<Vec3> normals = vertex_normals(dense, animated);
    std::vector<Vec3> passed(animated.size()), ways(animated.size());
    apply<Vec3>(beside.smooth, animated, passed);
    apply<Vec3>(beside.nearest, finest, ways);
    for (Index v = 0; v < Index(ways.size()); ++v) {
        const TriangleFrame frame = frame_at(animated, normals, v, beside.along[v]);
        ways[v] += frame.to_object(beside.way[v]) - beside.share[v] * passed[v];
        if (beside.share[v] > 0.0f) ways[v] /= beside.share[v];
    }
    return cage_of(beside.smooth, following(beside, ways));
}

std::vector<Vec3> displacements_of(const Beside& beside, std::span<const Vec3> finest) {
    std::vector<Vec3> own(beside.moves.rows());
    apply<Vec3>(beside.moves, finest, own);
    return following(beside, own);
}

}  // namespace rumple::wrinkle_mesh
