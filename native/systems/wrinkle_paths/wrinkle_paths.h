// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Paths: R. Gillette, Augmentation of Coarse Meshes with Wrinkles, UBC 2015 (with C. Peters). Folds
// are traced over a coarse animated mesh, across its compression, and persist from frame to frame. No rest
// pose is needed. Chapter and equation numbers are the thesis's. docs/wrinkle_paths.md lists the differences
// from it.
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

// The user's settings for every solve.
struct Settings {
    ReferenceSettings rest;   // the shape that compression is measured against (chapter 4)
    float smoothing = 0.1f;   // temporal smoothing of the triangles' shapes, seconds, >= 0; thesis: 0
    float threshold = 1.25f;  // tau: folds start where lambda~_min is above it, > 1
    float reach = 0.25f;      // folds continue down to this share of tau's compression, 0..1; thesis: 1
    float width = 0.02f;      // L_min: width of the tightest fold, object units, > 0
    float spacing = 1.12f;    // distance of seeds from folds / width, > 0
    float alignment = 0.4f;   // alpha of eq. 5.2: low: folds stay in place, high: folds turn, >= 0
    // Object units, >= 0: no folds along lines that bend on less; 0: along any line
    float bend_radius = 0.0f;
    int hem_rings = 2;           // rings over which compression and height fade towards open borders, >= 0
    float growth_limit = 0.15f;  // largest change of a fold's length, share per 1/30 s, >= 0
    float fade = 0.15f;          // time in which a fold appears or disappears, seconds, >= 0
    bool persistent = true;      // false: every frame is traced independently (as the thesis's figure 5.2)
    std::uint32_t seed = 0;      // seed of the places where folds may start
    Profile profile = Profile::kSpline;
    Direction direction = Direction::kOutward;
    float height = 1.0f;  // factor on the height that preserves the arc length, >= 0
    int threads = 0;      // of show(); 0: chosen by size; the result does not depend on it
};

// Throws InvalidInput naming the first setting out of its range, the range and the value. solve() calls it.
void check(const Settings& settings);

// The least painted factor on L_min.
inline constexpr float kLeastWidth = 0.1f;

// Painted factors per display vertex of the base, 0..1. Empty means 1 everywhere.
struct Paint {
    std::vector<float> mask;  // factor on (compression - 1): where folds may start, and how long they become
    std::vector<float> width{};  // factor on L_min, kLeastWidth..1
    std::vector<Vec3> along{};   // direction of folds, object space at rest, length 0..1 (guided_strain.h)
};

// Built once at rest, then immutable; may be shared between objects.
struct Model {
    Surface base;
    ReferenceModel triangles;
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

// Throws InvalidInput (a fine mesh with more than most_vertices). Fine edges of 3/8 L_min (section 7.3) can
// show every fold. Cost: as the fine mesh.
std::shared_ptr<const Model> build(Surface base, const FineSource& fine, AttachmentKind attachment);

// A point of a fold on the surface. An inner point of a path is on the edge where its segment leaves
// `triangle`, `at.x` of the way along half-edge 3 triangle + edge. An end point has edge kNone, and `at` has
// the weights of corners 1 and 2 of the triangle.
struct PathPoint {
    Index triangle = kNone;
    Index edge = kNone;  // 0..2
    Vec2 at{0.0f};
};

struct Path {
    Index id = 0;                   // in order of creation, never reused
    float fade = 1.0f;              // 0 when created, 1 at full height
    std::vector<PathPoint> points;  // >= 2; consecutive ones share a triangle
};

// The state that is kept from frame to frame. These values are complete: a stored state continues like the
// original.
struct State {
    ReferenceState reference;
    std::vector<FlatTriangle> shapes;  // per triangle, smoothed in time
    std::vector<float> compression;    // per triangle, as the paths use it: of `shapes`, masked
    std::vector<float> width;          // per triangle: painted factor on L_min; empty: 1 everywhere
    std::vector<Path> paths;           // by id
    Index next_id = 0;
};

// One frame of the base. positions: of the display vertices, deformed, object space.
struct Input {
    FrameTime frame_time;
    std::span<const Vec3> positions;
};

struct Report {
    Index paths = 0;
    Index born = 0;
    Index died = 0;
    Index merging = 0;     // paths that are being shortened to where they cross an older one
    Index compressed = 0;  // triangles with this label
    Index stretched = 0;
    Index collapsed_triangles = 0;  // triangles without area in this pose
    float moved_mean = 0.0f;        // mean movement of path points along the surface in this frame / L_min
    float moved_most = 0.0f;        // ... and its 99th percentile
};

// The pose of the base in one frame. Make it once per frame, for all functions of this frame.
struct Pose {
    FlatPose base;                     // u1 of a shape lies along its frame's tangent
    std::vector<SurfaceFrame> frames;  // per triangle
    Index collapsed = 0;
};
// Throws InvalidInput if positions do not match the model or are not finite.
Pose make_pose(const Model& model, std::span<const Vec3> positions);

// Solves one frame (chapters 4 and 5) from `state`, that of the frame before, or from the canonical start if
// there is none. The same input gives the same bits, also if the vertices are numbered differently. Throws
// InvalidInput if positions, labels, paint or state do not match the model or are not finite, or if the state
// is of a later time. pose, here and below: make_pose() of the input's positions.
State solve(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
            const Pose& pose, const State* state, Report& report);

// Upper limit of the numbers of paths. When all numbers are used, no new path is created.
inline constexpr Index kMostPathIds = 1 << 30;

// Throws InvalidInput if a state does not fit the model, or has values that no solve produces. solve() calls
// it too.
void check(const Model& model, const State& state);

// Checks that every path lies on the surface: each point on an edge or in a triangle, consecutive ones in the
// same triangle. Returns an empty text, or what is wrong with the first bad path. For tests and for stored
// states.
std::string validate(const Model& model, const std::vector<Path>& paths);

// The stretch of every triangle relative to its reference triangle, as seeds and paths use it.
std::vector<Stretch> stretches(const Model& model, const State& state,
                               std::span<const Vec3> welded_positions);

// Chapters 6 to 8: the shown mesh of a frame and its state.
struct Picture : ShownFrame {
    std::vector<float> height;  // per shown vertex, along the smooth normal, object units
};
// Throws InvalidInput if the state does not match the model.
void show(const Model& model, const Settings& settings, const Pose& pose, const State& state,
          Picture& picture);

// For every triangle the folds that reach it, in the layout that the preview uploads: the three buffers of
// section 7.2.
struct TriangleLists {
    std::vector<Index> triangle_start{0};      // triangles + 1, into ranges
    std::vector<std::array<Index, 2>> ranges;  // pieces [first, end) that reach the triangle
    std::vector<formulas::FoldEnd> ends;       // piece i is from ends[i] to ends[i + 1]; two RGBA texels each
};
// Chapter 8: walks outwards from each segment. Throws like show(). Cost: O(triangles reached).
TriangleLists build_triangle_lists(const Model& model, const Settings& settings, const Pose& pose,
                                   const State& state);

// The paths as curves in space, smoothed as in the shown mesh (section 6.2).
struct Curves {
    std::vector<Index> start{0};  // curves + 1, into positions
    std::vector<Index> id;        // per curve
    std::vector<Index> triangle;  // per point: of its segment
    std::vector<Vec3> positions;  // on the deformed base, but smoothed; object space
    std::vector<float> width;     // width L, object units
    std::vector<float> height;    // signed
};
Curves curves(const Model& model, const Settings& settings, const Pose& pose, const State& state);

}  // namespace rumple::wrinkle_paths
