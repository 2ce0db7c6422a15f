// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/mesh/positions.h"

#include <algorithm>

#include "base/expect.h"
#include "base/lanes.h"
#include "base/tolerances.h"

namespace rumple {
namespace {

// 0 without positions. They are finite.
float largest_coordinate(std::span<const Vec3> positions) {
    const auto* coordinates = reinterpret_cast<const float*>(positions.data());
    Lanes largest{};
    for_each_four(3 * positions.size(), [&](size_t first, auto how_many) {
        const Lanes four = load_lanes(coordinates + first, how_many);
        largest = most(most(largest, four), -four);
    });
    return std::max({largest[0], largest[1], largest[2], largest[3]});
}

// Without a branch, so that a compiler can vectorise it. Also of what is not finite.
bool is_any_beyond(std::span<const Vec3> positions, float farthest) {
    unsigned found = 0;
    for (const Vec3& p : positions) {
        const Vec3 size = glm::abs(p);
        found |= unsigned(!(size.x <= farthest)) | unsigned(!(size.y <= farthest)) |
                 unsigned(!(size.z <= farthest));
    }
    return found != 0;
}

void refuse_beyond(const std::string& name, std::span<const Vec3> positions, float farthest,
                   const std::string& why) {
    if (!is_any_beyond(positions, farthest)) return;
    for (size_t v = 0; v < positions.size(); ++v) {
        const Vec3& p = positions[v];
        if (!is_finite(p)) throw InvalidInput(name + ": vertex " + std::to_string(v) + " is not finite");
        const float at = largest_coordinate({&p, 1});
        if (at <= farthest) continue;
        std::string text = name + ": vertex " + std::to_string(v) + " is " + short_text(at);
        text += " away from the origin, more than " + short_text(farthest);
        throw InvalidInput(text += why);
    }
}

}  // namespace

void check_coordinates(const std::string& name, std::span<const Vec3> positions) {
    refuse_beyond(name, positions, kFarthestCoordinate, ": move the mesh to the origin, or scale it down");
}

void check_frame(const Surface& surface, std::span<const Vec3> positions, const std::string& name) {
    expect_count(name, positions.size(), surface.display.vertex_count, "vertices");
    const float size = largest_coordinate(surface.positions_rest);
    const float exploded = kExploded * size;
    if (exploded >= kFarthestCoordinate) return check_coordinates(name, positions);
    refuse_beyond(name, positions, exploded,
                  ", which is " + short_text(kExploded) +
                      " times the size of the mesh at rest: what moves it has exploded in this frame");
}

}  // namespace rumple
