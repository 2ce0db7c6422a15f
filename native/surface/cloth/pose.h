// SPDX-License-Identifier: GPL-3.0-or-later
// One frame, as the solvers of the base cloth see it: where it is animated, and what it stays outside of.
// Internal to the base cloth.
#pragma once

#include <algorithm>
#include <vector>

#include "base/solve_team.h"
#include "surface/cloth/base_cloth.h"
#include "surface/strain/deformation.h"

namespace rumple::base_cloth {

// The plane that stands for the inner surface near a vertex.
struct Plane {
    Vec3 point{0.0f};
    Vec3 normal{0.0f};
};

inline float height_above(const Plane& plane, const Vec3& p) {
    return glm::dot(p - plane.point, plane.normal);
}

// One frame, as the solver sees it. Per welded vertex, unless it is said; lengths in object units, places in
// object space.
struct Pose {
    std::vector<Vec3> animated;
    std::vector<Vec3> normal;          // unit, or zero
    std::vector<TriangleFrame> frame;  // tangent frames: rigid motion carries them along
    std::vector<Vec3> inner;           // the inner surface: what cloth stays outside of
    struct Facet {                     // a triangle of the inner surface
        Row a, b, c;
        Row ball;  // around it: x, y, z of its centre, and its radius
    };
    std::vector<Facet> facets;
    std::vector<float> clearance;     // Clearance::inwards: object units, negative inside a body
    std::vector<Plane> ahead;         // of a body in front of it, which it stays before; normal zero: none
    std::vector<float> ahead_height;  // of the animated place above that plane, object units; none: its room
    float body_known = 0.0f;          // share of the vertices that have a body under them
    std::vector<float> length;        // of every spring between the animated vertices, object units
    std::vector<float> cut;  // of every spring: length of the cloth, object units; in fours, 0 after the last
    // Of every spring: share of compression, folded and smoothing, 0..1; in fours, 0 after the last.
    std::vector<float> firmness;
    std::vector<float> follow;       // 1/s^2
    std::vector<float> room;         // Settings::room times paint, object units, >= 0
    std::vector<float> slide_share;  // 0..1: a way along the surface counts by this share against the room

    // The nearest place towards the animated one that is within the room. The way out of a body is always
    // free.
    Vec3 within_room(size_t v, const Vec3& p) const {
        const Vec3 away = p - animated[v], off = glm::dot(away, normal[v]) * normal[v];
        const Vec3 counted = slide_share[v] * away + (1.0f - slide_share[v]) * off;
        const float used = std::sqrt(glm::dot(counted, counted)), most = std::max(room[v], -clearance[v]);
        return used > most ? animated[v] + away * (most / used) : p;
    }
};

// Whether a state has as many springs and vertices as the model. Where its vertices are Hang and Swing say
// differently: each looks at that itself.
bool matches(const Model& model, const State& state);

// Whether a pose has what a state keeps of the one that it was solved for, but for rounding: springs as long,
// by kHeldStrain, and what is under and ahead of each vertex as far, by `still`, object units. state:
// matches() the model.
bool same_pose(const Model& model, const Pose& pose, const State& state, float still);

// Keeps what same_pose() compares. held: the state before, where it is held: what it kept stays as it is; or
// none.
void keep_pose(const Pose& pose, const State* held, State& state);

// Of the springs at rest, object units.
double mean_length(const Model& model);

// body_hint: as of clearance(). Throws InvalidInput.
Pose make_pose(const Model& model, const Settings& settings, const Paint& paint,
               std::span<const Vec3> positions, const PosedCollider* bodies, std::vector<Index>& body_hint);

// The pose with its vertices, and its inner surface with them, moved elsewhere; nothing turned. moved: a copy
// of the pose, which may have been moved before.
void move_to(const Model& model, const Pose& pose, std::vector<Vec3> animated, Pose& moved);

// The plane of every vertex. hints: per vertex the triangle that was nearest before, or kNone (loose); gets
// the one that is now.
void look_for_contacts(const Model& model, const Pose& pose, std::span<const Vec3> positions,
                       std::vector<Index>& hints, std::vector<Plane>& planes);

// Puts the vertices outside of the inner surface and within their room, and fills in what is handed out.
void finish(const Model& model, const Settings& settings, const Pose& pose, std::span<const Plane> planes,
            bool has_bodies, std::span<Vec3> x, Result& out);

}  // namespace rumple::base_cloth
