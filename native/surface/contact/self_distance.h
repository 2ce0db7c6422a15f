// SPDX-License-Identifier: GPL-3.0-or-later
// The distance of a cloth from itself. It bounds the movement of the cloth's vertices, so that folds do not
// pass through one another. After Chen and others 2025, Offset Geometric Contact: a vertex moves at most by a
// share of its distance to the nearest element that is not adjacent to it. docs/wrinkle_mesh.md (Layers)
// lists our differences.
#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "base/array.h"
#include "surface/contact/triangle_packets.h"

namespace rumple {

// The triangles of a cloth and a bounding volume hierarchy over them. Built once, then immutable.
class SelfContactMesh {
  public:
    // positions: at rest, object units; every index in `triangles` is one of them. There may be no triangles.
    // Cost: O(n log^2 n).
    SelfContactMesh(std::span<const Vec3> positions, const std::vector<std::array<Index, 3>>& triangles);

  private:
    friend class PosedSelfContactMesh;

    bool in_other_parts(Index vertex, Index triangle) const {
        return !part_.empty() && part_[vertex] != part_[triangles_[triangle][0]];
    }

    std::vector<std::array<Index, 3>> triangles_;
    CornersOfVertices corners_;
    PacketHierarchy hierarchy_;
    std::vector<Index> part_;  // per vertex: the lowest vertex of its part; empty: there is only one
};

// The nearest point of the cloth that faces a vertex. Its triangle does not contain the vertex. Either the
// normals of both are opposed, or the triangle belongs to another part, which is worn over or under the
// vertex.
struct SelfContactSide {
    Vec3 towards{0.0f};  // unit: from the vertex to that point; zero: nothing faces it
    float distance = std::numeric_limits<float>::infinity();  // object units
    // The distance, if the normals are opposed: it then bounds movement in any direction. Infinity if both
    // face the same way: one is worn over the other, and only movement towards it is bounded.
    float in_any_direction = std::numeric_limits<float>::infinity();
};

// A cloth in the pose of one frame.
class PosedSelfContactMesh {
  public:
    // Both must outlive it. positions: finite, as many as the cloth was built with. Cost: O(triangles), about
    // 20 ns each.
    PosedSelfContactMesh(const SelfContactMesh& surface, std::span<const Vec3> positions);

    // For every vertex, the nearest point that faces it within its reach (object units, >= 0; 0: no search).
    // If the vertex is a corner of the triangle that faces another vertex, and that other vertex is nearer,
    // it gets the other vertex instead. So both sides of a gap know of it. Cost: about 0.5 us a vertex with a
    // reach of two edges.
    std::vector<SelfContactSide> facing(std::span<const float> reach) const;

    // For every vertex, the smallest altitude of its triangles above the opposite sides, object units;
    // infinity without triangles. If no vertex moves along the surface by more than half of its value, no
    // triangle turns over.
    std::vector<float> heights() const;

  private:
    // Of the triangles that nearest() finds, this is true only for triangles of other parts.
    bool face_the_same_way(Index vertex, Index triangle) const;
    // The point that faces a vertex, and its triangle.
    SelfContactSide nearest(Index vertex, float reach, Index& triangle) const;

    const SelfContactMesh& surface_;
    size_t count_;
    std::vector<Row> positions_;
    TriangleNormals normals_;
    PosedPackets packets_;
};

}  // namespace rumple
