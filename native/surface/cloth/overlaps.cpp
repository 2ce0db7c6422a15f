// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/overlaps.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

// For distances that are computed in another way than in lies(), relative to the reach.
constexpr double kRounding = 1e-4;

// The lowest and the highest number of the parts in a node of the tree.
struct PartRange {
    Index low = std::numeric_limits<Index>::max(), high = -1;

    void add(const PartRange& other) {
        low = std::min(low, other.low);
        high = std::max(high, other.high);
    }
};

Index part_of(const Surface& surface, std::span<const Index> part, Index triangle) {
    return part[surface.welded.corner_vertex[surface.triangles[triangle].corner[0]]];
}

bool has_several_parts(const Surface& surface, std::span<const Index> part) {
    for (Index t = 1; t < static_cast<Index>(surface.triangles.size()); ++t)
        if (part_of(surface, part, t) != part_of(surface, part, 0)) return true;
    return false;
}

class Search {
  public:
    // part: per welded vertex, from connected_parts().
    Search(const Surface& surface, std::span<const Index> part)
        : surface_(surface),
          rest_(surface.positions_rest),
          normals_(vertex_normals(surface, rest_)),
          part_(part),
          reach_(kReach * bounding_diagonal(rest_)),
          tree_(surface),
          parts_(volumes_of<PartRange>(tree_.hierarchy(), [&](PartRange& parts, Index place) {
              const Index here = part_of(surface_, part_, tree_.hierarchy().order[place]);
              parts.add({here, here});
          })) {}

    // The nearest place of another part that is under a vertex (outer), or over it.
    SurfacePoint nearest(Index v, bool outer) const {
        return tree_
            .closest_within(
                rest_[v], reach_, [&](Index node) { return has_none(node, v, outer); },
                [&](Index t) { return part_of(surface_, part_, t) != part_[v]; },
                [&](const TrianglePoint& point) { return lies(v, outer, point.place); })
            .place;
    }

  private:
    // Whether the direction from the lower place to the upper one is outwards, and both face the same way.
    bool lies(Index v, bool outer, const SurfacePoint& place) const {
        const Vec3 way = (outer ? -1.0f : 1.0f) * (interpolate(surface_, place, rest_) - rest_[v]);
        const Vec3 normal = interpolate(surface_, place, normals_);
        const float height = glm::dot(way, normals_[v]);
        return glm::dot(normal, normals_[v]) > kSameWay * glm::length(normal) &&
               height > kAbove * glm::length(way) && height > kShortestEdge;
    }
    // Whether lies() is false everywhere in a node: it has no other part, or no place that is high enough. Of
    // a dense garment almost all triangles within the reach are left out here.
    bool has_none(Index node, Index v, bool outer) const {
        if (parts_[node].low == part_[v] && parts_[node].high == part_[v]) return true;
        const Bounds& box = tree_.bounds(node);
        const glm::dvec3 p(rest_[v]), up = (outer ? -1.0 : 1.0) * glm::dvec3(normals_[v]);
        const glm::dvec3 heights = glm::max(up * (box.low - p), up * (box.high - p));
        const double highest = heights.x + heights.y + heights.z + kRounding * reach_;
        return highest < kAbove * std::sqrt(squared_distance(box, p));
    }

    const Surface& surface_;
    const std::vector<Vec3>& rest_;
    std::vector<Vec3> normals_;
    std::span<const Index> part_;
    double reach_;
    TriangleTree tree_;
    std::vector<PartRange> parts_;  // per node of the tree
};

}  // namespace

std::vector<Overlap> find_overlaps(const Surface& surface) {
    const std::vector<Index> part = connected_parts(surface);
    if (!has_several_parts(surface, part)) return {};
    const Search search(surface, part);
    std::vector<Overlap> overlaps;
    for (Index v = 0; v < surface.welded.vertex_count; ++v) {
        for (const bool outer : {true, false}) {
            const SurfacePoint place = search.nearest(v, outer);
            if (place.triangle != kNone) overlaps.push_back({v, place, outer});
        }
    }
    return overlaps;
}

}  // namespace rumple::base_cloth
