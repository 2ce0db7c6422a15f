// SPDX-License-Identifier: GPL-3.0-or-later
// The points of the deformed base to which fine vertices are attached (Mueller and Chentanez 2010, section 4;
// Vlachos et al. 2001 for PN triangles).
#pragma once

#include <vector>

#include "surface/mesh/normals.h"
#include "surface/refine/refinement.h"

namespace rumple {

enum class AttachmentKind { kLinear, kPnTriangle, kLimit };

// places: one per fine vertex. A vertex with triangle == kNone is not attached.
struct Attachments {
    AttachmentKind kind = AttachmentKind::kLimit;
    std::vector<SurfacePoint> places;
    SparseRows limit;  // kLimit only: rows of limit-surface weights over welded vertices
};

// The cubic Bezier triangle of Vlachos et al. 2001, section 3.1, at weight b0 of corner 1 and b1 of corner 2.
// normals: unit, at the corners.
Vec3 pn_triangle(const Vec3 corner[3], const Vec3 normal[3], float b0, float b1);

// Attachment points a_i on the deformed base, object space. normals are used only by kPnTriangle. Vertices
// without attachment get the origin.
void attach(const Surface& surface, const Attachments& attachments, std::span<const Vec3> positions,
            std::span<const Vec3> normals, std::span<Vec3> out);

// Linear interpolation of the values of welded vertices at a place.
inline Vec3 interpolate(const Surface& surface, const SurfacePoint& place, std::span<const Vec3> values) {
    const std::array<Index, 3> corners = welded_vertices(surface, place.triangle);
    return place.interpolate([&](int k) { return values[corners[k]]; });
}

// How far attached vertices may move inwards, from how far the vertices of the base may: object units, per
// place. The values are interpolated like the attachments. The smooth surface (kLimit) is lower than a crest
// of its cage, and so is its gap. Rows of kLimit may have negative weights, but the result is never negative.
// gap: per display vertex. Vertices without attachment get 0. Cost: O(places).
std::vector<float> gaps_at(const Surface& surface, const Attachments& attachments,
                           std::span<const float> gap);

// A triangle of the body for the search near a triangle of the surface: the largest of its vertices' hints,
// so kNone only if none has a hint. hints: per display vertex.
Index hint_at(const Surface& surface, Index triangle, std::span<const Index> hints);

}  // namespace rumple
