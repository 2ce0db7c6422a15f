// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Meshes: M. Mueller and N. Chentanez, SCA 2010. A fine mesh is attached to a coarse animated mesh,
// and relaxed by a static position-based solver. Equation numbers are the paper's. docs/wrinkle_mesh.md lists
// our differences.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "surface/contact/collider.h"
#include "surface/output/attachments.h"
#include "surface/output/shown_mesh.h"
#include "surface/strain/adaptive_reference.h"
#include "surface/strain/deformation.h"
#include "surface/strain/guided_strain.h"

namespace rumple::wrinkle_mesh {

enum class Collision { kNone, kPlane, kNeighbourhood };
enum class OffsetSpace { kTriangle, kWorld };

// The user's settings for every solve. Lengths are relative to the fine mesh.
struct Settings {
    float radius = 1.0f;      // r: attachment radius, in mean lengths of the rest edges around a vertex, >= 0
    float prestretch = 1.0f;  // rest length / measured length, > 0
    float bending = 0.7f;     // k_bending, 0..1
    Collision collision = Collision::kPlane;
    float inside = 0.4f;          // depth of the collision plane below the surface, in radii, 0..1
    float stretch_relief = 0.3f;  // share of the base's excess length that is accepted, 0..1
    // Compression of the base that bears no folds, share of the length, 0..1
    float buckling_threshold = 0.0f;
    float compression_limit = 1.3f;  // rest length at most this times the base's length, >= 1
    int hem_rings = 3;               // rings over which r fades to 0 at open borders; 0: no fade
    int iterations = 10;             // from a given state, >= 0
    int start_iterations = 20;       // from the canonical start, >= 0
    float damping = 0.3f;            // share of the former offset that is kept, 0..1
    OffsetSpace offset_space = OffsetSpace::kTriangle;
    // Share of the distance to the attachment by which every pass pulls a vertex back, along the surface and
    // off it, 0..1. Without it cloth drifts within its radius, so folds in a frame depend on the frames
    // before. (Not in the paper.)
    float tangential_pull = 0.0f;
    float normal_pull = 0.0f;
    // Only layers use these, up to `slide` (layers.h). (Not in the paper.)
    float slack = 1.0f;  // length / rest length at which the base pulls the cloth taut, > 0
    // Range of length / rest length below `slack` over which s goes from slack to prestretch, >= 0; 0:
    // nowhere taut
    float taut_range = 0.0f;
    Vec3 hang{0.0f};  // object space, length 0..1: direction of its own weight, which pulls the cloth taut
    // Object units, >= 0: no folds along lines that bend on less; 0: along any line
    float bend_radius = 0.0f;
    // Share of compression_limit - 1 where cloth touches what is worn under it, 0..1
    float contact_gather = 1.0f;
    float apart = 0.0f;      // largest movement towards its own cloth / distance to it
    float slide = 0.0f;      // largest movement along the surface / height of its triangles
    float nudge = 0.02f;     // size of the random push on unbuckled vertices, in fine edges, >= 0
    std::uint32_t seed = 0;  // of this push
    int threads = 0;         // 0: chosen by size; does not change the result
    // The unwrinkled shape: the rest pose, or reference triangles that adapt (Source::adaptive).
    ReferenceSettings rest{.reference = Reference::kStaticRest};
};

// Throws InvalidInput with the name of the first setting out of its range, the range and the value. solve()
// calls it.
void check(const Settings& settings);

// Painted factors per solved vertex, each 0..1, and directions. Empty factors mean 1 everywhere.
struct Paint {
    std::vector<float> radius;      // r x value
    std::vector<float> prestretch;  // 1 + (s - 1) x value
    std::vector<float> bending;     // k x value
    std::vector<float> inside;      // inside x value
    std::vector<float> worn;        // 0: hangs free, so that its extra width does not count; 1: it counts
    // Directions for folds along lines of the base; none: no directions. Layers use the guide of the first
    // one.
    std::shared_ptr<const GuideLines> guide{};
};

// Distance constraints between pairs of solved vertices, in the order of the sweeps. The groups are: pairs
// within a block of rows, pairs between this block and the next, and so on. Within a group, pairs are sorted
// by colour. Two pairs of one colour share no vertex.
struct Pairs {
    std::vector<Index> a;
    std::vector<Index> b;
    std::vector<Index> row_a, row_b;  // Model::row_of of both
    std::vector<float> rest;          // measured at rest, before s, object units
    std::vector<Index> run_start;     // runs + 1: a run is the pairs of one colour in one group
    std::vector<Index> group_start;   // groups + 1, into runs. Group 2 k: within block k; 2 k + 1: to k + 1

