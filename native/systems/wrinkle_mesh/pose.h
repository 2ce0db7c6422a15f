// SPDX-License-Identifier: GPL-3.0-or-later
// One frame of the base as the solver of the Wrinkle Mesh sees it. For this system
// and for the handles of the library.
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

// The deformed base and the attachments of one frame.
struct Pose {
    std::vector<Vec3> base;  // welded vertices
    std::vector<Vec3> base_normals;
    std::vector<TriangleFrame> frames;  // per base triangle
    std::vector<Vec3> attachment;       // a_i
    std::vector<Vec3> unwrinkled;       // where layers without folds would have them; empty: no layers
    std::vector<SpareCloth> spare;      // of the base, at the attachments; empty: folds along any line
    std::vector<float> to_spare;        // 0..1: what of the pre-stretch is there to fold; empty: all of it
    std::vector<GuidedStrain> guided;   // of the base, at the attachments; empty: no directions are asked for
    std::vector<Vec3> normal;           // interpolated base normals at the attachments, unit or zero
    std::vector<Vec3> floor;            // unit: off what is worn under each; empty: the normals
    std::vector<float> gap;             // how far each may go inwards, object units, >= 0; empty: no limit
    std::vector<Index> body;            // the triangle of a body near each, or kNone; empty: no bodies
    // What of the cloth itself, or of a body in front, faces each attachment; empty: no bound.
    std::vector<SelfContactSide> self_contact;
    std::vector<float> heights;  // PosedSelfContactMesh::heights() at the attachments; empty: no bound
    Index collapsed = 0;
};

// Values of the base's vertices (as the artist has them) -> solved vertices.
template <typename Value>
std::vector<Value> carry(const Model& model, std::span<const Value> base_values) {
    std::vector<Value> out(model.attachments.places.size());
    for_each_index(out.size(), kLeastSteps, [&](size_t v) {
        const SurfacePoint& place = model.attachments.places[v];
        const Triangle& triangle = model.base.triangles[place.triangle];
        const auto value = [&](int k) {
            return base_values[model.base.display.corner_vertex[triangle.corner[k]]];
        };
        out[v] = (1.0f - place.b0 - place.b1) * value(0) + place.b0 * value(1) + place.b1 * value(2);
    });
    return out;
}

// Below so many solved vertices a frame takes a millisecond or two on one thread.
constexpr size_t kVerticesForTeam = 3'000;

// Of a frame of this model. threads: as Settings and Input have it.
SolveTeam team_for(const Model& model, int threads);

// Throws InvalidInput when positions do not match the model or are not finite.
Pose make_pose(const Model& model, const Input& input);

// Of the base's vertices: Pose::to_spare. Where a body is known under the cloth and it lies on that, its
// width is that of the body; what it is cut wider hangs where there is room. Empty without bodies.
std::vector<float> share_to_spare(const Input& input);

// The pose of a single mesh with the directions that are painted; none where none are.
std::optional<Pose> guided_pose(const Model& model, const Paint& paint, const Pose& pose);

// What a frame is asked for, with its pose, that make_pose() made of `input`.
State solve_pose(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
                 const Pose& pose, const State* state, Report& report);
State solve_pose_in_order(const Model& model, const Settings& settings, const Paint& paint,
                          const Input& input, const Pose& pose, const State* state, Report& report);
void show_pose(const Model& model, const Settings& settings, const Input& input, const Pose& pose,
               const State& state, Picture& picture, bool in_viewport = false);
Measures measure_pose(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
                      const Pose& pose, const State& state);

// p_i = a_i + o_i (2), object space.
std::vector<Vec3> solved_positions(const Model& model, const Settings& settings, const Input& input,
                                   const Pose& pose, const State& state);

// Throw InvalidInput when they are of another model.
void check(const Model& model, const Paint& paint);
void check(const Model& model, const State& state);

// A triangle's frame tilted onto the interpolated normal, so that what rides in
// it does not jump from triangle to triangle. The triangle's own frame where
// the normal is lost; zero where the triangle has collapsed.
TriangleFrame smooth_frame(const TriangleFrame& triangle, const Vec3& interpolated_normal);

// An offset of object space, as State stores it, and back.
class OffsetFrames {
  public:
    OffsetFrames(const Model& model, const Settings& settings, const Input& input, const Pose& pose);
    Vec3 stored(size_t v, const Vec3& offset) const;
    Vec3 in_object(size_t v, const Vec3& stored) const;

  private:
    const Model& model_;
    const Pose& pose_;
    bool world_;
    glm::mat3 world_from_object_;
    glm::mat3 object_from_world_;
};

// A painted factor: 1 where nothing was painted.
inline float painted(const std::vector<float>& paint, size_t v) {
    return paint.empty() ? 1.0f : paint[v];
}

// Fewer blocks are done before another thread has begun.
constexpr size_t kLeastBlocks = 4;

// act(begin, end) for the pairs of every group, all of which a thread does in their order. What it changes of
// the vertices of its pairs no other thread touches meanwhile.
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
// The same one by one: act(pair, vertex a, vertex b).
template <typename Act>
void for_each_pair(const Pairs& pairs, const Act& act) {
    for_each_group(pairs, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) act(i, pairs.a[i], pairs.b[i]);
    });
}

// r_i (section 3.1), object units: relative to the local edge, painted, faded at hems.
std::vector<float> attachment_radii(const Model& model, const Settings& settings, const Paint& paint);

// Length of every pair. rows: of to_rows() of the positions.
std::vector<float> pair_lengths(const Pairs& pairs, const std::vector<Row>& rows);

// The same of distance pairs, then bending. Empty positions: empty.
std::vector<float> pair_lengths(const Model& model, std::span<const Vec3> positions);

// Where the pairs lie on the base. Cost: O(pairs).
Adaptive place_pairs(const Model& model);

// The rest shape's state of this frame: empty for a static one. Throws InvalidInput as solve() does.
ReferenceState adapt_rest(const Model& model, const Settings& settings, const Input& input, const Pose& pose,
                          const State* before);

// By how much the rest length of every pair e is scaled; empty, which means 1, for an empty reference and no
// directions that are asked for (GuidedStrain::rest_scale()). From the rest pose: |F e| / |e|, F from rest to
// reference. Without one (kFirstFrame) the rest pose's lengths mean nothing: the length in this pose times
// |F e| / |F' e|, F' from rest to this pose. lengths: pair_lengths() of the attachments.
std::vector<float> rest_scales(const Model& model, const Settings& settings, const ReferenceState& reference,
                               const Pose& pose, std::span<const float> lengths);
inline float scale_of(const std::vector<float>& scales, size_t pair) {
    return scales.empty() ? 1.0f : scales[pair];
}

// What every pair is asked for in this pose, of its lengths at the attachments.
struct Targets {
    std::vector<float> distance;
    std::vector<float> bending;
    std::vector<float> stiffness;  // k_bending per bending pair
};

Targets make_targets(const Model& model, const Settings& settings, const Paint& paint,
                     std::span<const float> lengths, const Pose& pose, const std::vector<float>& rest_scales);

// Relative errors of the lengths of pairs.
struct LengthError {
    float rms = 0.0f;
    float largest = 0.0f;
};

// target, lengths: one of each for every pair.
LengthError length_error(std::span<const float> target, std::span<const float> lengths);

}  // namespace rumple::wrinkle_mesh
