// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_mesh/bounds.h"

#include <algorithm>
#include <cmath>

#include "surface/query/closest_point.h"

namespace rumple::wrinkle_mesh {
namespace {

Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    return mixed(closest_weights(p, a, b, c), a, b, c);
}

// Number of secant steps from a vertex below its floor to the attachment. A flat floor needs one.
constexpr int kFloorSteps = 4;

// Relative tolerance of squared distances, for rounding.
constexpr float kEquallyNear = 1e-4f;

// Unit: attachment radii. How far below its floor a vertex is left by a solve, and while it is held. A solve
// is stricter, so that what it leaves is not pushed again when it is held.
constexpr float kSolvedBelow = 0.25f * kHeldOutside, kHeldBelow = 0.5f * kHeldOutside;

bool in_any(bool beyond) {
    return beyond;
}
bool in_any(const LaneMask& beyond) {
    return bits_of(beyond) != 0;
}

// 1 if a length is at most `most`, else most / length. Nearly all lengths are shorter. They need no square
// root, because a square that is clearly below the square of `most` decides it.
template <typename Real>
Real shortening(const Real& squared, const Real& most) {
    constexpr float kClearly = 1.0f - 1e-5f;
    const Real one = all<Real>(1.0f);
    if (!in_any(squared > kClearly * (most * most))) return one;
    const Real length = square_root(squared);
    return length > most ? most / length : one;
}

// Keeps a vertex within the bounds by the cloth itself. lifted: whether the plane has just moved it.
template <typename Real>
void keep_off_self(const Bound<Real>& bound, bool lifted, Vec3Of<Real>& p) {
    const Real one = all<Real>(1.0f);
    const auto along = [&] { return p - bound.at - dot(p - bound.at, bound.normal) * bound.normal; };
    const auto slide_scale = [&](const Vec3Of<Real>& way) { return shortening(dot(way, way), bound.slide); };
    const Vec3Of<Real> way = along();
    const Real slides = slide_scale(way);
    p = p - (one - slides) * way;
    const Real moved = dot(p - bound.at, bound.towards);
    const bool too_near = in_any(moved > bound.ahead);
    if (too_near) p = choose(moved > bound.ahead, p - (moved - bound.ahead) * bound.towards, p);
    if (!lifted && !too_near && !in_any(slides < one)) return;  // it was within all bounds
    // The steps above may break other bounds. Moving the vertex straight towards the attachment repairs them
    // and breaks none. Then all bounds hold at once, so a held vertex is not pushed again in every frame.
    // (kNeighbourhood: keep_above_floor().)
    const Real height = dot(p - bound.at, bound.floor), slid = slide_scale(along());
    const auto below = height < bound.lowest;
    const Real raised = in_any(below) ? (below ? bound.lowest / height : one) : one;
    const Real scale = raised < slid ? raised : slid;
    if (in_any(scale < one)) p = choose(scale < one, bound.at + scale * (p - bound.at), p);
}

// Collision with the plane, with the cloth itself, then the ball.
template <typename Real>
void hold_within(const Bound<Real>& bound, bool self_contact, Vec3Of<Real>& p) {
    const Real height = dot(p - bound.at, bound.floor);
    const bool lifted = in_any(height < bound.lowest);
    if (lifted) p = choose(height < bound.lowest, p + (bound.lowest - height) * bound.floor, p);
    if (self_contact) keep_off_self(bound, lifted, p);
    const Vec3Of<Real> offset = p - bound.at;
    const Real scale = shortening(dot(offset, offset), bound.radius);
    if (in_any(scale < all<Real>(1.0f)))
        p = choose(scale < all<Real>(1.0f), bound.at + scale * offset, p);  // (7)
}

}  // namespace

