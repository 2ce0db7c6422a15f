// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Maps: L. Dutreve, A. Meyer and S. Bouakaz, Real-Time Dynamic Wrinkles
// of Face for Animated Skinned Mesh, ISVC 2009. The present pose of a skeleton is
// compared, bone by bone, with reference poses that have a normal map each; the
// skin weights say where on the mesh each map shows.
// Section numbers are the paper's; docs/wrinkle_maps.md says where we leave it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/array.h"
#include "base/formulas.h"

namespace rumple::wrinkle_maps {

inline constexpr Index kMostPoses = 16;

// What of a bone is followed. A joint that only turns does not move its own head.
// kKey: no bone but a shape key, whose value is the x of its head.
enum class Tracked { kHead, kTail, kBoth, kKey };

// A bone as two points.
struct Bone {
    Vec3 head;
    Vec3 tail;
};

struct ReferencePose {
    std::string name;
    std::vector<Bone> bones;  // root space
};

// The reference poses as the artist made them. b bones and shape keys, o poses.
struct Rig {
    std::vector<std::string> names;    // b, of the bones: for messages
    std::vector<Tracked> tracked;      // b
    std::vector<Index> group;          // b: number of its group, any number >= 0; kNone: on its own
    std::vector<Bone> neutral;         // b, P_0, root space
    std::vector<ReferencePose> poses;  // o, P_1 .. P_o, at most kMostPoses
};

// Settings of every frame.
struct Settings {
    float gain = 1.0f;  // of masks where the skin is only partly moved: slope of gained() at 0, 0.1..100
    std::vector<float> strength;  // per pose, 0..1: 0 mutes it. Empty: 1 for all
};

// Throws InvalidInput naming the first setting out of its range, the range and the value. masks() calls it.
void check(const Settings& settings, Index poses);

// Built once, then immutable; may be shared between objects.
struct Model {
    Rig rig;
    std::vector<std::uint8_t> moves;         // b x o: 1 where the bone itself moves in P_k
    std::vector<std::uint8_t> active;        // b x o: 1 where it or another of its group does
    std::vector<std::vector<Index>> groups;  // members of every group of two or more
    SparseRows weights;  // vertices x bones, every row sums to 1 with what other bones have, beside its keys
    // vertices x o: sum of the weights of what is active in P_k; above 1 where keys overlap
    std::vector<float> reach;
    bool overlaps = false;   // reach is above 1 somewhere
    Index unnormalised = 0;  // vertices whose weights did not sum to 1
    Index unbound = 0;       // vertices without any weight: their masks are 0

    Index bones() const { return static_cast<Index>(rig.neutral.size()); }
    Index poses() const { return static_cast<Index>(rig.poses.size()); }
    Index vertices() const { return weights.rows(); }
};

// weights: a row per vertex of the mesh, >= 0, of all bones that deform it; index kNone: a bone that is not
// in the rig. Those of bones are made to sum to 1. A key has its own, 0..1: how far it moves the vertex, as a
// share of what it moves farthest. Throws InvalidInput naming the first bad pose, bone or vertex:
// counts that do not match, points or weights that are not finite, a pose in which no bone moves, two poses
// that are the same. Cost: O(o^2 b + weights).
std::shared_ptr<const Model> build(const Rig& rig, const SparseRows& weights);

// Section 5, footnote 1: bones in the space of the root bone. root: from root space to the space of the
// bones. Throws InvalidInput when it is not finite or has no inverse. Cost: O(b).
std::vector<Bone> in_root_space(const glm::mat4& root, std::span<const Bone> bones);

// Section 5.1, groups of 5.2 included.
struct Influences {
    std::vector<float> pose;  // b x o: I_Pk(J_i), 0..1
    std::vector<float> rest;  // b: alpha_i0, 0..1
};
// bones: b, root space. Throws InvalidInput when their number does not match or one is not finite. Cost: O(o
// b).
Influences evaluate(const Model& model, std::span<const Bone> bones);

// How present each pose is as a whole, for bars and tables: mean of its influences over the bones active in
// it.
std::vector<float> presence(const Model& model, const Influences& influences);

// Section 5.2: Inf(v, P_k), o x vertices, 0..1; divided by the reach where that is above 1. Throws
// InvalidInput when a setting is out of its range or the influences are not of this model. Deterministic.
// Cost: O(o x weights).
std::vector<float> masks(const Model& model, const Settings& settings, const Influences& influences);

// The share that a reach gets. 0 -> 0, 1 -> 1, rising; the identity for a gain of 1.
inline float gained(float reach, float gain) {
    return reach * gain / (1.0f + (gain - 1.0f) * reach);
}

// What the wrinkle maps contain (section 5.3).
enum class Maps { kWhole, kWrinkles };  // the neutral map's details too; wrinkles only

// Section 5.3 for one pixel: tangent-space normals, decoded. neutral: N. wrinkles, masks: one for each pose.
Vec3 blend(Maps maps, const Vec3& neutral, std::span<const Vec3> wrinkles, std::span<const float> masks);

}  // namespace rumple::wrinkle_maps
