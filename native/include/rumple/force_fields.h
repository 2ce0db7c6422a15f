// SPDX-License-Identifier: GPL-3.0-or-later
// Blender's force fields, evaluated at points of the world as in its effect.c. They are input of
// rumple_base_cloth_swing, for cloth with inertia. docs/base_cloth.md has the formulas.
#ifndef RUMPLE_FORCE_FIELDS_H
#define RUMPLE_FORCE_FIELDS_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rumple_force_field_kind {
    RUMPLE_FORCE_FIELD_WIND = 0,
    RUMPLE_FORCE_FIELD_FORCE = 1,
    RUMPLE_FORCE_FIELD_VORTEX = 2,
    RUMPLE_FORCE_FIELD_HARMONIC = 3,
    RUMPLE_FORCE_FIELD_DRAG = 4,
    RUMPLE_FORCE_FIELD_TURBULENCE = 5
} rumple_force_field_kind;

typedef enum rumple_force_field_shape {
    RUMPLE_FIELD_SHAPE_POINT = 0,  // distances are measured from the location
    RUMPLE_FIELD_SHAPE_LINE = 1,   // ... from the axis
    RUMPLE_FIELD_SHAPE_PLANE = 2   // ... from the plane perpendicular to it; for a vortex: from the axis
} rumple_force_field_shape;

typedef enum rumple_force_field_falloff {
    RUMPLE_FIELD_FALLOFF_SPHERE = 0,
    RUMPLE_FIELD_FALLOFF_TUBE = 1,
    RUMPLE_FIELD_FALLOFF_CONE = 2
} rumple_force_field_falloff;

typedef enum rumple_force_field_side {
    RUMPLE_FIELD_SIDE_BOTH = 0,
    RUMPLE_FIELD_SIDE_ABOVE = 1,  // the side that the axis points to
    RUMPLE_FIELD_SIDE_BELOW = 2
} rumple_force_field_side;

// Lengths are in world units. No absolute value may be larger than 1e9.
typedef struct rumple_force_field {
    int32_t kind;     // rumple_force_field_kind
    int32_t shape;    // rumple_force_field_shape
    int32_t falloff;  // rumple_force_field_falloff
    int32_t side;     // rumple_force_field_side: of the plane across the axis; it acts on this side
    float location[3];
    float axis[3];       // Z axis of the object, any length; 0: no direction
    float strength;      // wind: velocity; drag: coefficient of quadratic drag; others: force
    float damping;       // harmonic: damping ratio; drag: coefficient of linear drag; >= 0
    float size;          // turbulence: size of the noise; harmonic: rest length; >= 0
    float flow;          // damping of the velocity; not used by wind, harmonic, drag
    float noise;         // random variation of the strength between points and frames, >= 0
    int32_t seed;        // seed of this noise
    float power;         // of the falloff (1 + distance - least)^-power, 0..1000
    float least;         // up to this distance there is no falloff, >= 0
    float most;          // if `ends`: beyond this distance the field is 0, >= 0
    bool ends;           // whether `most` is used
    float radial_power;  // the same; tube: by distance from the axis, cone: by the angle to the axis,
    float radial_least;  // ... degrees; sphere: without effect
    float radial_most;
    bool radial_ends;
    bool inverse_square;  // force: strength is divided by the squared distance
    bool in_world;        // turbulence: the noise does not move with the location
} rumple_force_field;
RUMPLE_API rumple_force_field rumple_force_field_default(void);

// The sum of all fields. frame: seed of the noise that changes from frame to frame. positions: (p, 3), world
// space, finite. Written, in the units of the strengths:
//   air: (p, 3), the velocity of the air, from winds.
//   push: (p, 3), the force of all other fields.
//   resist: (p, 2), >= 0, the coefficients of linear and of quadratic drag.
// Cost: about 0.1 us per point and field, 1 us for turbulence.
RUMPLE_API rumple_status rumple_force_fields_evaluate(const rumple_force_field* fields, size_t fields_count,
                                                      int32_t frame, const float* positions,
                                                      size_t positions_count, float* air, size_t air_count,
                                                      float* push, size_t push_count, float* resist,
                                                      size_t resist_count);

#ifdef __cplusplus
}
#endif

#endif
