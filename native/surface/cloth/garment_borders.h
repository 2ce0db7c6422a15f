// SPDX-License-Identifier: GPL-3.0-or-later
// The open borders of a garment at rest: collar, cuffs, hems, the outline of a sheet.
#pragma once

#include <vector>

#include "surface/mesh/topology.h"

namespace rumple::base_cloth {

struct Border {
    std::vector<Index> vertices;  // welded
    Index part = 0;
    float height = 0.0f;      // of its centre, object units
    float radius = 0.0f;      // mean, around its centre, object units
    bool is_opening = false;  // false: the outline of a sheet
};

// The connected parts of a garment, and their open borders.
struct Borders {
    Index parts = 0;
    std::vector<Index> part;      // per welded vertex, or kNone (loose)
    std::vector<float> diagonal;  // of each part, object units
    std::vector<Border> all;

    // up: unit, object space at rest, for heights. Cost: O(edges).
    explicit Borders(const Surface& surface, const Vec3& up = Vec3(0.0f));
};

}  // namespace rumple::base_cloth
