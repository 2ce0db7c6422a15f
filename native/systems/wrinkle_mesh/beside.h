// SPDX-License-Identifier: GPL-3.0-or-later
// A dense mesh beside the coarse one that is solved in its place. Skinning crushes the hollows of joints, the
// more the denser a mesh is: it has creases there, and crossings, that its layers on the coarse mesh have
// not. So without folds it is shown where it lay beside the coarse mesh at rest. (Not in the paper.)
#pragma once

#include <span>
#include <vector>

#include "surface/mesh/topology.h"

namespace rumple::wrinkle_mesh {

// Built once at rest, then immutable. Of every welded vertex of the dense mesh.
struct Beside {
    SparseRows smooth;   // where the shown surface passes it <- vertices: its limit position, or itself
    SparseRows nearest;  // the nearest point of the finest layer's smooth surface, times the share <- its
                         // vertices
    SparseRows moves;    // its displacement, where it does not follow its neighbours <- those of these
    std::vector<float> share;    // 1: it lies beside that surface in every pose; 0: it is too far from it
    std::vector<Index> along;    // a neighbour to which the tangent of its frame points, or kNone
    std::vector<Vec3> way;       // from the nearest point to the surface here, times the share, in its frame
    std::vector<Index> partly;   // the vertices with a share below 1 ...
    SparseRows from_neighbours;  // ... and what they take over from their neighbours
};

// How far a vertex at this distance from the finest layer lies beside it. edge: mean edge of the coarse mesh.
float share_beside(float distance, float edge);

// smooth, nearest (without shares): as above. distance: from each vertex's smooth position to that point,
// object units. finest_rest: of the finest layer's vertices. edge: mean edge of the coarse mesh.
Beside find_beside(const Surface& dense, SparseRows smooth, const SparseRows& nearest,
                   std::span<const float> distance, std::span<const Vec3> finest_rest, float edge);

// The ways of the welded vertices of the animated dense mesh to where they lie beside the finest layer.
// finest: the positions of its vertices without folds, for the same frame. Object space. Cost: O(vertices).
std::vector<Vec3> ways_beside(const Beside& beside, const Surface& dense, std::span<const Vec3> animated,
                              std::span<const Vec3> finest);

// The displacements of the welded vertices of the dense mesh. finest: those of the finest layer's vertices.
// Near a torn border, and on a flap or a strap, vertices follow their neighbours: the nearest point may be on
// one side of a hole for a vertex, and on the other side for the next one.
std::vector<Vec3> displacements_of(const Beside& beside, std::span<const Vec3> finest);

// The rows times a factor each.
SparseRows scaled(const SparseRows& rows, std::span<const float> factor);

}  // namespace rumple::wrinkle_mesh
