// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Field: J. Loviscach, Wrinkling Coarse Meshes on the GPU, Eurographics 2006. Every vertex of the
// coarse mesh has a plane wave. Its height and direction follow from the deformation, its phase from a
// relaxation. Equation numbers are the paper's. docs/wrinkle_field.md lists the differences from it. The
// formulas are in shaders/shared/wrinkle_field.glsl.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/formulas.h"
#include "base/lane_formulas.h"
#include "surface/mesh/topology.h"
#include "surface/output/attachments.h"
#include "surface/output/shown_mesh.h"
#include "surface/strain/adaptive_reference.h"
#include "surface/strain/bent_lines.h"
#include "surface/strain/deformation.h"
#include "surface/strain/guided_strain.h"

namespace rumple::wrinkle_field {

inline constexpr int kProfileIntervals = formulas::kProfileIntervals;

// Table of f and df/dphi (section 6.3) at phi = pi i / kProfileIntervals, i = 0 .. kProfileIntervals. Lookups
// make f even and 2 pi periodic, and interpolate linearly.
struct Profile {
    std::array<float, kProfileIntervals + 1> height;  // f, -1..1
    std::array<float, kProfileIntervals + 1> slope;   // df/dphi, for the half period 0..pi
};
Profile sine();
Profile accordion();      // straight flanks: the pleats of figure 5
Profile pencil_pleats();  // round crests, sharp valleys
// A drawn half wave from crest (first value) to valley (last), kProfileIntervals + 1 values in -1..1. Throws
// InvalidInput naming the first value outside of this range.
Profile drawn(std::span<const float> height);

// The length of a wave s f(x) / the length of its base, for slopes s: the mean of sqrt(1 + (s df/dphi)^2)
// over a period. It is 1 for s = 0. For the sine it is 2/pi sqrt(1 + s^2) E(s^2 / (1 + s^2)), a complete
// elliptic integral.
double length_ratio(const Profile& profile, double s);
// The inverse: the s at which the wave is `ratio` times as long as its base. It is 0 for a ratio of at most
// 1, and infinite for a flat profile. Cost: about 1 us.
double steepness(const Profile& profile, double ratio);

struct Settings {
    float wavelength = 0.05f;         // W in rest space, object units, > 0
    float strength = 1.0f;            // factor on the amplitude of equation (2), >= 0
    float buckling_threshold = 0.0f;  // compression that causes no waves, share of the length, 0..0.99
    bool keep_length = true;    // kGeometry: limit waves to the cloth's length at rest; see keep_length()
    float rate = 0.5f;          // epsilon / (2 pi^2) of equation (6), 0..1; stable below 1
    int rounds = 4;             // rounds of relaxation from a given state, >= 0
    int start_rounds = 200;     // from the canonical start, >= 0
    float irregularity = 0.0f;  // 0..1; 0: regular, like cloth, 1: like skin; random changes of k and W
    std::uint32_t seed = 0;     // seed of the first phases and of the irregularity
    bool aligned_start = true;  // align() the random first phases; false: random, as in the paper
    int threads = 0;            // 0: chosen by size; the result does not depend on it
    // Object units, >= 0: lines that bend with a smaller radius get no waves; 0: all may
    float bend_radius = 0.0f;
    bool dissolve = true;  // reduce waves that do not match their neighbours; see dissolve()
    // The shape that compression is measured against: the rest pose, or reference triangles that adapt.
    ReferenceSettings rest{.reference = Reference::kStaticRest};
};

// Throws InvalidInput naming the first setting out of its range, the range and the value. solve() calls it.
void check(const Settings& settings);

// Painted factors on W are between these limits, those on the amplitude between 0 and kMostPainted.
inline constexpr float kLeastPaintedWavelength = 1e-3f, kMostPainted = 1e3f;

// Painted values per display vertex of the base. Empty: nothing painted.
struct Paint {
    std::vector<float> mask;         // factor on the amplitude
    std::vector<float> wavelength;   // factor on W
    std::vector<Vec3> rest_wrinkle;  // p of section 7: along the compression, rest space, shorter than 1
    // Direction of the waves' crests, object space at rest, length 0..1 (guided_strain.h)
    std::vector<Vec3> along{};
};

// Waves only in the shading of the base's triangles, or as geometry of a fine mesh.
enum class Output { kShading, kGeometry };

// The neighbours of vertices 4 f to 4 f + 3, which are computed at a time: a column has the first neighbour
// of each of the four, the next column the second one, and so on.
struct NeighbourColumns {
    std::vector<Index> start{0};      // per four vertices: their first column
    std::vector<LaneIndices> vertex;  // any vertex where the neighbour is missing ...
    std::vector<Vec2Lanes> gradient;  // Model::Neighbour::gradient; ... and zero
    std::vector<Lanes> count;         // per four vertices: their numbers of neighbours
    std::vector<LaneMask> has_frame;  // per four vertices: whether they have a rest frame
};

// Built once at rest, then immutable; may be shared between objects.
struct Model {
    struct Neighbour {
        Index vertex;
        Vec2 gradient;  // regression_gradient() of the rest neighbourhood, in the vertex's rest frame
    };
    Surface base;
    Output output = Output::kShading;
    bool true_lengths = true;
    std::vector<Index> neighbour_start;  // per welded vertex, into neighbours
    // Along edges of triangles, ascending; the first one defines the frame
    std::vector<Neighbour> neighbours;
    NeighbourColumns columns;        // the same neighbours
    std::vector<Vec3> tangent_rest;  // per welded vertex: t and b of its rest frame; zero without a normal
    std::vector<Vec3> bitangent_rest;
    std::vector<std::uint32_t> identity;  // hash of its rest position: the seed of its first phase
    std::vector<Vec2> uv;                 // for each corner of every triangle in order; empty: none
    std::vector<Index> uv_fan;            // ... and the fan of corners with the same gradient of uv
    Attachments attachments;              // of the displaced vertices (kGeometry)
    StretchModel stretch;
    BentLinesModel bent_lines;
    ReferenceModel triangles;
    std::vector<Vec2> vertex_turn;  // per welded vertex: rotation from its `stretch` frame to its rest frame
    ShownMesh shown;
};

struct Plan {
    Output output = Output::kShading;
    FineSource fine;                                     // kGeometry
    AttachmentKind attachment = AttachmentKind::kLimit;  // kGeometry
    std::span<const Vec2> uv;  // per corner of the base, for parallax (kShading); or none
    // Equation (1) uses lengths of edges; false: of their projections, as in the paper
    bool true_lengths = true;
};

// Section 3. Throws InvalidInput (too many fine vertices, a uv that is not finite or not one per corner).
// Cost: O(edges); for kGeometry also the cost of the fine mesh.
std::shared_ptr<const Model> build(Surface base, const Plan& plan);

// The state that is kept from frame to frame, per welded vertex.
struct State {
    std::vector<float> phase;          // phi, radians, -pi..pi
    std::vector<Vec2> direction;       // k in the rest frame, with the sign that phi belongs to
    std::vector<float> solved_offset;  // radians, per neighbour: Link::offset in its last relaxation
    ReferenceState reference{};        // of an adaptive rest shape; otherwise empty
};

// The same phases, but no vertex is asleep. Use it before a solve with other settings.
State activated(const State& state);

// The field of one frame, per welded vertex: equations (1) to (4).
struct Waves {
    std::vector<Vec3> positions;     // deformed, object space
    std::vector<Vec3> normals;       // unit, or zero
    std::vector<Vec3> wave_vector;   // 2 pi / W k', radians per object unit, deformed space
    std::vector<float> height;       // h of equation (2) times strength and mask, object units
    std::vector<float> fullness;     // h / (W / 4), before strength: the weight of a neighbour depends on it
    std::vector<float> compression;  // r
    std::vector<float> gather;       // |k'|: rest length / length along the wave; 1 without a wave
    std::vector<Vec2> direction;     // k, rest frame
};

struct Report {
    int rounds = 0;              // rounds of relaxation
    float misfit_before = 0.0f;  // see misfit()
    float misfit_after = 0.0f;
    float largest_change = 0.0f;  // largest phase change of a wrinkled vertex since the given state, radians
    Index wrinkled = 0;           // vertices with a wave
    Index collapsed = 0;          // vertices without a wave because their neighbourhood collapsed
};

// Throws InvalidInput naming the first bad vertex if rest_wrinkle does not have one value per vertex of the
// base, is not finite or not shorter than 1. estimate_waves() calls it.
void check_rest_wrinkle(const Model& model, std::span<const Vec3> painted);

// The parameters of the waves that settings and paint give every welded vertex. They do not depend on the
// pose. estimate_waves() and the GPU read them.
struct WaveParameters {
    std::vector<float> wavelength;   // W, object units
    std::vector<float> mask;         // factor on the amplitude
    std::vector<Vec2> rest_wrinkle;  // q of section 7, rest frame
    std::vector<Vec2> turn;          // (cos, sin) of the random rotation of the wave away from k
};
// Throws InvalidInput like check(), and if paint does not match the model. Cost: O(vertices).
WaveParameters wave_parameters(const Model& model, const Settings& settings, const Paint& paint);

// k at the start of a clip, per welded vertex, rest frame. It determines the first sign of k, and is used
// where the compression has no direction.
std::vector<Vec2> first_directions(const Model& model);

// M from the rest frames of four vertices to their deformed frames (t', b').
struct Neighbourhoods {
    LaneMask exist{};  // false without a normal, in this pose or at rest
    Vec3Lanes tangent;
    Vec3Lanes bitangent;
    lane_formulas::mat2 m;
};

// Deformed positions and unit normals (or zero) of the welded vertices. positions: as for estimate_waves().
struct Pose {
    std::vector<Vec3> positions;
    std::vector<Vec3> normals;
    std::vector<Neighbourhoods> around;  // per four vertices; empty after weld_pose()
};
Pose weld_pose(const Model& model, std::span<const Vec3> positions);
// Also has M around every vertex, equation (1). Make it once per frame, for all functions of this frame.
// Throws InvalidInput if positions do not match the model or are not finite. Cost: O(edges).
Pose make_pose(const Model& model, std::span<const Vec3> positions);

// For an adaptive rest shape: the stretch of every welded vertex relative to the reference triangles around
// it, (xx, xy, yy) of the symmetric U in its rest frame. estimate_waves() measures compression with it. Empty
// for an empty reference. Throws InvalidInput if reference or positions do not match the model. Cost:
// O(triangles).
std::vector<Vec3> reference_stretches(const Model& model, const ReferenceState& reference, const Pose& pose);
std::vector<Vec3> reference_stretches(const Model& model, const ReferenceState& reference,
                                      std::span<const Vec3> positions);

// Section 4.2 ("Crush"). positions: of the display vertices, deformed, object space. before: directions of
// the frame before, or empty. stretches: from reference_stretches(); empty: relative to the rest pose. Throws
// InvalidInput if positions, paint, directions or stretches do not match the model or are not finite, or if a
// painted vector is not shorter than 1. Cost: O(edges).
Waves estimate_waves(const Model& model, const Settings& settings, const Paint& paint, const Pose& pose,
                     std::span<const Vec2> before, std::span<const Vec3> stretches = {});
Waves estimate_waves(const Model& model, const Settings& settings, const Paint& paint,
                     std::span<const Vec3> positions, std::span<const Vec2> before,
                     std::span<const Vec3> stretches = {});

// Reduces heights so that no wave over the compressed surface is longer than the cloth at rest. It is exactly
// as long if h |2 pi / W k'| = steepness(|k'|). (Not in the paper: its triangle of W/4, h and r W/4 preserves
// only the length of accordion pleats.) Cost: O(vertices).
void keep_length(const Profile& profile, Waves& waves);

// Reduces waves whose phases or directions do not match their neighbours (kept_at_fork()), to zero at a fork.
// Not in the paper. Its equation (5) is the real part of a complex amplitude interpolated over a triangle, so
// waves in opposite phase cancel. Here they cancel over the whole ring around a vertex. Cost: O(edges).
void dissolve(const Model& model, const Settings& settings, std::span<const float> phase, Waves& waves);

// The random phases at the start of a clip: a hash of the seed and of the vertex's rest position.
std::vector<float> random_phases(const Model& model, std::uint32_t seed);

// Aligns random phases: in each round every vertex takes the mean, as a complex number, of its own phase and
// of the phases that its neighbours predict. This is a power iteration for the mode of Knoeppel et al. 2015
// ("Stripe Patterns on Surfaces"). Gradient descent from there meets few bifurcations. Not in the paper.
void align(const Model& model, const Settings& settings, const Waves& waves, int rounds,
           std::vector<float>& phase);

// Section 5.2 ("Relax"): `rounds` rounds of equation (6), Jacobi, like the paper's two buffers. Deterministic
// on any number of threads. Cost: O(rounds x edges).
void relax(const Model& model, const Settings& settings, const Waves& waves, int rounds,
           std::vector<float>& phase);

// RMS of the phase error over the edges, in turns, 0..0.5, weighted by the attenuation of both ends.
float misfit(const Model& model, const Waves& waves, std::span<const float> phase);

// Crush and relax, from `state` (the frame before), or from the canonical start if there is none. A vertex is
// asleep if its links have not changed since its last relaxation, so rigid motion and an unchanged pose
// change no phase. A state of another model is ignored; a state without a reference starts one. frame_time:
// only used by an adaptive rest shape. Throws InvalidInput like estimate_waves() and check(), and if
// frame_time or reference do not match the model. Cost: O(rounds x edges). pose, here and below: from
// make_pose(). waves: receives the solved waves, for show().
State solve(const Model& model, const Settings& settings, const Paint& paint, const Pose& pose,
            const State* state, Report& report, const FrameTime& frame_time = {}, Waves* waves = nullptr);

// The waves that show() draws: estimate_waves(), dissolve() and, for geometry, keep_length(), according to
// the settings. Throws like estimate_waves(), and if the state does not match the model. estimated: the waves
// that solve() returned with `state`. They equal a new estimate from the directions of `state`, to the bit.
Waves shown_waves(const Model& model, const Settings& settings, const Profile& profile, Waves estimated,
                  const State& state);
Waves shown_waves(const Model& model, const Settings& settings, const Profile& profile, const Paint& paint,
                  const Pose& pose, const State& state);
Waves shown_waves(const Model& model, const Settings& settings, const Profile& profile, const Paint& paint,
                  std::span<const Vec3> positions, const State& state);

// The shown mesh of a frame, and the waves for shaders. Corner values are in the order of the triangles.
struct Picture : ShownFrame {
    std::vector<float> amplitude;  // h, object units, per shown vertex
    std::vector<Vec3> direction;   // k, unit, rest space
    std::vector<float> phase;      // phi, radians
    // kShading only: each corner of a triangle has values for the waves of all three corners. Interpolated
    // over the triangle they give equation (5).
    std::vector<Vec3> corner_phase;   // radians, without whole turns per triangle
    std::vector<Vec3> corner_weight;  // (h, 0, 0) at the first corner, (0, h, 0), (0, 0, h), object units
    std::array<std::vector<Vec3>, 3> corner_wave_vector;  // 2 pi / W k' of corners 0..2, same at each corner
    std::vector<Vec3> corner_u_gradient;  // du/dx' of equation (11), continuous over edges; empty without uv
    std::vector<Vec3> corner_v_gradient;
};
// waves: from shown_waves(). gap: per display vertex of the base, how far the waves of kGeometry may move
// inwards, object units; empty: as far as outwards. Throws InvalidInput if gap does not match the model.
// Cost: O(triangles + shown vertices).
Picture show(const Model& model, const Waves& waves, const Profile& profile, std::span<const Vec3> positions,
             const State& state, std::span<const float> gap = {});

// Equations (5) and (8) at places on the deformed base triangles. Used by tests and for geometry.
struct Height {
    float height;   // object units
    Vec3 gradient;  // object space, tangential
};
Height evaluate(const Model& model, const Waves& waves, const Profile& profile, std::span<const float> phase,
                const SurfacePoint& place);

}  // namespace rumple::wrinkle_field
