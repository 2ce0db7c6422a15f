// SPDX-License-Identifier: GPL-3.0-or-later
// How far a cloth is from itself: what bounds the way of its vertices, so that folds do not pass through one
// another. After Chen and others 2025, Offset Geometric Contact: a vertex moves at most a share of its
// distance to what it is not adjacent to. docs/wrinkle_mesh.md (Layers) says where we leave them.
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
    // positions: at rest, object units; every index of triangles is one of them. May have no triangle.
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
    std::vector<Index> part_;  // per vertex the lowest one of its part; empty: there is but one
};

// The nearest point of the cloth that faces a vertex: on a triangle that it is no corner of, and whose normal
// points against that of the vertex, or that is of another part: of what is worn over or under it.
struct SelfContactSide {
    Vec3 towards{0.0f};  // unit: from the vertex to that point; zero: nothing faces it
    float distance = std::numeric_limits<float>::infinity();  // object units
    // Whether the point lies on the side that the vertex's normal points to. Where both face the same way
    // always: then one is worn over the other, and they have not passed each other.
    bool outside = false;
};

// A cloth in the pose of one frame.
class PosedSelfContactMesh {
  public:
    // Both must outlive it. positions: finite, as many as the cloth was built with. Cost: O(triangles), about
    // 20 ns each.
    PosedSelfContactMesh(const SelfContactMesh& surface, std::span<const Vec3> positions);

    // Of every vertex what faces it within its reach (object units, >= 0; 0: nothing is looked for), or the
    // vertex that it faces as a corner of a triangle, whichever is nearer: so both sides of a gap know of it.
    // Cost: about 0.5 us a vertex with a reach of two edges.
    std::vector<SelfContactSide> facing(std::span<const float> reach) const;

    // Of every vertex the smallest height of its triangles above their opposite sides, object units; infinity
    // where it has none. As long as no vertex moves farther than half of it along the surface, none of them
    // turns over.
    std::vector<float> heights() const;

  private:
    // Only triangles of other parts do.
    bool face_the_same_way(Index vertex, Index triangle) const;
    // The side that faces a vertex, and the triangle that it is on.
    SelfContactSide nearest(Index vertex, float reach, Index& triangle) const;

    const SelfContactMesh& surface_;
    size_t count_;
    std::vector<Row> positions_;
    TriangleNormals normals_;
    PosedPackets packets_;
};

}  // namespace rumple