    size_t size() const { return a.size(); }
};

// The data for an adaptive rest shape: the base's triangles, and the places of all pairs in them.
struct Adaptive {
    struct Place {
        std::array<Index, 2> triangle;  // of the base: the one that contains it, or the two around it
        std::array<Vec2, 2> along;      // the pair at rest in the planes of both, object units
    };
    ReferenceModel triangles;
    std::vector<Place> pairs;  // distance, then bending
};

// Built once at rest, then immutable; may be shared between objects.
struct Model {
    Surface base;
    PolygonMesh solved;                  // the fine mesh that is solved
    Attachments attachments;             // per solved vertex
    SparseRows vertex_limit;             // kLimit: limit positions of the base's welded vertices; else empty
    std::vector<std::uint8_t> attached;  // 0: neither attachment nor collision constraint
    std::vector<Vec3> positions_rest;    // per solved vertex, object space
    // Own mesh: from surface to rest position, in the smooth frame; else empty
    std::vector<Vec3> rest_offset;
    Pairs distance;
    Pairs bending;
    // Sweeps keep the vertices in rows along the longest axis of the mesh. Each thread works on blocks of
    // rows. Pairs within a block share no vertex with pairs within another block. Pairs between two blocks
    // share none with pairs between two others.
    std::vector<Index> vertex_of_row, row_of;
    std::vector<Index> block_row;    // blocks + 1: the first row of every block, a multiple of kLanes
    std::vector<float> local_edge;   // per solved vertex: mean rest length of its edges
    std::vector<Index> border_ring;  // per solved vertex: edges to the nearest open border; -1: none
    std::vector<std::array<Index, 3>> triangles;  // of the solved mesh, for areas
    StretchModel stretch;
    NearTriangles near;
    std::optional<Adaptive> adaptive;  // if Source::adaptive is set
    ShownMesh shown;
    std::optional<ShownMesh> shown_in_viewport;  // if viewports use fewer subdivisions
    std::vector<float> unattached_distance;  // own mesh: distance to the base at rest, per vertex; else empty
};

struct Source : FineSource {
    const Surface* own = nullptr;  // the artist's mesh, at rest, in the base's object space; or none
    std::span<const std::uint8_t> attached;  // per display vertex of own; empty: all attached
    bool adaptive = false;                   // for Settings::rest other than kStaticRest
    float farthest = 0.0f;                   // an own mesh farther from the base is refused; 0: no limit
};

// Section 3. Throws InvalidInput (a fine mesh with more than most_vertices, or an own mesh too far away).
// display_steps: unsolved subdivisions of the shown mesh. viewport_steps: the same for viewports, at most as
// many. Cost: seconds for a million fine vertices.
std::shared_ptr<const Model> build(Surface base, const Source& source, AttachmentKind attachment,
                                   Index display_steps, Index viewport_steps = kMostLevels);

// The same for a layer of layers.h: without what only show() needs, and its rest shape does not adapt.
std::shared_ptr<const Model> build_unshown(Surface base, const Source& source, AttachmentKind attachment);

// Converts painted values of the base's vertices (as the artist has them) to solved vertices. No rounding
// takes a value out of the range of those around it: where everything is painted 1 it is 1.
std::vector<float> carry_paint(const Model& model, std::span<const float> base_values);

// The state from frame to frame (section 4: "we store o_i instead of p_i").
struct State {
    std::vector<Vec3> offset;          // o_i: in the frame of the base triangle, or in the world (kWorld)
    std::vector<float> solved_length;  // attachment length of every pair when it was last solved, over
                                       // that by which its rest length was scaled: distance, then bending
    ReferenceState reference{};        // of an adaptive rest shape; else empty
};

// The same offsets, but no vertex is held. Use it before a solve with other settings.
State activated(const State& state);

// One frame of the base. positions: of its vertices as the artist has them, deformed, object space.
// world_from_object is used only by OffsetSpace::kWorld, frame_time only by an adaptive rest shape.
// For Collision::kPlane:
//   gap: per vertex of the base, how far the cloth may move inwards before it meets what is worn under it,
//   object units; empty: no limit but Settings::inside. bodies, body_hint: if a vertex of the base has a
//   triangle of a body as its hint (else kNone), the body is searched for every solved vertex around it.
//   thickness: distance of the cloth from the body, object units. inner: how far an inner side extends below
//   the cloth. shown: no layer lies on this one, so the surface between its vertices is also kept off bodies.
//   looked_below: whether the layer below was put out of bodies.
struct Input {
    std::span<const Vec3> positions;
    glm::mat3 world_from_object{1.0f};
    FrameTime frame_time{};
    std::span<const float> gap{};
    const PosedCollider* bodies = nullptr;
    std::span<const Index> body_hint{};
    float thickness = 0.0f, inner = 0.0f;
    bool shown = false, looked_below = false;
    int threads = 0;  // for the searches of bodies and of the cloth itself; 0: chosen by size
};

struct Report {
    int iterations = 0;          // 0: the pose was held, and nothing was solved
    float error_before = 0.0f;   // RMS of relative length errors of distance constraints, at the attachments
    float error_after = 0.0f;    // ... of the solved mesh
    float largest_error = 0.0f;  // largest relative length error after
    float active = 0.0f;         // share of the vertices that were solved; the others were held
    Index collapsed_triangles = 0;  // base triangles without area in this pose
    Index kept_apart = 0;           // vertices that would have come too close to their own cloth or to a body
};

// Section 4.1. Solves one frame from `state` (the frame before), or from the canonical start if there is
// none, and returns the new state. Deterministic on any number of threads. A state of another model is
// ignored. A state without a reference starts a new one. Throws InvalidInput if positions, paint or reference
// do not match the model, if positions are not finite, if a setting is out of its range, or if the rest shape
// is to adapt and the model was not built for it. Cost: O(iterations x pairs).
State solve(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
            const State* state, Report& report);

// The same, with the sweeps in the order of the paper: one constraint after the other. For tests.
State solve_in_order(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
                     const State* state, Report& report);

// The shown mesh for a frame and its state. in_viewport: whether to show the mesh of viewports.
using Picture = ShownFrame;
// Throws InvalidInput if positions or state do not match the model.
void show(const Model& model, const Settings& settings, const Input& input, const State& state,
          Picture& picture, bool in_viewport = false);

// The quality of a frame, for reports and tests, not for playback.
struct Measures {
    float edge_error_before_rms = 0.0f;  // |length - s l0| / (s l0), fine mesh at its attachments
    float edge_error_before_max = 0.0f;
    float edge_error_after_rms = 0.0f;  // ... solved
    float edge_error_after_max = 0.0f;
    // Area / rest area where base triangles are below 0.9 of their rest area
    float compressed_area_before = 1.0f;
    float compressed_area_after = 1.0f;
    // Largest (|o| - r) / r over attached vertices with r > 0, not below 0
    float attachment_violation = 0.0f;
    float largest_offset = 0.0f;  // object units
    std::vector<Vec3> offsets;    // o_i, per solved vertex, in the triangle frame
};
Measures measure(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
                 const State& state);

}  // namespace rumple::wrinkle_mesh
