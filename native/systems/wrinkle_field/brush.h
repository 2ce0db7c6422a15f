// SPDX-License-Identifier: GPL-3.0-or-later
// The brush of the Wrinkle Field: painted and random rest-pose wrinkles (Loviscach 2006, section 7).
//
// A painted value is p: a tangent vector of the rest pose, along the compression (across the folds), shorter
// than 1. p and -p mean the same. Arrays of painted values have one value per display vertex of the base. All
// vertices that a seam was split into get the same value.
#pragma once

#include <vector>

#include "systems/wrinkle_field/wrinkle_field.h"

namespace rumple::wrinkle_field {

// The longest vector a brush or scatter paints: at 1 the cloth would have collapsed.
inline constexpr float kLongestPainted = 0.99f;

// The surface under the brush: a pose of the base, per welded vertex, in the space of the given positions.
struct Canvas {
    std::vector<Vec3> positions;
    std::vector<Vec3> normals;    // unit, or zero
    std::vector<Vec3> tangent;    // M t: the rest frame's t, deformed by equation (1) ...
    std::vector<Vec3> bitangent;  // M b; both are zero if the neighbourhood has no normal
};

// positions: of the display vertices, deformed, in any space. In world space, angles are the visible ones,
// whatever the object's scale. Throws InvalidInput if they do not match the model or are not finite. Cost:
// O(edges).
Canvas lay_out(const Model& model, std::span<const Vec3> positions);

enum class Touch { kPaint, kErase, kSmooth };
enum class Falloff { kSmooth, kSharp, kLinear, kConstant };

// One dab of the brush. Lengths and directions in the canvas's space.
struct Dab {
    Touch touch = Touch::kPaint;
    Vec3 centre{0.0f};                 // on the surface
    Vec3 normal{0.0f, 0.0f, 1.0f};     // there: only vertices whose same side faces the viewer change
    Vec3 view{0.0f, 0.0f, -1.0f};      // from the viewer to the centre
    Vec3 direction{1.0f, 0.0f, 0.0f};  // of the stroke, as seen: parallel to the screen. kPaint only
    bool across = false;               // false: the folds run along the stroke; true: at right angles to it
    float radius = 0.1f;               // > 0
    float strength = 1.0f;             // blend factor at the centre, 0..1
    float length = 0.7f;               // length of the painted vectors, 0..kLongestPainted
    Falloff falloff = Falloff::kSmooth;
};

// For every welded vertex, the place on the rest surface of its mirror image in the plane x = 0. The triangle
// is kNone if this place is farther away than half the vertex's mean edge. Cost: O(vertices log triangles).
std::vector<SurfacePoint> find_twins(const Model& model);

// Applies a dab. twins: from find_twins(), to paint the mirror image too; or empty. painted: per vertex of
// the base, rest space, changed in place. Throws InvalidInput if an argument is out of its range or does not
// match, or if a painted value is not finite or not shorter than 1. Lengths stay below 1. Cost: O(vertices).
void apply(const Model& model, const Canvas& canvas, const Dab& dab, std::span<const SurfacePoint> twins,
           std::span<Vec3> painted);

// Random rest-pose wrinkles. They depend only on these numbers and on the rest positions.
struct Scatter {
    std::uint32_t seed = 0;
    float density = 0.5f;  // share of the vertices with wrinkles, 0..1
    float size = 0.1f;     // distance over which direction and strength change, object units, > 0
    float length = 0.7f;   // length of the longest vectors, 0..kLongestPainted
};
// Per vertex of the base. Throws InvalidInput naming a setting out of its range. Cost: O(vertices).
std::vector<Vec3> scatter(const Model& model, const Scatter& settings);

// Lines on the canvas for an overlay: two ends each, and their strengths |p|.
struct Lines {
    std::vector<Vec3> ends;
    std::vector<float> strength;
};
// A line for every painted vertex: along its folds or, with `across`, along the compression. Its length is
// the mean edge around the vertex times |p|. Values that are not finite have no line. Throws InvalidInput if
// painted does not match. Cost: O(edges).
Lines draw(const Model& model, const Canvas& canvas, std::span<const Vec3> painted, bool across);

}  // namespace rumple::wrinkle_field
