// SPDX-License-Identifier: GPL-3.0-or-later
// The base cloth: the coarse mesh itself becomes cloth around its animation, so that it hangs, pulls taut and
// rests on bodies. Mueller and Chentanez 2010, section 4.3; docs/base_cloth.md has the energy.
#ifndef RUMPLE_BASE_CLOTH_H
#define RUMPLE_BASE_CLOTH_H

#include "surface.h"

#ifdef __cplusplus
extern "C" {
#endif

// ---- bodies

// The triangles of bodies that cloth stays outside of, with a bounding volume hierarchy.
typedef struct rumple_collider rumple_collider;

// positions: (b, 3), any pose, finite. triangles: (triangles, 3), at least one, 0..b - 1.
// rest: (b, 3) or none: positions of the bodies while the cloth is at rest. They decide which triangles can
// be under which place of the cloth, in every pose. A triangle is not under a place if, at rest, its middle
// is farther than worn_within from it, or its outer side faces away from it. A triangle whose rest positions
// are not finite may be under any place. Cost: O(n log^2 n).
RUMPLE_API rumple_status rumple_collider_build(const float* positions, size_t positions_count,
                                               const int32_t* triangles, size_t triangles_count,
                                               const float* rest, size_t rest_count, float worn_within,
                                               rumple_collider** collider);
RUMPLE_API void rumple_collider_free(rumple_collider* collider);
// The number of vertices b; 0 for NULL.
RUMPLE_API int32_t rumple_collider_vertex_count(const rumple_collider* collider);

// Bodies in the pose of a frame. Without a collider there are none.
typedef struct rumple_bodies {
    const rumple_collider* collider;  // or NULL
    const float* positions;           // (b, 3), object space of the cloth, finite
    size_t positions_count;
} rumple_bodies;

// ---- the cloth

// The springs and contacts of a coarse mesh at rest.
typedef struct rumple_base_cloth rumple_base_cloth;
// surface: any surface, at rest; n vertices, w welded vertices. Cost: O(n log n).
RUMPLE_API rumple_status rumple_base_cloth_build(const rumple_surface* surface, rumple_base_cloth** model);
RUMPLE_API void rumple_base_cloth_free(rumple_base_cloth* model);

// Stiffness is per mass of cloth: membrane stiffness / mass per area, object units^2 / s^2.
typedef struct rumple_base_cloth_settings {
    float stretch;            // stiffness of edges that are longer than at rest, > 0
    float strain_limit;       // strain beyond which stretch is ten times as stiff, >= 0
    float shear;              // stiffness of quad diagonals that are longer than at rest, >= 0
    float compression;        // k1: stiffness of edges shorter than at rest, >= 0
    float compression_limit;  // c_l: length / rest length below which k2 applies, 0..1
    float folded;             // k2: stiffness of edges shorter than c_l, >= 0
    float smoothing;          // resistance of edges against turning from their animated direction, >= 0
    float tube_radius;        // around a tube of radius R these three are scaled by (tube_radius / R)^4; > 0
    float flat_share;         // the least such scale, for directions along tubes and flat cloth, 0..1
    float hem_share;          // factor on smoothing at a hem that nothing holds, 0..1
    float slack;              // length of the cloth / length of the modelled garment, > 0
    float hang[3];            // object space, length 0..1: in this direction there is no slack
    float follow;             // pull towards the animation where nothing is pinned, 1/s^2, > 0
    float room;               // largest distance of a vertex from its animated place, object units, >= 0
    float slide_room;         // the same along the surface, if larger than room; object units, >= 0
    float friction;           // coefficient of Coulomb friction on the bodies under the cloth, >= 0
    float gravity[3];         // object space, object units / s^2, finite
    float thickness;          // how far cloth stays off bodies, object units, >= 0
    float unknown;            // how far cloth may move inwards where no body is found, object units, >= 0
    float reach;              // bodies farther away are ignored, object units, > 0
    float depth;              // cloth deeper inside a body is not pushed out, object units, > 0
    float spread;             // length over which clearance fades from bodies to `unknown`, object units, > 0
    int32_t steps;            // largest number of Newton steps from a given state, >= 0
    int32_t start_steps;      // Newton steps from the animation, >= 0
    int32_t most_cg_iterations;  // of conjugate gradients (CG) in a Newton step, >= 0
} rumple_base_cloth_settings;
RUMPLE_API rumple_base_cloth_settings rumple_base_cloth_settings_default(void);

// Additional settings for cloth with inertia.
typedef struct rumple_base_cloth_swing {
    float seconds;       // time since the frame before, >= 0
    float longest_step;  // longest time step, s, > 0: the same value gives the same motion at any frame rate
    int32_t newton_steps;  // for every time step, >= 1
    float damping;         // damping of the velocity relative to the animated one, 1/s, >= 0
    float locomotion;      // share of the garment's overall motion that causes inertia, 0..1
    float drag;            // density of the air x coefficient / (2 mass per area), 1/object unit, >= 0
    float wind[3];         // velocity of the air, object space, object units / s
    float matrix[9];       // (3, 3): from the object space of the frame before to this one's ...
    float shift[3];        // ... and the translation after it, object units
    // Values per vertex, in object space; each finite, or none.
    const float* air;  // (n, 3): velocity of the air in addition to `wind`, object units / s
    size_t air_count;
    const float* push;  // (n, 3): acceleration in addition to gravity, object units / s^2
    size_t push_count;
    const float* resist;  // (n, 2): linear drag on the velocity, 1/s, and quadratic drag, 1/object
    size_t resist_count;  // unit; >= 0
} rumple_base_cloth_swing;
RUMPLE_API rumple_base_cloth_swing rumple_base_cloth_swing_default(void);

// Painted factors of the base's vertices; each (n), or none.
typedef struct rumple_base_cloth_painted {
    const float* follow;  // 0..1; 1: pinned to the animation; none: 0 for all
    size_t follow_count;
    const float* room;  // 0..1000: factor on `room`, and, limited to 1, on `slide_room`; none: 1 for all
    size_t room_count;
} rumple_base_cloth_painted;
typedef struct rumple_base_cloth_paint rumple_base_cloth_paint;
// Refused: an array that is neither of n values nor none, a value outside of its range. Cost: O(n).
RUMPLE_API rumple_status rumple_base_cloth_paint_build(const rumple_base_cloth* model,
                                                       const rumple_base_cloth_painted* painted,
                                                       rumple_base_cloth_paint** paint);
RUMPLE_API void rumple_base_cloth_paint_free(rumple_base_cloth_paint* paint);

// A solved frame, and the values that the next frame starts from.
typedef struct rumple_base_cloth_state rumple_base_cloth_state;
RUMPLE_API void rumple_base_cloth_state_free(rumple_base_cloth_state* state);

typedef struct rumple_base_cloth_state_view {
    int32_t vertex_count;         // n
    int32_t welded_vertex_count;  // w
    int32_t body_hint_count;      // n; 0 without bodies
    int32_t velocity_count;       // w; 0 without inertia
    int32_t offset_count;         // w; 0 with inertia
    int32_t clearance_count;
    size_t bytes;              // memory of the values for the next frame
    const float* positions;    // (n, 3): the cloth, object space
    const float* gap;          // (n): height above the body, object units, >= 0
    const int32_t* body_hint;  // (body_hint_count): a triangle of the collider near each vertex, or -1
    const float* velocity;     // (velocity_count, 3), object units / s
    const float* offset;       // (offset_count, 3): in the tangent frame of the animated vertex
    const float* clearance;    // (clearance_count): how far each may move inwards, object units
} rumple_base_cloth_state_view;
// The arrays are the state's own: valid until it is freed. Cost: none.
RUMPLE_API rumple_status rumple_base_cloth_state_get_view(const rumple_base_cloth_state* state,
                                                          rumple_base_cloth_state_view* view);
// The values that the next frame starts from, as plain arrays. A state can be built from them again, and
// continues with the same bits. A state built in this way has no positions: its view has no vertices. The
// next solve gives a complete state.
typedef struct rumple_base_cloth_kept {
    const float* offset;  // (w, 3), or none with inertia
    size_t offset_count;
    const float* length;  // (springs): in the solved pose, as the next two
    size_t length_count;
    const float* clearance;  // (w)
    size_t clearance_count;
    const float* ahead_height;  // (w)
    size_t ahead_height_count;
    const int32_t* body_hint;  // (w) or none: a triangle of the collider near each vertex, or -1
    size_t body_hint_count;
    const int32_t* contact_hint;  // (w): a triangle of the cloth near each vertex, or -1
    size_t contact_hint_count;
    const float* position;  // (w, 3), object units; this and all below only with inertia
    size_t position_count;
    const float* velocity;  // (w, 3), object units / s
    size_t velocity_count;
    const float* animated;  // (w, 3)
    size_t animated_count;
    const float* animated_before;  // (w, 3)
    size_t animated_before_count;
    float moved;       // largest movement of a vertex in the last full step, object units, >= 0
    float seconds;     // between the two poses, >= 0
    float fastest;     // largest speed in the frame, object units / s, >= 0
    float gravity[3];  // in this frame, object space, object units / s^2; without inertia in the frame of
                       // the rest shape
    float wind[3];     // in this frame, object space, object units / s
    const float* air;  // (w, 3), object units / s, or none
    size_t air_count;
    const float* push;  // (w, 3), object units / s^2, or none
    size_t push_count;
} rumple_base_cloth_kept;
// The arrays are the state's own: valid until it is freed. Cost: none.
RUMPLE_API rumple_status rumple_base_cloth_state_get_kept(const rumple_base_cloth_state* state,
                                                          rumple_base_cloth_kept* kept);
// Copies the arrays. Refused: arrays that do not fit the model, numbers that are not finite, invalid hints.
// Cost: O(w).
RUMPLE_API rumple_status rumple_base_cloth_state_build(const rumple_base_cloth* model,
                                                       const rumple_base_cloth_kept* kept,
                                                       rumple_base_cloth_state** state);
// A copy in which no vertex is asleep. Use it before a solve with other settings.
RUMPLE_API rumple_status rumple_base_cloth_state_activated(const rumple_base_cloth_state* state,
                                                           rumple_base_cloth_state** activated);

typedef struct rumple_base_cloth_report {
    int32_t steps;          // 0: the cloth was asleep, nothing was solved
    int32_t cg_iterations;  // of all steps
    float moved;            // largest movement of a vertex in the last full step, object units
    float offset_mean;      // from the animation, object units
    float offset_max;
    float taut;        // share of the springs that are longer than at rest
    float touching;    // share of the vertices that rest on the inner surface
    float body_known;  // share of the vertices that have a body under them
} rumple_base_cloth_report;

// Solves one frame without inertia: the equilibrium of its pose. positions: (n, 3), animated. before: state
// of the frame before. report: written. paint, bodies, before and report may be NULL. Refused: a setting out
// of its range; positions that are not n, not finite, or far from the rest shape; paint or state of another
// model. Cost: about 0.03 us per vertex and CG iteration, and 1 us per vertex and step for contact.
RUMPLE_API rumple_status rumple_base_cloth_solve(const rumple_base_cloth* model,
                                                 const rumple_base_cloth_settings* settings,
                                                 const rumple_base_cloth_paint* paint, const float* positions,
                                                 size_t positions_count, const rumple_bodies* bodies,
                                                 const rumple_base_cloth_state* before,
                                                 rumple_base_cloth_report* report,
                                                 rumple_base_cloth_state** state);
// Solves one frame with inertia (Baraff and Witkin 1998). Without a state with inertia it returns the
// equilibrium, with zero velocity. All else is as in rumple_base_cloth_solve(). Also refused: a value of
// `swing` out of its range; air, push or resist that are neither n rows nor none. Cost: about 0.7 of
// rumple_base_cloth_solve() for each time step.
RUMPLE_API rumple_status rumple_base_cloth_swing_solve(
    const rumple_base_cloth* model, const rumple_base_cloth_settings* settings,
    const rumple_base_cloth_swing* swing, const rumple_base_cloth_paint* paint, const float* positions,
    size_t positions_count, const rumple_bodies* bodies, const rumple_base_cloth_state* before,
    rumple_base_cloth_report* report, rumple_base_cloth_state** state);

// ---- its smooth surface

// Points of the smooth surface of a coarse mesh, which are kept off bodies. It is for systems that lie on the
// base cloth and do not handle bodies themselves.
typedef struct rumple_cloth_cover rumple_cloth_cover;
// surface: the coarse mesh at rest, n vertices. It is subdivided once. Cost: O(n).
RUMPLE_API rumple_status rumple_cloth_cover_build(const rumple_surface* surface, rumple_cloth_cover** cover);
RUMPLE_API void rumple_cloth_cover_free(rumple_cloth_cover* cover);

typedef struct rumple_cloth_cover_settings {
    float thickness;  // how far the smooth surface stays off bodies, object units, >= 0
    float depth;      // cloth deeper inside a body is not pushed out, object units, > 0
} rumple_cloth_cover_settings;
RUMPLE_API rumple_cloth_cover_settings rumple_cloth_cover_settings_default(void);

// How far every vertex must move outwards, and how far folds around it may go inwards then. positions: (n, 3)
// of the cloth. hints: (n), a triangle of the collider near each vertex, or -1. lifts: (n, 3), written. room:
// (n), object units, written: 0 where the cloth was lifted, 1e8 where no body is near. Cost: about 1 us per
// point with a hint.
RUMPLE_API rumple_status rumple_cloth_cover_lift(const rumple_cloth_cover* cover,
                                                 const rumple_cloth_cover_settings* settings,
                                                 const rumple_bodies* bodies, const float* positions,
                                                 size_t positions_count, const int32_t* hints,
                                                 size_t hints_count, float* lifts, size_t lifts_count,
                                                 float* room, size_t room_count);

// The positions of the cloth without triangles that are turned over there and not in the animation: vertices
// around them get the mean displacement of their neighbours, if no edge becomes much longer. animated,
// positions: (n, 3). untangled: (n, 3), written. Cost: about 30 ns per triangle.
RUMPLE_API rumple_status rumple_cloth_untangle(const rumple_surface* surface, const float* animated,
                                               size_t animated_count, const float* positions,
                                               size_t positions_count, float* untangled,
                                               size_t untangled_count);

#ifdef __cplusplus
}
#endif

#endif
