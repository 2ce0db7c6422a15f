// SPDX-License-Identifier: GPL-3.0-or-later
// The brush of the Wrinkle Field: painting wrinkles of the rest pose, and random wrinkles (Loviscach 2006,
// section 7). A painted value p is a tangent vector of the rest pose, along the compression (across the
// folds), shorter than 1. p and -p mean the same. Arrays of painted values are (n, 3), for the base's
// vertices.
#ifndef RUMPLE_WRINKLE_FIELD_BRUSH_H
#define RUMPLE_WRINKLE_FIELD_BRUSH_H

#include "wrinkle_field.h"

#ifdef __cplusplus
extern "C" {
#endif

// The longest vector that a brush or scatter paints.
#define RUMPLE_LONGEST_PAINTED 0.99f

// A pose that is painted on.
typedef struct rumple_canvas rumple_canvas;
// positions: (n, 3), deformed, in any space. Dabs must be in the same space. Cost: O(edges).
RUMPLE_API rumple_status rumple_canvas_build(const rumple_wrinkle_field* model, const float* positions,
                                             size_t positions_count, rumple_canvas** canvas);
RUMPLE_API void rumple_canvas_free(rumple_canvas* canvas);

// For every vertex, the place on the rest surface of its mirror image in x = 0.
typedef struct rumple_twins rumple_twins;
// found: how many welded vertices have a mirror image, written; or NULL. Cost: O(vertices log triangles).
RUMPLE_API rumple_status rumple_twins_build(const rumple_wrinkle_field* model, int32_t* found,
                                            rumple_twins** twins);
RUMPLE_API void rumple_twins_free(rumple_twins* twins);

typedef enum rumple_touch {
    RUMPLE_TOUCH_PAINT = 0,
    RUMPLE_TOUCH_ERASE = 1,
    RUMPLE_TOUCH_SMOOTH = 2
} rumple_touch;
typedef enum rumple_falloff {
    RUMPLE_FALLOFF_SMOOTH = 0,
    RUMPLE_FALLOFF_SHARP = 1,
    RUMPLE_FALLOFF_LINEAR = 2,
    RUMPLE_FALLOFF_CONSTANT = 3
} rumple_falloff;

// One dab of the brush. Lengths and directions are in the space of the canvas.
typedef struct rumple_dab {
    int32_t touch;       // rumple_touch
    float centre[3];     // on the surface
    float normal[3];     // at the centre: only vertices whose same side faces the viewer are changed
    float view[3];       // from the viewer to the centre
    float direction[3];  // of the stroke, parallel to the screen; RUMPLE_TOUCH_PAINT only
    bool across;         // false: the folds run along the stroke; true: at right angles to it
    float radius;        // > 0
    float strength;      // blend factor at the centre, 0..1
    float length;        // length of the painted vectors, 0..RUMPLE_LONGEST_PAINTED
    int32_t falloff;     // rumple_falloff
} rumple_dab;
RUMPLE_API rumple_dab rumple_dab_default(void);

// Applies a dab. twins: to paint the mirror image too; or NULL. painted: (n, 3), changed. Cost: O(vertices).
RUMPLE_API rumple_status rumple_dab_apply(const rumple_canvas* canvas, const rumple_dab* dab,
                                          const rumple_twins* twins, float* painted, size_t painted_count);

// Random wrinkles. They depend only on these numbers and on the rest positions.
typedef struct rumple_scatter {
    uint32_t seed;
    float density;  // share of the vertices with wrinkles, 0..1
    float size;     // distance over which direction and strength change, object units, > 0
    float length;   // length of the longest vectors, 0..RUMPLE_LONGEST_PAINTED
} rumple_scatter;
RUMPLE_API rumple_scatter rumple_scatter_default(void);
// painted: (n, 3), written. Cost: O(vertices).
RUMPLE_API rumple_status rumple_scatter_paint(const rumple_wrinkle_field* model,
                                              const rumple_scatter* scatter, float* painted,
                                              size_t painted_count);

// Lines on a canvas, for an overlay.
typedef struct rumple_lines rumple_lines;
RUMPLE_API void rumple_lines_free(rumple_lines* lines);
typedef struct rumple_lines_view {
    int32_t line_count;     // m
    const float* ends;      // (2 m, 3): both ends of every line, space of the canvas
    const float* strength;  // (m): |p|
} rumple_lines_view;
RUMPLE_API rumple_status rumple_lines_get_view(const rumple_lines* lines, rumple_lines_view* view);
// painted: (n, 3). across: true: lines run along the compression; false: along the folds. Cost: O(edges).
RUMPLE_API rumple_status rumple_canvas_draw(const rumple_canvas* canvas, const float* painted,
                                            size_t painted_count, bool across, rumple_lines** lines);

#ifdef __cplusplus
}
#endif

#endif
