// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/overlaps.h"

#include "base/tolerances.h"
#include "surface/mesh/positions.h"
#include "surface/output/attachments.h"
#include "surface/query/bounds.h"
#include "surface/refine/triangle_tree.h"

namespace rumple::base_cloth {
namespace {

constexpr double kReach = 1.0 / 30.0;  // of the garment's diagonal

// Cosines: the parts face the same way, and one is above the other, not beside it.
constexpr float kSameWay = 0.5f, kAbove = 0.7f;

class Search {
  public:
    explicit Search(const Surface& surface)
        : surface_(surface),
          rest_(surface.positions_rest),
          normals_(vertex_normals(surface, rest_)),
          part_(connected_parts(surface)) {}

    bool has_several_parts() const {
        const Index triangles = static_cast<Index>(surface_.triangles.size());
        for (Index t = 1; t < triangles; ++t) {
            if (part_of(t) != part_of(0)) return true;
        }
        return false;
    }

    // The nearest place of another part that is under a vertex (outer), or over it.
    SurfacePoint nearest(const TriangleTree& tree, double reach, Index v, bool outer) const {
        return tree
            .closest_within(
                rest_[v], reach, [&](Index t) { return part_of(t) != part_[v]; },
                [&](const TrianglePoint& point) { return lies(v, outer, point.place); })
            .place;
    }

  private:
    Index part_of(Index triangle) const {  // the lowest vertex of it
        return part_[surface_.welded.corner_vertex[surface_.triangles[triangle].corner[0]]];
    }
    // Whether the direction from the lower place to the upper one is outwards, and both face the same way.
    bool lies(Index v, bool outer, const SurfacePoint& place) const {
        const Vec3 way = (outer ? -1.0f : 1.0f) * (interpolate(surface_, place, rest_) - rest_[v]);
        const Vec3 normal = interpolate(surface_, place, normals_);
        const float height = glm::dot(way, normals_[v]);
        return glm::dot(normal, normals_[v]) > kSameWay * glm::length(normal) &&
               height > kAbove * glm::length(way) && height > kShortestEdge;
    }

    const Surface& surface_;
    const std::vector<Vec3>& rest_;
    std::vector<Vec3> normals_;
    std::vector<Index> part_;  // per welded vertex: the lowest vertex of its part
};

}  // namespace

std::vector<Overlap> find_overlaps(const Surface& surface) {
    const Search search(surface);
    if (!search.has_several_parts()) return {};
    const TriangleTree tree(surface);
    const double reach = kReach * bounding_diagonal(surface.positions_rest);
    std::vector<Overlap> overlaps;
    for (Index v = 0; v < surface.welded.vertex_count; ++v) {
        for (const bool outer : {true, false}) {
            const SurfacePoint place = search.nearest(tree, reach, v, outer);
            if (place.triangle != kNone) overlaps.push_back({v, place, outer});
        }
    }
    return overlaps;
}

}  // namespace rumple::base_cloth
