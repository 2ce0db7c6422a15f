// SPDX-License-Identifier: GPL-3.0-or-later
// The data from which the GPU preview draws Wrinkle Paths (Gillette 2015, chapter 7). docs/gpu_preview.md
// describes how its shaders read it.
#pragma once

#include "systems/wrinkle_paths/wrinkle_paths.h"

namespace rumple::wrinkle_paths {

// Parts that a triangle is cut into along each edge: powers of two.
inline constexpr Index kMostParts = 32;

struct Parts {
    Index triangle = 1;                   // the largest number of parts of an edge
    std::array<Index, 3> edges{1, 1, 1};  // per edge, from corner k to k + 1: equal for both triangles
};

// A frame. The surface is the PN triangles over `smooth` and `normal`; heights are measured over `flat`.
struct Drawing {
    std::vector<Vec3> flat;    // per welded vertex, object space: the deformed base
    std::vector<Vec3> smooth;  // ... its place on the surface that the fine mesh is attached to
    std::vector<Vec3> normal;  // unit; of the triangles around it: also the direction of the folds' heights
    bool curved = true;        // false: straight triangles, for a linear attachment
    std::vector<float> hem;    // factor on the folds
    std::vector<Parts> parts;  // per triangle
    TriangleLists lists;
    std::vector<Vec3> proxy_offset;  // per display vertex: from the vertex to `smooth`
};
// Throws like show(). Cost: O(triangles reached).
Drawing draw(const Model& model, const Settings& settings, const Input& input, const Pose& pose,
             const State& state);

// For tests: computes a place like the vertex and fragment stages.
struct Drawn {
    Vec3 position;
    Vec3 normal;
    float height;
};
Drawn drawn_at(const Model& model, const Settings& settings, const Drawing& drawing,
               const SurfacePoint& place);

}  // namespace rumple::wrinkle_paths
