// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

#include "base/lanes.h"

namespace rumple {

// 0 up to low, 1 from high on, and smooth between them, like GLSL's smoothstep().
inline float smooth_step(float low, float high, float x) {
    const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

inline Lanes smooth_step(float low, float high, const Lanes& x) {
    const Lanes t = within((x - low) / (high - low), Lanes{}, all_lanes(1.0f));
    return t * t * (3.0f - 2.0f * t);
}

}  // namespace rumple
