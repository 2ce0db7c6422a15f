// SPDX-License-Identifier: GPL-3.0-or-later
// The inner surface of the base cloth: its triangles, and the contact with it.
#include <array>
#include <cmath>

#include "surface/cloth/pose.h"
#include "surface/query/closest_point.h"

namespace rumple::base_cloth {
namespace {

// Four facets at a time: those of a list from a place on. The last one stands for those beyond its end.
class FourFacets {
  public:
    FourFacets(const Pose& pose, std::span<const Index> list, size_t first)
        : count_(std::min<size_t>(list.size() - first, kLanes)) {
        for (size_t k = 0; k < kLanes; ++k) facet_[k] = &pose.facets[list[first + std::min(k, count_ - 1)]];
    }

    LaneMask present() const {
        constexpr LaneMask kNumber{0, 1, 2, 3};
        return kNumber < static_cast<std::int32_t>(count_);
    }
    float radius(int k) const { return facet_[k]->ball.xyz[3]; }
    Lanes radii() const { return Lanes{radius(0), radius(1), radius(2), radius(3)}; }
    Vec3Lanes centres() const { return all_of(&Pose::Facet::ball); }
    Vec3Lanes a() const { return all_of(&Pose::Facet::a); }
    Vec3Lanes b() const { return all_of(&Pose::Facet::b); }
    Vec3Lanes c() const { return all_of(&Pose::Facet::c); }

  private:
    Vec3Lanes all_of(Row Pose::Facet::*part) const {
        return columns(std::array{facet_[0]->*part, facet_[1]->*part, facet_[2]->*part, facet_[3]->*part});
    }

    size_t count_;
    std::array<const Pose::Facet*, kLanes> facet_;
};

// The point of the inner surface nearest to p, found by walking from triangle to triangle.
Plane nearest_plane(const Model& model, const Pose& pose, const Vec3& p, Index& triangle) {
    const auto mix = [&](Index t, const Vec3& w, const std::vector<Vec3>& values) {
        const auto [a, b, c] = welded_vertices(model.surface, t);
        return mixed(w, values[a], values[b], values[c]);
    };
    const auto outside = [](float away, float radius, float least) {
        const float farther = std::sqrt(least) + radius;
        return away > farther * farther;
    };
    Index best = triangle;
    const Pose::Facet& home = pose.facets[best];
    Vec3 weights = closest_weights(p, home.a.vec(), home.b.vec(), home.c.vec());
    const Vec3 to = p - mix(best, weights, pose.inner);
    float least = glm::dot(to, to);
    const Vec3Lanes at(p);
    for (Index from = kNone; from != best;) {
        from = best;
        const Index begin = model.near.start[from], end = model.near.start[from + 1];
        const std::span<const Index> near(&model.near.triangle[begin], size_t(end - begin));
        for (size_t first = 0; first < near.size(); first += kLanes) {
            const FourFacets facets(pose, near, first);
            const Vec3Lanes from_centre = at - facets.centres();
            const Lanes away = dot(from_centre, from_centre), farther = std::sqrt(least) + facets.radii();
            const LaneMask close = ~(away > farther * farther) & facets.present();
            if (bits_of(close) == 0) continue;
            const Vec3Lanes a = facets.a(), b = facets.b(), c = facets.c();
            const Vec3Lanes w = closest_weights(at, a, b, c), way = at - mixed(w, a, b, c);
            const Lanes squared = dot(way, way);
            for_each_true(close, [&](int k) {
                if (outside(away[k], facets.radius(k), least)) return;  // one of the four is nearer
                if (!(squared[k] < least)) return;  // what is no number is no way: the walk ends
                least = squared[k];
                best = near[first + size_t(k)];
                weights = w.at(k);
            });
        }
    }
    triangle = best;
    return {mix(best, weights, pose.inner), direction_of_normals(mix(best, weights, pose.normal))};
}

}  // namespace

void place_facets(const Surface& surface, Pose& pose) {
    pose.facets.resize(surface.triangles.size());
    for (Index t = 0; t < static_cast<Index>(surface.triangles.size()); ++t) {
        const auto [a, b, c] = welded_vertices(surface, t);
        const Vec3 centre = (pose.inner[a] + pose.inner[b] + pose.inner[c]) / 3.0f;
        float square = 0.0f;
        for (const Index v : {a, b, c}) {
            const Vec3 from_centre = pose.inner[v] - centre;
            square = std::max(square, glm::dot(from_centre, from_centre));
        }
        const Lanes ball{centre.x, centre.y, centre.z, std::sqrt(square)};
        pose.facets[t] = {pose.inner[a], pose.inner[b], pose.inner[c], Row(ball)};
    }
}

void move_to(const Model& model, const Pose& pose, std::vector<Vec3> animated, Pose& moved) {
    for (size_t v = 0; v < animated.size(); ++v) {
        const Vec3 displacement = animated[v] - pose.animated[v];
        moved.inner[v] = pose.inner[v] + displacement;
        moved.ahead[v].point = pose.ahead[v].point + displacement;
    }
    moved.animated = std::move(animated);
    place_facets(model.surface, moved);
}

void look_for_contacts(const Model& model, const Pose& pose, std::span<const Vec3> positions,
                       std::vector<Index>& hints, std::vector<Plane>& planes) {
    for_each_index(positions.size(), kLeastSearches, [&](size_t v) {
        if (hints[v] != kNone) planes[v] = nearest_plane(model, pose, positions[v], hints[v]);
    });
}

}  // namespace rumple::base_cloth
