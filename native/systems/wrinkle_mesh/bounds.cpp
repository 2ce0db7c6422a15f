// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_mesh/bounds.h"

#include <algorithm>
#include <cmath>

#include "surface/query/closest_point.h"

namespace rumple::wrinkle_mesh {
namespace {

Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 w = closest_weights(p, a, b, c);
    return w.x * a + w.y * b + w.z * c;
}

// Secants from a vertex below its floor to the attachment: one where the floor is flat.
constexpr int kFloorSteps = 4;

// Of squared distances, relative: a rounding.
constexpr float kEquallyNear = 1e-4f;

}  // namespace

Bounds::Bounds(const Model& model, const Settings& settings, const Paint& paint, const Pose& pose)
    : model_(model),
      pose_(pose),
      collision_(settings.collision),
      apart_(pose.own.empty() ? 0.0f : settings.apart),
      slide_(pose.heights.empty() ? 0.0f : settings.slide),
      tangential_pull_(settings.tangential_pull),
      normal_pull_(settings.normal_pull),
      radii_(attachment_radii(model, settings, paint)) {
    depth_.resize(radii_.size());
    for (size_t v = 0; v < radii_.size(); ++v)
        depth_[v] = settings.inside * painted(paint.inside, v) * radii_[v];
    for (size_t v = 0; v < pose.gap.size(); ++v) depth_[v] = std::min(depth_[v], pose.gap[v]);
    if (collision_ != Collision::kNeighbourhood) return;
    // The attachments of curved patches may lie below the flat triangles already.
    for (size_t v = 0; v < radii_.size(); ++v) {
        floor_.push_back(std::min(side_of(v, pose.attachment[v]).height, 0.0f) - depth_[v]);
    }
}

void Bounds::project(size_t v, Vec3& p) const {
    put_within(v, 0.25f * kHeldOutside * radii_[v], p);
}

void Bounds::put_within(size_t v, float slack, Vec3& p) const {
    if (!model_.attached[v]) return;
    const Vec3& a = pose_.attachment[v];
    const bool own = apart_ > 0.0f || slide_ > 0.0f;
    if (collision_ == Collision::kPlane) {
        const float height = glm::dot(p - a, pose_.normal[v]);
        if (height < -depth_[v]) p += (-depth_[v] - height) * pose_.normal[v];
    } else if (collision_ == Collision::kNeighbourhood) {
        const Side side = side_of(v, p);
        // What keep_above_floor() left is above it.
        if (side.height < floor_[v] - (own ? slack : 0.0f)) p += (floor_[v] - side.height) * side.normal;
    }
    if (own) keep_off_own(v, p);
    const Vec3 offset = p - a;
    const float length = std::sqrt(glm::dot(offset, offset));
    if (length > radii_[v]) p = a + offset * (radii_[v] / length);  // (7)
    if (own && collision_ == Collision::kNeighbourhood) keep_above_floor(v, slack, p);
}

void Bounds::keep_above_floor(size_t v, float slack, Vec3& p) const {
    const Vec3& a = pose_.attachment[v];
    const float top = side_of(v, a).height;
    for (int i = 0; i < kFloorSteps; ++i) {
        const float height = side_of(v, p).height;
        if (height >= floor_[v] - slack) return;
        p = a + (top - floor_[v]) / (top - height) * (p - a);
    }
    if (side_of(v, p).height < floor_[v] - slack) p = a;
}

void Bounds::keep_off_own(size_t v, Vec3& p) const {
    const Vec3 &a = pose_.attachment[v], &normal = pose_.normal[v];
    const auto along = [&] { return p - a - glm::dot(p - a, normal) * normal; };
    // By how much the way along the surface is too long: 1 where it is not.
    const auto slide_scale = [&] {
        const float slid = glm::length(along()), most = slide_ * pose_.heights[v];
        return slide_ > 0.0f && slid > most ? most / slid : 1.0f;
    };
    p -= (1.0f - slide_scale()) * along();
    if (apart_ > 0.0f && pose_.own[v].towards != Vec3(0.0f)) {
        // Where what faces it lies behind the vertex the two may have passed each other already, and neither
        // way is the safe one.
        const OwnSide& side = pose_.own[v];
        const float moved = glm::dot(p - a, side.towards), left = apart_ * side.distance;
        if (moved > left) p -= (moved - left) * side.towards;
        if (!side.outside && moved < -left) p -= (moved + left) * side.towards;
    }
    // What that broke is mended straight towards the attachment, which breaks nothing: all bounds hold at
    // once, so a held vertex is not pushed again in every frame. (kNeighbourhood: keep_above_floor().)
    float scale = slide_scale();
    const float height = glm::dot(p - a, normal);
    if (collision_ == Collision::kPlane && height < -depth_[v]) scale = std::min(scale, -depth_[v] / height);
    if (scale < 1.0f) p = a + scale * (p - a);
}

bool Bounds::kept_apart(size_t v, const Vec3& p) const {
    if (apart_ <= 0.0f || pose_.own[v].towards == Vec3(0.0f) || radii_[v] <= 0.0f) return false;
    const float moved = glm::dot(p - pose_.attachment[v], pose_.own[v].towards);
    const float left = apart_ * pose_.own[v].distance;
    const float nearly = left - kHeldOutside * radii_[v];
    return moved > nearly || (!pose_.own[v].outside && moved < -nearly);
}

bool Bounds::push_back(size_t v, Vec3& p) const {
    Vec3 inside = p;
    put_within(v, 0.5f * kHeldOutside * radii_[v], inside);
    if (glm::distance(inside, p) <= kHeldOutside * radii_[v]) return false;
    p = inside;
    return true;
}

Bounds::Side Bounds::side_of(size_t v, const Vec3& p) const {
    const Index home = model_.attachments.places[v].triangle;
    float best = -1.0f;
    Side side{0.0f, Vec3(0.0f)};
    for (Index k = model_.near.start[home]; k < model_.near.start[home + 1]; ++k) {
        const Index t = model_.near.triangle[k];
        const Index* corner = model_.base.triangles[t].corner;
        const auto at = [&](int i) { return pose_.base[model_.base.welded.corner_vertex[corner[i]]]; };
        const Vec3 from = p - closest_on_triangle(p, at(0), at(1), at(2));
        const float distance = glm::dot(from, from), height = glm::dot(from, pose_.frames[t].normal);
        // Triangles that meet in the nearest point are equally near: the one that faces the vertex most says
        // on which side it is (Baerentzen, Aanaes 2005), not a rounding.
        const bool nearer = best < 0.0f || distance < (1.0f - kEquallyNear) * best;
        if (!nearer && (distance > (1.0f + kEquallyNear) * best || std::abs(height) <= std::abs(side.height)))
            continue;
        best = nearer ? distance : std::min(best, distance);
        side = {height, pose_.frames[t].normal};
    }
    return side;
}

}  // namespace rumple::wrinkle_mesh
