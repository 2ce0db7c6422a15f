// SPDX-License-Identifier: GPL-3.0-or-later
// The constraints of a single mesh as passes over its pairs, for a solver on the graphics card: each pass
// projects at most one pair of a vertex. One iteration of all passes in their order projects every pair after
// the same pairs as relax_by_blocks(), so it has the same result but for rounding.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "systems/wrinkle_mesh/wrinkle_mesh.h"

namespace rumple::wrinkle_mesh {

// Vertices are in the order of Model::vertex_of_row. Lengths: object units.
struct Passes {
    std::vector<std::array<Index, 3>> triangles;      // welded vertices of the base's triangles
    std::vector<Index> vertex;                        // solved vertex
    std::vector<std::array<Index, 3>> base_vertices;  // welded vertices of the triangle of its attachment
    std::vector<Vec2> weights;                        // of the second and the third of them
    SparseRows limit;           // AttachmentKind::kLimit: over welded vertices; else no rows
    bool curved = false;        // AttachmentKind::kPnTriangle
    std::vector<float> radius;  // r of equation (7)
    std::vector<float> depth;   // how far below its attachment it may be; without collision: no limit
    std::vector<float> push;    // largest random push of an unbuckled vertex
    std::vector<float> noise;   // -1..1: share and direction of this push
    std::vector<std::array<Index, 2>> pairs;  // vertices in this order: distance pairs, then bending
    std::vector<Index> pass;                  // of every pair, 0..count - 1
    std::vector<float> rest;                  // of every pair: l0
    std::vector<float> stretched;             // s l0
    std::vector<float> stiffness;             // 1 for distance, k_bending for bending
    Index distance_count = 0;
    Index count = 0;  // of passes in an iteration
};

// Throws InvalidInput if paint or settings do not fit, or for what the passes do not have: an own mesh,
// collision with the neighbourhood, painted directions. Cost: O(vertices + pairs).
Passes collect_passes(const Model& model, const Settings& settings, const Paint& paint);

// The welded vertices of the deformed base, their unit normals (or zero), and where the surface of the
// attachments passes them. Throws InvalidInput like solve().
struct WeldedPose {
    std::vector<Vec3> positions, normals, smooth;
};
WeldedPose weld_pose(const Model& model, std::span<const Vec3> positions);

}  // namespace rumple::wrinkle_mesh
