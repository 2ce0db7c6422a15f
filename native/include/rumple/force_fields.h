// SPDX-License-Identifier: GPL-3.0-or-later
// Blender's force fields at points of the world, as its effect.c has them: for cloth that swings
// (rumple_base_cloth_swing). docs/base_cloth.md has the formulas.
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
    RUMPLE_FIELD_SHAPE_POINT = 0,  // distance is from the location
    RUMPLE_FIELD_SHAPE_LINE = 1,   // ... from the axis
    RUMPLE_FIELD_SHAPE_PLANE = 2   // ... from the plane across it; of a vortex: from the axis
} rumple_force_field_shape;

typedef enum rumple_force_field_falloff {
    RUMPLE_FIELD_FALLOFF_SPHERE = 0,
    RUMPLE_FIELD_FALLOFF_TUBE = 1,
    RUMPLE_FIELD_FALLOFF_CONE = 2
} rumple_force_field_falloff;

typedef enum rumple_force_field_side {
    RUMPLE_FIELD_SIDE_BOTH = 0,
    RUMPLE_FIELD_SIDE_ABOVE = 1,  // where the axis points
    RUMPLE_FIELD_SIDE_BELOW = 2
} rumple_force_field_side;

// Lengths are units of the world. No number is beyond 1e9.
typedef struct rumple_force_field {
    int32_t kind;     // rumple_force_field_kind
    int32_t shape;    // rumple_force_field_shape
    int32_t falloff;  // rumple_force_field_falloff
    int32_t side;     // of the plane across the axis, where it acts: rumple_force_field_side
    float location[3];
    float axis[3];       // Z of the object, of any length; 0: no direction
    float strength;      // wind: velocity; drag: of the square of the velocity; else: force
    float damping;       // of harmonic, a ratio, and of drag, >= 0
    float size;          // of the noise of turbulence; rest length of harmonic; >= 0
    float flow;          // how much it takes from the velocity; not of wind, harmonic, drag
    float noise;         // how much the strength varies from point to point and frame to frame, >= 0
    int32_t seed;        // of that
    float power;         // of the falloff, 0..1000: (1 + distance - least)^-power
    float least;         // distance up to which nothing is lost, >= 0
    float most;          // beyond it nothing is left, where it ends, >= 0
    bool ends;           // whether `most` counts
    float radial_power;  // likewise; tube: with the distance from the axis, cone: with the angle to it,
    float radial_least;  // ... degrees; sphere: without effect
    float radial_most;
    bool radial_ends;
    bool inverse_square;  // of force: divided by the distance squared
    bool in_world;        // of turbulence: stays in the world when the location moves
} rumple_force_field;
RUMPLE_API rumple_force_field rumple_force_field_default(void);

// What all fields do together. frame: noise differs from frame to frame. positions: (p, 3), world space,
// finite. Written: air, (p, 3), the velocity of the air: winds; push, (p, 3), the force of all others;
// resist, (p, 2), >= 0: against the velocity, times it and times it and its length. Units are those of the
// strengths.
// Cost: about 0.1 us a point and field, 1 us for turbulence.
RUMPLE_API rumple_status rumple_force_fields_evaluate(const rumple_force_field* fields, size_t fields_count,
                                                      int32_t frame, const float* positions,
                                                      size_t positions_count, float* air, size_t air_count,
                                                      float* push, size_t push_count, float* resist,
                                                      size_t resist_count);

#ifdef __cplusplus
}
#endif

#endif
