// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Layers: several Wrinkle Meshes on top of each other, for wide folds with finer folds on them. Each
// is solved over the solved surface of the one before. See docs/wrinkle_mesh.md, Layers.
#ifndef RUMPLE_WRINKLE_LAYERS_H
#define RUMPLE_WRINKLE_LAYERS_H

#include "base_cloth.h"
#include "wrinkle_mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

// Layer 0 is the base mesh itself. Every further layer is the one before, subdivided once.
typedef struct rumple_wrinkle_layers rumple_wrinkle_layers;

typedef struct rumple_wrinkle_layers_plan {
    int32_t levels;          // solved subdivisions of the base, >= 0; there are levels + 1 layers
    int32_t display_steps;   // further subdivisions of the shown mesh, which are not solved, >= 0
    int32_t viewport_steps;  // ... of the mesh that viewports show, >= 0; at most as many count
    int32_t most_vertices;   // a shown mesh with more is refused
} rumple_wrinkle_layers_plan;
RUMPLE_API rumple_wrinkle_layers_plan rumple_wrinkle_layers_plan_default(void);

// base: at rest, n vertices. Refused: more than 8 levels, a shown mesh with more than most_vertices. Cost: as
// rumple_wrinkle_mesh_build() for every layer.
RUMPLE_API rumple_status rumple_wrinkle_layers_build(const rumple_surface* base,
                                                     const rumple_wrinkle_layers_plan* plan,
                                                     rumple_wrinkle_layers** model);
RUMPLE_API void rumple_wrinkle_layers_free(rumple_wrinkle_layers* model);
// Borrowed; NULL for NULL. in_viewport: the one of viewports, where that has fewer steps; else the same.
RUMPLE_API const rumple_shown_mesh* rumple_wrinkle_layers_shown(const rumple_wrinkle_layers* model,
                                                                bool in_viewport);

typedef struct rumple_wrinkle_layers_view {
    int32_t layer_count;          // levels + 1
    int32_t solved_vertex_count;  // of all layers
    int32_t finest_triangle_count;
    const int32_t* finest_triangles;  // (finest_triangle_count, 3): rows of a state's `solved`
} rumple_wrinkle_layers_view;
RUMPLE_API rumple_status rumple_wrinkle_layers_get_view(const rumple_wrinkle_layers* model,
                                                        rumple_wrinkle_layers_view* view);
// The view of one layer, as a Wrinkle Mesh. layer: 0..layer_count - 1.
RUMPLE_API rumple_status rumple_wrinkle_layers_get_layer(const rumple_wrinkle_layers* model, int32_t layer,
                                                         rumple_wrinkle_mesh_view* view);

// Painted factors of the base's vertices: those of a Wrinkle Mesh for all layers, and one for each layer.
typedef struct rumple_wrinkle_layers_painted {
    rumple_wrinkle_mesh_painted all;
    const float* const* strength;  // (layers): for each (n), 0..1, r x value, or NULL; or none
    size_t strength_count;
} rumple_wrinkle_layers_painted;
typedef struct rumple_wrinkle_layers_paint rumple_wrinkle_layers_paint;
RUMPLE_API rumple_status rumple_wrinkle_layers_paint_build(const rumple_wrinkle_layers* model,
                                                           const rumple_wrinkle_layers_painted* painted,
                                                           rumple_wrinkle_layers_paint** paint);
RUMPLE_API void rumple_wrinkle_layers_paint_free(rumple_wrinkle_layers_paint* paint);

// The solver's state, which is kept from frame to frame.
typedef struct rumple_wrinkle_layers_state rumple_wrinkle_layers_state;
RUMPLE_API void rumple_wrinkle_layers_state_free(rumple_wrinkle_layers_state* state);

typedef struct rumple_wrinkle_layers_state_view {
    int32_t layer_count;
    int32_t solved_count;  // vertices of the finest layer
    const float* solved;   // (solved_count, 3): positions of the finest layer, object space
    size_t bytes;          // memory of the state
} rumple_wrinkle_layers_state_view;
RUMPLE_API rumple_status rumple_wrinkle_layers_state_get_view(const rumple_wrinkle_layers_state* state,
                                                              rumple_wrinkle_layers_state_view* view);
// The state of one layer, as the state of a Wrinkle Mesh. layer: 0..layer_count - 1.
RUMPLE_API rumple_status rumple_wrinkle_layers_state_get_layer(const rumple_wrinkle_layers_state* state,
                                                               int32_t layer,
                                                               rumple_wrinkle_mesh_state_view* view);
