// SPDX-License-Identifier: GPL-3.0-or-later
// Limits the layers at a hem, so that their folds do not uncover what the hem covers.
#pragma once

#include <vector>

#include "surface/cloth/hem_room.h"
#include "systems/wrinkle_mesh/wrinkle_mesh.h"

namespace rumple::wrinkle_mesh {

// The hems of a base that lie over borders of its other parts. Built once at rest.
struct OverlappingHems {
    base_cloth::Hems hems;
    std::vector<base_cloth::HemOverlap> overlaps;  // empty: nothing
};
OverlappingHems find_overlapping_hems(const Surface& base);

// The paint of each layer, with a radius such that all layers together do not move farther than hems may.
class PaintOfHems {
  public:
    // positions: of the base's display vertices, where the layers begin, object space.
    PaintOfHems(const Surface& base, const OverlappingHems& hems, std::span<const Vec3> positions,
                size_t layers);

    // The paint of the next layer. Called once for every layer, coarse first. Each has an equal share of the
    // room.
    const Paint& go_on(const Model& layer, const Settings& settings, const Paint& paint);

  private:
    size_t layers_;
    // Per vertex of the base, then of the layer before. Empty if no hem covers anything.
    std::vector<float> room_;
    Paint held_;
};

}  // namespace rumple::wrinkle_mesh
