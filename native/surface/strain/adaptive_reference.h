// SPDX-License-Identifier: GPL-3.0-or-later
// Reference triangles: what compression is measured against where there is no rest pose, or where what lasts
// should become the rest shape. R. Gillette, Augmentation of Coarse Meshes with Wrinkles, UBC 2015, chapter 4
// (C. Peters's work); docs/wrinkle_paths.md says where we leave it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "surface/mesh/topology.h"
#include "surface/mesh/triangle_net.h"
#include "surface/strain/flat_triangle.h"
#include "surface/strain/labels.h"

namespace rumple {

// Reference triangles that start from the rest pose or from the first frame and adapt, or the rest pose
// itself.
enum class Reference { kRestPose, kFirstFrame, kStaticRest };

struct ReferenceSettings {
    Reference reference = Reference::kRestPose;
    float window = 0.1f;       // labels compare with the pose so long ago, s, 0..10; 0: the previous frame
    float relaxation = 0.01f;  // of compressed reference triangles, share per 1/30 s, 0..1; printed: 0.05
    float growth = 1.05f;      // most length of a reference triangle over the rest pose's (kRestPose), >= 1
    float growth_time = 0.1f;  // of reference triangles that take over a longer shape, s, 0..10; printed: 0
};
// Throws InvalidInput naming the first setting out of its range, the range and the value.
void check_reference(const ReferenceSettings& settings);

// What the rest pose fixes, built once.
struct ReferenceModel {
    TriangleNet net;
    std::vector<FlatTriangle> rest;  // per triangle
};
// Cost: O(triangles log triangles).
ReferenceModel build_reference(const Surface& surface);

// A pose of the base as chapter 4 sees it.
struct FlatPose {
    std::vector<Vec3> positions;       // welded vertices, object space
    std::vector<FlatTriangle> shapes;  // per triangle
};
FlatPose flat_pose(const TriangleNet& net, std::vector<Vec3> welded);

// When a frame is, and what is known ahead of it. Labels never read the reference, so they can be cut ahead.
struct FrameTime {
    double time = 0.0;                       // seconds; the frame number over the frame rate
    std::span<const std::uint8_t> labels{};  // of label_clip(), per triangle; or empty: they are cut here
    std::span<const Vec3> next_positions{};  // one frame of look-ahead for the cut, as positions; or empty
    double next_time = 0.0;
};

// What is kept from frame to frame. All plain values: a stored state continues as the one that was stored.
struct ReferenceState {
    double time = 0.0;                    // seconds
    Labels labels;                        // per triangle
    std::vector<FlatTriangle> reference;  // per triangle
    std::vector<double> past_times;       // of the poses that labels still need, oldest first, this one last
    std::vector<Vec3> past_positions;     // poses x welded vertices, object space

    bool empty() const { return reference.empty(); }
    size_t bytes() const {
        return labels.size() + reference.size() * sizeof(FlatTriangle) + past_times.size() * sizeof(double) +
               past_positions.size() * sizeof(Vec3);
    }
};

// Throw InvalidInput naming the first bad value: a frame time that does not fit the surface or the state, a
// state that is of another surface or holds values that no frame leaves.
void check_frame_time(const Surface& surface, const FrameTime& frame_time, const ReferenceState* state);
void check_reference(const Surface& surface, const ReferenceState& state);

// One frame, from `before` or from the canonical start when there is none: sections 4.1 and 4.2. pose: of
// this frame. changes: gets how every triangle changed since settings.window ago; undefined where there is no
// state. Checks nothing. The same input gives the same bits, whatever the numbering of vertices. Cost: about
// 0.3 ms for 1,000 triangles.
ReferenceState adapt(const Surface& surface, const ReferenceModel& model, const ReferenceSettings& settings,
                     const FrameTime& frame_time, const FlatPose& pose, const ReferenceState* before,
                     std::vector<Stretch>& changes);

// The same for a system that needs no more: welded positions of this frame, and a state that counts as none
// when it is empty. Throws InvalidInput as the public functions do.
ReferenceState adapt(const Surface& surface, const ReferenceModel& model, const ReferenceSettings& settings,
                     const FrameTime& frame_time, std::span<const Vec3> welded, const ReferenceState& before);

// Labels of a whole clip in one cut (section 4.1.2), frames x triangles; for bakes. raw: without the cut.
// positions: frames x vertices as the artist has them, object space. Throws InvalidInput when they are not
// finite or do not match, or times do not ascend. Cost: about 1 ms and half a megabyte (250 in all, then in
// pieces: cut_clip) per frame and 1,000 triangles.
Labels label_clip(const Surface& surface, const ReferenceModel& model, const ReferenceSettings& settings,
                  std::span<const double> times, std::span<const Vec3> positions, bool raw = false);

// ---- steps of adapt(), for tests
std::vector<Stretch> recent_changes(const ReferenceModel& model, const ReferenceSettings& settings,
                                    double time, const FlatPose& pose, const ReferenceState* state);
std::vector<FlatTriangle> update_reference(const ReferenceModel& model, const ReferenceSettings& settings,
                                           const FlatPose& pose, const Labels& labels, double seconds,
                                           const ReferenceState* state);

// A share per 1/30 s as a share of `seconds`, so that any frame rate gives the same in the same time.
float fraction_in(float share_per_thirtieth, double seconds);

// What an exponential filter of this time constant takes over in `seconds`.
float fraction_of(double seconds, double time);

}  // namespace rumple
