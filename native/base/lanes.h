// SPDX-License-Identifier: GPL-3.0-or-later
// Four floats at a time. SSE2 and NEON support this, and one source serves both (vector types of GCC and
// Clang). Every lane is computed like a single float, so results have the same bits as without lanes.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#if defined(__SSE2__)
#include <emmintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

#include "base/array.h"

namespace rumple {

using Lanes = float __attribute__((vector_size(16)));
using LaneMask = std::int32_t __attribute__((vector_size(16)));  // -1: true
inline constexpr int kLanes = 4;

inline Lanes all_lanes(float x) {
    return Lanes{x, x, x, x};
}
// Correctly rounded, as IEEE 754 requires.
inline float square_root(float x) {
    return std::sqrt(x);
}
inline Lanes square_root(const Lanes& x) {
#if defined(__SSE2__)
    return (Lanes)_mm_sqrt_ps((__m128)x);
#elif defined(__aarch64__)
    return (Lanes)vsqrtq_f32((float32x4_t)x);
#else
    return Lanes{std::sqrt(x[0]), std::sqrt(x[1]), std::sqrt(x[2]), std::sqrt(x[3])};
#endif
}
// Bit k is set if lane k is true.
inline unsigned bits_of(const LaneMask& mask) {
#if defined(__SSE2__)
    return static_cast<unsigned>(_mm_movemask_ps((__m128)mask));
#else
    const LaneMask bit = mask & LaneMask{1, 2, 4, 8};
    return static_cast<unsigned>(bit[0] | bit[1] | bit[2] | bit[3]);
#endif
}
// Calls act(lane) for every true lane, in ascending order.
template <typename Act>
void for_each_true(const LaneMask& mask, Act&& act) {
    for (unsigned left = bits_of(mask); left != 0; left &= left - 1) act(std::countr_zero(left));
}
// Loads the first `count` floats, and zeros for the other lanes.
inline Lanes load_lanes(const float* from, size_t count = kLanes) {
    Lanes out{};
    std::memcpy(&out, from, count * sizeof(float));
    return out;
}
inline void store_lanes(const Lanes& lanes, float* to, size_t count = kLanes) {
    std::memcpy(to, &lanes, count * sizeof(float));
}
// Calls act(first, count) for every full four, and for the rest.
template <typename Act>
void for_each_four(size_t count, Act&& act) {
    size_t first = 0;
    for (; first + kLanes <= count; first += kLanes) act(first, std::integral_constant<size_t, kLanes>());
    if (first < count) act(first, count - first);
}
// Rounded towards zero, for numbers that an Index can hold.
inline Lanes whole_part(const Lanes& x) {
    return __builtin_convertvector(__builtin_convertvector(x, LaneMask), Lanes);
}
inline Lanes least(const Lanes& a, const Lanes& b) {
    return a < b ? a : b;
}
inline Lanes most(const Lanes& a, const Lanes& b) {
    return a < b ? b : a;
}

inline Lanes within(const Lanes& x, const Lanes& low, const Lanes& high) {
    return x < low ? low : high < x ? high : x;
}

// Four vectors, one per lane.
struct Vec2Lanes {
    Lanes x{}, y{};

    Vec2Lanes() = default;
    Vec2Lanes(const Lanes& x_, const Lanes& y_) : x(x_), y(y_) {}
    Vec2Lanes(float x_, float y_) : x(all_lanes(x_)), y(all_lanes(y_)) {}

