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

namespace rumple::force_fields {
namespace {

using Real3 = glm::dvec3;

constexpr double kFarthest = 1e9;       // coordinates, lengths and strengths beyond it are refused
constexpr double kNearest = 1e-9;       // what is nearer has no direction
constexpr double kMostDrag = 2.0;       // of a strength and a damping of Drag
constexpr int kOctaves = 3;             // of Turbulence, each twice as fine and half as high
constexpr double kLattice = 1048576.0;  // 2^20: what is farther from the lattice's origin is taken modulo it

// The permutation of Perlin's reference implementation: its lattice is Blender's.
constexpr std::array<std::uint8_t, 256> kPermutation = {
    151, 160, 137, 91,  90,  15,  131, 13,  201, 95,  96,  53,  194, 233, 7,   225, 140, 36,  103, 30,
    69,  142, 8,   99,  37,  240, 21,  10,  23,  190, 6,   148, 247, 120, 234, 75,  0,   26,  197, 62,
    94,  252, 219, 203, 117, 35,  11,  32,  57,  177, 33,  88,  237, 149, 56,  87,  174, 20,  125, 136,
    171, 168, 68,  175, 74,  165, 71,  134, 139, 48,  27,  166, 77,  146, 158, 231, 83,  111, 229, 122,
    60,  211, 133, 230, 220, 105, 92,  41,  55,  46,  245, 40,  244, 102, 143, 54,  65,  25,  63,  161,
    1,   216, 80,  73,  209, 76,  132, 187, 208, 89,  18,  169, 200, 196, 135, 130, 116, 188, 159, 86,
    164, 100, 109, 198, 173, 186, 3,   64,  52,  217, 226, 250, 124, 123, 5,   202, 38,  147, 118, 126,
    255, 82,  85,  212, 207, 206, 59,  227, 47,  16,  58,  17,  182, 189, 28,  42,  223, 183, 170, 213,
    119, 248, 152, 2,   44,  154, 163, 70,  221, 153, 101, 155, 167, 43,  172, 9,   129, 22,  39,  253,
    19,  98,  108, 110, 79,  113, 224, 232, 178, 185, 112, 104, 218, 246, 97,  228, 251, 34,  242, 193,
    238, 210, 144, 12,  191, 179, 162, 241, 81,  51,  145, 235, 249, 14,  239, 107, 49,  192, 214, 31,
    181, 199, 106, 157, 184, 84,  204, 176, 115, 121, 50,  45,  127, 4,   150, 254, 138, 236, 205, 93,
    222, 114, 67,  29,  24,  72,  243, 141, 128, 195, 78,  66,  215, 61,  156, 180};

int permuted(int at) {
    return kPermutation[static_cast<size_t>(at & 255)];
}

// One of the twelve edges of a cube, times (x, y, z).
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

// Three octaves, -1..1. The size 0 counts as 1.
double turbulence(double size, Real3 p) {
    if (size != 0.0) p /= size;
    double sum = 0.0, height = 1.0;
    for (int octave = 0; octave < kOctaves; ++octave, height *= 0.5, p *= 2.0)
        sum += height * (0.5 + 0.5 * perlin_noise(p.x, p.y, p.z));
    return 2.0 * sum * 4.0 / 7.0 - 1.0;
}

Real3 unit(const Real3& v) {
    const double length = glm::length(v);
    return length > kNearest ? v / length : Real3(0.0);
}

// -1/2..1, spread as the noise of Blender's effectors is: what is below 0 is small, and the mean is 0.17.
// Only its random numbers are others.
double random_share(std::uint32_t seed, std::uint32_t value) {
    const std::uint32_t bits = hashed(seed, value), whole = bits & 127u;
    const double divisor = 1.0 + double(bits >> 8) / 16777216.0;
    return (whole > 64u ? 1.0 : -1.0) * double(whole) / (128.0 * divisor);
}

struct Placed {
    Real3 axis;         // unit
    Real3 from_origin;  // the point, from the origin of the field
    Real3 to_point;     // the point, from the nearest one of its shape
    double distance;    // to that
};

Placed placed(const Field& field, const Real3& point) {
    const Real3 axis = unit(Real3(field.axis)), from_origin = point - Real3(field.location);
    const Real3 along = axis * glm::dot(axis, from_origin);
    // A vortex about a plane takes the plane for its axis.
    const bool is_line =
        field.shape == Shape::Line || (field.shape == Shape::Plane && field.kind == Kind::Vortex);
    const Real3 to_point = field.shape == Shape::Point ? from_origin : is_line ? from_origin - along : along;
    return {axis, from_origin, to_point, glm::length(to_point)};
}

double share(const Field& field, const Placed& at) {
    const double height = glm::dot(at.axis, at.from_origin);
    if ((field.side == Side::Above && height < 0.0) || (field.side == Side::Below && height > 0.0))
        return 0.0;
    if (field.falloff == Falloff::Sphere) return field.along.share(at.distance);
    const double radius = glm::length(at.from_origin - height * at.axis);
    const double angle = elementary::atan2(radius, height) * (180.0 / std::numbers::pi);
    return field.along.share(std::abs(height)) *
           field.across.share(field.falloff == Falloff::Tube ? radius : angle);
}

// What the strength became by noise. The damping of Drag and Harmonic has noise too.
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
    if (field.shape == Shape::Point) {
        sum.push += unit(glm::cross(at.axis, at.to_point)) * (strength * left * at.distance);
        return;
    }
    // The velocity of a body that turns with the field, and what keeps it on its circle.
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
    const Real3 p = field.global ? point : at.from_origin + at.axis;
    sum.push += Real3(turbulence(field.size, p), turbulence(field.size, {p.y, p.z, p.x}),
                      turbulence(field.size, {p.z, p.x, p.y})) *
                strength;
}

void add(const Field& field, const Real3& point, const Varied& by, Sum& sum) {
    const Placed at = placed(field, point);
    const double left = share(field, at);
    if (left <= 0.0) return;
    switch (field.kind) {
        case Kind::Wind:
            sum.air += at.axis * (by.strength * left);
            return;  // it resists as air does
        case Kind::Force: {
            const double square = field.inverse_square ? at.distance * at.distance : 1.0;
            if (at.distance > kNearest) sum.push += at.to_point / at.distance * (by.strength * left / square);
            break;
        }
        case Kind::Vortex:
            add_vortex(field, at, by.strength, left, sum);
            break;
        case Kind::Harmonic:
            return add_harmonic(field, at, by, left, sum);
        case Kind::Drag:
            sum.resist +=
                left * glm::dvec2(std::min(by.damping, kMostDrag), std::min(by.strength, kMostDrag));
            return;
        case Kind::Turbulence:
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
