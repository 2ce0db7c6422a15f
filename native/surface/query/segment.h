// SPDX-License-Identifier: GPL-3.0-or-later
// The closest point of a segment.
#pragma once

#include <algorithm>

#include "base/array.h"

namespace rumple {

// The s of the point a + s (b - a), 0 <= s <= 1, that is closest to p; 0 if the segment has no length.
// Vector: of floats or doubles.
template <typename Vector>
typename Vector::value_type closest_on_segment(const Vector& a, const Vector& b, const Vector& p) {
    using Real = typename Vector::value_type;
    const Vector ab = b - a;
    const Real square = glm::dot(ab, ab);
    return square > Real(0) ? std::clamp(glm::dot(p - a, ab) / square, Real(0), Real(1)) : Real(0);
}

}  // namespace rumple