    const Lanes& operator[](int i) const { return i == 0 ? x : y; }
    void set(int lane, const Vec2& v) {
        x[lane] = v.x;
        y[lane] = v.y;
    }
    Vec2 at(int lane) const { return {x[lane], y[lane]}; }
};

inline Vec2Lanes operator-(const Vec2Lanes& a) {
    return {-a.x, -a.y};
}
inline Vec2Lanes operator+(const Vec2Lanes& a, const Vec2Lanes& b) {
    return {a.x + b.x, a.y + b.y};
}
inline Vec2Lanes operator-(const Vec2Lanes& a, const Vec2Lanes& b) {
    return {a.x - b.x, a.y - b.y};
}
inline Vec2Lanes operator*(const Vec2Lanes& a, const Lanes& s) {
    return {a.x * s, a.y * s};
}
inline Vec2Lanes operator/(const Vec2Lanes& a, const Lanes& s) {
    return {a.x / s, a.y / s};
}
inline Lanes dot(const Vec2Lanes& a, const Vec2Lanes& b) {
    return a.x * b.x + a.y * b.y;
}
inline Vec2Lanes load_lanes(const Vec2* from, size_t count = kLanes) {
    std::array<Lanes, 2> pairs{};
    std::memcpy(&pairs, from, count * sizeof(Vec2));
    return {__builtin_shufflevector(pairs[0], pairs[1], 0, 2, 4, 6),
            __builtin_shufflevector(pairs[0], pairs[1], 1, 3, 5, 7)};
}
inline void store_lanes(const Vec2Lanes& lanes, Vec2* to, size_t count = kLanes) {
    const std::array<Lanes, 2> pairs{__builtin_shufflevector(lanes.x, lanes.y, 0, 4, 1, 5),
                                     __builtin_shufflevector(lanes.x, lanes.y, 2, 6, 3, 7)};
    std::memcpy(to, &pairs, count * sizeof(Vec2));
}

struct Vec3Lanes {
    Lanes x{}, y{}, z{};

    Vec3Lanes() = default;
    Vec3Lanes(const Lanes& x_, const Lanes& y_, const Lanes& z_) : x(x_), y(y_), z(z_) {}
    Vec3Lanes(float x_, float y_, float z_) : x(all_lanes(x_)), y(all_lanes(y_)), z(all_lanes(z_)) {}
    explicit Vec3Lanes(const Vec3& v) : Vec3Lanes(v.x, v.y, v.z) {}

