// SPDX-License-Identifier: GPL-3.0-or-later
// The pose of a frame for the solvers of the base cloth: its animated positions and the surfaces that it
// stays outside of. Internal to the base cloth.
#pragma once

#include <algorithm>
#include <vector>

#include "base/solve_team.h"
#include "surface/cloth/base_cloth.h"
#include "surface/strain/deformation.h"

namespace rumple::base_cloth {

// The plane that represents the inner surface near a vertex.
struct Plane {
    Vec3 point{0.0f};
    Vec3 normal{0.0f};
};

inline float height_above(const Plane& plane, const Vec3& p) {
    return glm::dot(p - plane.point, plane.normal);
}

// The pose of one frame. Per welded vertex, unless stated otherwise. Lengths in object units, positions in
// object space.
struct Pose {
    std::vector<Vec3> animated;
    std::vector<Vec3> normal;         // unit, or zero
    std::vector<SurfaceFrame> frame;  // tangent frames, which move with rigid motion
    std::vector<Vec3> inner;          // the inner surface, which cloth stays outside of
    struct Facet {                    // a triangle of the inner surface
        Row a, b, c;
        Row ball;  // bounding sphere: x, y, z of its centre, and its radius
    };
    std::vector<Facet> facets;
    std::vector<float> clearance;  // Clearance::inwards: object units, negative inside a body
    std::vector<Plane> ahead;  // of a body in front of the cloth, which it must not pass; normal zero: none
    std::vector<float> ahead_height;  // of the animated place above that plane, object units; none: its room
    float body_known = 0.0f;          // share of the vertices that have a body under them
    std::vector<float> length;        // of every spring between the animated vertices, object units
    // Of every spring, in fours, 0 after the last: rest length with its slack, object units; the factor of
    // Settings::compression and Settings::folded, 0..1.
    std::vector<float> rest_length, compression_scale;
    std::vector<float> smoothing;    // of every spring: Settings::smoothing times shares; likewise
    std::vector<float> follow;       // 1/s^2
    std::vector<float> room;         // Settings::room times paint, object units, >= 0
    std::vector<float> slide_share;  // 0..1: share of a way along the surface that uses up room

    // Moves a place towards the animated one until it is within the room. Movement out of a body is always
    // allowed.
    Vec3 within_room(size_t v, const Vec3& p) const {
        const Vec3 away = p - animated[v], off = glm::dot(away, normal[v]) * normal[v];
        const Vec3 counted = slide_share[v] * away + (1.0f - slide_share[v]) * off;
        const float used = std::sqrt(glm::dot(counted, counted)), most = std::max(room[v], -clearance[v]);
        return used > most ? animated[v] + away * (most / used) : p;
    }
};

// Whether a state has as many springs and vertices as the model. Hang and Swing store positions differently,
// and check them separately.
bool matches(const Model& model, const State& state);

// Whether a pose equals, apart from rounding, the pose that a state was solved for: lengths of springs within
// kHeldStrain, distances to bodies under and ahead of each vertex within `still`, object units. state:
// matches() the model.
bool same_pose(const Model& model, const Pose& pose, const State& state, float still);

// Stores the values that same_pose() compares. held: the state before if the cloth is asleep, whose stored
// values are kept; or none.
void keep_pose(const Pose& pose, const State* held, State& state);

// Mean length of the springs at rest, object units.
double mean_length(const Model& model);

// body_hint: as of clearance(). Throws InvalidInput.
Pose make_pose(const Model& model, const Settings& settings, const Paint& paint,
               std::span<const Vec3> positions, const PosedCollider* bodies, std::vector<Index>& body_hint);

// Makes the triangles of the inner surface from its vertices.
void place_facets(const Surface& surface, Pose& pose);

// Moves the vertices of a pose and its inner surface with them, without rotation. moved: a copy of the pose,
// which may have been moved before.
void move_to(const Model& model, const Pose& pose, std::vector<Vec3> animated, Pose& moved);

// The plane of every vertex. hints: per vertex the triangle that was nearest before, or kNone (loose);
// receives the nearest one now.
void look_for_contacts(const Model& model, const Pose& pose, std::span<const Vec3> positions,
                       std::vector<Index>& hints, std::vector<Plane>& planes);

// Moves the vertices outside of the inner surface and within their room, and fills in the result.
void finish(const Model& model, const Settings& settings, const Pose& pose, std::span<const Plane> planes,
            bool has_bodies, std::span<Vec3> x, Result& out);

}  // namespace rumple::base_cloth
