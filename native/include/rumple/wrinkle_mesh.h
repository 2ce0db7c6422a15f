// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Mesh: M. Mueller and N. Chentanez, Wrinkle Meshes, SCA 2010. A fine mesh attached to a coarse
// animated one, relaxed by a static position-based solver. docs/wrinkle_mesh.md has the mathematics.
#ifndef RUMPLE_WRINKLE_MESH_H
#define RUMPLE_WRINKLE_MESH_H

#include "surface.h"

#ifdef __cplusplus
extern "C" {
#endif

// ---- the model, section 3

// A fine mesh with v solved vertices, attached to a base at rest.
typedef struct rumple_wrinkle_mesh rumple_wrinkle_mesh;

typedef struct rumple_wrinkle_mesh_plan {
    rumple_fine_plan fine;
    const rumple_surface* own;  // RUMPLE_FINE_OBJECT: a mesh at rest, in the base's space; else NULL
    const uint8_t* attached;    // (vertices of own): 0: not attached; or none: all are attached
    size_t attached_count;
    float farthest;          // `own` is refused if farther than this from the base, object units; 0: never
    int32_t display_steps;   // further subdivisions of the shown mesh, which are not solved, >= 0
    int32_t viewport_steps;  // ... of the mesh for viewports, >= 0; limited to display_steps
    bool adaptive;           // needed for settings whose reference is not RUMPLE_REFERENCE_STATIC_REST
} rumple_wrinkle_mesh_plan;
RUMPLE_API rumple_wrinkle_mesh_plan rumple_wrinkle_mesh_plan_default(void);

// Refused: a fine mesh of more than most_vertices, an own mesh too far away. Cost: seconds for a million
// fine vertices.
RUMPLE_API rumple_status rumple_wrinkle_mesh_build(const rumple_surface* base,
                                                   const rumple_wrinkle_mesh_plan* plan,
                                                   rumple_wrinkle_mesh** model);
RUMPLE_API void rumple_wrinkle_mesh_free(rumple_wrinkle_mesh* model);
// Borrowed; NULL for NULL. in_viewport: the mesh for viewports if it has fewer steps, else the same mesh.
RUMPLE_API const rumple_shown_mesh* rumple_wrinkle_mesh_shown(const rumple_wrinkle_mesh* model,
                                                              bool in_viewport);

typedef struct rumple_wrinkle_mesh_view {
    int32_t solved_vertex_count;       // v
    int32_t pair_count;                // distance and bending constraints
    int32_t unattached_count;          // vertices of the own mesh, or 0
    int32_t base_vertex_count;         // n
    int32_t welded_count;              // w: welded vertices of the base
    const float* local_edge;           // (v): mean rest length of the edges around a vertex, object units
    const float* unattached_distance;  // (unattached_count): to the base at rest, object units
    const int32_t* welded_of;          // (n): the welded vertex of every vertex of the base
} rumple_wrinkle_mesh_view;
RUMPLE_API rumple_status rumple_wrinkle_mesh_get_view(const rumple_wrinkle_mesh* model,
                                                      rumple_wrinkle_mesh_view* view);

// ---- settings

typedef enum rumple_collision {
    RUMPLE_COLLISION_NONE = 0,
    RUMPLE_COLLISION_PLANE = 1,         // no vertex is deeper than `inside` below its attachment
    RUMPLE_COLLISION_NEIGHBOURHOOD = 2  // ... below the triangles around it
} rumple_collision;

typedef enum rumple_offset_space {
    RUMPLE_OFFSETS_TRIANGLE = 0,  // offsets move with the frame of the deformed triangle
    RUMPLE_OFFSETS_WORLD = 1      // ... or keep their direction in the world
} rumple_offset_space;

// Lengths are relative to the fine mesh.
typedef struct rumple_wrinkle_mesh_settings {
    float radius;              // r: attachment radius / mean length of the edges around a vertex, >= 0
    float prestretch;          // s: rest length / measured length, > 0
    float bending;             // k_bending, 0..1
    int32_t collision;         // rumple_collision
    float inside;              // depth of the collision plane below the surface, in radii, 0..1
    float stretch_relief;      // share of the base's stretch that the rest lengths adopt, 0..1
    float buckling_threshold;  // compression of the base that causes no folds, share of the length, 0..1
    float compression_limit;   // largest rest length / length on the base, >= 1
    int32_t hem_rings;         // rings over which r fades to 0 at open borders, >= 0
    int32_t iterations;        // passes from a given state, >= 0
    int32_t start_iterations;  // passes from the canonical start, >= 0
    float damping;             // share of the former offset that is kept, 0..1
    int32_t offset_space;      // rumple_offset_space
    float tangential_pull;     // share of a vertex's offset along the surface that a pass removes, 0..1
    float normal_pull;         // the same for the offset along the normal, 0..1
    float slack;               // layers only: length / rest length at which the base is taut, > 0
    float taut_range;          // layers only: range below slack where s falls to prestretch, >= 0; 0: none
    float hang[3];      // layers only: direction in which weight pulls cloth taut; object space, length 0..1
    float bend_radius;  // layers only, read from the first one: object units, >= 0: lines with a smaller
                        // radius of curvature get no folds; 0: all lines may
    float contact_gather;  // layers only: share of compression_limit - 1 where cloth touches what is worn
                           // under it, 0..1; with room for an edge of the layer it is all of it
    float apart;           // layers only: share of the distance to other cloth that a vertex may move, 0..0.5
    float slide;           // layers only: share of its triangles' heights that it may move along them, 0..0.5
    float nudge;           // size of the random push of unbuckled vertices, in fine edges, >= 0
    uint32_t seed;         // seed of this push
    int32_t threads;       // 0: chosen by size; never changes the result
    rumple_reference_settings rest;  // the shape that compression is measured against
} rumple_wrinkle_mesh_settings;
RUMPLE_API rumple_wrinkle_mesh_settings rumple_wrinkle_mesh_settings_default(void);

// Painted factors of the base's vertices, 0..1; each (n), or none, which means 1 everywhere.
typedef struct rumple_wrinkle_mesh_painted {
    const float* radius;  // r x value
    size_t radius_count;
    const float* prestretch;  // 1 + (s - 1) x value
    size_t prestretch_count;
    const float* bending;  // k x value
    size_t bending_count;
    const float* inside;  // inside x value
    size_t inside_count;
    const float* worn;  // 0: hangs free, so that its extra width does not count; 1: it counts
    size_t worn_count;
    const float* along;  // (n, 3): direction of the folds at rest, v and -v mean the same; its length,
    size_t along_count;  // 0..1, is the strength; or none
} rumple_wrinkle_mesh_painted;
typedef struct rumple_wrinkle_mesh_paint rumple_wrinkle_mesh_paint;
RUMPLE_API rumple_status rumple_wrinkle_mesh_paint_build(const rumple_wrinkle_mesh* model,
                                                         const rumple_wrinkle_mesh_painted* painted,
                                                         rumple_wrinkle_mesh_paint** paint);
RUMPLE_API void rumple_wrinkle_mesh_paint_free(rumple_wrinkle_mesh_paint* paint);

// ---- frames, section 4

// The pose of a model in one frame: the deformed base and the attachments. Build it once per frame, and pass
// it to all functions for this frame. It keeps its model and a copy of the arrays of `frame`. Refused:
// positions that are not n or not finite. Fields that only an adaptive rest shape reads are checked in the
// solve. Cost: O(vertices).
typedef struct rumple_wrinkle_mesh_pose rumple_wrinkle_mesh_pose;
RUMPLE_API rumple_status rumple_wrinkle_mesh_pose_build(const rumple_wrinkle_mesh* model,
                                                        const rumple_pose* frame,
                                                        rumple_wrinkle_mesh_pose** pose);
RUMPLE_API void rumple_wrinkle_mesh_pose_free(rumple_wrinkle_mesh_pose* pose);

// The solver's state, which is kept from frame to frame.
typedef struct rumple_wrinkle_mesh_state rumple_wrinkle_mesh_state;
RUMPLE_API void rumple_wrinkle_mesh_state_free(rumple_wrinkle_mesh_state* state);

// A state as plain arrays. A state built from them again continues with the same bits.
typedef struct rumple_wrinkle_mesh_state_view {
    const float* offset;  // (v, 3): o_i, in the frame of the base triangle, or in the world
    size_t offset_count;
    const float* solved_length;  // (pairs): length at the attachments in the last solve / rest scale
    size_t solved_length_count;
    rumple_reference_view reference;  // of an adaptive rest shape
    size_t bytes;                     // memory of the state; not read by rumple_wrinkle_mesh_state_build()
} rumple_wrinkle_mesh_state_view;
RUMPLE_API rumple_status rumple_wrinkle_mesh_state_get_view(const rumple_wrinkle_mesh_state* state,
                                                            rumple_wrinkle_mesh_state_view* view);
RUMPLE_API rumple_status rumple_wrinkle_mesh_state_build(const rumple_wrinkle_mesh* model,
                                                         const rumple_wrinkle_mesh_state_view* arrays,
                                                         rumple_wrinkle_mesh_state** state);
// The same offsets, but no vertex is asleep. Use it before a solve with other settings.
RUMPLE_API rumple_status rumple_wrinkle_mesh_state_activated(const rumple_wrinkle_mesh_state* state,
                                                             rumple_wrinkle_mesh_state** activated);

typedef struct rumple_wrinkle_mesh_report {
    int32_t iterations;           // 0: all vertices were asleep, nothing was solved
    float error_before;           // RMS relative length error of the distance constraints at the attachments
    float error_after;            // ... and of the solved mesh
    float largest_error;          // largest relative length error of the solved mesh
    float active;                 // share of the vertices that were solved, 0..1; the others were asleep
    int32_t collapsed_triangles;  // triangles of the base without area in this pose
    int32_t kept_apart;           // vertices that other cloth or a body in front stopped
} rumple_wrinkle_mesh_report;

// Solves one frame. before: state of the frame before; NULL: the canonical start. report: written. paint and
// report may be NULL. Deterministic on any number of threads. Cost: O(iterations x pairs).
RUMPLE_API rumple_status rumple_wrinkle_mesh_solve(const rumple_wrinkle_mesh* model,
                                                   const rumple_wrinkle_mesh_settings* settings,
                                                   const rumple_wrinkle_mesh_paint* paint,
                                                   const rumple_wrinkle_mesh_pose* pose,
                                                   const rumple_wrinkle_mesh_state* before,
                                                   rumple_wrinkle_mesh_report* report,
                                                   rumple_wrinkle_mesh_state** state);

// The shown mesh of a solved frame. in_viewport: see rumple_wrinkle_mesh_shown().
RUMPLE_API rumple_status rumple_wrinkle_mesh_show(const rumple_wrinkle_mesh* model,
                                                  const rumple_wrinkle_mesh_settings* settings,
                                                  const rumple_wrinkle_mesh_pose* pose,
                                                  const rumple_wrinkle_mesh_state* state, bool in_viewport,
                                                  rumple_frame** frame);

// Measures of the quality of a frame, for reports and tests.
typedef struct rumple_wrinkle_mesh_measures {
    float edge_error_before_rms;  // |length - s l0| / (s l0) of the fine mesh at its attachments
    float edge_error_before_max;
    float edge_error_after_rms;  // ... and solved
    float edge_error_after_max;
    float compressed_area_before;  // area / rest area, where base triangles have less than 0.9 of their rest
                                   // area
    float compressed_area_after;
    float attachment_violation;  // largest (|o| - r) / r over attached vertices with r > 0, at least 0
    float largest_offset;        // object units
} rumple_wrinkle_mesh_measures;
// offsets: (v, 3), written: o_i in the triangle frame.
RUMPLE_API rumple_status rumple_wrinkle_mesh_measure(const rumple_wrinkle_mesh* model,
                                                     const rumple_wrinkle_mesh_settings* settings,
                                                     const rumple_wrinkle_mesh_paint* paint,
                                                     const rumple_wrinkle_mesh_pose* pose,
                                                     const rumple_wrinkle_mesh_state* state,
                                                     rumple_wrinkle_mesh_measures* measures, float* offsets,
                                                     size_t offsets_count);

// Labels a whole clip by one graph cut (Gillette 2015, section 4.1.2). The model must be built with
// `adaptive`. times: (f), s, ascending. positions: (f n, 3), frame after frame. raw: true: every triangle
// gets the label that is cheapest for itself, without a cut. labels: (f t), written. Cost: about 1 ms and
// half a megabyte per frame and 1,000 triangles.
RUMPLE_API rumple_status rumple_wrinkle_mesh_label_clip(const rumple_wrinkle_mesh* model,
                                                        const rumple_wrinkle_mesh_settings* settings,
                                                        const double* times, size_t times_count,
                                                        const float* positions, size_t positions_count,
                                                        bool raw, uint8_t* labels, size_t labels_count);

// ---- for a solver on the graphics card

// The constraints of a solve, so that a graphics card can go on from a state (section 4.1). Vertices are in
// the order of `vertex`. Each pass projects at most one pair of a vertex. All passes in their order, then the
// bounds (3.1, 4.2), are one iteration of rumple_wrinkle_mesh_solve(), with the same result but for rounding.
typedef struct rumple_wrinkle_mesh_passes rumple_wrinkle_mesh_passes;

// Lengths: object units.
typedef struct rumple_wrinkle_mesh_passes_view {
    int32_t vertex_count;    // v
    int32_t triangle_count;  // t: triangles of the base
    int32_t pair_count;      // p, in the order of a state's solved_length
    int32_t distance_count;  // the first of them keep distances, the others resist bending
    int32_t pass_count;      // passes of an iteration
    int32_t limit_count;     // m; 0: attached to triangles
    bool curved;             // attached to PN triangles

    const int32_t* triangles;      // (t, 3): welded vertices of the base's triangles
    const int32_t* vertex;         // (v): the solved vertex
    const int32_t* base_vertices;  // (v, 3): welded vertices of the base's triangle that it is attached to
    const float* weights;          // (v, 2): of the second and the third of them
    const int32_t* limit_start;    // (v + 1): row of every vertex, or (1) without limit surface
    const int32_t* limit_vertex;   // (m): welded vertices
    const float* limit_weight;     // (m)
    const float* radius;           // (v): attachment radius
    const float* depth;            // (v): how far below its attachment it may be
    const float* push;             // (v): largest random push of an unbuckled vertex
    const float* noise;            // (v): -1..1: share and direction of this push
    const int32_t* pairs;          // (p, 2): vertices, in the order of `vertex`
    const int32_t* of_pass;        // (p): its pass, 0..pass_count - 1
    const float* rest;             // (p): length at rest
    const float* stretched;        // (p): s times it
    const float* stiffness;        // (p): 0..1; of distances 1
} rumple_wrinkle_mesh_passes_view;

// paint may be NULL. Refused: a model with an own mesh, collision with the neighbourhood, painted directions.
// Cost: O(v + p).
RUMPLE_API rumple_status rumple_wrinkle_mesh_passes_build(const rumple_wrinkle_mesh* model,
                                                          const rumple_wrinkle_mesh_settings* settings,
                                                          const rumple_wrinkle_mesh_paint* paint,
                                                          rumple_wrinkle_mesh_passes** passes);
RUMPLE_API void rumple_wrinkle_mesh_passes_free(rumple_wrinkle_mesh_passes* passes);
RUMPLE_API rumple_status rumple_wrinkle_mesh_passes_get_view(const rumple_wrinkle_mesh_passes* passes,
                                                             rumple_wrinkle_mesh_passes_view* view);

// The base's welded vertices in a pose, (w, 3) each, written: deformed positions, unit normals (or zero), and
// where the surface that the fine mesh is attached to passes them. Refused: as in
// rumple_wrinkle_mesh_pose_build(). Cost: O(vertices of the base).
RUMPLE_API rumple_status rumple_wrinkle_mesh_weld_pose(const rumple_wrinkle_mesh* model,
                                                       const float* positions, size_t positions_count,
                                                       float* welded, float* normals, float* smooth,
                                                       size_t welded_count);

#ifdef __cplusplus
}
#endif

#endif
