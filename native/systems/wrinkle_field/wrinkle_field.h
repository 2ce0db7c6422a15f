// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Field: J. Loviscach, Wrinkling Coarse Meshes on the GPU, Eurographics
// 2006. A plane wave at every vertex of the coarse mesh: how high and in which
// direction follows from the deformation, its phase from relaxation.
// Equation numbers are the paper's; docs/wrinkle_field.md says where we leave it.
// The formulas stand in shaders/shared/wrinkle_field.glsl.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/formulas.h"
#include "surface/mesh/topology.h"
#include "surface/output/attachments.h"
#include "surface/output/shown_mesh.h"
#include "surface/strain/adaptive_reference.h"
#include "surface/strain/bent_lines.h"
#include "surface/strain/deformation.h"
#include "surface/strain/guided_strain.h"

namespace rumple::wrinkle_field {

inline constexpr int kProfileIntervals = formulas::kProfileIntervals;

// Table of f and df/dphi (section 6.3) at phi = pi i / kProfileIntervals, i = 0 .. kProfileIntervals.
// Even and 2 pi periodic by the way it is read; linear between its entries.
struct Profile {
    std::array<float, kProfileIntervals + 1> height;  // f, -1..1
    std::array<float, kProfileIntervals + 1> slope;   // df/dphi, of the half period 0..pi
};
Profile sine();
Profile accordion();      // straight flanks: the pleats of figure 5
Profile pencil_pleats();  // round crests, sharp valleys
// A drawn half wave from crest (first value) to valley (last), kProfileIntervals + 1 values in -1..1. Throws
// InvalidInput naming the first value that is not.
Profile drawn(std::span<const float> height);

// The length of a wave s f(x) over that of its base, for slopes s: the mean of sqrt(1 + (s df/dphi)^2) over a
// period. 1 for s = 0; of the sine 2/pi sqrt(1 + s^2) E(s^2 / (1 + s^2)), a complete elliptic integral.
double length_ratio(const Profile& profile, double s);
// Its inverse: the s at which the wave is `ratio` times as long as its base; 0 for a ratio of at most 1,
// infinite for a flat profile. Cost: about 1 us.
double steepness(const Profile& profile, double ratio);

struct Settings {
    float wavelength = 0.05f;         // W in rest space, object units, > 0
    float strength = 1.0f;            // factor on the amplitude of equation (2), >= 0
    float buckling_threshold = 0.0f;  // share of its length that cloth may lose without waves, 0..0.99
    bool keep_length = true;          // kGeometry: waves no longer than the cloth at rest; see keep_length()
    float rate = 0.5f;                // epsilon / (2 pi^2) of equation (6), 0..1; stable below 1
    int rounds = 4;                   // of relaxation, from the frame before, >= 0
    int start_rounds = 200;           // from the canonical start, >= 0
    float irregularity = 0.0f;        // 0: tidy cloth, 1: skin: seeded turns of k and of W, 0..1
    std::uint32_t seed = 0;           // of the first phases and of the irregularity
    bool aligned_start = true;        // align() the random first phases; false: as printed
    int threads = 0;                  // 0: chosen by size; the result does not depend on it
    float bend_radius =
        0.0f;              // object units, >= 0: no waves along lines that bend on less; 0: along any line
    bool dissolve = true;  // waves that disagree with their neighbours are lower; see dissolve()
    // What compression is measured against: the rest pose, or reference triangles that adapt.
    ReferenceSettings rest{.reference = Reference::kStaticRest};
};

// Throws InvalidInput naming the first setting out of its range, the range and the value. solve() calls it.
void check(const Settings& settings);

// Painted factors reach from 0, or this, to that.
inline constexpr float kLeastPaintedWavelength = 1e-3f, kMostPainted = 1e3f;

// Painted values per vertex of the base as the artist has it. Empty: nothing painted.
struct Paint {
    std::vector<float> mask;         // factor on the amplitude
    std::vector<float> wavelength;   // factor on W
    std::vector<Vec3> rest_wrinkle;  // p of section 7: along the compression, rest space, shorter than 1
    std::vector<Vec3>
        along{};  // where waves are to run, object space at rest, of length 0..1 (guided_strain.h)
};

// The wrinkles in the shading of the base's own triangles, or in the shape of a fine mesh.
enum class Output { kShading, kGeometry };

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
    std::vector<Neighbour>
        neighbours;                  // over the edges of the triangles, ascending; the first builds the frame
    std::vector<Vec3> tangent_rest;  // per welded vertex: t and b of its rest frame; zero without a normal
    std::vector<Vec3> bitangent_rest;
    std::vector<std::uint32_t> identity;  // hash of its rest position: the seed of its first phase
    std::vector<Vec2> uv;                 // per corner of every triangle in turn; empty: none
    std::vector<Index> uv_fan;            // ... and the fan of corners that share its gradient of uv
    Attachments attachments;              // of the displaced vertices (kGeometry)
    StretchModel stretch;
    BentLinesModel bent_lines;
    ReferenceModel triangles;
    std::vector<Vec2> vertex_turn;  // per welded vertex: from its frame in `stretch` to its rest frame
    ShownMesh shown;
};

