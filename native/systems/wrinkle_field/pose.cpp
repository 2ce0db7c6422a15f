// SPDX-License-Identifier: GPL-3.0-or-later
// One frame of the base, used by solve() and show().
#include "surface/mesh/positions.h"
#include "systems/wrinkle_field/frames.h"

namespace rumple::wrinkle_field {

Pose weld_pose(const Model& model, std::span<const Vec3> positions) {
    check_frame(model.base, positions);
    Pose pose;
    pose.positions = weld_positions(model.base, positions);
    pose.normals = vertex_normals(model.base, pose.positions);
    return pose;
}

Pose make_pose(const Model& model, std::span<const Vec3> positions) {
    Pose pose = weld_pose(model, positions);
    pose.around.resize(pose.positions.size());
    for_each_vertex(Settings{}, pose.positions.size(),
                    [&](size_t v) { pose.around[v] = regress(model, pose.positions, pose.normals[v], v); });
    return pose;
}

}  // namespace rumple::wrinkle_field
