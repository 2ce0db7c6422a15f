// SPDX-License-Identifier: GPL-3.0-or-later
// Several Wrinkle Meshes on one another: first wide folds, then finer folds on them. Each is solved on the
// solved surface of the one before, so that cloth has folds of many sizes. (Not in the paper, which has one
// mesh.)
#pragma once

#include <memory>
#include <vector>

#include "surface/contact/self_distance.h"
#include "surface/strain/bent_lines.h"
#include "systems/wrinkle_mesh/hem_paint.h"
#include "systems/wrinkle_mesh/wrinkle_mesh.h"

namespace rumple::wrinkle_mesh {

// Built once at rest, then immutable. Layer 0 is the base mesh itself. Every other layer is the one before,
// subdivided once.
struct Layers {
    Surface base;
    std::vector<std::shared_ptr<const Model>> layers;  // coarse first; a layer's base is the one before it
    std::vector<SelfContactMesh> self_contact;         // the solved triangles of each layer
    std::vector<SparseRows> limit;                     // of each layer: its vertices on its smooth surface
    ShownMesh shown;                                   // of the finest layer, embedded in the base
    std::optional<ShownMesh> shown_in_viewport;        // if viewports use fewer subdivisions
    StretchModel stretch;
    BentLinesModel bent_lines;
    OverlappingHems hems;
};

// levels: solved subdivisions of the base, 0..kMostLevels; there are levels + 1 layers. display_steps,
// viewport_steps: as in build(). Throws InvalidInput (more than most_vertices in the shown mesh). Cost: the
// cost of build() for each layer.
std::shared_ptr<const Layers> build_layers(Surface base, Index levels, Index display_steps,
                                           Index most_vertices, Index viewport_steps = kMostLevels);

// The solved mesh of a layer at rest, as the base of the next layer.
Surface solved_surface(const Model& layer);

// The part of displacements from an unwrinkled surface that is missing in the limit surface of a layer, at
// most a seventh of an edge. Subdivision smooths: for folds five edges wide, the limit surface has three
// quarters of their height. So the next layer and the shown mesh start from vertices that are moved on by
// this amount. It is one step towards the surface that interpolates the vertices (Halstead, Kass and DeRose
// 1993).
std::vector<Vec3> missed_by_limit(const Layers& layers, size_t layer, std::span<const Vec3> displacements);

// Converts painted values of the base's vertices to the solved vertices of every layer.
std::vector<std::vector<float>> carry_paint(const Layers& layers, std::span<const float> base_values);

struct LayersState {
    std::vector<State> layers;
    std::vector<Vec3> solved;  // of the finest layer, object space
};
LayersState activated(const LayersState& state);

// settings, paint: one for each layer. Report: of each layer. The rest is as in solve() of one mesh.
LayersState solve(const Layers& layers, std::span<const Settings> settings, std::span<const Paint> paint,
                  const Input& input, const LayersState* state, std::vector<Report>& reports);

// The displacement of every vertex of the finest layer from its position without cloth and folds, object
// space. animated: of the base's vertices before the base cloth was solved.
std::vector<Vec3> offsets(const Layers& layers, std::span<const Vec3> animated, const LayersState& state);

// animated: of the base's vertices before the base cloth was solved, or the positions that were solved if
// there is no base cloth. The shown mesh is embedded in them, and its offsets start from them. positions: the
// positions that were solved. in_viewport: whether to show the mesh of viewports.
void show(const Layers& layers, std::span<const Vec3> animated, std::span<const Vec3> positions,
          const LayersState& state, Picture& picture, bool in_viewport = false);

}  // namespace rumple::wrinkle_mesh
