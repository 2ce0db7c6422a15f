// SPDX-License-Identifier: GPL-3.0-or-later
// Blender's force fields at points of the world, with the formulas of its effect.c, so that swinging cloth
// moves like Blender's own Cloth. docs/base_cloth.md has the formulas, the units, and what is not supported.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/array.h"

namespace rumple::force_fields {

enum class Kind { kWind, kForce, kVortex, kHarmonic, kDrag, kTurbulence };
enum class Shape { kPoint, kLine, kPlane };  // distance is measured from the origin, the Z axis, the XY plane
enum class Falloff { kSphere, kTube, kCone };
enum class Side { kBoth, kAbove, kBelow };  // the side of the XY plane on which it acts

// The falloff of the strength with distance: 1 up to `least`, then (1 + distance - least)^-power, 0 beyond
// `most`.
struct Decay {
    float power = 0.0f;  // >= 0
    float least = 0.0f;  // >= 0
    float most = 0.0f;   // >= 0; used if `ends`
    bool ends = false;

    double share(double distance) const;
};

// Lengths in world units.
struct Field {
    Kind kind = Kind::kForce;
    Shape shape = Shape::kPoint;
    Falloff falloff = Falloff::kSphere;
    Side side = Side::kBoth;
    Vec3 location{0.0f};
    Vec3 axis{0.0f, 0.0f, 1.0f};  // Z, of any length but 0
    float strength = 1.0f;        // Drag: coefficient of quadratic drag
    float damping = 0.0f;         // Harmonic: damping ratio; Drag: coefficient of linear drag; >= 0
    float size = 0.0f;            // Turbulence: size of the noise; Harmonic: rest length; >= 0
    float flow = 0.0f;            // damping of the velocity
    float noise = 0.0f;           // random variation of the strength between points and frames, >= 0
    std::int32_t seed = 0;        // seed of this noise
    Decay along{};                // with the distance
    Decay across{};  // Tube: with the distance from the axis; Cone: with the angle to it, degrees
    bool inverse_square = false;  // Force: divided by the square of the distance
    bool in_world = false;        // Turbulence: the noise does not move with its object
};

// Throws InvalidInput naming the first number out of its range.
void check(const Field& field, size_t index);

// The effect of all fields together at a point.
struct Effect {
    Vec3 air{0.0f};     // velocity of the air: of the kind Wind, in the unit of its strength
    Vec3 push{0.0f};    // force of all other fields, in the unit of their strength
    Vec2 resist{0.0f};  // coefficients of linear and of quadratic drag
};

// frame: seed of the noise that changes from frame to frame. Each point i has its own noise. Throws
// InvalidInput. Cost: about 0.1 us per point and field, 1 us for Turbulence.
std::vector<Effect> effects(std::span<const Field> fields, std::int32_t frame, std::span<const Vec3> points);

// Improved noise (K. Perlin, "Improving Noise", SIGGRAPH 2002), -1..1. Finite.
double perlin_noise(double x, double y, double z);

}  // namespace rumple::force_fields
