// SPDX-License-Identifier: GPL-3.0-or-later
// Reference triangles. Compression is measured against them if there is no rest pose, or if a lasting shape
// should become the rest shape. R. Gillette, Augmentation of Coarse Meshes with Wrinkles, UBC 2015, chapter 4
// (C. Peters's work). docs/wrinkle_paths.md lists our differences.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "surface/mesh/topology.h"
#include "surface/mesh/triangle_net.h"
#include "surface/strain/flat_triangle.h"
#include "surface/strain/labels.h"

namespace rumple {

// Reference triangles that start from the rest pose or from the first frame and then adapt, or the unchanged
// rest pose.
enum class Reference { kRestPose, kFirstFrame, kStaticRest };

struct ReferenceSettings {
    Reference reference = Reference::kRestPose;
    float window = 0.1f;       // age of the pose that labels compare with, s, 0..10; 0: the previous frame
    float relaxation = 0.01f;  // of compressed reference triangles, share per 1/30 s, 0..1; thesis: 0.05
    float growth = 1.05f;      // largest length / length in the rest pose (kRestPose), >= 1
    float growth_time = 0.1f;  // of references that take over a longer shape, s, 0..10; thesis: 0
};
// Throws InvalidInput naming the first setting out of its range, the range and the value.
void check_reference(const ReferenceSettings& settings);

// Depends only on the rest pose, built once.
struct ReferenceModel {
    TriangleNet net;
    std::vector<FlatTriangle> rest;  // per triangle
};
// Cost: O(triangles log triangles).
ReferenceModel build_reference(const Surface& surface);

// A pose of the base for chapter 4.
struct FlatPose {
    std::vector<Vec3> positions;       // welded vertices, object space
    std::vector<FlatTriangle> shapes;  // per triangle
};
FlatPose flat_pose(const TriangleNet& net, std::vector<Vec3> welded);

// The time of a frame, and what is known about later frames. Labels do not depend on the reference, so they
// can be computed in advance.
struct FrameTime {
    double time = 0.0;                       // seconds; the frame number over the frame rate
    std::span<const std::uint8_t> labels{};  // of label_clip(), per triangle; empty: computed here
    std::span<const Vec3> next_positions{};  // positions of the next frame for the cut; or empty
    double next_time = 0.0;
};

// The state from frame to frame. It has only plain values, so a stored state continues exactly like the
// original.
struct ReferenceState {
    double time = 0.0;                    // seconds
    Labels labels;                        // per triangle
    std::vector<FlatTriangle> reference;  // per triangle
    std::vector<double> past_times;    // of the poses that labels still need, the oldest first, this one last
    std::vector<Vec3> past_positions;  // poses x welded vertices, object space

    bool empty() const { return reference.empty(); }
    size_t bytes() const {
        return labels.size() + reference.size() * sizeof(FlatTriangle) + past_times.size() * sizeof(double) +
               past_positions.size() * sizeof(Vec3);
    }
};

// Throws InvalidInput naming the first bad value: a frame time that does not match the surface or the state,
// or a state that belongs to another surface or has values that no frame can give.
void check_frame_time(const Surface& surface, const FrameTime& frame_time, const ReferenceState* state);
void check_reference(const Surface& surface, const ReferenceState& state);

// Computes one frame, from `before` or from the canonical start if there is none: sections 4.1 and 4.2. pose:
// of this frame. changes: receives how every triangle changed since settings.window ago; undefined without a
// state. Checks nothing. The same input gives the same bits with any numbering of vertices. Cost: about 0.3
// ms for 1,000 triangles.
ReferenceState adapt(const Surface& surface, const ReferenceModel& model, const ReferenceSettings& settings,
                     const FrameTime& frame_time, const FlatPose& pose, const ReferenceState* before,
                     std::vector<Stretch>& changes);

// The same for a system that needs only the state. It takes the welded positions of this frame, and an empty
// state counts as none. Throws InvalidInput like the public functions.
ReferenceState adapt(const Surface& surface, const ReferenceModel& model, const ReferenceSettings& settings,
                     const FrameTime& frame_time, std::span<const Vec3> welded, const ReferenceState& before);

// Labels of a whole clip in one cut (section 4.1.2), frames x triangles; for bakes. raw: without the cut.
// positions: frames x vertices as the artist has them, object space. Throws InvalidInput if they are not
// finite or do not match, or if times do not ascend. Cost: about 1 ms and half a megabyte per frame and 1,000
// triangles. If it is more than 250 MB in all, the clip is cut in pieces (cut_clip).
Labels label_clip(const Surface& surface, const ReferenceModel& model, const ReferenceSettings& settings,
                  std::span<const double> times, std::span<const Vec3> positions, bool raw = false);

// ---- steps of adapt(), for tests
std::vector<Stretch> recent_changes(const ReferenceModel& model, const ReferenceSettings& settings,
                                    double time, const FlatPose& pose, const ReferenceState* state);
std::vector<FlatTriangle> update_reference(const ReferenceModel& model, const ReferenceSettings& settings,
                                           const FlatPose& pose, const Labels& labels, double seconds,
                                           const ReferenceState* state);

// Converts a share per 1/30 s to a share per `seconds`, so that the result does not depend on the frame rate.
float fraction_in(float share_per_thirtieth, double seconds);

// The share that an exponential filter with this time constant takes over in `seconds`.
float fraction_of(double seconds, double time);

}  // namespace rumple