Bounds::Bounds(const Model& model, const Settings& settings, const Paint& paint, const Pose& pose)
    : model_(model),
      pose_(pose),
      collision_(settings.collision),
      self_contact_((settings.apart > 0.0f && !pose.self_contact.empty()) ||
                    (settings.slide > 0.0f && !pose.heights.empty())),
      tangential_pull_(settings.tangential_pull),
      normal_pull_(settings.normal_pull),
      radii_(attachment_radii(model, settings, paint)),
      fours_(in_fours(radii_.size()) / kLanes),
      floor_(settings.collision == Collision::kNeighbourhood ? radii_.size() : 0) {
    for_each_index(radii_.size(), kLeastSteps, [&](size_t row) {
        const size_t v = size_t(model.vertex_of_row[row]);
        Bound<Lanes>& four = fours_[row / kLanes];
        const int k = static_cast<int>(row % kLanes);
        four.at.set(k, pose.attachment[v]);
        four.normal.set(k, pose.normal[v]);
        four.floor.set(k, pose.floor.empty() ? pose.normal[v] : pose.floor[v]);
        if (!model.attached[v]) return;
        float depth = settings.inside * painted(paint.inside, v) * radii_[v];
        if (!pose.gap.empty()) depth = std::min(depth, pose.gap[v]);
        four.radius[k] = radii_[v];
        if (collision_ == Collision::kPlane) four.lowest[k] = -depth;
        // Attachments on curved patches may already be below the flat triangles.
        if (collision_ == Collision::kNeighbourhood)
            floor_[v] = std::min(side_of(v, pose.attachment[v]).height, 0.0f) - depth;
        if (settings.slide > 0.0f && !pose.heights.empty()) four.slide[k] = settings.slide * pose.heights[v];
        if (settings.apart <= 0.0f || pose.self_contact.empty() || pose.self_contact[v].towards == Vec3(0.0f))
            return;
        const SelfContactSide& facing = pose.self_contact[v];
        four.radius[k] = std::min(radii_[v], settings.apart * facing.in_any_direction);
        four.towards.set(k, facing.towards);
        four.ahead[k] = settings.apart * facing.distance;
    });
}

Bound<float> Bounds::bound(size_t v) const {
    const size_t row = size_t(model_.row_of[v]);
    const Bound<Lanes>& four = fours_[row / kLanes];
    const int k = static_cast<int>(row % kLanes);
    return {four.at.at(k),  four.normal.at(k), four.radius[k],     four.floor.at(k),
            four.lowest[k], four.slide[k],     four.towards.at(k), four.ahead[k]};
}

void Bounds::project(size_t v, Vec3& p) const {
    put_within(v, kSolvedBelow * radii_[v], p);
}

void Bounds::pull(const Bound<Lanes>& bound, Vec3Lanes& p) const {
    const Vec3Lanes away = p - bound.at;
    const Vec3Lanes off = dot(away, bound.normal) * bound.normal;
    p = p - (all_lanes(tangential_pull_) * (away - off) + all_lanes(normal_pull_) * off);
}

void Bounds::pull_and_project_four(size_t four, std::span<Row, kLanes> positions) const {
    hold_four(four, pulls(), positions);
}

void Bounds::project_four(size_t four, std::span<Row, kLanes> positions) const {
    hold_four(four, false, positions);
}

void Bounds::hold_four(size_t four, bool pulled, std::span<Row, kLanes> positions) const {
    Vec3Lanes p = columns(positions);
    if (pulled) pull(fours_[four], p);
    if (collision_ != Collision::kNeighbourhood) hold_within(fours_[four], self_contact_, p);
    store_rows(p, positions);
    if (collision_ != Collision::kNeighbourhood) return;
    for (size_t k = 0; k < kLanes && kLanes * four + k < radii_.size(); ++k) {
        Vec3 one = positions[k].vec();
        project(size_t(model_.vertex_of_row[kLanes * four + k]), one);
        positions[k] = Row(one);
    }
}

void Bounds::put_within(size_t v, float slack, Vec3& p) const {
    if (!model_.attached[v]) return;
    const bool neighbourhood = collision_ == Collision::kNeighbourhood;
    if (neighbourhood) {
        const Side side = side_of(v, p);
        // A vertex that keep_above_floor() accepts is not pushed.
        if (side.height < floor_[v] - (self_contact_ ? slack : 0.0f))
            p += (floor_[v] - side.height) * side.normal;
    }
    hold_within(bound(v), self_contact_, p);
    if (neighbourhood && self_contact_) keep_above_floor(v, slack, p);
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

bool Bounds::kept_apart(size_t v, const Vec3& p) const {
    const Bound<float> b = bound(v);
    if (b.towards == Vec3(0.0f) || radii_[v] <= 0.0f) return false;
    const float rounding = kHeldOutside * radii_[v];
    return glm::dot(p - b.at, b.towards) > b.ahead - rounding ||
           (b.radius < radii_[v] && glm::distance(p, b.at) > b.radius - rounding);
}

bool Bounds::push_back(size_t v, Vec3& p) const {
    Vec3 inside = p;
    put_within(v, kHeldBelow * radii_[v], inside);
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
        // Several triangles may share the nearest point and so be equally near. Then the triangle that faces
        // the vertex most directly decides the side (Baerentzen, Aanaes 2005), so that rounding does not.
        const bool nearer = best < 0.0f || distance < (1.0f - kEquallyNear) * best;
        if (!nearer && (distance > (1.0f + kEquallyNear) * best || std::abs(height) <= std::abs(side.height)))
            continue;
        best = nearer ? distance : std::min(best, distance);
        side = {height, pose_.frames[t].normal};
    }
    return side;
}

}  // namespace rumple::wrinkle_mesh
