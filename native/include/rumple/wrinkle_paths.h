// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Paths: R. Gillette, Augmentation of Coarse Meshes with Wrinkles, UBC 2015 (with C. Peters). Folds
// traced over a coarse animated mesh across its compression, which live from frame to frame. No rest pose is
// needed. docs/wrinkle_paths.md has the mathematics.
#ifndef RUMPLE_WRINKLE_PATHS_H
#define RUMPLE_WRINKLE_PATHS_H

#include "surface.h"

#ifdef __cplusplus
extern "C" {
#endif

// ---- the model

// A base and the fine mesh that folds are shown on.
typedef struct rumple_wrinkle_paths rumple_wrinkle_paths;

RUMPLE_API rumple_fine_plan rumple_wrinkle_paths_plan_default(void);
// Edges of 3/8 of the width (section 7.3) show every fold. Cost: that of the fine mesh.
RUMPLE_API rumple_status rumple_wrinkle_paths_build(const rumple_surface* base, const rumple_fine_plan* plan,
                                                    rumple_wrinkle_paths** model);
RUMPLE_API void rumple_wrinkle_paths_free(rumple_wrinkle_paths* model);
// Borrowed; NULL for NULL.
RUMPLE_API const rumple_shown_mesh* rumple_wrinkle_paths_shown(const rumple_wrinkle_paths* model);

typedef struct rumple_wrinkle_paths_view {
    int32_t triangle_count;          // t
    const int32_t* triangle_vertex;  // (t, 3): welded vertices of the base's triangles
} rumple_wrinkle_paths_view;
RUMPLE_API rumple_status rumple_wrinkle_paths_get_view(const rumple_wrinkle_paths* model,
                                                       rumple_wrinkle_paths_view* view);

// ---- settings

typedef enum rumple_fold_direction {
    RUMPLE_FOLDS_OUTWARD = 0,
    RUMPLE_FOLDS_INWARD = 1,
    RUMPLE_FOLDS_BOTH = 2
} rumple_fold_direction;

// The cross-section of a fold, section 6.1.
typedef enum rumple_fold_profile {
    RUMPLE_FOLD_SPLINE = 0,
    RUMPLE_FOLD_QUARTIC = 1,
    RUMPLE_FOLD_CIRCULAR_ARCS = 2,
    RUMPLE_FOLD_SINE = 3
} rumple_fold_profile;

typedef struct rumple_wrinkle_paths_settings {
    rumple_reference_settings rest;  // what compression is measured against, chapter 4
    float smoothing;                 // of the triangles' shapes in time, s, >= 0
    float threshold;                 // tau: folds start where the compression is above it, > 1
    float reach;                     // folds go on down to this share of tau's compression, 0..1
    float width;                     // L_min: width of the tightest fold, object units, > 0
    float spacing;                   // of seeds from folds, in widths, > 0
    float alignment;     // alpha of equation 5.2: low keeps folds where they are, high turns them, >= 0
    float bend_radius;   // object units, >= 0: no folds along lines that bend on less; 0: along any line
    int32_t hem_rings;   // rings over which compression and height fade towards open borders, >= 0
    float growth_limit;  // most change of a fold's length, share per 1/30 s, >= 0
    float fade;          // in which a fold rises and sinks, s, >= 0
    bool persistent;     // false: every frame is traced anew
    uint32_t seed;       // of the places where folds may start
    int32_t profile;     // rumple_fold_profile
    int32_t direction;   // rumple_fold_direction
    float height;        // factor on the height that keeps the arc length, >= 0
    int32_t threads;     // 0: chosen by size; never changes the result
} rumple_wrinkle_paths_settings;
RUMPLE_API rumple_wrinkle_paths_settings rumple_wrinkle_paths_settings_default(void);

typedef struct rumple_wrinkle_paths_painted {
    const float* mask;  // (n), 0..1: where folds may start, and how long they get; or none: 1 everywhere
    size_t mask_count;
    const float* width;  // (n), 0.1..1: factor on the width; or none
    size_t width_count;
    const float* along;  // (n, 3): where folds are to run, as rumple_wrinkle_mesh_painted has it; or none
    size_t along_count;
} rumple_wrinkle_paths_painted;
typedef struct rumple_wrinkle_paths_paint rumple_wrinkle_paths_paint;
RUMPLE_API rumple_status rumple_wrinkle_paths_paint_build(const rumple_wrinkle_paths* model,
                                                          const rumple_wrinkle_paths_painted* painted,
                                                          rumple_wrinkle_paths_paint** paint);
RUMPLE_API void rumple_wrinkle_paths_paint_free(rumple_wrinkle_paths_paint* paint);

// ---- frames, chapters 4 and 5

// What the positions of one frame make of a model: the shapes and frames of the triangles. Made once a frame
// and handed to what is asked of the frame. It keeps its model and a copy of the arrays of `frame`. Refused:
// other positions than the model has, or such that are not finite; what only a rest shape that adapts reads
// is checked when it is solved. Cost: O(vertices).
typedef struct rumple_wrinkle_paths_pose rumple_wrinkle_paths_pose;
RUMPLE_API rumple_status rumple_wrinkle_paths_pose_build(const rumple_wrinkle_paths* model,
                                                         const rumple_pose* frame,
                                                         rumple_wrinkle_paths_pose** pose);
RUMPLE_API void rumple_wrinkle_paths_pose_free(rumple_wrinkle_paths_pose* pose);

// What is kept from frame to frame.
typedef struct rumple_wrinkle_paths_state rumple_wrinkle_paths_state;
RUMPLE_API void rumple_wrinkle_paths_state_free(rumple_wrinkle_paths_state* state);

// A state as plain arrays: what a handle holds, and what one can be made of again, to the bit.
typedef struct rumple_wrinkle_paths_state_view {
    rumple_reference_view reference;
    const float* shapes;  // (t, 3): as `reference`, smoothed in time
    size_t shapes_count;
    const float* compression;  // (t): as the paths see it
    size_t compression_count;
    const float* width;  // (t): painted factor on the width; or none: 1 everywhere
    size_t width_count;
    const int32_t* path_id;  // (paths): in order of birth, never used twice
    size_t path_id_count;
    const float* path_fade;  // (paths): 0 at birth, 1 at full height
    size_t path_fade_count;
    const int32_t* path_start;  // (paths + 1): the first point of every path, then how many there are
    size_t path_start_count;
    // A point inside a path lies on the edge that its segment leaves the triangle by, at.x of the way along
    // it. At an end: edge -1, weights of corners 1 and 2.
    const int32_t* point_triangle_edge;  // (points, 2)
    size_t point_triangle_edge_count;
    const float* point_at;  // (points, 2)
    size_t point_at_count;
    int32_t next_id;
    size_t bytes;  // memory of the state; not read by rumple_wrinkle_paths_state_build()
} rumple_wrinkle_paths_state_view;
RUMPLE_API rumple_status rumple_wrinkle_paths_state_get_view(const rumple_wrinkle_paths_state* state,
                                                             rumple_wrinkle_paths_state_view* view);
RUMPLE_API rumple_status rumple_wrinkle_paths_state_build(const rumple_wrinkle_paths* model,
                                                          const rumple_wrinkle_paths_state_view* arrays,
                                                          rumple_wrinkle_paths_state** state);
// Refused where a path does not lie on the surface; rumple_error() says what is wrong with the first one.
RUMPLE_API rumple_status rumple_wrinkle_paths_state_check(const rumple_wrinkle_paths_state* state);

typedef struct rumple_wrinkle_paths_report {
    int32_t paths;
    int32_t born;
    int32_t died;
    int32_t merging;     // paths that are being cut back to where they cross an older one
    int32_t compressed;  // triangles by label
    int32_t stretched;
    int32_t collapsed_triangles;  // without area in this pose
    float moved_mean;             // of path points along the surface since the frame before, in widths
    float moved_most;             // ... of the 99th percentile
} rumple_wrinkle_paths_report;

// One frame. paint: or NULL. before: of the frame before, or NULL: the canonical start. report: written, or
// NULL. The same input gives the same bits, whatever the numbering of vertices.
RUMPLE_API rumple_status rumple_wrinkle_paths_solve(const rumple_wrinkle_paths* model,
                                                    const rumple_wrinkle_paths_settings* settings,
                                                    const rumple_wrinkle_paths_paint* paint,
                                                    const rumple_wrinkle_paths_pose* pose,
                                                    const rumple_wrinkle_paths_state* before,
                                                    rumple_wrinkle_paths_report* report,
                                                    rumple_wrinkle_paths_state** state);

// Chapters 6 to 8: the shown mesh of a solved frame. Of the frame only positions are read, here and below.
RUMPLE_API rumple_status rumple_wrinkle_paths_show(const rumple_wrinkle_paths* model,
                                                   const rumple_wrinkle_paths_settings* settings,
                                                   const rumple_wrinkle_paths_pose* pose,
                                                   const rumple_wrinkle_paths_state* state,
                                                   rumple_frame** frame);
typedef struct rumple_frame_folds_view {
    int32_t vertex_count;  // d
    const float* height;   // (d): along the smooth normal, object units
} rumple_frame_folds_view;
// Refused: a frame of another system.
RUMPLE_API rumple_status rumple_frame_get_folds(const rumple_frame* frame, rumple_frame_folds_view* view);

// As rumple_wrinkle_mesh_label_clip().
RUMPLE_API rumple_status rumple_wrinkle_paths_label_clip(const rumple_wrinkle_paths* model,
                                                         const rumple_wrinkle_paths_settings* settings,
                                                         const double* times, size_t times_count,
                                                         const float* positions, size_t positions_count,
                                                         bool raw, uint8_t* labels, size_t labels_count);

// ---- curves

// The paths as lines, smoothed as they are shown (section 6.2).
typedef struct rumple_curves rumple_curves;
RUMPLE_API void rumple_curves_free(rumple_curves* curves);

typedef struct rumple_curves_view {
    int32_t curve_count;     // c
    int32_t point_count;     // p
    int32_t riding_count;    // p of rumple_wrinkle_paths_ride(), else 0
    const int32_t* start;    // (c + 1): the first point of every curve, then p
    const int32_t* id;       // (c)
    const float* positions;  // (p, 3), object space
    const float* width;      // (p): L there, object units
    const float* height;     // (p): signed, object units
    // In terms of the posed base: position = p0 + u (p1 - p0) + v (p2 - p0) + t o.x + b o.y + n o.z.
    const int32_t* corners;     // (riding_count, 3): the base's vertices around every point
    const float* weights;       // (riding_count, 2): u, v
    const float* local_offset;  // (riding_count, 3): o, in the frame of the deformed triangle, object units
} rumple_curves_view;
RUMPLE_API rumple_status rumple_curves_get_view(const rumple_curves* curves, rumple_curves_view* view);

// On the triangles of the deformed base but for the smoothing.
RUMPLE_API rumple_status rumple_wrinkle_paths_trace(const rumple_wrinkle_paths* model,
                                                    const rumple_wrinkle_paths_settings* settings,
                                                    const rumple_wrinkle_paths_pose* pose,
                                                    const rumple_wrinkle_paths_state* state,
                                                    rumple_curves** curves);
// On the crests of the folds, hems faded, riding on any pose of the base. animated: (n, 3) of what they are
// to ride on, where that is not what was solved over; or none.
RUMPLE_API rumple_status rumple_wrinkle_paths_ride(const rumple_wrinkle_paths* model,
                                                   const rumple_wrinkle_paths_settings* settings,
                                                   const rumple_wrinkle_paths_pose* pose,
                                                   const float* animated, size_t animated_count,
                                                   const rumple_wrinkle_paths_state* state,
                                                   rumple_curves** curves);

// Compression (1 / lambda_min) and stretch of every triangle from its reference: (t, 2), written.
RUMPLE_API rumple_status rumple_wrinkle_paths_stretches(const rumple_wrinkle_paths* model,
                                                        const rumple_wrinkle_paths_pose* pose,
                                                        const rumple_wrinkle_paths_state* state,
                                                        float* stretches, size_t stretches_count);
// Centre and two semi-axes, compressed and stretched, of what became of a circle on every reference triangle:
// (t, 9), object space, written. size: its radius over that of the inscribed circle.
RUMPLE_API rumple_status rumple_wrinkle_paths_ellipses(const rumple_wrinkle_paths* model,
                                                       const rumple_wrinkle_paths_pose* pose,
                                                       const rumple_wrinkle_paths_state* state, float size,
                                                       float* ellipses, size_t ellipses_count);

// ---- for who draws the folds himself, chapter 7

// Which folds reach which triangle, and the surface that they stand on.
typedef struct rumple_drawing rumple_drawing;
RUMPLE_API void rumple_drawing_free(rumple_drawing* drawing);

typedef struct rumple_drawing_view {
    int32_t vertex_count;           // w; 0 of rumple_wrinkle_paths_list()
    int32_t base_vertex_count;      // n; likewise
    int32_t part_count;             // t; likewise
    int32_t triangle_count;         // t
    int32_t range_count;            // r
    int32_t end_count;              // e
    bool curved;                    // false: straight triangles, for a linear attachment
    const float* flat;              // (w, 3): welded vertices of the deformed base; heights are over them
    const float* smooth;            // (w, 3): their places on the surface that the fine mesh is attached to
    const float* normal;            // (w, 3), unit
    const float* hem;               // (w): factor on the folds
    const int32_t* parts;           // (t, 4): parts that a triangle, and its edges from corners 0, 1, 2, have
    const float* proxy_offset;      // (n, 3): the way from every vertex of the base to `smooth`
    const int32_t* triangle_start;  // (t + 1): where the ranges of every triangle begin
    const int32_t* ranges;          // (r, 2): first piece and end of the pieces that reach the triangle
    const float* ends;              // (e, 8): piece i runs from end i to i + 1; at, width, along, height
} rumple_drawing_view;
RUMPLE_API rumple_status rumple_drawing_get_view(const rumple_drawing* drawing, rumple_drawing_view* view);

// All of it. Cost: that of the triangles reached.
RUMPLE_API rumple_status rumple_wrinkle_paths_draw(const rumple_wrinkle_paths* model,
                                                   const rumple_wrinkle_paths_settings* settings,
                                                   const rumple_wrinkle_paths_pose* pose,
                                                   const rumple_wrinkle_paths_state* state,
                                                   rumple_drawing** drawing);
// The lists of pieces alone: section 7.2.
RUMPLE_API rumple_status rumple_wrinkle_paths_list(const rumple_wrinkle_paths* model,
                                                   const rumple_wrinkle_paths_settings* settings,
                                                   const rumple_wrinkle_paths_pose* pose,
                                                   const rumple_wrinkle_paths_state* state,
                                                   rumple_drawing** drawing);
// Position, height and normal that the shaders make of places: (p, 7), written. For tests. triangles: (p).
// barycentric: (p, 2), weights of corners 1 and 2, -1 to 2.
RUMPLE_API rumple_status rumple_drawing_evaluate(const rumple_drawing* drawing,
                                                 const rumple_wrinkle_paths_settings* settings,
                                                 const int32_t* triangles, const float* barycentric,
                                                 size_t place_count, float* out);

#ifdef __cplusplus
}
#endif

#endif
