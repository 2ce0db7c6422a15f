// SPDX-License-Identifier: GPL-3.0-or-later
// The paths for artists: curves along the crests, attached to the base, and the base's deformation as
// ellipses.
#pragma once

#include "systems/wrinkle_paths/wrinkle_paths.h"

namespace rumple::wrinkle_paths {

// Curves on the crests of the folds, embedded in the posed base, so that they follow any pose of it:
//     position = p0 + u (p1 - p0) + v (p2 - p0) + t o.x + b o.y + n o.z
// with the frame of a shown mesh's local offset. `positions` and `height` of `curves` are those of the
// crests, with faded hems.
struct RidingCurves {
    Curves curves;
    std::vector<std::array<Index, 3>> corners;  // per point: display vertices of the base
    std::vector<Vec2> weights;                  // u, v; 0 in a triangle without area
    std::vector<Vec3> local_offset;             // o, object units
};
// animated: positions of the base that the curves are attached to, object space, if it differs from the
// solved one (over a base cloth); empty: the pose's positions. Throws like show(), and if there is not one
// position per vertex of the base. Cost: as curves() and the base's normals.
RidingCurves ride(const Model& model, const Settings& settings, const Pose& pose, const State& state,
                  std::span<const Vec3> animated = {});

// The deformation of a circle drawn on each reference triangle: an ellipse. Its semi-axes are the stretches
// relative to the reference, times `size`, times the radius of the triangle's inscribed circle.
struct Ellipse {
    Vec3 centre{0.0f};
    Vec3 compressed{0.0f};  // semi-axis along the strongest compression, object space
    Vec3 stretched{0.0f};   // the other one
};
// Per triangle. Triangles without known stretches have no axes. Throws InvalidInput if the state does not
// match the model. Cost: O(triangles).
std::vector<Ellipse> ellipses(const Model& model, const Pose& pose, const State& state, float size = 0.8f);

}  // namespace rumple::wrinkle_paths
