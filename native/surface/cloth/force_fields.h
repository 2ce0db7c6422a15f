// SPDX-License-Identifier: GPL-3.0-or-later
// What Blender's force fields do at points of the world: the formulas of its effect.c, so that cloth that
// swings meets them as Blender's own Cloth does. docs/base_cloth.md has them, with units and what is not
// covered.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/array.h"

namespace rumple::force_fields {

enum class Kind { kWind, kForce, kVortex, kHarmonic, kDrag, kTurbulence };
enum class Shape { kPoint, kLine, kPlane };  // what distance is from: the origin, the Z axis, the XY plane
enum class Falloff { kSphere, kTube, kCone };
enum class Side { kBoth, kAbove, kBelow };  // of the XY plane: where it acts

// What is left of the strength at a distance: 1 up to `least`, (1 + distance - least)^-power, 0 beyond
// `most`.
struct Decay {
    float power = 0.0f;  // >= 0
    float least = 0.0f;  // >= 0
    float most = 0.0f;   // >= 0; counts where `ends`
    bool ends = false;

    double share(double distance) const;
};

// Lengths in units of the world.
struct Field {
    Kind kind = Kind::kForce;
    Shape shape = Shape::kPoint;
    Falloff falloff = Falloff::kSphere;
    Side side = Side::kBoth;
    Vec3 location{0.0f};
    Vec3 axis{0.0f, 0.0f, 1.0f};  // Z, of any length but 0
    float strength = 1.0f;        // Drag: of the square of the velocity
    float damping = 0.0f;         // of Harmonic and Drag, >= 0
    float size = 0.0f;            // of the noise of Turbulence; rest length of Harmonic, >= 0
    float flow = 0.0f;            // how much of the velocity is taken
    float noise = 0.0f;     // how much the strength varies, from point to point and frame to frame, >= 0
    std::int32_t seed = 0;  // of that
    Decay along{};          // with the distance
    Decay across{};         // Tube: with the distance from the axis; Cone: with the angle to it, degrees
    bool inverse_square = false;  // Force: divided by the square of the distance
    bool in_world = false;        // Turbulence: stays where it is when its object moves
};

// Throws InvalidInput naming the first number out of its range.
void check(const Field& field, size_t index);

// Of all fields together at a point.
struct Effect {
    Vec3 air{0.0f};     // velocity of the air: of the kind Wind, in the unit of its strength
    Vec3 push{0.0f};    // of all others, in the unit of theirs
    Vec2 resist{0.0f};  // times the velocity, and times the velocity and its length: against it
};

// frame: for what varies from frame to frame. Point i has noise of its own. Throws InvalidInput. Cost: about
// 0.1 us a point and field, 1 us for Turbulence.
std::vector<Effect> effects(std::span<const Field> fields, std::int32_t frame, std::span<const Vec3> points);

// Improved noise (K. Perlin, "Improving Noise", SIGGRAPH 2002), -1..1. Finite.
double perlin_noise(double x, double y, double z);

}  // namespace rumple::force_fields
