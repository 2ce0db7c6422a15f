// SPDX-License-Identifier: GPL-3.0-or-later
// Four floats at a time: SSE2 and NEON have them, and one source serves both (vectors of GCC and Clang).
// Every lane is computed as one float would be, so results have the same bits as without.
#pragma once

#include <array>
#include <cstdint>

#include "base/array.h"

namespace rumple {

using Lanes = float __attribute__((vector_size(16)));
using LaneMask = std::int32_t __attribute__((vector_size(16)));  // -1: true
inline constexpr int kLanes = 4;

inline Lanes all_lanes(float x) {
    return Lanes{x, x, x, x};
}
inline Lanes least(const Lanes& a, const Lanes& b) {
    return a < b ? a : b;
}
inline Lanes most(const Lanes& a, const Lanes& b) {
    return a < b ? b : a;
}

// A vector in every lane.
struct Vec3Lanes {
    Lanes x{}, y{}, z{};

    Vec3Lanes() = default;
    Vec3Lanes(const Lanes& x_, const Lanes& y_, const Lanes& z_) : x(x_), y(y_), z(z_) {}
    explicit Vec3Lanes(const Vec3& v) : x(all_lanes(v.x)), y(all_lanes(v.y)), z(all_lanes(v.z)) {}

    void set(int lane, const Vec3& v) {
        x[lane] = v.x;
        y[lane] = v.y;
        z[lane] = v.z;
    }
    Vec3 at(int lane) const { return {x[lane], y[lane], z[lane]}; }
};

inline Vec3Lanes operator-(const Vec3Lanes& a, const Vec3Lanes& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3Lanes operator+(const Vec3Lanes& a, const Vec3Lanes& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3Lanes operator*(const Lanes& s, const Vec3Lanes& a) {
    return {s * a.x, s * a.y, s * a.z};
}
inline Lanes dot(const Vec3Lanes& a, const Vec3Lanes& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

}  // namespace rumple
