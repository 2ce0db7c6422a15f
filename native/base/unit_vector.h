// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <glm/glm.hpp>

namespace rumple {

// The unit vector in the direction of `v`; zero if `v` is not longer than `least`, because its direction
// would be noise.
template <glm::length_t N, typename Real, glm::qualifier Q>
glm::vec<N, Real, Q> unit_or_zero(const glm::vec<N, Real, Q>& v, Real least) {
    const Real length = glm::length(v);
    return length > least ? v / length : glm::vec<N, Real, Q>(Real(0));
}

}  // namespace rumple
