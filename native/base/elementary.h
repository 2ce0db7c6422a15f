// SPDX-License-Identifier: GPL-3.0-or-later
// Sine, exponential and the like, the same bits on every system. Those of <cmath> differ from system to
// system in their last bit; what is computed here takes nothing but + - * / and square roots, which IEEE 754
// fixes. Of <cmath> only what is exact everywhere is used in results: floor, ceil, round, lround, fmod,
// ldexp, frexp, nextafter, copysign, abs and sqrt.
//
// Errors, in units of the last place: sin, cos, exp, log 2, atan2 5, pow 3 (1 + |y log x|). The float
// functions round the double result: hardly ever is it not the float nearest to the true value.
#pragma once

namespace rumple::elementary {

// Radians, finite. Beyond 2^20 the angle counts modulo the double nearest to 2 pi.
double sin(double x);
double cos(double x);
// -pi..pi. x and y finite; 0 or pi where both are zero, as std::atan2.
double atan2(double y, double x);
double exp(double x);
double log(double x);            // x > 0, finite
double pow(double x, double y);  // x > 0, finite
// The length of (x, y); no care is taken of overflow.
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
inline float hypot(float x, float y) {
    return float(hypot(double(x), double(y)));
}

}  // namespace rumple::elementary