struct Plan {
    Output output = Output::kShading;
    FineSource fine;                                     // kGeometry
    AttachmentKind attachment = AttachmentKind::kLimit;  // kGeometry
    std::span<const Vec2> uv;  // per corner of the base, for parallax; or none (kShading)
    bool true_lengths =
        true;  // lengths of edges, not of their projections, in equation (1); false: as printed
};

// Section 3. Throws InvalidInput (too many fine vertices, a uv that is not finite or not one per corner).
// Cost: O(edges); for kGeometry that of the fine mesh.
std::shared_ptr<const Model> build(Surface base, const Plan& plan);

// What is kept from frame to frame, per welded vertex.
struct State {
    std::vector<float> phase;          // phi, radians, -pi..pi
    std::vector<Vec2> direction;       // k in the rest frame: the sign that phi belongs to
    std::vector<float> solved_offset;  // radians, per neighbour: Link::offset when it was last relaxed
    ReferenceState reference{};        // of an adaptive rest shape; else empty
};

// The same phases with no vertex held: for a solve with other settings than the state was solved with.
State activated(const State& state);

// The field of one frame, per welded vertex: equations (1) to (4).
struct Waves {
    std::vector<Vec3> positions;     // deformed, object space
    std::vector<Vec3> normals;       // unit, or zero
    std::vector<Vec3> wave_vector;   // 2 pi / W k', radians per object unit, deformed space
    std::vector<float> height;       // h of equation (2) times strength and mask, object units
    std::vector<float> fullness;     // h over W/4 before strength: what neighbours are weighed by
    std::vector<float> compression;  // r
    std::vector<float> gather;       // |k'|: rest length over length along the wave; 1 where there is none
    std::vector<Vec2> direction;     // k, rest frame
};

struct Report {
    int rounds = 0;              // of relaxation
    float misfit_before = 0.0f;  // see misfit()
    float misfit_after = 0.0f;
    float largest_change = 0.0f;  // of the phase of a wrinkled vertex since the state given, radians
    Index wrinkled = 0;           // vertices that wrinkle
    Index collapsed = 0;          // vertices without a wave because their neighbourhood collapsed
};

// Throws InvalidInput when rest_wrinkle is not one per vertex of the base, not finite or not shorter than 1,
// naming the first vertex. estimate_waves() calls it.
void check_rest_wrinkle(const Model& model, std::span<const Vec3> painted);

// What settings and paint ask of every welded vertex, whatever the pose: estimate_waves() reads it, and so
// does the GPU.
struct WaveParameters {
    std::vector<float> wavelength;   // W here, object units
    std::vector<float> mask;         // factor on the amplitude
    std::vector<Vec2> rest_wrinkle;  // q of section 7, rest frame
    std::vector<Vec2> turn;          // (cos, sin) by which irregularity turns the wave away from k
};
// Throws InvalidInput as check() does, and when paint does not match the model. Cost: O(vertices).
WaveParameters wave_parameters(const Model& model, const Settings& settings, const Paint& paint);

