// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Paths: R. Gillette, Augmentation of Coarse Meshes with Wrinkles, UBC 2015 (with C. Peters). Folds
// are traced over a coarse animated mesh, across its compression, and persist from frame to frame. No rest
// pose is needed. docs/wrinkle_paths.md has the mathematics.
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
// Fine edges of 3/8 of the width (section 7.3) can show every fold. Cost: as the fine mesh.
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
    rumple_reference_settings rest;  // the shape that compression is measured against, chapter 4
    float smoothing;                 // temporal smoothing of the triangles' shapes, s, >= 0
    float threshold;                 // tau: folds start where the compression is larger, > 1
    float reach;                     // folds continue down to this share of tau's compression, 0..1
    float width;                     // L_min: width of the tightest fold, object units, > 0
    float spacing;                   // distance of seeds from folds / width, > 0
    float alignment;     // alpha of equation 5.2: low: folds stay in place, high: folds turn, >= 0
    float bend_radius;   // object units, >= 0: lines with a smaller radius get no folds; 0: all may
    int32_t hem_rings;   // rings over which compression and height fade towards open borders, >= 0
    float growth_limit;  // largest change of a fold's length, share per 1/30 s, >= 0
    float fade;          // time in which a fold appears or disappears, s, >= 0
    bool persistent;     // false: every frame is traced independently
    uint32_t seed;       // seed of the places where folds may start
    int32_t profile;     // rumple_fold_profile
    int32_t direction;   // rumple_fold_direction
    float height;        // factor on the height that preserves the arc length, >= 0
    int32_t threads;     // 0: chosen by size; never changes the result
} rumple_wrinkle_paths_settings;
RUMPLE_API rumple_wrinkle_paths_settings rumple_wrinkle_paths_settings_default(void);

typedef struct rumple_wrinkle_paths_painted {
    const float* mask;  // (n), 0..1: where folds may start, and how long they become; none: 1 everywhere
    size_t mask_count;
    const float* width;  // (n), 0.1..1: factor on the width; or none
    size_t width_count;
    const float* along;  // (n, 3): direction of the folds, see rumple_wrinkle_mesh_painted; or none
    size_t along_count;
} rumple_wrinkle_paths_painted;
typedef struct rumple_wrinkle_paths_paint rumple_wrinkle_paths_paint;
RUMPLE_API rumple_status rumple_wrinkle_paths_paint_build(const rumple_wrinkle_paths* model,
                                                          const rumple_wrinkle_paths_painted* painted,
                                                          rumple_wrinkle_paths_paint** paint);
RUMPLE_API void rumple_wrinkle_paths_paint_free(rumple_wrinkle_paths_paint* paint);

// ---- frames, chapters 4 and 5

// The pose of a model in one frame: the shapes and frames of the triangles. Build it once per frame, and pass
// it to all functions for this frame. It keeps its model and a copy of the arrays of `frame`. Refused:
// positions that are not n or not finite. Fields that only an adaptive rest shape reads are checked in the
// solve. Cost: O(vertices).
typedef struct rumple_wrinkle_paths_pose rumple_wrinkle_paths_pose;
RUMPLE_API rumple_status rumple_wrinkle_paths_pose_build(const rumple_wrinkle_paths* model,
                                                         const rumple_pose* frame,
                                                         rumple_wrinkle_paths_pose** pose);
RUMPLE_API void rumple_wrinkle_paths_pose_free(rumple_wrinkle_paths_pose* pose);

// The solver's state, which is kept from frame to frame.
typedef struct rumple_wrinkle_paths_state rumple_wrinkle_paths_state;
RUMPLE_API void rumple_wrinkle_paths_state_free(rumple_wrinkle_paths_state* state);

