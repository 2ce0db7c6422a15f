// SPDX-License-Identifier: GPL-3.0-or-later
// Checks of arguments. Each throws InvalidInput with the name of the argument.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "base/array.h"
#include "base/errors.h"

namespace rumple {

// With six digits: "0.5", "1e+06"; with a point, whatever the locale of the program.
inline std::string short_text(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    std::replace(text, text + sizeof text, ',', '.');
    return text;
}

// Checks that a value is within [low, high]. NaN never is.
inline void expect_within(const std::string& name, double value, double low, double high) {
    if (value >= low && value <= high) return;
    throw InvalidInput(name + ": expected " + short_text(low) + " to " + short_text(high) + ", got " +
                       short_text(value));
}

// The same for every value. element: what each value belongs to, e.g. "vertex".
inline void expect_each_within(const std::string& name, std::span<const float> values, double low,
                               double high, const char* element) {
    for (size_t i = 0; i < values.size(); ++i) {
        if (values[i] >= low && values[i] <= high) continue;
        expect_within(name + ": " + element + " " + std::to_string(i), values[i], low, high);
    }
}

// Checks that a value is above low and at most high.
inline void expect_above(const std::string& name, double value, double low, double high) {
    if (value > low && value <= high) return;
    throw InvalidInput(name + ": expected a value above " + short_text(low) + " to " + short_text(high) +
                       ", got " + short_text(value));
}

// what: the things that are counted, e.g. "vertices".
inline void expect_count(const std::string& name, size_t count, size_t expected, const char* what) {
    if (count == expected) return;
    throw InvalidInput(name + ": expected " + std::to_string(expected) + " " + what + ", got " +
                       std::to_string(count));
}

inline bool is_finite(float value) {
    return std::isfinite(value);
}
inline bool is_finite(const Vec2& v) {
    return std::isfinite(v.x) && std::isfinite(v.y);
}
inline bool is_finite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// element: what each value belongs to, e.g. "vertex".
template <typename T>
void expect_finite(const std::string& name, std::span<const T> values, const char* element) {
    for (size_t i = 0; i < values.size(); ++i) {
        if (is_finite(values[i])) continue;
        throw InvalidInput(name + ": " + element + " " + std::to_string(i) + " is not finite");
    }
}

}  // namespace rumple
