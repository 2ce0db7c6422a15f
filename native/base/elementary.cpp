// SPDX-License-Identifier: GPL-3.0-or-later
// Every function first reduces its argument to a small range, in which a few terms of the Taylor series
// suffice.
#include "base/elementary.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

namespace rumple::elementary {
namespace {

using std::numbers::pi;

template <std::size_t N>
double series(const std::array<double, N>& coefficients, double x) {
    double sum = coefficients[N - 1];
    for (std::size_t k = N - 1; k-- > 0;) sum = sum * x + coefficients[k];
    return sum;
}

template <std::size_t N, typename Coefficient>
constexpr std::array<double, N> coefficients(Coefficient coefficient) {
    std::array<double, N> values{};
    for (std::size_t k = 0; k < N; ++k) values[k] = coefficient(int(k));
    return values;
}
constexpr double factorial(int n) {
    return n < 2 ? 1.0 : n * factorial(n - 1);
}
constexpr double sign(int k) {
    return k % 2 == 0 ? 1.0 : -1.0;
}

constexpr auto kSine = coefficients<9>([](int k) { return sign(k) / factorial(2 * k + 1); });
constexpr auto kCosine = coefficients<9>([](int k) { return sign(k) / factorial(2 * k); });
constexpr auto kExponential = coefficients<14>([](int k) { return 1.0 / factorial(k); });
constexpr auto kArcTangent = coefficients<12>([](int k) { return sign(k) / (2 * k + 1); });
constexpr auto kLogarithm = coefficients<11>([](int k) { return 1.0 / (2 * k + 1); });

// x minus n quarter turns, within an eighth of a turn. pi / 2 is the sum of three numbers. The first two have
// 33 bits, so their products with n are exact.
struct Reduced {
    double angle;
    int quarter;  // n modulo 4
};
Reduced reduced(double x) {
    constexpr double kFirst = 0x1.921fb544p+0, kSecond = 0x1.0b4611a6p-34, kThird = 0x1.3198a2e037073p-69;
    if (!(std::abs(x) <= 0x1p20)) {
        if (!std::isfinite(x)) return {std::numeric_limits<double>::quiet_NaN(), 0};
        x = std::fmod(x, 2.0 * pi);
    }
    const double n = std::floor(x * (2.0 / pi) + 0.5);
    const double angle = ((x - n * kFirst) - n * kSecond) - n * kThird;
    return {angle, int(n - 4.0 * std::floor(n / 4.0))};
}

double sine_near_zero(double x) {
    return x * series(kSine, x * x);
}
double cosine_near_zero(double x) {
    return series(kCosine, x * x);
}

// 0 <= x <= 1. Halving the angle twice brings x below 0.2.
double arc_tangent(double x) {
    for (int halved = 0; halved < 2; ++halved) x = x / (1.0 + std::sqrt(1.0 + x * x));
    return 4.0 * x * series(kArcTangent, x * x);
}

// ln 2 is the sum of the two. The first has 33 bits.
constexpr double kLn2First = 0x1.62e42fee00000p-1, kLn2Second = 0x1.a39ef35793c76p-33;

}  // namespace

double sin(double x) {
    const Reduced r = reduced(x);
    const double value = r.quarter % 2 == 0 ? sine_near_zero(r.angle) : cosine_near_zero(r.angle);
    return r.quarter < 2 ? value : -value;
}

double cos(double x) {
    const Reduced r = reduced(x);
    const double value = r.quarter % 2 == 0 ? cosine_near_zero(r.angle) : sine_near_zero(r.angle);
    return r.quarter == 0 || r.quarter == 3 ? value : -value;
}

double atan2(double y, double x) {
    const double width = std::abs(x), height = std::abs(y);
    double angle = 0.0;
    if (height > width) {
        angle = 0.5 * pi - arc_tangent(width / height);
    } else if (width > 0.0) {
        angle = arc_tangent(height / width);
    }
    return std::copysign(std::signbit(x) ? pi - angle : angle, y);
}

double exp(double x) {
    if (!(std::abs(x) < 800.0)) return x < 0.0 ? 0.0 : x * HUGE_VAL;  // far out of range, or NaN
    const double n = std::floor(x * std::numbers::log2e + 0.5);
    return std::ldexp(series(kExponential, (x - n * kLn2First) - n * kLn2Second), int(n));
}

double log(double x) {
    int exponent = 0;
    double m = std::frexp(x, &exponent);
    if (m < std::numbers::sqrt2 / 2.0) {
        m *= 2.0;
        --exponent;
    }
    const double s = (m - 1.0) / (m + 1.0);  // log m = 2 artanh s
    return exponent * kLn2First + (2.0 * s * series(kLogarithm, s * s) + exponent * kLn2Second);
}

double pow(double x, double y) {
    return exp(y * log(x));
}

double hypot(double x, double y) {
    return std::sqrt(x * x + y * y);
}

}  // namespace rumple::elementary
