// SPDX-License-Identifier: GPL-3.0-or-later
// One frame of the base for the solver of the Wrinkle Mesh. Used by this system and by the handles of the
// library.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/solve_team.h"
#include "base/tolerances.h"
#include "surface/contact/self_distance.h"
#include "surface/strain/bent_lines.h"
#include "systems/wrinkle_mesh/wrinkle_mesh.h"

namespace rumple::wrinkle_mesh {

// The deformed base and the attachments in one frame.
struct Pose {
    std::vector<Vec3> base;  // welded vertices
    std::vector<Vec3> base_normals;
    std::vector<SurfaceFrame> frames;  // per base triangle
    std::vector<Vec3> attachment;      // a_i
    std::vector<Vec3> unwrinkled;      // attachments of layers without folds; empty: no layers
    std::vector<SpareCloth> spare;     // of the base, at the attachments; empty: folds along any line
    std::vector<float> to_spare;       // 0..1: usable share of the pre-stretch; empty: all of it
    std::vector<GuidedStrain> guided;  // of the base, at the attachments; empty: no painted directions
    std::vector<Vec3> normal;          // interpolated base normals at the attachments, unit or zero
    std::vector<Vec3> floor;           // unit: away from what is worn under each; empty: the normals
    std::vector<float> gap;            // how far each may move inwards, object units, >= 0; empty: no limit
    std::vector<Index> body;           // the triangle of a body near each, or kNone; empty: no bodies
    // The part of the cloth itself, or of a body in front, that faces each attachment; empty: no bound.
    std::vector<SelfContactSide> self_contact;
    std::vector<float> heights;  // PosedSelfContactMesh::heights() at the attachments; empty: no bound
    Index collapsed = 0;
};

// Converts values of the base's vertices (as the artist has them) to solved vertices.
template <typename Value>
std::vector<Value> carry(const Model& model, std::span<const Value> base_values) {
    std::vector<Value> out(model.attachments.places.size());
    for_each_index(out.size(), kLeastSteps, [&](size_t v) {
        const SurfacePoint& place = model.attachments.places[v];
        const Triangle& triangle = model.base.triangles[place.triangle];
        out[v] = place.interpolate(
            [&](int k) { return base_values[model.base.display.corner_vertex[triangle.corner[k]]]; });
    });
    return out;
}

// With fewer solved vertices a frame takes a millisecond or two on one thread.
constexpr size_t kVerticesForTeam = 3'000;

// The team for a frame of this model. threads: as in Settings and Input.
SolveTeam team_for(const Model& model, int threads);

// Throws InvalidInput if positions do not match the model or are not finite.
Pose make_pose(const Model& model, const Input& input);

// How far every vertex may move inwards. Attachments inside a body are first moved out of it.
void find_gaps(const Model& model, const Input& input, Pose& pose);

// Pose::to_spare at the base's vertices. If cloth lies on a known body, its width is the width of the body,
// and the extra width hangs where there is room. length: the shortest distance over which the share rises
// from 0 to 1, object units; 0: it may rise at once. Empty without bodies. Cost: O(edges), a few times.
std::vector<float> share_to_spare(const Surface& base, const Input& input, float length);

// The length for share_to_spare(): the more extra width the layers have, the longer. 0 without a bend_radius.
float length_to_spare(std::span<const Settings> layers);

// The pose of a single mesh with the painted directions; none without painted directions.
std::optional<Pose> guided_pose(const Model& model, const Paint& paint, const Pose& pose);

// Solves a frame with its pose, which make_pose() made from `input`.
State solve_pose(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
                 const Pose& pose, const State* state, Report& report);
void show_pose(const Model& model, const Settings& settings, const Input& input, const Pose& pose,
               const State& state, Picture& picture, bool in_viewport = false);
Measures measure_pose(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
                      const Pose& pose, const State& state);

// p_i = a_i + o_i (2). offset: o_i, object space.
std::vector<Vec3> solved_positions(const Pose& pose, std::span<const Vec3> offset);

// Throws InvalidInput if the argument belongs to another model.
void check(const Model& model, const Paint& paint);
void check(const Model& model, const State& state);

// A triangle's frame tilted to the interpolated normal, so that vectors in it do not jump from triangle to
// triangle. If the normal is not defined: the triangle's own frame. Zero if the triangle has collapsed.
SurfaceFrame smooth_frame(const SurfaceFrame& triangle, const Vec3& interpolated_normal);

// Converts offsets between object space and the form that State stores.
class OffsetFrames {
  public:
    OffsetFrames(const Model& model, const Settings& settings, const Input& input, const Pose& pose);
    Vec3 stored(size_t v, const Vec3& offset) const;
    std::vector<Vec3> in_object(const State& state) const;

