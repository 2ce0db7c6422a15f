// SPDX-License-Identifier: GPL-3.0-or-later
// The paths for artists: lines along the crests that ride on the base, and what the base does, as ellipses.
#pragma once

#include "systems/wrinkle_paths/wrinkle_paths.h"

namespace rumple::wrinkle_paths {

// Curves on the crests of the folds, in terms of the posed base, so that they ride on any pose of it:
//     position = p0 + u (p1 - p0) + v (p2 - p0) + t o.x + b o.y + n o.z
// with the frame of a shown mesh's local offset. `positions` and `height` are those of the crests, hems
// faded.
struct RidingCurves : Curves {
    std::vector<std::array<Index, 3>> corners;  // per point: the base's vertices as the artist has them
    std::vector<Vec2> weights;                  // u, v; of a triangle without area 0
    std::vector<Vec3> local_offset;             // o, object units
};
// animated: positions of the base that the curves are to ride on, object space, where that is not what was
// solved (over a base cloth); empty: those of the pose. Throws as show() does, and when there is not one for
// each vertex of the base. Cost: that of curves() and of the base's normals.
RidingCurves ride(const Model& model, const Settings& settings, const Pose& pose, const State& state,
                  std::span<const Vec3> animated = {});
RidingCurves ride(const Model& model, const Settings& settings, const Input& input, const State& state,
                  std::span<const Vec3> animated = {});

// What became of a circle drawn on each reference triangle: an ellipse with the stretches from the reference
// as semi-axes, times `size` of the radius of the triangle's inscribed circle.
struct Ellipse {
    Vec3 centre{0.0f};
    Vec3 compressed{0.0f};  // semi-axis along the strongest compression, object space
    Vec3 stretched{0.0f};   // the other one
};
// Per triangle; without axes where nothing is known. Throws InvalidInput when positions or state do not match
// the model. Cost: O(triangles).
std::vector<Ellipse> ellipses(const Model& model, const Pose& pose, const State& state, float size = 0.8f);
std::vector<Ellipse> ellipses(const Model& model, std::span<const Vec3> positions, const State& state,
                              float size = 0.8f);

}  // namespace rumple::wrinkle_paths
