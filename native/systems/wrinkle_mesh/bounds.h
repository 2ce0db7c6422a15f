// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "systems/wrinkle_mesh/pose.h"

namespace rumple::wrinkle_mesh {

// Where one vertex may be: section 3.1 (attachment, equation 7) and 4.2 (collision).
class Bounds {
  public:
    // model and pose must outlive it.
    Bounds(const Model& model, const Settings& settings, const Paint& paint, const Pose& pose);

    // Collision first, then the ball around the attachment: shrinking towards
    // the attachment never crosses a plane that lies below it, so both hold.
    void project(size_t v, Vec3& p) const;

    bool pulls() const { return tangential_pull_ > 0.0f || normal_pull_ > 0.0f; }

    // Towards the attachment by Settings::tangential_pull and normal_pull.
    void pull(size_t v, Vec3& p) const {
        const Vec3 away = p - pose_.attachment[v];
        const Vec3 off = glm::dot(away, pose_.normal[v]) * pose_.normal[v];
        p -= tangential_pull_ * (away - off) + normal_pull_ * off;
    }

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

    // project(); with kNeighbourhood and bounds by the own cloth a vertex may be so far below its floor.
    void put_within(size_t v, float slack, Vec3& p) const;

    // The bounds by the own cloth.
    void keep_off_own(size_t v, Vec3& p) const;

    // Straight towards the attachment until it is above its floor, but for the slack: the floor is no plane,
    // so the other bounds hold after it, and it not after them.
    void keep_above_floor(size_t v, float slack, Vec3& p) const;

    const Model& model_;
    const Pose& pose_;
    Collision collision_;
    float apart_;
    float slide_;
    float tangential_pull_;
    float normal_pull_;
    std::vector<float> radii_;
    std::vector<float> depth_;  // how far below the surface a vertex may be
    std::vector<float> floor_;  // kNeighbourhood: the lowest signed distance
};

}  // namespace rumple::wrinkle_mesh
