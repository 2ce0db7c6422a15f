// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Field: J. Loviscach, Wrinkling Coarse Meshes on the GPU, Eurographics 2006. Every vertex of the
// coarse mesh has a plane wave. Its height and direction follow from the deformation, its phase from a
// relaxation. docs/wrinkle_field.md has the mathematics. See also wrinkle_field_brush.h.
#ifndef RUMPLE_WRINKLE_FIELD_H
#define RUMPLE_WRINKLE_FIELD_H

#include "surface.h"

#ifdef __cplusplus
extern "C" {
#endif

// ---- the model, section 3

// Neighbourhoods of a base at rest, and the shown mesh. w welded vertices, m neighbours of all vertices
// together.
typedef struct rumple_wrinkle_field rumple_wrinkle_field;

typedef enum rumple_field_output {
    RUMPLE_FIELD_SHADING = 0,  // waves only in the shading of the base's triangles
    RUMPLE_FIELD_GEOMETRY = 1  // waves as geometry of a fine mesh
} rumple_field_output;

typedef struct rumple_wrinkle_field_plan {
    int32_t output;         // rumple_field_output
    rumple_fine_plan fine;  // for RUMPLE_FIELD_GEOMETRY
    const float* uv;        // (corners of the base, 2): for parallax with RUMPLE_FIELD_SHADING; or none
    size_t uv_count;
    bool true_lengths;  // true: equation (1) uses lengths of edges; false: of their projections, as in the
                        // paper
} rumple_wrinkle_field_plan;
RUMPLE_API rumple_wrinkle_field_plan rumple_wrinkle_field_plan_default(void);

// Cost: O(edges); for RUMPLE_FIELD_GEOMETRY also the cost of the fine mesh.
RUMPLE_API rumple_status rumple_wrinkle_field_build(const rumple_surface* base,
                                                    const rumple_wrinkle_field_plan* plan,
                                                    rumple_wrinkle_field** model);
RUMPLE_API void rumple_wrinkle_field_free(rumple_wrinkle_field* model);
// Borrowed; NULL for NULL.
RUMPLE_API const rumple_shown_mesh* rumple_wrinkle_field_shown(const rumple_wrinkle_field* model);

typedef struct rumple_wrinkle_field_view {
    int32_t vertex_count;            // w
    int32_t neighbour_count;         // m
    int32_t base_vertex_count;       // n
    int32_t triangle_count;          // t, of the base
    int32_t uv_count;                // 3 t, or 0 without a uv
    const int32_t* neighbour_start;  // (w + 1): the first neighbour of every vertex
    const int32_t* neighbours;       // (m): welded vertices
    const float* gradients;          // (m, 2): M of equation (1) is the sum of v' (x) gradient
    const float* tangent_rest;       // (w, 3): tangent t of the rest frame; zero without a normal
    const float* bitangent_rest;     // (w, 3): bitangent b of the rest frame
    const int32_t* welded_of;        // (n): the welded vertex of every vertex of the base
    const int32_t* triangles;        // (t, 3): welded vertices of the base's triangles
    const float* uv;                 // (uv_count, 2): for each corner of every triangle in order
    const int32_t* uv_fan;           // (uv_count): corners with the same fan number share their uv gradient
    const float* first_directions;   // (w, 2): k at the start of a clip, rest frame
} rumple_wrinkle_field_view;
RUMPLE_API rumple_status rumple_wrinkle_field_get_view(const rumple_wrinkle_field* model,
                                                       rumple_wrinkle_field_view* view);

// ---- settings

typedef struct rumple_wrinkle_field_settings {
    float wavelength;          // W in rest space, object units, > 0
    float strength;            // factor on the amplitude of equation (2), >= 0
    float buckling_threshold;  // compression that causes no waves, share of the length, 0..0.99
    bool keep_length;          // geometry: limit the waves to the length of the cloth at rest
    float rate;                // epsilon / (2 pi^2) of equation (6), 0..1; stable below 1
    int32_t rounds;            // rounds of relaxation from a given state, >= 0
    int32_t start_rounds;      // from the canonical start, >= 0
    float irregularity;        // 0..1; 0: regular, like cloth, 1: like skin
    float bend_radius;         // object units, >= 0: lines with a smaller radius get no waves; 0: all may
    uint32_t seed;             // of the first phases and of the irregularity
    bool aligned_start;        // true: align the random first phases; false: random, as in the paper
    int32_t threads;           // 0: chosen by size; never changes the result
    bool dissolve;             // reduce waves that do not match their neighbours
    rumple_reference_settings rest;  // the shape that compression is measured against
} rumple_wrinkle_field_settings;
RUMPLE_API rumple_wrinkle_field_settings rumple_wrinkle_field_settings_default(void);

// f and df/dphi of the wave (section 6.3) at phi = pi i / RUMPLE_PROFILE_INTERVALS. f is even and has the
// period 2 pi.
#define RUMPLE_PROFILE_INTERVALS 64
typedef struct rumple_wrinkle_field_profile {
    float height[65];  // f, -1..1
    float slope[65];   // df/dphi
} rumple_wrinkle_field_profile;

typedef enum rumple_profile {
    RUMPLE_PROFILE_SINE = 0,
    RUMPLE_PROFILE_ACCORDION = 1,      // straight flanks
    RUMPLE_PROFILE_PENCIL_PLEATS = 2,  // round crests, sharp valleys
    RUMPLE_PROFILE_CURVE = 3           // drawn by the user
} rumple_profile;
// drawn: (RUMPLE_PROFILE_INTERVALS + 1) heights from crest to valley, -1..1, for RUMPLE_PROFILE_CURVE; or
// none.
RUMPLE_API rumple_status rumple_wrinkle_field_profile_build(int32_t kind, const float* drawn,
                                                            size_t drawn_count,
                                                            rumple_wrinkle_field_profile* profile);

// Painted values of the base's vertices; each n rows, or none.
typedef struct rumple_wrinkle_field_painted {
    const float* mask;  // (n): factor on the amplitude, 0..1
    size_t mask_count;
    const float* wavelength;  // (n), 0.001..1000: factor on W; or none
    size_t wavelength_count;
    const float* rest_wrinkle;  // (n, 3): p of section 7, along the compression, rest space, shorter than 1
    size_t rest_wrinkle_count;
    const float* along;  // (n, 3): direction of the waves' crests, see rumple_wrinkle_mesh_painted
    size_t along_count;
} rumple_wrinkle_field_painted;
typedef struct rumple_wrinkle_field_paint rumple_wrinkle_field_paint;
RUMPLE_API rumple_status rumple_wrinkle_field_paint_build(const rumple_wrinkle_field* model,
                                                          const rumple_wrinkle_field_painted* painted,
                                                          rumple_wrinkle_field_paint** paint);
RUMPLE_API void rumple_wrinkle_field_paint_free(rumple_wrinkle_field_paint* paint);

// ---- frames

// The pose of a model in one frame: the welded base and M of equation (1). Build it once per frame, and pass
// it to all functions for this frame. It keeps its model and a copy of the arrays of `frame`. Refused:
// positions that are not n or not finite. Fields that only an adaptive rest shape reads are checked in the
// solve. Cost: O(vertices), on several threads from 50,000 vertices on.
typedef struct rumple_wrinkle_field_pose rumple_wrinkle_field_pose;
RUMPLE_API rumple_status rumple_wrinkle_field_pose_build(const rumple_wrinkle_field* model,
                                                         const rumple_pose* frame,
                                                         rumple_wrinkle_field_pose** pose);
RUMPLE_API void rumple_wrinkle_field_pose_free(rumple_wrinkle_field_pose* pose);

// The solver's state, which is kept from frame to frame.
typedef struct rumple_wrinkle_field_state rumple_wrinkle_field_state;
RUMPLE_API void rumple_wrinkle_field_state_free(rumple_wrinkle_field_state* state);

// A state as plain arrays. A state built from them again continues with the same bits.
typedef struct rumple_wrinkle_field_state_view {
    const float* phase;  // (w): phi, radians
    size_t phase_count;
    const float* direction;  // (w, 2): k in the rest frame, with the sign that phi belongs to
    size_t direction_count;
    const float* solved_offset;  // (m): phase offsets in the last relaxation, radians
    size_t solved_offset_count;
    rumple_reference_view reference;  // of an adaptive rest shape
    size_t bytes;                     // memory of the state; not read by rumple_wrinkle_field_state_build()
} rumple_wrinkle_field_state_view;
RUMPLE_API rumple_status rumple_wrinkle_field_state_get_view(const rumple_wrinkle_field_state* state,
                                                             rumple_wrinkle_field_state_view* view);
RUMPLE_API rumple_status rumple_wrinkle_field_state_build(const rumple_wrinkle_field* model,
                                                          const rumple_wrinkle_field_state_view* arrays,
                                                          rumple_wrinkle_field_state** state);
// The same phases, but no vertex is asleep. Use it before a solve with other settings.
RUMPLE_API rumple_status rumple_wrinkle_field_state_activated(const rumple_wrinkle_field_state* state,
                                                              rumple_wrinkle_field_state** activated);

typedef struct rumple_wrinkle_field_report {
    int32_t rounds;       // of relaxation
    float misfit_before;  // RMS phase error over edges, turns, 0..0.5
    float misfit_after;
    float largest_change;  // largest change of a phase since the given state, radians
    int32_t wrinkled;      // vertices with a wave
    int32_t collapsed;     // vertices without a wave because their neighbourhood collapsed
} rumple_wrinkle_field_report;

// The waves of a frame without their phases: equations (1) to (4).
typedef struct rumple_waves rumple_waves;
RUMPLE_API void rumple_waves_free(rumple_waves* waves);

// Solves one frame: sections 4.2 and 5.2. before: state of the frame before; NULL: the canonical start.
// report: written. waves: receives the waves of this frame for rumple_wrinkle_field_show(); free them. It
// receives NULL if the waves are not finite, for example in a pose of an exploded simulation. paint, report
// and waves may be NULL. Deterministic on any number of threads. Cost: O(rounds x edges).
RUMPLE_API rumple_status rumple_wrinkle_field_solve(const rumple_wrinkle_field* model,
                                                    const rumple_wrinkle_field_settings* settings,
                                                    const rumple_wrinkle_field_paint* paint,
                                                    const rumple_wrinkle_field_pose* pose,
                                                    const rumple_wrinkle_field_state* before,
                                                    rumple_wrinkle_field_report* report, rumple_waves** waves,
                                                    rumple_wrinkle_field_state** state);

// The shown mesh of a solved frame, with its waves for shaders. gap: (n), how far the waves of a fine mesh
// may move inwards, object units; none: as far as outwards. waves: the waves from
// rumple_wrinkle_field_solve() for this state, settings, paint and pose. NULL: they are estimated again, with
// the same bits. Cost: O(triangles + shown vertices).
RUMPLE_API rumple_status rumple_wrinkle_field_show(
    const rumple_wrinkle_field* model, const rumple_wrinkle_field_settings* settings,
    const rumple_wrinkle_field_profile* profile, const rumple_wrinkle_field_paint* paint,
    const rumple_wrinkle_field_pose* pose, const float* gap, size_t gap_count, const rumple_waves* waves,
    const rumple_wrinkle_field_state* state, rumple_frame** frame);

// The waves of a frame. Corner values are in the order of the shown triangles. Each corner has values for the
// waves of all three corners. Interpolated over the triangle they give equation (5).
typedef struct rumple_frame_waves_view {
    int32_t vertex_count;               // d
    int32_t corner_count;               // 3 t with RUMPLE_FIELD_SHADING, else 0
    int32_t uv_count;                   // corner_count with a uv, else 0
    const float* amplitude;             // (d): h, object units
    const float* direction;             // (d, 3): k, unit, rest space
    const float* phase;                 // (d): phi, radians
    const float* corner_phase;          // (corner_count, 3): radians, without whole turns per triangle
    const float* corner_weight;         // (corner_count, 3): (h, 0, 0) at the first corner, object units
    const float* corner_wave_vector_0;  // (corner_count, 3): 2 pi / W k' of the first corner
    const float* corner_wave_vector_1;  // ... the second
    const float* corner_wave_vector_2;  // ... the third
    const float* corner_u_gradient;     // (uv_count, 3): du/dx' of equation (11), continuous over edges
    const float* corner_v_gradient;     // (uv_count, 3)
} rumple_frame_waves_view;
// Refused: a frame of another system.
RUMPLE_API rumple_status rumple_frame_get_waves(const rumple_frame* frame, rumple_frame_waves_view* view);

// See rumple_wrinkle_mesh_label_clip().
RUMPLE_API rumple_status rumple_wrinkle_field_label_clip(const rumple_wrinkle_field* model,
                                                         const rumple_wrinkle_field_settings* settings,
                                                         const double* times, size_t times_count,
                                                         const float* positions, size_t positions_count,
                                                         bool raw, uint8_t* labels, size_t labels_count);

// ---- the steps of a frame: for programs that draw the waves themselves, and for tests

typedef struct rumple_waves_view {
    int32_t vertex_count;      // w
    const float* positions;    // (w, 3): deformed, object space
    const float* normals;      // (w, 3): unit, or zero
    const float* wave_vector;  // (w, 3): 2 pi / W k', radians per object unit
    const float* height;       // (w): h, object units
    const float* fullness;     // (w): h / (W / 4), before strength
    const float* compression;  // (w): r
    const float* gather;       // (w): rest length / length along the wave
    const float* direction;    // (w, 2): k, rest frame
} rumple_waves_view;
RUMPLE_API rumple_status rumple_waves_get_view(const rumple_waves* waves, rumple_waves_view* view);

// Estimates the waves of a pose: section 4.2. positions: (n, 3). before may be NULL. Cost: O(edges).
RUMPLE_API rumple_status rumple_wrinkle_field_estimate_waves(const rumple_wrinkle_field* model,
                                                             const rumple_wrinkle_field_settings* settings,
                                                             const rumple_wrinkle_field_paint* paint,
                                                             const float* positions, size_t positions_count,
                                                             const rumple_wrinkle_field_state* before,
                                                             rumple_waves** waves);
// The waves that rumple_wrinkle_field_show() draws.
RUMPLE_API rumple_status rumple_wrinkle_field_shown_waves(const rumple_wrinkle_field* model,
                                                          const rumple_wrinkle_field_settings* settings,
                                                          const rumple_wrinkle_field_profile* profile,
                                                          const rumple_wrinkle_field_paint* paint,
                                                          const float* positions, size_t positions_count,
                                                          const rumple_wrinkle_field_state* state,
                                                          rumple_waves** waves);

// The parameters of the waves that settings and paint give every welded vertex. They do not depend on the
// pose. Each array has w rows, written.
typedef struct rumple_wrinkle_field_wave_parameters {
    float* wavelength;    // (w): W, object units
    float* mask;          // (w): factor on the amplitude
    float* rest_wrinkle;  // (w, 2): q, rest frame
    float* turn;          // (w, 2): (cos, sin) of the rotation away from k
    size_t count;         // w
} rumple_wrinkle_field_wave_parameters;
RUMPLE_API rumple_status rumple_wrinkle_field_get_wave_parameters(
    const rumple_wrinkle_field* model, const rumple_wrinkle_field_settings* settings,
    const rumple_wrinkle_field_paint* paint, const rumple_wrinkle_field_wave_parameters* parameters);

// Deformed positions and unit normals (or zero) of the welded vertices, (w, 3) each, written.
RUMPLE_API rumple_status rumple_wrinkle_field_weld_pose(const rumple_wrinkle_field* model,
                                                        const float* positions, size_t positions_count,
                                                        float* welded, float* normals, size_t welded_count);

// The stretch (xx, xy, yy) of every welded vertex from the reference triangles around it, rest frame.
// stretches: (w, 3), written where the rest shape adapts. adapts: written.
RUMPLE_API rumple_status rumple_wrinkle_field_stretches(const rumple_wrinkle_field* model,
                                                        const rumple_wrinkle_field_state* state,
                                                        const float* positions, size_t positions_count,
                                                        float* stretches, size_t stretches_count,
                                                        bool* adapts);

// The random phases at the start of a clip. phase: (w), radians, written.
RUMPLE_API rumple_status rumple_wrinkle_field_random_phases(const rumple_wrinkle_field* model, uint32_t seed,
                                                            float* phase, size_t phase_count);
// Section 5.2: runs `rounds` rounds of equation (6). align: align the phases first. phase: (w), changed.
RUMPLE_API rumple_status rumple_wrinkle_field_relax(const rumple_wrinkle_field* model,
                                                    const rumple_wrinkle_field_settings* settings,
                                                    const rumple_waves* waves, int32_t rounds, bool align,
                                                    float* phase, size_t phase_count);
// RMS phase error over edges, turns. phase: (w).
RUMPLE_API rumple_status rumple_wrinkle_field_misfit(const rumple_wrinkle_field* model,
                                                     const rumple_waves* waves, const float* phase,
                                                     size_t phase_count, float* misfit);

// Equations (5) and (8) at p places of the base. phase: (w). triangles: (p). barycentric: (p, 2), weights of
// corners 1 and 2, -1 to 2. heights: (p), gradients: (p, 3), object units and space, written.
RUMPLE_API rumple_status rumple_wrinkle_field_evaluate(const rumple_wrinkle_field* model,
                                                       const rumple_waves* waves,
                                                       const rumple_wrinkle_field_profile* profile,
                                                       const float* phase, size_t phase_count,
                                                       const int32_t* triangles, const float* barycentric,
                                                       size_t place_count, float* heights, float* gradients);

// For tests: evaluates shaders/shared/wrinkle_field_probe.glsl. arguments: (rows, 16). out: (rows, 16),
// written.
RUMPLE_API rumple_status rumple_probe_formula(int32_t formula, const float* arguments, size_t rows,
                                              float* out);

#ifdef __cplusplus
}
#endif

#endif
