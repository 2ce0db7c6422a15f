// SPDX-License-Identifier: GPL-3.0-or-later
// Layers on a coarse mesh (surface/output/coarse.h), shown on the dense mesh that it represents. Every vertex
// moves like the nearest part of the finest layer's surface. So wide folds, and the time for them, do not
// depend on the density of the modelled garment. (Not in the paper.)
#pragma once

#include <memory>

#include "surface/output/coarse.h"
#include "systems/wrinkle_mesh/layers.h"

namespace rumple::wrinkle_mesh {

// Where the dense mesh lies beside the smooth surface of the finest layer at rest, per welded vertex.
struct Beside {
    SparseRows smooth;   // where the shown surface passes a vertex <- vertices: its limit position, or itself
    SparseRows nearest;  // the nearest point of that surface, times the share <- its vertices
    std::vector<float> share;    // 1: the vertex lies beside that surface in every pose; 0: too far from it
    std::vector<Index> along;    // a neighbour that the tangent of the vertex's frame points to, or kNone
    std::vector<Vec3> way;       // from the nearest point to the vertex, times the share, in its frame
    std::vector<Index> partly;   // the vertices with a share below 1 ...
    SparseRows from_neighbours;  // ... what they take over from their neighbours
};

// Built once at rest, then immutable.
struct Transfer {
    Surface base;             // the dense mesh
    Attachments attachments;  // of the moved vertices, on the dense mesh
    Beside beside;
    SparseRows from_finest;  // from displacements of the finest layer's vertices to displacements of these
    ShownMesh shown;
    std::optional<ShownMesh> shown_in_viewport;  // if viewports use fewer subdivisions
    StretchModel stretch;
};

// coarse, layers: built on base. level: subdivisions of the base that are moved. display_steps: how many of
// these are shown. viewport_steps: as in build(). Throws InvalidInput (more than most_vertices in the shown
// mesh). Cost: as limit_stencils().
std::shared_ptr<const Transfer> build_transfer(Surface base, const CoarseMesh& coarse, const Layers& layers,
                                               Index level, Index display_steps, Index most_vertices,
                                               Index viewport_steps = kMostLevels);

// animated: of the dense mesh's vertices, object space. state: of the layers, solved for coarse_positions()
// of these. Throws InvalidInput if positions or state do not match.
void show(const Transfer& transfer, const CoarseMesh& coarse, const Layers& layers,
          std::span<const Vec3> animated, const LayersState& state, Picture& picture,
          bool in_viewport = false);

}  // namespace rumple::wrinkle_mesh
