// SPDX-License-Identifier: GPL-3.0-or-later
// Several Wrinkle Meshes, one on the other: wide folds first, finer ones on them. Each is solved over the
// solved surface of the one before, so that cloth has folds of many sizes. (Not in the paper, which has one.)
#pragma once

#include <memory>
#include <vector>

#include "surface/contact/self_distance.h"
#include "surface/strain/bent_lines.h"
#include "systems/wrinkle_mesh/wrinkle_mesh.h"

namespace rumple::wrinkle_mesh {

// Built once at rest, then immutable. Layer 0 is the base mesh itself; every further one is the one before,
// subdivided once.
struct Layers {
    Surface base;
    std::vector<std::shared_ptr<const Model>> layers;  // coarse first; a layer's base is the one before it
    std::vector<SelfContactMesh> self_contact;         // the solved triangles of each layer
    std::vector<SparseRows> limit;               // of each: its vertices on the smooth surface through them
    ShownMesh shown;                             // of the finest, embedded in the base
    std::optional<ShownMesh> shown_in_viewport;  // where that is subdivided fewer times
    StretchModel stretch;
    BentLinesModel bent_lines;
};

// levels: subdivisions of the base that are solved, 0..kMostLevels; there are levels + 1 layers.
// display_steps, viewport_steps: as build() has them. Throws InvalidInput (more than most_vertices in the
// shown mesh). Cost: that of build() for each.
std::shared_ptr<const Layers> build_layers(Surface base, Index levels, Index display_steps,
                                           Index most_vertices, Index viewport_steps = kMostLevels);

// The solved mesh of a layer at rest, as the base of what lies on it.
Surface solved_surface(const Model& layer);

// What the limit surface of a layer misses of displacements of its vertices from an unwrinkled surface, at
// most a seventh of an edge. Subdivision is a smoothing: of folds five edges wide its limit has three
// quarters of the height. So what rides on solved vertices, or shows them, starts from vertices that went on
// by that: one step towards the surface that goes through them (Halstead, Kass and DeRose 1993).
std::vector<Vec3> missed_by_limit(const Layers& layers, size_t layer, std::span<const Vec3> displacements);

// Painted values of the base's vertices -> solved vertices of every layer.
std::vector<std::vector<float>> carry_paint(const Layers& layers, std::span<const float> base_values);

struct LayersState {
    std::vector<State> layers;
    std::vector<Vec3> solved;  // of the finest layer, object space
};
LayersState activated(const LayersState& state);

// settings, paint: one for each layer. Report: of each layer. Everything else as solve() has it.
LayersState solve(const Layers& layers, std::span<const Settings> settings, std::span<const Paint> paint,
                  const Input& input, const LayersState* state, std::vector<Report>& reports);

// Of every vertex of the finest layer, from where it would be without cloth and folds, object space.
// animated: of the base's vertices before they became cloth.
std::vector<Vec3> offsets(const Layers& layers, std::span<const Vec3> animated, const LayersState& state);

// animated: of the base's vertices before they became cloth (or the positions that were solved, where they
// did not): what the shown mesh is embedded in and what its offsets start from. positions: as they were
// solved. in_viewport: the shown mesh of viewports.
void show(const Layers& layers, std::span<const Vec3> animated, std::span<const Vec3> positions,
          const LayersState& state, Picture& picture, bool in_viewport = false);

}  // namespace rumple::wrinkle_mesh
