// SPDX-License-Identifier: GPL-3.0-or-later
// The formulas that formulas.h compiles for single floats, compiled for four at a time: GLSL's types and
// functions over Lanes, as far as these formulas need them. Every lane has the bits of formulas.h, so each
// function here computes in the order of GLM's.
#pragma once

#include <limits>

#include "base/formulas.h"
#include "base/lanes.h"

#define FORMULA inline

namespace rumple::lane_formulas {

using REAL = Lanes;
using BOOL = LaneMask;
using vec2 = Vec2Lanes;
using vec3 = Vec3Lanes;

// Columns, as in GLSL.
struct mat2 {
    vec2 column[2];

    mat2() = default;
    mat2(const vec2& a, const vec2& b) : column{a, b} {}
    explicit mat2(float diagonal) : column{{diagonal, 0.0f}, {0.0f, diagonal}} {}

    const vec2& operator[](int i) const { return column[i]; }
};

inline vec2 operator*(const mat2& m, const vec2& v) {
    return {m[0].x * v.x + m[1].x * v.y, m[0].y * v.x + m[1].y * v.y};
}
inline mat2 operator+(const mat2& a, const mat2& b) {
    return {a[0] + b[0], a[1] + b[1]};
}
inline mat2 operator-(const mat2& a, const mat2& b) {
    return {a[0] - b[0], a[1] - b[1]};
}
inline mat2 operator*(const mat2& a, const mat2& b) {
    return {a * b[0], a * b[1]};
}
inline mat2 transpose(const mat2& m) {
    return {{m[0].x, m[1].x}, {m[0].y, m[1].y}};
}

inline glm::mat2 at_lane(const mat2& m, int lane) {
    return {m[0].at(lane), m[1].at(lane)};
}
inline Lanes sqrt(const Lanes& x) {
    return square_root(x);
}
inline Lanes abs(const Lanes& x) {
    return (Lanes)((LaneMask)x & 0x7fffffff);
}
inline Lanes min(const Lanes& x, const Lanes& y) {
    return y < x ? y : x;
}
inline Lanes max(const Lanes& x, const Lanes& y) {
    return x < y ? y : x;
}
inline Lanes min(const Lanes& x, float y) {
    return min(x, all_lanes(y));
}
inline Lanes max(const Lanes& x, float y) {
    return max(x, all_lanes(y));
}
inline Lanes clamp(const Lanes& x, float low, float high) {
    return min(max(x, low), high);
}
// As elementary::nearest_integer().
inline Lanes nearest_integer(const Lanes& x) {
#if defined(__aarch64__)
    return (Lanes)vrndnq_f32((float32x4_t)x) + 0.0f;  // 0 for -0
#else
#if defined(__SSE2__)
    const auto nearest = (LaneMask)_mm_cvtps_epi32((__m128)x);
    const LaneMask is_too_large = nearest == std::numeric_limits<std::int32_t>::min();
    if (bits_of(is_too_large) == 0) [[likely]]  // faster than a choice
        return __builtin_convertvector(nearest, Lanes);
#endif
    return Lanes{elementary::nearest_integer(x[0]), elementary::nearest_integer(x[1]),
                 elementary::nearest_integer(x[2]), elementary::nearest_integer(x[3])};
#endif
}

inline Lanes length(const vec2& v) {
    return sqrt(dot(v, v));
}
inline Lanes length(const vec3& v) {
    return sqrt(dot(v, v));
}
inline vec3 normalize(const vec3& v) {
    return (1.0f / length(v)) * v;
}

#include "shared/tangents.glsl"
#include "shared/wrinkle_field.glsl"

// One of four estimates.
inline formulas::WaveEstimate at_lane(const WaveEstimate& four, int lane) {
    return {four.r[lane], four.fullness[lane], four.k.at(lane), four.k_deformed.at(lane)};
}
inline void set_lane(WaveEstimate& four, int lane, const formulas::WaveEstimate& one) {
    four.r[lane] = one.r;
    four.fullness[lane] = one.fullness;
    four.k.set(lane, one.k);
    four.k_deformed.set(lane, one.k_deformed);
}

}  // namespace rumple::lane_formulas

#undef FORMULA
