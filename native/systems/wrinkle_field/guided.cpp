// SPDX-License-Identifier: GPL-3.0-or-later
// Waves in directions painted by an artist. Not in the paper: surface/strain/guided_strain.h.
#include <algorithm>
#include <cmath>

#include "systems/wrinkle_field/frames.h"

namespace rumple::wrinkle_field {

void turn_along(const Vec2& along, const glm::mat2& m, const Vec2& q, const Vec2& before, const Vec2& turn,
                float threshold, formulas::WaveEstimate& estimate, float& gather) {
    const glm::mat2 mq = m * (glm::mat2(1.0f) - glm::outerProduct(q, q));
    const Vec2 line = mq * along;
    const float length = glm::length(line), det = glm::determinant(mq);
    if (!(length > 0.0f) || estimate.r < formulas::kCollapsed) return;
    const glm::mat2 columns = mq * glm::transpose(mq);
    const Tensor2 left{columns[0][0], columns[1][0], columns[1][1]};
    if (!has_squares(left)) return;
    const Principal p = principal(turned(left, glm::length(along) / length * line));
    const Vec2 across = glm::transpose(mq) * p.small_direction;  // in the rest frame
    estimate.k = across / glm::length(across);
    if (glm::dot(estimate.k, before) < 0.0f) estimate.k = -estimate.k;
    estimate.r = std::sqrt(std::max(p.small, 0.0f));
    estimate.fullness = formulas::fullness_of(p.small, q, threshold);
    gather = 1.0f / std::max(estimate.r, formulas::kCollapsed);
    const Vec2 k(turn.x * estimate.k.x - turn.y * estimate.k.y,
                 turn.y * estimate.k.x + turn.x * estimate.k.y);
    estimate.k_deformed =
        Vec2(mq[1][1] * k.x - mq[0][1] * k.y, mq[0][0] * k.y - mq[1][0] * k.x) / det;  // (M^-1)^T k
}

}  // namespace rumple::wrinkle_field
