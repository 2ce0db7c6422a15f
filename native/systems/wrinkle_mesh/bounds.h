// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>
#include <vector>

#include "base/lanes.h"
#include "systems/wrinkle_mesh/pose.h"

namespace rumple::wrinkle_mesh {

// The bounds of one vertex (Real: float), or of four (Lanes). A bound that does not apply is infinitely far
// away.
template <typename Real>
struct Bound {
    static constexpr float kFar = std::numeric_limits<float>::infinity();

    Vec3Of<Real> at{}, normal{};     // of the attachment
    Real radius = all<Real>(kFar);   // largest distance from the attachment
    Vec3Of<Real> floor{};            // unit: direction away from the surface worn under it
    Real lowest = all<Real>(-kFar);  // least height above the attachment in this direction
    Real slide = all<Real>(kFar);    // largest distance from the attachment along the surface
    Vec3Of<Real> towards{};          // unit: direction to its own cloth, or to a body; zero: none faces it
    Real ahead = all<Real>(kFar);    // limit in this direction from the attachment
};

// The bounds of vertices: section 3.1 (attachment, equation 7) and 4.2 (collision).
class Bounds {
  public:
    // model and pose must outlive it.
    Bounds(const Model& model, const Settings& settings, const Paint& paint, const Pose& pose);

    // Applies the collision first, then the ball around the attachment. Moving towards the attachment never
    // crosses a plane below it, so both bounds hold.
    void project(size_t v, Vec3& p) const;

    // project() for the kLanes rows (Model::row_of) from kLanes * four on.
    void project_four(size_t four, std::span<Row, kLanes> positions) const;

    // The same after pulling them towards the attachment by Settings::tangential_pull and normal_pull.
    void pull_and_project_four(size_t four, std::span<Row, kLanes> positions) const;

    // Whether a vertex is stopped by its own cloth.
    bool kept_apart(size_t v, const Vec3& p) const;

    // project() for a held vertex. It moves the vertex only if it is outside by more than rounding. Returns
    // whether it did.
    bool push_back(size_t v, Vec3& p) const;

  private:
    struct Side {
        float height;
        Vec3 normal;
    };
    // Signed distance to the nearest base triangle around the vertex.
    Side side_of(size_t v, const Vec3& p) const;

    // Like project(). With kNeighbourhood and bounds by the cloth itself, a vertex may be below its floor by
    // `slack`.
    void put_within(size_t v, float slack, Vec3& p) const;

    Bound<float> bound(size_t v) const;
    bool pulls() const { return tangential_pull_ > 0.0f || normal_pull_ > 0.0f; }
    void pull(const Bound<Lanes>& bound, Vec3Lanes& p) const;
    void hold_four(size_t four, bool pulled, std::span<Row, kLanes> positions) const;

    // Moves the vertex straight towards the attachment until it is above its floor, or below it by at most
    // `slack`. The floor is not a plane. So this step is the last one: it keeps the other bounds, but they
    // would not keep the floor.
    void keep_above_floor(size_t v, float slack, Vec3& p) const;

    const Model& model_;
    const Pose& pose_;
    Collision collision_;
    bool self_contact_;  // whether the cloth itself gives any bound
    float tangential_pull_;
    float normal_pull_;
    std::vector<float> radii_;
    std::vector<Bound<Lanes>> fours_;  // in the order of rows
    std::vector<float> floor_;         // kNeighbourhood: the lowest signed distance
};

}  // namespace rumple::wrinkle_mesh
