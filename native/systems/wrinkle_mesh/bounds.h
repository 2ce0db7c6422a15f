// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>
#include <vector>

#include "base/lanes.h"
#include "systems/wrinkle_mesh/pose.h"

namespace rumple::wrinkle_mesh {

// Where a vertex may be (Real: float), or four of them (Lanes), in numbers: what does not bound it is
// infinitely far.
template <typename Real>
struct Bound {
    static constexpr float kFar = std::numeric_limits<float>::infinity();

    Vec3Of<Real> at{}, normal{};                    // of the attachment
    Real radius = all<Real>(kFar);                  // around it
    Vec3Of<Real> floor{};                           // off what is worn under it, unit
    Real lowest = all<Real>(-kFar);                 // above it along that
    Real slide = all<Real>(kFar);                   // from it along the surface
    Vec3Of<Real> towards{};                         // its own cloth, unit; zero: nothing faces it
    Real ahead = all<Real>(kFar), behind = -ahead;  // from the attachment towards that
};

// Where vertices may be: section 3.1 (attachment, equation 7) and 4.2 (collision).
class Bounds {
  public:
    // model and pose must outlive it.
    Bounds(const Model& model, const Settings& settings, const Paint& paint, const Pose& pose);

    // Collision first, then the ball around the attachment: shrinking towards
    // the attachment never crosses a plane that lies below it, so both hold.
    void project(size_t v, Vec3& p) const;

    // Of the rows (Model::row_of) from kLanes * four on: towards the attachment by Settings::tangential_pull
    // and normal_pull, and then project().
    void pull_and_project_four(size_t four, std::span<Row, kLanes> positions) const;

    // Whether its own cloth keeps a vertex from going on.
    bool kept_apart(size_t v, const Vec3& p) const;

    // project() for a vertex that should rather stay: only when it is outside by more than a rounding. Says
    // whether it was.
    bool push_back(size_t v, Vec3& p) const;

  private:
    struct Side {
        float height;
        Vec3 normal;
    };
    // Signed distance to the closest of the base triangles around the vertex.
    Side side_of(size_t v, const Vec3& p) const;

    // project(); with kNeighbourhood and bounds by the cloth itself a vertex may be so far below its floor.
    void put_within(size_t v, float slack, Vec3& p) const;

    Bound<float> bound(size_t v) const;
    bool pulls() const { return tangential_pull_ > 0.0f || normal_pull_ > 0.0f; }
    void pull(const Bound<Lanes>& bound, Vec3Lanes& p) const;

    // Straight towards the attachment until it is above its floor, but for the slack: the floor is no plane,
    // so the other bounds hold after it, and it not after them.
    void keep_above_floor(size_t v, float slack, Vec3& p) const;

    const Model& model_;
    const Pose& pose_;
    Collision collision_;
    bool self_contact_;  // whether the cloth itself bounds anything
    float tangential_pull_;
    float normal_pull_;
    std::vector<float> radii_;
    std::vector<Bound<Lanes>> fours_;  // by their rows
    std::vector<float> floor_;         // kNeighbourhood: the lowest signed distance
};

}  // namespace rumple::wrinkle_mesh