    void set(int lane, const Vec3& v) {
        x[lane] = v.x;
        y[lane] = v.y;
        z[lane] = v.z;
    }
    Vec3 at(int lane) const { return {x[lane], y[lane], z[lane]}; }
};

inline Vec3Lanes load_lanes(const Vec3* from, size_t count = kLanes) {
    Vec3Lanes out;
    for (size_t k = 0; k < count; ++k) out.set(int(k), from[k]);
    return out;
}
inline void store_lanes(const Vec3Lanes& lanes, Vec3* to, size_t count = kLanes) {
    for (size_t k = 0; k < count; ++k) to[k] = lanes.at(int(k));
}

inline Vec3Lanes operator-(const Vec3Lanes& a, const Vec3Lanes& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3Lanes operator+(const Vec3Lanes& a, const Vec3Lanes& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3Lanes operator-(const Vec3Lanes& a) {
    return {-a.x, -a.y, -a.z};
}
inline Vec3Lanes operator*(const Lanes& s, const Vec3Lanes& a) {
    return {s * a.x, s * a.y, s * a.z};
}
inline Vec3Lanes operator/(const Vec3Lanes& a, const Lanes& s) {
    return {a.x / s, a.y / s, a.z / s};
}
inline Lanes dot(const Vec3Lanes& a, const Vec3Lanes& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3Lanes cross(const Vec3Lanes& a, const Vec3Lanes& b) {
    return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}
inline Vec3Lanes choose(const LaneMask& mask, const Vec3Lanes& a, const Vec3Lanes& b) {
    return {mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z};
}
inline Vec3 choose(bool condition, const Vec3& a, const Vec3& b) {
    return condition ? a : b;
}

// Types for formulas that are written once, for one vector (Real: float) and for four (Lanes).
template <typename Real>
using Vec3Of = std::conditional_t<std::is_same_v<Real, float>, Vec3, Vec3Lanes>;
template <typename Real>
Real all(float x) {
    if constexpr (std::is_same_v<Real, float>) {
        return x;
    } else {
        return all_lanes(x);
    }
}

// A vector in memory that is loaded and stored as a whole: x, y, z, and a fourth number without meaning.
struct Row {
    Lanes xyz{};

    Row() = default;
    Row(const Vec3& v) : xyz{v.x, v.y, v.z, 0.0f} {}
    explicit Row(const Lanes& lanes) : xyz(lanes) {}
    Vec3 vec() const {
        Vec3 out;
        std::memcpy(&out, &xyz, sizeof(out));
        return out;
    }
};
inline float dot(const Row& a, const Row& b) {
    const Lanes product = a.xyz * b.xyz;
    return product[0] + product[1] + product[2];
}

// Rounds a count up to a multiple of four.
inline size_t in_fours(size_t count) {
    return (count + kLanes - 1) / kLanes * kLanes;
}
inline std::vector<Row> to_rows(std::span<const Vec3> vectors) {
    std::vector<Row> rows;
    rows.reserve(in_fours(vectors.size()));
    rows.assign(vectors.begin(), vectors.end());
    rows.resize(in_fours(vectors.size()));
    return rows;
}
// The four rows from index `first` on, a multiple of kLanes.
inline std::span<Row, kLanes> four_from(std::span<Row> rows, size_t first) {
    return std::span<Row, kLanes>(&rows[first], kLanes);
}

inline Vec3Lanes columns(std::span<const Row, kLanes> rows) {
    const Row &a = rows[0], &b = rows[1], &c = rows[2], &d = rows[3];
    const Lanes ab = __builtin_shufflevector(a.xyz, b.xyz, 0, 4, 1, 5);  // ax bx ay by
    const Lanes cd = __builtin_shufflevector(c.xyz, d.xyz, 0, 4, 1, 5);
    const Lanes ab_z = __builtin_shufflevector(a.xyz, b.xyz, 2, 6, 3, 7);
    const Lanes cd_z = __builtin_shufflevector(c.xyz, d.xyz, 2, 6, 3, 7);
    return {__builtin_shufflevector(ab, cd, 0, 1, 4, 5), __builtin_shufflevector(ab, cd, 2, 3, 6, 7),
            __builtin_shufflevector(ab_z, cd_z, 0, 1, 4, 5)};
}
inline Vec3Lanes columns_from(std::span<const Row> rows, size_t first) {
    return columns(std::span<const Row, kLanes>(&rows[first], kLanes));
}
inline void store_rows(const Vec3Lanes& v, std::span<Row, kLanes> rows) {
    const Lanes ab = __builtin_shufflevector(v.x, v.y, 0, 4, 1, 5);  // ax ay bx by
    const Lanes cd = __builtin_shufflevector(v.x, v.y, 2, 6, 3, 7);
    rows[0].xyz = __builtin_shufflevector(ab, v.z, 0, 1, 4, 4);
    rows[1].xyz = __builtin_shufflevector(ab, v.z, 2, 3, 5, 5);
    rows[2].xyz = __builtin_shufflevector(cd, v.z, 0, 1, 6, 6);
    rows[3].xyz = __builtin_shufflevector(cd, v.z, 2, 3, 7, 7);
}

// What stands at four indices.
using LaneIndices = std::array<Index, kLanes>;
inline Lanes gathered(std::span<const float> from, const LaneIndices& at) {
    return Lanes{from[at[0]], from[at[1]], from[at[2]], from[at[3]]};
}
inline Vec3Lanes gathered(std::span<const Row> from, const LaneIndices& at) {
    const std::array<Row, kLanes> rows{from[at[0]], from[at[1]], from[at[2]], from[at[3]]};
    return columns(rows);
}

// Row r of apply() in base/solve_team.h.
inline Lanes weighted_sum(const SparseRows& rows, Index r, std::span<const Row> values) {
    Lanes sum{};
    for (Index k = rows.start[r]; k < rows.start[r + 1]; ++k)
        sum += rows.weight[k] * values[rows.index[k]].xyz;
    return sum;
}

}  // namespace rumple
