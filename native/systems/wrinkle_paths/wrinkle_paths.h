// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Paths: R. Gillette, Augmentation of Coarse Meshes with Wrinkles, UBC 2015 (with C. Peters). Folds
// traced over a coarse animated mesh across its compression, which live from frame to frame. No rest pose is
// needed. Chapter and equation numbers are the thesis's; docs/wrinkle_paths.md says where we leave it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "surface/output/attachments.h"
#include "surface/output/shown_mesh.h"
#include "surface/strain/adaptive_reference.h"
#include "surface/strain/bent_lines.h"
#include "surface/strain/deformation.h"
#include "surface/strain/guided_strain.h"
#include "systems/wrinkle_paths/profile.h"

namespace rumple::wrinkle_paths {

enum class Direction { kOutward, kInward, kBoth };

// What the user sets for every solve; what compression is measured against (chapter 4) first.
struct Settings : ReferenceSettings {
    float smoothing = 0.1f;   // of the triangles' shapes in time, seconds, >= 0; printed: 0
    float threshold = 1.25f;  // tau: folds start where lambda~_min is above it, > 1
    float reach = 0.25f;      // folds go on down to this share of tau's compression, 0..1; printed: 1
    float width = 0.02f;      // L_min: width of the tightest fold, object units, > 0
    float spacing = 1.12f;    // of seeds from folds, in widths, > 0
    float alignment = 0.4f;   // alpha of eq. 5.2: low keeps folds where they are, high turns them, >= 0
    float bend_radius =
        0.0f;           // object units, >= 0: no folds along lines that bend on less; 0: along any line
    int hem_rings = 2;  // rings over which compression and height fade towards open borders, >= 0
    float growth_limit = 0.15f;  // most change of a fold's length, share per 1/30 s, >= 0
    float fade = 0.15f;          // time in which a fold rises at birth and sinks at its end, seconds, >= 0
    bool persistent = true;      // false: every frame is traced anew (the thesis's figure 5.2, to compare)
    std::uint32_t seed = 0;      // of the places where folds may start
    Profile profile = Profile::kSpline;
    Direction direction = Direction::kOutward;
    float height = 1.0f;  // factor on the height that keeps the arc length, >= 0
    int threads = 0;      // of show(); 0: chosen by size; the result does not depend on it
};

// Throws InvalidInput naming the first setting out of its range, the range and the value. solve() calls it.
void check(const Settings& settings);

// The narrowest that folds are painted, in L_min.
inline constexpr float kLeastWidth = 0.1f;

// Painted factors per vertex of the base as the artist has it, 0..1. Empty means 1 everywhere.
struct Paint {
    std::vector<float> mask;     // on the compression above 1: where folds may start, and how long they get
    std::vector<float> width{};  // on L_min, kLeastWidth..1
    std::vector<Vec3>
        along{};  // where folds are to run, object space at rest, of length 0..1 (guided_strain.h)
};

// Built once at rest, then immutable; may be shared between objects.
struct Model : ReferenceModel {
    Surface base;
    std::vector<float> quality;        // per triangle at rest: 1 equilateral, 0 a sliver
    std::vector<Index> border_ring;    // per welded vertex: edges to the nearest open border, or kNone
    Attachments attachments;           // of the fine vertices
    SparseRows vertex_limit;           // kLimit: limit positions of the welded vertices; else empty
    std::vector<Vec3> positions_rest;  // of the fine vertices, object space
    std::vector<Index> fine_start;     // per triangle, into fine_vertex:
    std::vector<Index> fine_vertex;    //   the fine vertices that lie in it
    StretchModel stretch;
    BentLinesModel bent_lines;
    ShownMesh shown;
};

// Throws InvalidInput (a fine mesh of more than most_vertices). A target edge of 3/8 L_min (section 7.3)
// shows every fold. Cost: that of the fine mesh.
std::shared_ptr<const Model> build(Surface base, const FineSource& fine, AttachmentKind attachment);

// A point of a fold on the surface. Inside a path: on the edge that its segment leaves `triangle` by, `at.x`
// of the way along half-edge 3 triangle + edge. At an end: edge kNone, weights `at` of corners 1 and 2 of the
// triangle.
struct PathPoint {
    Index triangle = kNone;
    Index edge = kNone;  // 0..2
    Vec2 at{0.0f};
};

struct Path {
    Index id = 0;                   // in order of birth, never used twice
    float fade = 1.0f;              // 0 at birth, 1 at full height
    std::vector<PathPoint> points;  // >= 2; consecutive ones share a triangle
};

// What is kept from frame to frame. All plain values: a stored state continues as the one that was stored.
struct State : ReferenceState {
    std::vector<FlatTriangle> shapes;  // per triangle, smoothed in time
    std::vector<float> compression;    // per triangle, as the paths see it: of `shapes`, masked
    std::vector<float> width;          // per triangle: painted factor on L_min; empty: 1 everywhere
    std::vector<Path> paths;           // by id
    Index next_id = 0;
};

// One frame of the base. positions: of its vertices as the artist has them, deformed, object space.
struct Input : FrameTime {
    std::span<const Vec3> positions;
};

struct Report {
    Index paths = 0;
    Index born = 0;
    Index died = 0;
    Index merging = 0;     // paths that are being cut back to where they cross an older one
    Index compressed = 0;  // triangles by label
    Index stretched = 0;
    Index collapsed_triangles = 0;  // without area in this pose
    float moved_mean = 0.0f;        // of path points along the surface since the frame before, in L_min
    float moved_most = 0.0f;        // ... of the 99th percentile
};

// What the positions of one frame make of the base. Made once a frame, for all that is asked of the frame.
struct Pose : FlatPose {                // u1 of a shape lies along its frame's tangent
    std::vector<TriangleFrame> frames;  // per triangle
    Index collapsed = 0;
};
// Throws InvalidInput when positions do not match the model or are not finite.
Pose make_pose(const Model& model, std::span<const Vec3> positions);

// Chapters 4 and 5: one frame, from `state` (of the frame before), or from the canonical start when there is
// none. The same input gives the same bits, whatever the numbering of vertices. Throws InvalidInput when
// positions, labels, paint or state do not match the model, are not finite, or the state is of a later time.
// pose: make_pose() of the input's positions; so in all that follows.
State solve(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
            const Pose& pose, const State* state, Report& report);
State solve(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
            const State* state, Report& report);

// A path is numbered below this; when the numbers have run out, no path is born any more.
inline constexpr Index kMostPathIds = 1 << 30;

// Throws InvalidInput where a state is not of the model, or holds what no solve leaves. solve() checks it,
// too.
void check(const Model& model, const State& state);

// Empty when every path lies on the surface: each point on an edge or in a triangle, consecutive ones in one
// triangle. Else what is wrong with the first that does not. For tests and for stored states.
std::string validate(const Model& model, const std::vector<Path>& paths);

// The stretch of every triangle from its reference: what seeds and paths see.
std::vector<Stretch> stretches(const Model& model, const State& state,
                               std::span<const Vec3> welded_positions);

// Chapters 6 to 8: the shown mesh of a frame and its state.
struct Picture : ShownFrame {
    std::vector<float> height;  // per shown vertex, along the smooth normal, object units
};
// Throws InvalidInput when positions or state do not match the model.
void show(const Model& model, const Settings& settings, const Pose& pose, const State& state,
          Picture& picture);
void show(const Model& model, const Settings& settings, const Input& input, const State& state,
          Picture& picture);

// Whom the folds reach, as the preview uploads it: the three buffers of section 7.2.
struct TriangleLists {
    std::vector<Index> triangle_start{0};      // triangles + 1, into ranges
    std::vector<std::array<Index, 2>> ranges;  // pieces [first, end) that reach the triangle
    std::vector<formulas::FoldEnd> ends;  // piece i runs from ends[i] to ends[i + 1]; two RGBA texels each
};
// Chapter 8: walks outwards from each segment. Throws as show() does. Cost: that of the triangles reached.
TriangleLists build_triangle_lists(const Model& model, const Settings& settings, const Pose& pose,
                                   const State& state);
TriangleLists build_triangle_lists(const Model& model, const Settings& settings, const Input& input,
                                   const State& state);

// The paths as lines in space, smoothed as they are shown (section 6.2).
struct Curves {
    std::vector<Index> start{0};  // curves + 1, into positions
    std::vector<Index> id;        // per curve
    std::vector<Index> triangle;  // per point: of its segment
    std::vector<Vec3> positions;  // on the triangles of the deformed base but for the smoothing, object space
    std::vector<float> width;     // L there, object units
    std::vector<float> height;    // signed
};
Curves curves(const Model& model, const Settings& settings, const Pose& pose, const State& state);
Curves curves(const Model& model, const Settings& settings, const Input& input, const State& state);

}  // namespace rumple::wrinkle_paths