// A state as plain arrays. A state built from them again continues with the same bits.
typedef struct rumple_wrinkle_paths_state_view {
    rumple_reference_view reference;
    const float* shapes;  // (t, 3): in the format of `reference`, smoothed in time
    size_t shapes_count;
    const float* compression;  // (t): compression that the paths use
    size_t compression_count;
    const float* width;  // (t): painted factor on the width; none: 1 everywhere
    size_t width_count;
    const int32_t* path_id;  // (paths): in order of creation, never reused
    size_t path_id_count;
    const float* path_fade;  // (paths): 0 when created, 1 at full height
    size_t path_fade_count;
    const int32_t* path_start;  // (paths + 1): the first point of every path, then the number of points
    size_t path_start_count;
    // An inner point of a path lies on the edge where its segment leaves the triangle, at.x of the way along
    // this edge. An end point has edge -1, and at has the weights of corners 1 and 2.
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
// Fails if a path does not lie on the surface. rumple_error() describes the first such path.
RUMPLE_API rumple_status rumple_wrinkle_paths_state_check(const rumple_wrinkle_paths_state* state);

typedef struct rumple_wrinkle_paths_report {
    int32_t paths;
    int32_t born;
    int32_t died;
    int32_t merging;     // paths that are being shortened to where they cross an older one
    int32_t compressed;  // triangles with this label
    int32_t stretched;
    int32_t collapsed_triangles;  // triangles without area in this pose
    float moved_mean;             // mean movement of path points along the surface in this frame / width
    float moved_most;             // ... and its 99th percentile
} rumple_wrinkle_paths_report;

// Solves one frame. before: state of the frame before; NULL: the canonical start. report: written. paint and
// report may be NULL. The same input gives the same bits, also if the vertices are numbered differently.
RUMPLE_API rumple_status rumple_wrinkle_paths_solve(const rumple_wrinkle_paths* model,
                                                    const rumple_wrinkle_paths_settings* settings,
                                                    const rumple_wrinkle_paths_paint* paint,
                                                    const rumple_wrinkle_paths_pose* pose,
                                                    const rumple_wrinkle_paths_state* before,
                                                    rumple_wrinkle_paths_report* report,
                                                    rumple_wrinkle_paths_state** state);

// Chapters 6 to 8: the shown mesh of a solved frame. Here and below, only the positions of the pose are read.
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

// See rumple_wrinkle_mesh_label_clip().
RUMPLE_API rumple_status rumple_wrinkle_paths_label_clip(const rumple_wrinkle_paths* model,
                                                         const rumple_wrinkle_paths_settings* settings,
                                                         const double* times, size_t times_count,
                                                         const float* positions, size_t positions_count,
                                                         bool raw, uint8_t* labels, size_t labels_count);

// ---- curves

// The paths as curves, smoothed as in the shown mesh (section 6.2).
typedef struct rumple_curves rumple_curves;
RUMPLE_API void rumple_curves_free(rumple_curves* curves);

typedef struct rumple_curves_view {
    int32_t curve_count;     // c
    int32_t point_count;     // p
    int32_t riding_count;    // p from rumple_wrinkle_paths_ride(), else 0
    const int32_t* start;    // (c + 1): the first point of every curve, then p
    const int32_t* id;       // (c)
    const float* positions;  // (p, 3), object space
    const float* width;      // (p): width L, object units
    const float* height;     // (p): signed, object units
    // Relative to the posed base: position = p0 + u (p1 - p0) + v (p2 - p0) + t o.x + b o.y + n o.z.
    const int32_t* corners;     // (riding_count, 3): the base triangle of every point
    const float* weights;       // (riding_count, 2): u, v
    const float* local_offset;  // (riding_count, 3): o, in the frame of the deformed triangle, object units
} rumple_curves_view;
RUMPLE_API rumple_status rumple_curves_get_view(const rumple_curves* curves, rumple_curves_view* view);

// Curves on the triangles of the deformed base, apart from the smoothing.
RUMPLE_API rumple_status rumple_wrinkle_paths_trace(const rumple_wrinkle_paths* model,
                                                    const rumple_wrinkle_paths_settings* settings,
                                                    const rumple_wrinkle_paths_pose* pose,
                                                    const rumple_wrinkle_paths_state* state,
                                                    rumple_curves** curves);
// Curves on the crests of the folds, faded at hems. They are bound to the base, and can follow any pose of
// it. animated: (n, 3) of the base that they are bound to, if it is not the one that was solved over; or
// none.
RUMPLE_API rumple_status rumple_wrinkle_paths_ride(const rumple_wrinkle_paths* model,
                                                   const rumple_wrinkle_paths_settings* settings,
                                                   const rumple_wrinkle_paths_pose* pose,
                                                   const float* animated, size_t animated_count,
                                                   const rumple_wrinkle_paths_state* state,
                                                   rumple_curves** curves);

// Compression (1 / lambda_min) and stretch of every triangle relative to its reference triangle. stretches:
// (t, 2), written.
RUMPLE_API rumple_status rumple_wrinkle_paths_stretches(const rumple_wrinkle_paths* model,
                                                        const rumple_wrinkle_paths_pose* pose,
                                                        const rumple_wrinkle_paths_state* state,
                                                        float* stretches, size_t stretches_count);
// For every triangle, the ellipse that a circle on the reference triangle becomes: centre, compressed
// semi-axis, stretched semi-axis. ellipses: (t, 9), object space, written. size: radius of the circle /
// radius of the inscribed circle.
RUMPLE_API rumple_status rumple_wrinkle_paths_ellipses(const rumple_wrinkle_paths* model,
                                                       const rumple_wrinkle_paths_pose* pose,
                                                       const rumple_wrinkle_paths_state* state, float size,
                                                       float* ellipses, size_t ellipses_count);

// ---- for programs that draw the folds themselves, chapter 7

// The surface under the folds, and for every triangle the folds that reach it.
typedef struct rumple_drawing rumple_drawing;
RUMPLE_API void rumple_drawing_free(rumple_drawing* drawing);

typedef struct rumple_drawing_view {
    int32_t vertex_count;       // w; 0 from rumple_wrinkle_paths_list()
    int32_t base_vertex_count;  // n; likewise
    int32_t part_count;         // t; likewise
    int32_t triangle_count;     // t
    int32_t range_count;        // r
    int32_t end_count;          // e
    bool curved;                // false: straight triangles, for a linear attachment
    const float* flat;     // (w, 3): welded vertices of the deformed base; heights are measured from here
    const float* smooth;   // (w, 3): the same on the surface that the fine mesh is attached to
    const float* normal;   // (w, 3), unit
    const float* hem;      // (w): factor on the folds
    const int32_t* parts;  // (t, 4): numbers of parts of a triangle and of its edges from corners 0, 1, 2
    const float* proxy_offset;      // (n, 3): from every vertex of the base to `smooth`
    const int32_t* triangle_start;  // (t + 1): the first range of every triangle
    const int32_t* ranges;          // (r, 2): first and end of the pieces that reach the triangle
    const float* ends;              // (e, 8): piece i is from end i to end i + 1; at, width, along, height
} rumple_drawing_view;
RUMPLE_API rumple_status rumple_drawing_get_view(const rumple_drawing* drawing, rumple_drawing_view* view);

// The surface and the lists. Cost: O(triangles reached).
RUMPLE_API rumple_status rumple_wrinkle_paths_draw(const rumple_wrinkle_paths* model,
                                                   const rumple_wrinkle_paths_settings* settings,
                                                   const rumple_wrinkle_paths_pose* pose,
                                                   const rumple_wrinkle_paths_state* state,
                                                   rumple_drawing** drawing);
// Only the lists of pieces: section 7.2.
RUMPLE_API rumple_status rumple_wrinkle_paths_list(const rumple_wrinkle_paths* model,
                                                   const rumple_wrinkle_paths_settings* settings,
                                                   const rumple_wrinkle_paths_pose* pose,
                                                   const rumple_wrinkle_paths_state* state,
                                                   rumple_drawing** drawing);
// For tests: position, height and normal as the shaders compute them. triangles: (p). barycentric: (p, 2),
// weights of corners 1 and 2, -1 to 2. out: (p, 7), written.
RUMPLE_API rumple_status rumple_drawing_evaluate(const rumple_drawing* drawing,
                                                 const rumple_wrinkle_paths_settings* settings,
                                                 const int32_t* triangles, const float* barycentric,
                                                 size_t place_count, float* out);

#ifdef __cplusplus
}
#endif

#endif
