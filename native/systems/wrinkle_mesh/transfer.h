// SPDX-License-Identifier: GPL-3.0-or-later
// Layers on a coarse mesh (surface/output/coarse.h), shown on the base mesh that it represents. Every vertex
// moves like the nearest part of the finest layer's surface. So wide folds, and the time for them, do not
// depend on the density of the modelled garment. (Not in the paper.)
#pragma once

#include <memory>

#include "surface/output/coarse.h"
#include "systems/wrinkle_mesh/binding.h"
#include "systems/wrinkle_mesh/layers.h"

namespace rumple::wrinkle_mesh {

// Built once at rest, then immutable.
struct Transfer {
    Surface base;             // the base mesh
    Attachments attachments;  // of the moved vertices, on the base mesh
    Binding binding;          // of the base mesh to the finest layer
    SparseRows from_finest;   // displacements of the moved vertices <- those of the finest layer's vertices
    SparseRows from_base;     // ... of those that are not bound to it <- of the base mesh's
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

// animated: of the base mesh's vertices, object space. state: of the layers, solved for coarse_positions()
// of these. Throws InvalidInput if positions or state do not match.
void show(const Transfer& transfer, const CoarseMesh& coarse, const Layers& layers,
          std::span<const Vec3> animated, const LayersState& state, Picture& picture,
          bool in_viewport = false);

}  // namespace rumple::wrinkle_mesh
