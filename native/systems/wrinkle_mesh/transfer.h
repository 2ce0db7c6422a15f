// SPDX-License-Identifier: GPL-3.0-or-later
// Layers over a coarse mesh (surface/output/coarse.h), shown on the dense mesh that it stands for: every
// vertex moves as the finest layer's surface does beside it. Wide folds, and the time they take, then do not
// depend on how densely a garment was modelled. (Not in the paper.)
#pragma once

#include <memory>

#include "surface/output/coarse.h"
#include "systems/wrinkle_mesh/layers.h"

namespace rumple::wrinkle_mesh {

// Built once at rest, then immutable.
struct Transfer {
    Surface base;             // the dense mesh
    Attachments attachments;  // of the vertices that are moved, on it
    SparseRows from_finest;   // ways of these <- ways of the finest layer's vertices
    ShownMesh shown;
    std::optional<ShownMesh> shown_in_viewport;  // where that is subdivided fewer times
    StretchModel stretch;
};

// coarse, layers: built over base. level: subdivisions of the base that are moved; display_steps: of these
// that are shown; viewport_steps: as build() has them. Throws InvalidInput (more than most_vertices in the
// shown mesh). Cost: as of limit_stencils().
std::shared_ptr<const Transfer> build_transfer(Surface base, const CoarseMesh& coarse, const Layers& layers,
                                               Index level, Index display_steps, Index most_vertices,
                                               Index viewport_steps = kMostLevels);

// animated: of the dense mesh's vertices, object space. state: of the layers, which were solved over the
// coarse positions of these. Throws InvalidInput when positions or state do not match.
void show(const Transfer& transfer, const CoarseMesh& coarse, const Layers& layers,
          std::span<const Vec3> animated, const LayersState& state, Picture& picture,
          bool in_viewport = false);

}  // namespace rumple::wrinkle_mesh
