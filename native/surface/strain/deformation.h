// SPDX-License-Identifier: GPL-3.0-or-later
// The stretch of the base and its direction: the right Cauchy-Green tensor of its triangles, averaged at
// vertices.
#pragma once

#include <vector>

#include "surface/mesh/normals.h"
#include "surface/refine/refinement.h"

namespace rumple {

// A symmetric 2x2 tensor in some orthonormal tangent frame.
struct Tensor2 {
    float xx = 0.0f;
    float xy = 0.0f;
    float yy = 0.0f;
};

// R T R^T for the rotation R by the angle whose (cos, sin) is given.
Tensor2 rotated(const Tensor2& tensor, const Vec2& turn);

// Eigenvalues small <= large and the unit eigenvector of the small one. If both are equal, the eigenvector is
// the x axis.
struct Principal {
    float small = 0.0f;
    float large = 0.0f;
    Vec2 small_direction{1.0f, 0.0f};
};
Principal principal(const Tensor2& tensor);

// Depends only on the rest pose, built once.
struct StretchModel {
    struct Corner {
        Index triangle;
        float weight;    // rest area / sum of the rest areas at the vertex
        Vec2 transport;  // (cos, sin) of the angle from the triangle's rest frame to the vertex's frame
    };
    std::vector<glm::mat2> inverse_rest;  // per triangle; zero if the rest triangle has no area
    std::vector<Index> corner_start;      // per welded vertex, into corners
    std::vector<Corner> corners;
    std::vector<Vec2> triangle_transport;  // 3 per triangle: the rotation to each corner's vertex frame
    std::vector<Vec3> vertex_tangent;      // per welded vertex: the x axis of its frame, unit
};
StretchModel build_stretch(const Surface& surface);

// Converts tensors of the triangles, each in its rest frame, to tensors of the welded vertices, each in its
// frame: the mean weighted by area. Cost: O(triangles).
std::vector<Tensor2> at_vertices(const StretchModel& model, std::span<const Tensor2> of_triangles);

// Principal stretches (1 = as at rest) and the direction of strongest compression (unit, object space,
// deformed) at points of the surface. positions: deformed welded vertices. Cost: O(triangles + places).
struct StretchField {
    std::vector<float> minimum;
    std::vector<float> maximum;
    std::vector<Vec3> direction;
};
void measure_stretch(const Surface& surface, const StretchModel& model, std::span<const Vec3> positions,
                     std::span<const SurfacePoint> places, StretchField& out);

}  // namespace rumple