// k that a clip starts from, per welded vertex, rest frame: it gives k its first sign, and stands in where no
// direction is compressed more than another.
std::vector<Vec2> first_directions(const Model& model);

// M from the rest frame of a vertex to its deformed frame (t', b').
struct Neighbourhood {
    Vec3 tangent;
    Vec3 bitangent;
    glm::mat2 m;
};

// Deformed positions and unit normals (or zero) of the welded vertices. positions: as estimate_waves() takes
// them.
struct Pose {
    std::vector<Vec3> positions;
    std::vector<Vec3> normals;
    std::vector<std::optional<Neighbourhood>> around;  // none without a normal; empty: weld_pose() alone
};
Pose weld_pose(const Model& model, std::span<const Vec3> positions);
// With M around every vertex, equation (1). Made once a frame, for all that is asked of the frame. Throws
// InvalidInput when positions do not match the model or are not finite. Cost: O(edges).
Pose make_pose(const Model& model, std::span<const Vec3> positions);

// For an adaptive rest shape: the stretch of every welded vertex from the reference triangles around it, (xx,
// xy, yy) of the symmetric U in its rest frame; estimate_waves() measures compression by it. Empty for an
// empty reference. Throws InvalidInput when reference or positions do not match the model. Cost:
// O(triangles).
std::vector<Vec3> reference_stretches(const Model& model, const ReferenceState& reference, const Pose& pose);
std::vector<Vec3> reference_stretches(const Model& model, const ReferenceState& reference,
                                      std::span<const Vec3> positions);

// Section 4.2 ("Crush"). positions: of the base's vertices as the artist has them, deformed, object space.
// before: directions of the frame before, or empty. stretches: reference_stretches(), or empty: the rest pose
// counts. Throws InvalidInput when positions, paint, directions or stretches do not match the model, or are
// not finite, or a painted vector is not shorter than 1. Cost: O(edges).
Waves estimate_waves(const Model& model, const Settings& settings, const Paint& paint, const Pose& pose,
                     std::span<const Vec2> before, std::span<const Vec3> stretches = {});
Waves estimate_waves(const Model& model, const Settings& settings, const Paint& paint,
                     std::span<const Vec3> positions, std::span<const Vec2> before,
                     std::span<const Vec3> stretches = {});

// Lowers the heights at which a wave would be longer over the compressed surface than the cloth is at rest:
// with h |2 pi / W k'| = steepness(|k'|) it is as long. (Not in the paper: its triangle of W/4, h and r W/4
// keeps the length of accordion pleats only.) Cost: O(vertices).
void keep_length(const Profile& profile, Waves& waves);

// Lowers waves whose phases or directions disagree with those around them (kept_at_fork()), down to nothing
// at a fork. Not in the paper, whose equation (5) is the real part of a complex amplitude interpolated over a
// triangle, so that waves in opposite phase cancel: here they do so over the whole ring around a vertex.
// Cost: O(edges).
void dissolve(const Model& model, const Settings& settings, std::span<const float> phase, Waves& waves);

// The phases that a clip starts from: a hash of the seed and of the vertex's rest position.
std::vector<float> random_phases(const Model& model, std::uint32_t seed);

// The same made to agree: every vertex takes the mean, as a complex number, of what it and its neighbours ask
// for, so many rounds. Finds the mode that Knoeppel et al. 2015 ("Stripe Patterns on Surfaces") solve for, by
// power iteration; gradient descent from there meets few bifurcations. Not in the paper.
void align(const Model& model, const Settings& settings, const Waves& waves, int rounds,
           std::vector<float>& phase);