  private:
    const Model& model_;
    const Pose& pose_;
    bool world_;
    glm::mat3 world_from_object_;
    glm::mat3 object_from_world_;
};

// A painted factor; 1 without paint.
inline float painted(const std::vector<float>& paint, size_t v) {
    return paint.empty() ? 1.0f : paint[v];
}

// With fewer blocks the work is done before another thread has started.
constexpr size_t kLeastBlocks = 4;

// Calls act(begin, end) for the pairs of every group. One thread does a whole group in order. It may change
// the vertices of its pairs, because no other thread uses them meanwhile.
template <typename Act>
void for_each_group(const Pairs& pairs, const Act& act) {
    for (const size_t between : {0, 1}) {
        for_each_block(pairs.group_start.size() / 2, kLeastBlocks, [&](size_t block) {
            const size_t group = 2 * block + between;
            act(size_t(pairs.run_start[pairs.group_start[group]]),
                size_t(pairs.run_start[pairs.group_start[group + 1]]));
        });
    }
}
// The same for each pair: act(pair, vertex a, vertex b).
template <typename Act>
void for_each_pair(const Pairs& pairs, const Act& act) {
    for_each_group(pairs, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) act(i, pairs.a[i], pairs.b[i]);
    });
}

// r_i (section 3.1), object units: relative to the local edge, painted, faded at hems.
std::vector<float> attachment_radii(const Model& model, const Settings& settings, const Paint& paint);

// The length of every pair. rows: from to_rows() of the positions.
std::vector<float> pair_lengths(const Pairs& pairs, const std::vector<Row>& rows);

// The same for distance pairs, then bending pairs. Without positions the result is empty.
std::vector<float> pair_lengths(const Model& model, std::span<const Vec3> positions);

// The places of the pairs on the base. Cost: O(pairs).
Adaptive place_pairs(const Model& model);

// The state of the rest shape in this frame; empty for a static one. Throws InvalidInput like solve().
ReferenceState adapt_rest(const Model& model, const Settings& settings, const Input& input, const Pose& pose,
                          const State* before);

// Factors on the rest length of every pair e. Empty, which means 1, without a reference and without painted
// directions (GuidedStrain::rest_scale()). If there is a rest pose: |F e| / |e|, F from rest to reference. If
// there is none (kFirstFrame), lengths in the rest pose mean nothing, so the rest length is the length in
// this pose times |F e| / |F' e|, F' from rest to this pose. lengths: pair_lengths() of the attachments.
std::vector<float> rest_scales(const Model& model, const Settings& settings, const ReferenceState& reference,
                               const Pose& pose, std::span<const float> lengths);
inline float scale_of(const std::vector<float>& scales, size_t pair) {
    return scales.empty() ? 1.0f : scales[pair];
}

// The targets of every pair in this pose, from its lengths at the attachments.
struct Targets {
    std::vector<float> distance;
    std::vector<float> bending;
    std::vector<float> stiffness;  // k_bending per bending pair
};

Targets make_targets(const Model& model, const Settings& settings, const Paint& paint,
                     std::span<const float> lengths, const Pose& pose, const std::vector<float>& rest_scales);

// s l0 of every pair of a single mesh whose rest shape does not adapt.
std::vector<float> stretched_lengths(const Settings& settings, const Paint& paint, const Pairs& pairs);

// Targets::stiffness
std::vector<float> bending_stiffness(const Model& model, const Settings& settings, const Paint& paint);

// Relative errors of the lengths of pairs.
struct LengthError {
    float rms = 0.0f;
    float largest = 0.0f;
};

// target, lengths: one of each per pair.
LengthError length_error(std::span<const float> target, std::span<const float> lengths);

}  // namespace rumple::wrinkle_mesh
