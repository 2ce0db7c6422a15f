// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Maps: L. Dutreve, A. Meyer and S. Bouakaz, Real-Time Dynamic Wrinkles
// of Face for Animated Skinned Mesh, ISVC 2009. The current pose of a skeleton is compared, bone by bone,
// with reference poses. Each reference pose has a normal map. The skin weights determine where each map is
// visible. Section numbers are the paper's. docs/wrinkle_maps.md lists the differences from it.
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

// The part of a bone that is compared. A joint that only rotates does not move its own head. kKey: a shape
// key instead of a bone; its value is the x of the head.
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

// The artist's reference poses. b bones and shape keys, o poses.
struct Rig {
    std::vector<std::string> names;    // b, of the bones: for messages
    std::vector<Tracked> tracked;      // b
    std::vector<Index> group;          // b: number of its group, any number >= 0; kNone: in no group
    std::vector<Bone> neutral;         // b, P_0, root space
    std::vector<ReferencePose> poses;  // o, P_1 .. P_o, at most kMostPoses
};

// Settings of every frame.
struct Settings {
    // Gain of masks where bones move the skin only partly: slope of gained() at 0, 0.1..100
    float gain = 1.0f;
    std::vector<float> strength;  // per pose, 0..1: 0 mutes it. Empty: 1 for all
};

// Throws InvalidInput naming the first setting out of its range, the range and the value. masks() calls it.
void check(const Settings& settings, Index poses);

// Built once, then immutable; may be shared between objects.
struct Model {
    Rig rig;
    std::vector<std::uint8_t> moves;         // b x o: 1 if the bone itself moves in P_k
    std::vector<std::uint8_t> active;        // b x o: 1 if it or another one of its group moves
    std::vector<std::vector<Index>> groups;  // members of every group of two or more
    SparseRows weights;  // vertices x bones; a row, with other bones and without keys, sums to 1
    // vertices x o: sum of the weights of bones that are active in P_k; above 1 if keys overlap
    std::vector<float> reach;
    bool overlaps = false;   // reach is above 1 somewhere
    Index unnormalised = 0;  // vertices whose weights did not sum to 1
    Index unbound = 0;       // vertices without any weight: their masks are 0

    Index bones() const { return static_cast<Index>(rig.neutral.size()); }
    Index poses() const { return static_cast<Index>(rig.poses.size()); }
    Index vertices() const { return weights.rows(); }
};

// weights: a row per vertex of the mesh, >= 0, of all bones that deform it; index kNone: a bone that is not
// in the rig. Weights of bones are normalised to a sum of 1. A key has weights of its own, 0..1: the
// displacement of the vertex relative to the largest one. Throws InvalidInput about the first bad pose, bone
// or vertex: counts that do not match, points or weights that are not finite, a pose in which no bone moves,
// two equal poses. Cost: O(o^2 b + weights).
std::shared_ptr<const Model> build(const Rig& rig, const SparseRows& weights);

// Section 5, footnote 1: bones in the space of the root bone. root: from root space to the space of the
// bones. Throws InvalidInput if it is not finite or has no inverse. Cost: O(b).
std::vector<Bone> in_root_space(const glm::mat4& root, std::span<const Bone> bones);

// Section 5.1, groups of 5.2 included.
struct Influences {
    std::vector<float> pose;  // b x o: I_Pk(J_i), 0..1
    std::vector<float> rest;  // b: alpha_i0, 0..1
};
// bones: b, root space. Throws InvalidInput if their number does not match or one is not finite. Cost: O(o
// b).
Influences evaluate(const Model& model, std::span<const Bone> bones);

// How much of each pose is present as a whole, for bars and tables: the mean of its influences over the bones
// that are active in it.
std::vector<float> presence(const Model& model, const Influences& influences);

// Section 5.2: Inf(v, P_k), o x vertices, 0..1; divided by the reach if that is above 1. Throws InvalidInput
// if a setting is out of its range or the influences are not of this model. Deterministic. Cost: O(o x
// weights).
std::vector<float> masks(const Model& model, const Settings& settings, const Influences& influences);

// The share for a reach after the gain: 0 -> 0, 1 -> 1, increasing; the identity for a gain of 1.
inline float gained(float reach, float gain) {
    return reach * gain / (1.0f + (gain - 1.0f) * reach);
}

// The contents of the wrinkle maps (section 5.3).
enum class Maps { kWhole, kWrinkles };  // also the details of the neutral map; only wrinkles

// Section 5.3 for one pixel: tangent-space normals, decoded. neutral: N. wrinkles, masks: one for each pose.
Vec3 blend(Maps maps, const Vec3& neutral, std::span<const Vec3> wrinkles, std::span<const float> masks);

}  // namespace rumple::wrinkle_maps