// Section 5.2 ("Relax"): so many rounds of equation (6), Jacobi, as the paper's two buffers. Deterministic on
// any number of threads. Cost: O(rounds x edges).
void relax(const Model& model, const Settings& settings, const Waves& waves, int rounds,
           std::vector<float>& phase);

// RMS of the phase error over the edges, in turns, 0..0.5, weighted by the attenuation of both ends.
float misfit(const Model& model, const Waves& waves, std::span<const float> phase);

// Crush and relax, from `state` (the frame before) or from the canonical start when there is none. A vertex
// whose links have not changed since it was last relaxed is held: rigid motion and a standing pose change no
// phase. A state of another model counts as none; one without a reference starts one. frame_time: read by an
// adaptive rest shape only. Throws InvalidInput as estimate_waves() and check() do, and when frame_time or
// reference do not match the model. Cost: O(rounds x edges).
// pose: of make_pose(); so in all that follows. waves: becomes the field that was solved, for show().
State solve(const Model& model, const Settings& settings, const Paint& paint, const Pose& pose,
            const State* state, Report& report, const FrameTime& frame_time = {}, Waves* waves = nullptr);
State solve(const Model& model, const Settings& settings, const Paint& paint, std::span<const Vec3> positions,
            const State* state, Report& report, const FrameTime& frame_time = {});

// The waves that show() draws: estimate_waves(), dissolve() and, as geometry, keep_length(), as far as
// settings ask for them. Throws as show() does. estimated: what solve() gave with `state`, the same to the
// bit: over the directions of a state its estimate finds these again.
Waves shown_waves(const Model& model, const Settings& settings, const Profile& profile, Waves estimated,
                  const State& state);
Waves shown_waves(const Model& model, const Settings& settings, const Profile& profile, const Paint& paint,
                  const Pose& pose, const State& state);
Waves shown_waves(const Model& model, const Settings& settings, const Profile& profile, const Paint& paint,
                  std::span<const Vec3> positions, const State& state);

// The shown mesh of a frame, and the waves for shaders. Values of corners: of every triangle in turn.
struct Picture : ShownFrame {
    std::vector<float> amplitude;  // h, object units, per shown vertex
    std::vector<Vec3> direction;   // k, unit, rest space
    std::vector<float> phase;      // phi, radians
    // kShading only: the waves of a triangle's three corners, as each corner sees them; interpolated over the
    // triangle they give equation (5).
    std::vector<Vec3> corner_phase;   // radians, less whole turns for each triangle
    std::vector<Vec3> corner_weight;  // (h, 0, 0) at the first corner, (0, h, 0), (0, 0, h), object units
    std::array<std::vector<Vec3>, 3> corner_wave_vector;  // 2 pi / W k' of the three, the same at each
    std::vector<Vec3> corner_u_gradient;  // du/dx' of equation (11), continuous over edges; empty without uv
    std::vector<Vec3> corner_v_gradient;
};
// gap: per vertex of the base as the artist has it, how far the waves of kGeometry may go inwards, object
// units; empty: as far as outwards. Throws InvalidInput when positions, paint, state or gap do not match the
// model. Cost: O(triangles + shown vertices).
Picture show(const Model& model, const Settings& settings, const Profile& profile, const Paint& paint,
             std::span<const Vec3> positions, const Pose& pose, const State& state,
             std::span<const float> gap = {});
Picture show(const Model& model, const Settings& settings, const Profile& profile, const Paint& paint,
             std::span<const Vec3> positions, const State& state, std::span<const float> gap = {});
// waves: of shown_waves().
Picture show(const Model& model, const Waves& waves, const Profile& profile, std::span<const Vec3> positions,
             const State& state, std::span<const float> gap = {});

// Equations (5) and (8) at places on the deformed base triangles: for tests and the geometry.
struct Height {
    float height;   // object units
    Vec3 gradient;  // object space, tangential
};
Height evaluate(const Model& model, const Waves& waves, const Profile& profile, std::span<const float> phase,
                const SurfacePoint& place);

}  // namespace rumple::wrinkle_field
