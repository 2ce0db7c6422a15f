// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/force_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "base/elementary.h"
#include "base/expect.h"
#include "base/random.h"
#include "base/unit_vector.h"

namespace rumple::force_fields {
namespace {

using Real3 = glm::dvec3;

constexpr double kFarthest = 1e9;  // larger coordinates, lengths and strengths are refused
constexpr double kNearest = 1e-9;  // a shorter vector has no direction
constexpr double kMostDrag = 2.0;  // limit of the strength and of the damping of Drag
constexpr int kOctaves = 3;  // of Turbulence: each has half the size and half the height of the one before
constexpr double kLattice = 1048576.0;  // 2^20: coordinates in the lattice are taken modulo this

// Blender's permutation, which differs from Perlin's reference implementation. Measured at the lattice points
// of mathutils.noise (PERLIN_NEW).
constexpr std::array<std::uint8_t, 256> kPermutation = {
    162, 160, 25,  59,  248, 235, 170, 238, 243, 28,  103, 40,  29,  237, 0,   222, 149, 46,  220, 63,
    58,  130, 53,  77,  108, 186, 54,  208, 246, 12,  121, 50,  209, 89,  244, 8,   139, 99,  137, 47,
    184, 180, 151, 131, 242, 143, 24,  199, 81,  20,  101, 135, 72,  32,  66,  168, 128, 181, 64,  19,
    178, 34,  126, 87,  188, 127, 107, 157, 134, 76,  200, 219, 124, 213, 37,  78,  90,  85,  116, 80,
    205, 179, 122, 187, 195, 203, 182, 226, 228, 236, 253, 152, 11,  150, 211, 158, 92,  161, 100, 241,
    129, 97,  225, 196, 36,  114, 73,  140, 144, 75,  132, 52,  56,  171, 120, 202, 31,  1,   215, 147,
    17,  193, 88,  169, 49,  249, 68,  109, 191, 51,  156, 95,  9,   148, 163, 133, 6,   198, 154, 30,
    123, 70,  21,  48,  39,  43,  27,  113, 60,  91,  214, 111, 98,  172, 79,  194, 192, 14,  177, 35,
    167, 223, 71,  176, 119, 105, 5,   233, 230, 231, 118, 115, 15,  254, 110, 155, 86,  239, 18,  165,
    55,  252, 174, 217, 3,   142, 221, 16,  185, 206, 201, 141, 218, 42,  189, 104, 23,  159, 190, 212,
    10,  204, 210, 232, 67,  61,  112, 183, 2,   125, 153, 216, 13,  96,  138, 4,   44,  62,  146, 229,
    175, 83,  7,   224, 41,  166, 197, 227, 245, 247, 74,  65,  38,  106, 22,  94,  82,  45,  33,  173,
    240, 145, 255, 234, 84,  250, 102, 26,  69,  57,  207, 117, 164, 136, 251, 93};

int permuted(int at) {
    return kPermutation[static_cast<size_t>(at & 255)];
}

// The dot product of (x, y, z) with one of the twelve edge directions of a cube.
double gradient(int hash, double x, double y, double z) {
    const int h = hash & 15;
    const double u = h < 8 ? x : y;
    const double v = h < 4 ? y : h == 12 || h == 14 ? x : z;
    return ((h & 1) == 0 ? u : -u) + ((h & 2) == 0 ? v : -v);
}

double faded(double t) {
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
}

double mixed(double t, double a, double b) {
    return a + t * (b - a);
}

// Three octaves, -1..1. A size of 0 counts as 1.
double turbulence(double size, Real3 p) {
    if (size != 0.0) p /= size;
    double sum = 0.0, height = 1.0;
    for (int octave = 0; octave < kOctaves; ++octave, height *= 0.5, p *= 2.0)
        sum += height * (0.5 + 0.5 * perlin_noise(p.x, p.y, p.z));
    return 2.0 * sum * 4.0 / 7.0 - 1.0;
}

// -1/2..1, with the distribution of the noise of Blender's effectors: negative values are small, and the mean
// is 0.17. Only the random numbers differ from Blender's.
double random_share(std::uint32_t seed, std::uint32_t value) {
    const std::uint32_t bits = hashed(seed, value), whole = bits & 127u;
    const double divisor = 1.0 + double(bits >> 8) / 16777216.0;
    return (whole > 64u ? 1.0 : -1.0) * double(whole) / (128.0 * divisor);
}

struct Placed {
    Real3 axis;         // unit
    Real3 from_origin;  // the point, from the origin of the field
    Real3 to_point;     // the point, from the nearest point of the field's shape
    double distance;    // length of to_point
};

Placed placed(const Field& field, const Real3& point) {
    const Real3 axis = unit_or_zero(Real3(field.axis), kNearest), from_origin = point - Real3(field.location);
    const Real3 along = axis * glm::dot(axis, from_origin);
    // A vortex with the shape of a plane acts around the plane's axis.
    const bool is_line =
        field.shape == Shape::kLine || (field.shape == Shape::kPlane && field.kind == Kind::kVortex);
    const Real3 to_point = field.shape == Shape::kPoint ? from_origin : is_line ? from_origin - along : along;
    return {axis, from_origin, to_point, glm::length(to_point)};
}

double share(const Field& field, const Placed& at) {
    const double height = glm::dot(at.axis, at.from_origin);
    if ((field.side == Side::kAbove && height < 0.0) || (field.side == Side::kBelow && height > 0.0))
        return 0.0;
    if (field.falloff == Falloff::kSphere) return field.along.share(at.distance);
    const double radius = glm::length(at.from_origin - height * at.axis);
    const double angle = elementary::atan2(radius, height) * (180.0 / std::numbers::pi);
    return field.along.share(std::abs(height)) *
           field.across.share(field.falloff == Falloff::kTube ? radius : angle);
}

// The strength with noise. The damping of Drag and Harmonic has noise too.
struct Varied {
    double strength, damping;
};

Varied varied(const Field& field, std::int32_t frame, size_t point) {
    if (field.noise <= 0.0f) return {field.strength, field.damping};
    const std::uint32_t seed = hashed(std::uint32_t(field.seed), std::uint32_t(frame));
    const auto at = static_cast<std::uint32_t>(2 * point);
    return {field.strength + field.noise * random_share(seed, at),
            field.damping + field.noise * random_share(seed, at + 1)};
}

struct Sum {
    Real3 air{0.0}, push{0.0};
    glm::dvec2 resist{0.0};
};

void add_vortex(const Field& field, const Placed& at, double strength, double left, Sum& sum) {
    if (field.shape == Shape::kPoint) {
        sum.push +=
            unit_or_zero(glm::cross(at.axis, at.to_point), kNearest) * (strength * left * at.distance);
        return;
    }
    // The velocity of a body that rotates with the field, and the force that keeps it on its circle.
    const Real3 turning = glm::cross(at.axis, at.from_origin) * (strength * left);
    sum.push += glm::cross(at.axis, turning) * (strength * left) + turning;
    sum.resist.x += 1.0;
}

void add_harmonic(const Field& field, const Placed& at, const Varied& by, double left, Sum& sum) {
    const double rest = field.size > 0.0f && at.distance > kNearest ? field.size / at.distance : 0.0;
    sum.push -= at.to_point * ((1.0 - rest) * by.strength * left);
    sum.resist.x += by.damping * 2.0 * std::sqrt(std::abs(by.strength));
}

void add_turbulence(const Field& field, const Placed& at, const Real3& point, double strength, Sum& sum) {
    const Real3 p = field.in_world ? point : at.from_origin + at.axis;
    sum.push += Real3(turbulence(field.size, p), turbulence(field.size, {p.y, p.z, p.x}),
                      turbulence(field.size, {p.z, p.x, p.y})) *
                strength;
}

void add(const Field& field, const Real3& point, const Varied& by, Sum& sum) {
    const Placed at = placed(field, point);
    const double left = share(field, at);
    if (left <= 0.0) return;
    switch (field.kind) {
        case Kind::kWind:
            sum.air += at.axis * (by.strength * left);
            return;  // its resistance is part of the drag of the air
        case Kind::kForce: {
            const double square = field.inverse_square ? at.distance * at.distance : 1.0;
            if (at.distance > kNearest) sum.push += at.to_point / at.distance * (by.strength * left / square);
            break;
        }
        case Kind::kVortex:
            add_vortex(field, at, by.strength, left, sum);
            break;
        case Kind::kHarmonic:
            return add_harmonic(field, at, by, left, sum);
        case Kind::kDrag:
            sum.resist +=
                left * glm::dvec2(std::min(by.damping, kMostDrag), std::min(by.strength, kMostDrag));
            return;
        case Kind::kTurbulence:
            add_turbulence(field, at, point, by.strength * left, sum);
            break;
    }
    sum.resist.x += field.flow * left;
}

Vec3 bounded(const Real3& v) {
    return Vec3(glm::clamp(v, Real3(-kFarthest), Real3(kFarthest)));
}

void check(const Decay& decay, const std::string& name) {
    expect_within(name + ".power", decay.power, 0.0, 1e3);
    expect_within(name + ".least", decay.least, 0.0, kFarthest);
    expect_within(name + ".most", decay.most, 0.0, kFarthest);
}

}  // namespace

double Decay::share(double distance) const {
    if (ends && distance > most) return 0.0;
    if (power == 0.0f || distance <= least) return 1.0;
    return elementary::pow(1.0 + distance - least, -double(power));
}

double perlin_noise(double x, double y, double z) {
    double part[3] = {x, y, z};
    int cell[3];
    for (int k = 0; k < 3; ++k) {
        const double from = std::fmod(part[k], kLattice), corner = std::floor(from);
        cell[k] = int(corner) & 255;
        part[k] = from - corner;
    }
    const double u = faded(part[0]), v = faded(part[1]), w = faded(part[2]);
    double at[2][2];  // y, z
    for (int i = 0; i < 4; ++i) {
        const int j = i & 1, k = i >> 1;
        double end[2];
        for (int e = 0; e < 2; ++e) {
            const int hash = permuted(permuted(permuted(cell[0] + e) + cell[1] + j) + cell[2] + k);
            end[e] = gradient(hash, part[0] - e, part[1] - j, part[2] - k);
        }
        at[j][k] = mixed(u, end[0], end[1]);
    }
    return mixed(w, mixed(v, at[0][0], at[1][0]), mixed(v, at[0][1], at[1][1]));
}

void check(const Field& field, size_t index) {
    const std::string name = "fields[" + std::to_string(index) + "]";
    for (int k = 0; k < 3; ++k) {
        expect_within(name + ".location", field.location[k], -kFarthest, kFarthest);
        expect_within(name + ".axis", field.axis[k], -kFarthest, kFarthest);
    }
    expect_within(name + ".strength", field.strength, -kFarthest, kFarthest);
    expect_within(name + ".flow", field.flow, -kFarthest, kFarthest);
    expect_within(name + ".damping", field.damping, 0.0, kFarthest);
    expect_within(name + ".size", field.size, 0.0, kFarthest);
    expect_within(name + ".noise", field.noise, 0.0, kFarthest);
    check(field.along, name + ".along");
    check(field.across, name + ".across");
}

std::vector<Effect> effects(std::span<const Field> fields, std::int32_t frame, std::span<const Vec3> points) {
    for (size_t f = 0; f < fields.size(); ++f) check(fields[f], f);
    expect_finite("positions", points, "vertex");
    std::vector<Effect> out;
    out.reserve(points.size());
    for (size_t i = 0; i < points.size(); ++i) {
        const Real3 point = bounded(Real3(points[i]));
        Sum sum;
        for (const Field& field : fields) add(field, point, varied(field, frame, i), sum);
        const glm::dvec2 resist = glm::clamp(sum.resist, glm::dvec2(0.0), glm::dvec2(kFarthest));
        out.push_back({bounded(sum.air), bounded(sum.push), Vec2(resist)});
    }
    return out;
}

}  // namespace rumple::force_fields
