// SPDX-License-Identifier: GPL-3.0-or-later
// Sine, exponential and similar functions with the same bits on every system. The last bit of the functions
// in <cmath> differs between systems. The functions here use only + - * / and square roots, whose results
// IEEE 754 defines. Results use only those functions of <cmath> that are exact everywhere: floor, ceil,
// round, lround, fmod, ldexp, frexp, nextafter, copysign, abs and sqrt.
//
// Errors, in units of the last place: sin, cos, exp, log 2, atan2 5, pow 3 (1 + |y log x|). The float
// functions round the double result, so they nearly always return the float nearest to the true value.
#pragma once

#include <cmath>

namespace rumple::elementary {

// Radians, finite. Beyond 2^20 the angle is reduced modulo the double nearest to 2 pi.
double sin(double x);
double cos(double x);
// -pi..pi. x and y finite. If both are zero: 0 or pi, like std::atan2.
double atan2(double y, double x);
double exp(double x);
double log(double x);            // x > 0, finite
double pow(double x, double y);  // x > 0, finite
// The length of (x, y). It may overflow.
double hypot(double x, double y);

inline float sin(float x) {
    return float(sin(double(x)));
}
inline float cos(float x) {
    return float(cos(double(x)));
}
inline float exp(float x) {
    return float(exp(double(x)));
}
inline float atan2(float y, float x) {
    return float(atan2(double(y), double(x)));
}
// Halves to the even one; never -0. std::nearbyint is a call of a function on processors without SSE 4.1.
inline float nearest_integer(float x) {
    constexpr float kIntegersFrom = 0x1p23f;  // floats of this size have no fraction
    if (!(std::abs(x) < kIntegersFrom)) return x;
    return x < 0.0f ? (x - kIntegersFrom) + kIntegersFrom : (x + kIntegersFrom) - kIntegersFrom;
}
inline float hypot(float x, float y) {
    return float(hypot(double(x), double(y)));
}

}  // namespace rumple::elementary
