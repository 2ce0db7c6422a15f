// SPDX-License-Identifier: GPL-3.0-or-later
// One frame of the base, used by solve() and show().
#include "surface/mesh/positions.h"
#include "systems/wrinkle_field/frames.h"

namespace rumple::wrinkle_field {
namespace {

// Equation (1) at four vertices.
Neighbourhoods regress(const Model& model, std::span<const Row> positions, const Vec3Lanes& normal,
                       size_t four) {
    const NeighbourColumns& columns = model.columns;
    const Index begin = columns.start[four], end = columns.start[four + 1];
    Neighbourhoods out;
    if (begin == end) return out;
    out.exist = columns.has_frame[four] & ((normal.x != 0.0f) | (normal.y != 0.0f) | (normal.z != 0.0f));
    const Vec3Lanes own = columns_from(positions, kLanes * four);
    const auto displacement = [&](Index c) { return gathered(positions, columns.vertex[c]) - own; };
    out.tangent = lane_formulas::tangent_towards(displacement(begin), normal);
    out.bitangent = cross(normal, out.tangent);
    for (Index c = begin; c < end; ++c) {
        const Vec2Lanes way =
            lane_formulas::tangent_space(displacement(c), out.tangent, out.bitangent, model.true_lengths);
        out.m = out.m + lane_formulas::outer_product(way, columns.gradient[c]);
    }
    return out;
}

}  // namespace

Pose weld_pose(const Model& model, std::span<const Vec3> positions) {
    check_frame(model.base, positions);
    Pose pose;
    pose.positions = weld_positions(model.base, positions);
    pose.normals = vertex_normals(model.base, pose.positions);
    return pose;
}

Pose make_pose(const Model& model, std::span<const Vec3> positions) {
    Pose pose = weld_pose(model, positions);
    const std::vector<Row> positions_in_rows = to_rows(pose.positions), normals = to_rows(pose.normals);
    pose.around.resize(model.columns.count.size());
    for_each_four_vertices(Settings{}, pose.positions.size(), [&](size_t first, size_t) {
        const size_t four = first / kLanes;
        pose.around[four] = regress(model, positions_in_rows, columns_from(normals, first), four);
    });
    return pose;
}

}  // namespace rumple::wrinkle_field
