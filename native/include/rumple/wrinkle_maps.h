// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Maps: L. Dutreve, A. Meyer and S. Bouakaz, Real-Time Dynamic Wrinkles of Face for Animated Skinned
// Mesh, ISVC 2009. The current pose of a skeleton is compared, bone by bone, with reference poses. Each
// reference pose has a normal map. The skin weights determine where each map is visible. docs/wrinkle_maps.md
// has the mathematics.
#ifndef RUMPLE_WRINKLE_MAPS_H
#define RUMPLE_WRINKLE_MAPS_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

#define RUMPLE_MOST_POSES 16

// Reference poses and skin weights: b bones, o poses, n vertices. A bone is its head and tail, 6 floats. A
// shape key counts as a bone: the first of its 6 floats is its value, the others are ignored.
typedef struct rumple_wrinkle_maps rumple_wrinkle_maps;

// The part of a bone that is compared.
typedef enum rumple_tracked {
    RUMPLE_TRACKED_HEAD = 0,
    RUMPLE_TRACKED_TAIL = 1,
    RUMPLE_TRACKED_BOTH = 2,
    RUMPLE_TRACKED_KEY = 3  // a shape key
} rumple_tracked;

typedef struct rumple_wrinkle_maps_pose {
    const char* name;    // UTF-8, for messages
    const float* bones;  // (b, 6), root space, finite
    size_t bones_count;
} rumple_wrinkle_maps_pose;

typedef struct rumple_wrinkle_maps_plan {
    const char* const* names;  // (b), UTF-8, for messages
    size_t names_count;
    const int32_t* tracked;  // (b), rumple_tracked
    size_t tracked_count;
    const int32_t* group;  // (b): bones of the same group share their influences; -1: in no group
    size_t group_count;
    const float* neutral;  // (b, 6): P_0, root space, finite
    size_t neutral_count;
    const rumple_wrinkle_maps_pose* poses;  // (o), at most RUMPLE_MOST_POSES
    size_t poses_count;
    const int32_t* weight_start;  // (n + 1): the first weight of every vertex, then their number
    size_t weight_start_count;
    const int32_t* weight_bone;  // (weights); -1: a bone that is not listed
    size_t weight_bone_count;
    const float* weight;  // (weights), >= 0; bones: normalised to a sum of 1 per vertex; shape keys: 0..1
    size_t weight_count;
} rumple_wrinkle_maps_plan;

// Refused: counts that do not match, a pose in which no bone moves, two equal poses. The error names the
// first bad pose, bone or vertex. Cost: O(o^2 b + weights).
RUMPLE_API rumple_status rumple_wrinkle_maps_build(const rumple_wrinkle_maps_plan* plan,
                                                   rumple_wrinkle_maps** model);
RUMPLE_API void rumple_wrinkle_maps_free(rumple_wrinkle_maps* model);

typedef struct rumple_wrinkle_maps_view {
    int32_t vertex_count;  // n
    int32_t pose_count;    // o
    int32_t bone_count;    // b
    int32_t weight_count;
    int32_t unnormalised;  // vertices whose weights did not sum to 1
    int32_t unbound;       // vertices without any weight: their masks are 0
    const uint8_t* moves;  // (b, o): 1 if the bone moves in the pose
    const float* reach;  // (n, o): sum of the weights of bones that move in a pose; > 1 only with shape keys
    const int32_t* weight_start;  // (n + 1): the weights that are used: of listed bones only
    const int32_t* weight_bone;   // (weight_count)
    const float* weight;          // (weight_count)
} rumple_wrinkle_maps_view;
RUMPLE_API rumple_status rumple_wrinkle_maps_get_view(const rumple_wrinkle_maps* model,
                                                      rumple_wrinkle_maps_view* view);

// Bones in the space of the root bone (section 5, footnote 1). root: (4, 4), from root space to the space of
// the bones. bones: (b, 6). out: (b, 6), written.
RUMPLE_API rumple_status rumple_bones_in_root_space(const float root[16], const float* bones,
                                                    size_t bones_count, float* out, size_t out_count);

// Section 5.1: influences of the poses on every bone, 0..1. bones: (b, 6), root space. pose: (b, o) and
// rest: (b), written.
RUMPLE_API rumple_status rumple_wrinkle_maps_evaluate(const rumple_wrinkle_maps* model, const float* bones,
                                                      size_t bones_count, float* pose, size_t pose_count,
                                                      float* rest, size_t rest_count);
// How much of each pose is present as a whole. presence: (o), written. pose, rest: from
// rumple_wrinkle_maps_evaluate().
RUMPLE_API rumple_status rumple_wrinkle_maps_presence(const rumple_wrinkle_maps* model, const float* pose,
                                                      size_t pose_count, const float* rest, size_t rest_count,
                                                      float* presence, size_t presence_count);

typedef struct rumple_wrinkle_maps_settings {
    float gain;             // gain of masks where bones move the skin only partly, 0.1..100
    const float* strength;  // (o), 0..1: 0 mutes a pose; or none: 1 for all
    size_t strength_count;
} rumple_wrinkle_maps_settings;
RUMPLE_API rumple_wrinkle_maps_settings rumple_wrinkle_maps_settings_default(void);
// Section 5.2: where each map is visible. masks: (o, n), 0..1, written. Cost: O(o x weights).
RUMPLE_API rumple_status rumple_wrinkle_maps_masks(const rumple_wrinkle_maps* model,
                                                   const rumple_wrinkle_maps_settings* settings,
                                                   const float* pose, size_t pose_count, const float* rest,
                                                   size_t rest_count, float* masks, size_t masks_count);

// The contents of the wrinkle maps.
typedef enum rumple_maps_kind {
    RUMPLE_MAPS_WHOLE = 0,    // also the details of the neutral map
    RUMPLE_MAPS_WRINKLES = 1  // wrinkles only
} rumple_maps_kind;
// Section 5.3: blends unit normals in tangent space, pixel by pixel. neutral: (p, 3). wrinkles: (p, 3) for
// each of `poses` poses. masks: (p) for each. out: (p, 3), written.
RUMPLE_API rumple_status rumple_wrinkle_maps_blend(int32_t kind, const float* neutral, size_t neutral_count,
                                                   const float* const* wrinkles, const float* const* masks,
                                                   size_t poses, float* out, size_t out_count);

#ifdef __cplusplus
}
#endif

#endif