// Builds a state from the views of its layers, coarse first, and of the whole. It continues with the same
// bits.
RUMPLE_API rumple_status rumple_wrinkle_layers_state_build(const rumple_wrinkle_layers* model,
                                                           const rumple_wrinkle_mesh_state_view* layers,
                                                           size_t layers_count, const float* solved,
                                                           size_t solved_count,
                                                           rumple_wrinkle_layers_state** state);
// The same offsets, but no vertex is asleep. Use it before a solve with other settings.
RUMPLE_API rumple_status rumple_wrinkle_layers_state_activated(const rumple_wrinkle_layers_state* state,
                                                               rumple_wrinkle_layers_state** activated);

// The input of a frame.
typedef struct rumple_wrinkle_layers_input {
    const float* positions;  // (n, 3): the deformed base, or the base cloth on it, object space
    size_t positions_count;
    const float* gap;  // (n): how far each vertex may move inwards, object units, >= 0; none: any distance
    size_t gap_count;
    rumple_bodies bodies;      // in this pose; or none
    const int32_t* body_hint;  // (n), with bodies: from rumple_base_cloth_solve()
    size_t body_hint_count;
    float thickness;  // how far cloth stays off bodies, object units, >= 0
    float inner;      // how far the garment's inner side is below the cloth, object units, >= 0
} rumple_wrinkle_layers_input;
RUMPLE_API rumple_wrinkle_layers_input rumple_wrinkle_layers_input_default(void);

// Solves one frame. settings: one for each layer, coarse first. before: state of the frame before. paint and
// before may be NULL. reports: one for each layer, written; or none. Refused: settings or reports that are
// not one for each layer, a setting out of its range, an input that does not fit the base, paint or state of
// another model. Cost: as rumple_wrinkle_mesh_solve() for every layer.
RUMPLE_API rumple_status rumple_wrinkle_layers_solve(
    const rumple_wrinkle_layers* model, const rumple_wrinkle_mesh_settings* settings, size_t settings_count,
    const rumple_wrinkle_layers_paint* paint, const rumple_wrinkle_layers_input* input,
    const rumple_wrinkle_layers_state* before, rumple_wrinkle_mesh_report* reports, size_t reports_count,
    rumple_wrinkle_layers_state** state);

// The shown mesh of a solved frame. animated: (n, 3) of the animated base, without base cloth. The shown mesh
// is embedded in it. positions: (n, 3), as in the solve. in_viewport: see rumple_wrinkle_layers_shown().
RUMPLE_API rumple_status rumple_wrinkle_layers_show(const rumple_wrinkle_layers* model, const float* animated,
                                                    size_t animated_count, const float* positions,
                                                    size_t positions_count,
                                                    const rumple_wrinkle_layers_state* state,
                                                    bool in_viewport, rumple_frame** frame);

// ---- layers that are solved on a coarse mesh and shown on the base mesh

// Every vertex of the base mesh moves like the nearest place on the surface of the finest layer.
typedef struct rumple_wrinkle_transfer rumple_wrinkle_transfer;

typedef struct rumple_wrinkle_transfer_plan {
    int32_t level;           // subdivisions of the base mesh whose vertices are moved, >= 0
    int32_t display_steps;   // further subdivisions of the shown mesh, >= 0
    int32_t viewport_steps;  // ... of the mesh that viewports show, >= 0; at most as many count
    int32_t most_vertices;   // a shown mesh with more is refused
} rumple_wrinkle_transfer_plan;
RUMPLE_API rumple_wrinkle_transfer_plan rumple_wrinkle_transfer_plan_default(void);

// base: the mesh that coarse was built from. layers: built on the surface of coarse.
RUMPLE_API rumple_status rumple_wrinkle_transfer_build(const rumple_surface* base,
                                                       const rumple_coarse* coarse,
                                                       const rumple_wrinkle_layers* layers,
                                                       const rumple_wrinkle_transfer_plan* plan,
                                                       rumple_wrinkle_transfer** model);
RUMPLE_API void rumple_wrinkle_transfer_free(rumple_wrinkle_transfer* model);
// Borrowed; NULL for NULL. in_viewport: the one of viewports, where that has fewer steps; else the same.
RUMPLE_API const rumple_shown_mesh* rumple_wrinkle_transfer_shown(const rumple_wrinkle_transfer* model,
                                                                  bool in_viewport);

// The shown mesh of a solved frame. animated: (n, 3) of the animated base mesh, without base cloth. state:
// of the layers. in_viewport: see rumple_wrinkle_transfer_shown().
RUMPLE_API rumple_status rumple_wrinkle_transfer_show(const rumple_wrinkle_transfer* model,
                                                      const float* animated, size_t animated_count,
                                                      const rumple_wrinkle_layers_state* state,
                                                      bool in_viewport, rumple_frame** frame);

#ifdef __cplusplus
}
#endif

#endif
