// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_mesh/binding.h"

#include "base/smooth_step.h"
#include "base/solve_team.h"
#include "surface/mesh/normals.h"

namespace rumple::wrinkle_mesh {
namespace {

// Unit: edges of the coarse mesh. Vertices within kNear of it move fully with it, vertices beyond kFar do not
// move, unless they follow their neighbours.
constexpr float kNear = 1.0f, kFar = 2.0f;

// Unit: edges of the coarse mesh. Vertices within kBound of it at rest are bound to it, vertices beyond
// kUnbound follow their neighbours.
constexpr float kBound = 0.15f, kUnbound = 0.5f;

// Passes in which vertices that are not bound follow their neighbours.
constexpr int kPasses = 8;

// Corrections of the vertices until the smooth surface passes where they should be.
constexpr int kCorrections = 6;

// A tangent that is shorter than this share of the side to the neighbour has no direction.
constexpr float kUpright = 0.1f;

// The frame of a vertex: its normal, and a tangent towards a neighbour. Zero where these are parallel.
SurfaceFrame frame_at(std::span<const Vec3> positions, std::span<const Vec3> normals, Index v, Index along) {
    if (along == kNone) return {};
    const Vec3 side = positions[along] - positions[v];
    return frame_towards(normals[v], side, kUpright * glm::length(side));
}

// For the vertices with a share below 1: what is left of it, shared out among their neighbours.
void find_neighbours(const Surface& base, Binding& binding) {
    std::vector<std::vector<Index>> around(base.positions_rest.size());
    for (const Edge& e : base.edges) around[e.a].push_back(e.b), around[e.b].push_back(e.a);
    for (Index v = 0; v < Index(around.size()); ++v) {
        binding.along.push_back(around[v].empty() ? kNone : around[v].front());
        if (binding.share[v] >= 1.0f || around[v].empty()) continue;
        binding.partly.push_back(v);
        for (const Index other : around[v])
            binding.from_neighbours.add(other, (1.0f - binding.share[v]) / float(around[v].size()));
        binding.from_neighbours.end_row();
    }
}

// Vertices with a share below 1 take over from their neighbours what is left of it. own: of every vertex.
std::vector<Vec3> following(const Binding& binding, const std::vector<Vec3>& own) {
    std::vector<Vec3> out = own;
    const SparseRows& rows = binding.from_neighbours;
    for (int pass = 0; pass < kPasses; ++pass) {
        for (Index r = 0; r < rows.rows(); ++r) {
            const Index v = binding.partly[r];
            out[v] = binding.share[v] * own[v];
            for (Index k = rows.start[r]; k < rows.start[r + 1]; ++k)
                out[v] += rows.weight[k] * out[rows.index[k]];
        }
    }
    return out;
}

// The offsets of vertices whose smooth surface gets the given offsets. Each correction leaves about half of
// the error.
std::vector<Vec3> cage_of(const SparseRows& smooth, const std::vector<Vec3>& offsets) {
    std::vector<Vec3> cage = offsets, reached(offsets.size());
    for (int i = 0; i < kCorrections; ++i) {
        apply(smooth, to_rows(cage), reached);
        for (size_t v = 0; v < offsets.size(); ++v) cage[v] += offsets[v] - reached[v];
    }
    return cage;
}

}  // namespace

float bound_share(float distance, float edge) {
    return 1.0f - smooth_step(kBound * edge, kUnbound * edge, distance);
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

Binding bind_to_finest(const Surface& base, SparseRows smooth, const SparseRows& nearest,
                       std::span<const float> distance, std::span<const Vec3> finest_rest, float edge) {
    Binding out;
    std::vector<float> moved;
    for (const float d : distance) {
        out.share.push_back(bound_share(d, edge));
        moved.push_back(1.0f - smooth_step(kNear * edge, kFar * edge, d));
    }
    out.moves = scaled(nearest, moved);
    out.smooth = std::move(smooth);
    out.nearest = scaled(nearest, out.share);
    find_neighbours(base, out);
    const std::vector<Vec3>& rest = base.positions_rest;
    std::vector<Vec3> passed(rest.size()), nearest_at(rest.size());
    apply<Vec3>(out.smooth, rest, passed);
    apply<Vec3>(out.nearest, finest_rest, nearest_at);
    const std::vector<Vec3> normals = vertex_normals(base, rest);
    for (Index v = 0; v < Index(rest.size()); ++v) {
        const SurfaceFrame frame = frame_at(rest, normals, v, out.along[v]);
        out.rest_offset.push_back(frame.to_local(out.share[v] * passed[v] - nearest_at[v]));
    }
    return out;
}

std::vector<Vec3> bound_offsets(const Binding& binding, const Surface& base, std::span<const Vec3> animated,
                                std::span<const Vec3> finest) {
    const std::vector<Vec3> normals = vertex_normals(base, animated);
    std::vector<Vec3> passed(animated.size()), offsets(animated.size());
    apply(binding.smooth, to_rows(animated), passed);
    apply(binding.nearest, to_rows(finest), offsets);
    for (Index v = 0; v < Index(offsets.size()); ++v) {
        const SurfaceFrame frame = frame_at(animated, normals, v, binding.along[v]);
        offsets[v] += frame.to_object(binding.rest_offset[v]) - binding.share[v] * passed[v];
        if (binding.share[v] > 0.0f) offsets[v] /= binding.share[v];
    }
    return cage_of(binding.smooth, following(binding, offsets));
}

std::vector<Vec3> bound_displacements(const Binding& binding, std::span<const Vec3> finest) {
    std::vector<Vec3> own(binding.moves.rows());
    apply(binding.moves, to_rows(finest), own);
    return following(binding, own);
}

}  // namespace rumple::wrinkle_mesh
