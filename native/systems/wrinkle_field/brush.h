// SPDX-License-Identifier: GPL-3.0-or-later
// Section 7 of Loviscach 2006: painting rest-pose wrinkles, and generating them randomly.
//
// A painted value is p: a tangent vector of the rest pose, along the compression (across the folds), shorter
// than 1. p and -p mean the same. Arrays of them have one value per vertex of the base as the artist has it;
// what is written is the same for all vertices that a seam was split into.
#pragma once

#include <vector>

#include "systems/wrinkle_field/wrinkle_field.h"

namespace rumple::wrinkle_field {

// The longest vector a brush or scatter paints: at 1 the cloth would have collapsed.
inline constexpr float kLongestPainted = 0.99f;

// The surface under the brush: a pose of the base, per welded vertex, in the space of the positions given.
struct Canvas {
    std::vector<Vec3> positions;
    std::vector<Vec3> normals;    // unit, or zero
    std::vector<Vec3> tangent;    // M t: where the deformation of equation (1) takes the rest frame's t ...
    std::vector<Vec3> bitangent;  // ... and b; zero where a neighbourhood has no normal
};

// positions: of the base's vertices as the artist has them, deformed, in any space (the world: then angles
// are those that are seen, whatever the object's scale). Throws InvalidInput when they do not match the model
// or are not finite. Cost: O(edges).
Canvas lay_out(const Model& model, std::span<const Vec3> positions);

enum class Touch { kPaint, kErase, kSmooth };
enum class Falloff { kSmooth, kSharp, kLinear, kConstant };

// The brush set down once. Lengths and directions in the canvas's space.
struct Dab {
    Touch touch = Touch::kPaint;
    Vec3 centre{0.0f};                 // on the surface
    Vec3 normal{0.0f, 0.0f, 1.0f};     // there: only vertices that show the viewer the same side are touched
    Vec3 view{0.0f, 0.0f, -1.0f};      // from the viewer to the centre
    Vec3 direction{1.0f, 0.0f, 0.0f};  // of the stroke, as seen: parallel to the screen. kPaint only
    bool across = false;               // false: the folds run along the stroke; true: at right angles to it
    float radius = 0.1f;               // > 0
    float strength = 1.0f;             // share of the way to what is asked for, at the centre, 0..1
    float length = 0.7f;               // of the vectors asked for, 0..kLongestPainted
    Falloff falloff = Falloff::kSmooth;
};

// For every welded vertex the place where its mirror image in the plane x = 0 lies on the rest surface;
// triangle kNone where that is farther away than half the vertex's mean edge. Cost: O(vertices log
// triangles).
std::vector<SurfacePoint> find_twins(const Model& model);

// One dab. twins: of find_twins() to paint the mirror image too, or empty. painted: per vertex of the base,
// rest space, changed in place. Throws InvalidInput when an argument is out of its range or does not match,
// or a value of painted is not finite or not shorter than 1. Lengths stay below 1. Cost: O(vertices).
void apply(const Model& model, const Canvas& canvas, const Dab& dab, std::span<const SurfacePoint> twins,
           std::span<Vec3> painted);

// Random rest-pose wrinkles: a function of these numbers and of the rest positions alone.
struct Scatter {
    std::uint32_t seed = 0;
    float density = 0.5f;  // share of the vertices that wrinkle, 0..1
    float size = 0.1f;     // over which direction and strength change, object units, > 0
    float length = 0.7f;   // of the longest vectors, 0..kLongestPainted
};
// Per vertex of the base. Throws InvalidInput naming a setting out of its range. Cost: O(vertices).
std::vector<Vec3> scatter(const Model& model, const Scatter& settings);

// What an overlay draws: lines on the canvas, two ends each, and how strong they are (|p|).
struct Lines {
    std::vector<Vec3> ends;
    std::vector<float> strength;
};
// A line for every painted vertex: along its folds or, with `across`, along the compression; as long as the
// mean edge around the vertex times |p|. Vectors that are not finite have none. Throws InvalidInput when
// painted does not match. Cost: O(edges).
Lines draw(const Model& model, const Canvas& canvas, std::span<const Vec3> painted, bool across);

}  // namespace rumple::wrinkle_field
