// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_mesh/hem_paint.h"

#include <algorithm>

#include "base/tolerances.h"
#include "surface/mesh/normals.h"
#include "surface/mesh/positions.h"
#include "surface/query/bounds.h"
#include "systems/wrinkle_mesh/pose.h"

namespace rumple::wrinkle_mesh {

OverlappingHems find_overlapping_hems(const Surface& base) {
    const std::vector<base_cloth::Overlap> overlaps = base_cloth::find_overlaps(base);
    if (overlaps.empty()) return {};
    OverlappingHems out{base_cloth::find_hems(base), {}};
    out.overlaps = base_cloth::find_hem_overlaps(base, out.hems, overlaps);
    return out;
}

PaintOfHems::PaintOfHems(const Surface& base, const OverlappingHems& hems, std::span<const Vec3> positions,
                         size_t layers)
    : layers_(layers) {
    if (hems.overlaps.empty()) return;
    const std::vector<Vec3> welded = weld_positions(base, positions);
    const float most = static_cast<float>(bounding_diagonal(base.positions_rest));
    const std::vector<float> room = base_cloth::room_over_parts(base, hems.hems, hems.overlaps, welded,
                                                                vertex_normals(base, welded), most);
    for (const Index w : base.welded_of) room_.push_back(std::min(room[w], most));
}

const Paint& PaintOfHems::go_on(const Model& layer, const Settings& settings, const Paint& paint) {
    if (room_.empty()) return paint;
    room_ = carry(layer, std::span<const float>(room_));
    held_ = paint;
    held_.radius.resize(room_.size());
    for (size_t v = 0; v < room_.size(); ++v) {
        const float radius = std::max(settings.radius * layer.local_edge[v], kShortestEdge);
        held_.radius[v] = painted(paint.radius, v) * std::min(room_[v] / (float(layers_) * radius), 1.0f);
    }
    return held_;
}

}  // namespace rumple::wrinkle_mesh
