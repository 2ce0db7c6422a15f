// SPDX-License-Identifier: GPL-3.0-or-later
// A modelled mesh that is bound to the coarse one that is solved in its place. Skinning crushes the hollows
// of joints, the more the denser a mesh is: it has creases there, and crossings, that the layers on the
// coarse mesh have not. So without folds it is shown where it was bound at rest. (Not in the paper.)
#pragma once

#include <span>
#include <vector>

#include "surface/mesh/topology.h"

namespace rumple::wrinkle_mesh {

// Built once at rest, then immutable. Of every welded vertex of the modelled mesh.
struct Binding {
    SparseRows smooth;   // where the shown surface passes it <- vertices: its limit position, or itself
    SparseRows nearest;  // times the share: the nearest point of the finest layer's smooth surface <- the
                         // layer's vertices
    SparseRows moves;  // its displacement, before it follows its neighbours <- those of the layer's vertices
    std::vector<float> share;       // 1: it is bound to that surface; 0: it is too far from it
    std::vector<Vec3> rest_offset;  // times the share: from the nearest point to the smooth one, in its frame
    std::vector<Index> along;       // a neighbour to which the tangent of its frame points, or kNone
    std::vector<Index> partly;      // the vertices with a share below 1 ...
    SparseRows from_neighbours;     // ... and what they take over from their neighbours
};

// The share of a vertex at this distance from the finest layer. edge: mean edge of the coarse mesh.
float bound_share(float distance, float edge);

// smooth, nearest (without shares): as above. distance: from each vertex's smooth position to that point,
// object units. finest_rest: of the finest layer's vertices. edge: mean edge of the coarse mesh.
Binding bind_to_finest(const Surface& base, SparseRows smooth, const SparseRows& nearest,
                       std::span<const float> distance, std::span<const Vec3> finest_rest, float edge);

// How far the welded vertices of the animated mesh are from where they are bound, object space. finest: the
// positions of the finest layer's vertices without folds, for the same frame. Cost: O(vertices).
std::vector<Vec3> bound_offsets(const Binding& binding, const Surface& base, std::span<const Vec3> animated,
                                std::span<const Vec3> finest);

// The displacements of the welded vertices of the base mesh. finest: those of the finest layer's vertices.
// Near a torn border, and on a flap or a strap, vertices follow their neighbours: the nearest point may be on
// one side of a hole for a vertex, and on the other side for the next one.
std::vector<Vec3> bound_displacements(const Binding& binding, std::span<const Vec3> finest);

// The rows times a factor each.
SparseRows scaled(const SparseRows& rows, std::span<const float> factor);

}  // namespace rumple::wrinkle_mesh
