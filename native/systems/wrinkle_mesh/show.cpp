// SPDX-License-Identifier: GPL-3.0-or-later
// The shown mesh of a solved frame, and measures of its quality.
#include <algorithm>

#include "systems/wrinkle_mesh/pose.h"

namespace rumple::wrinkle_mesh {

namespace {

// Area of the solved mesh / rest area, in compressed triangles of the base.
float compressed_area(const Model& model, std::span<const Vec3> base, std::span<const Vec3> positions) {
    const auto area = [](std::span<const Vec3> p, Index a, Index b, Index c) {
        return double(glm::length(glm::cross(p[b] - p[a], p[c] - p[a])));
    };
    std::vector<bool> compressed;
    for (const Triangle& t : model.base.triangles) {
        const auto v = [&](int k) { return model.base.welded.corner_vertex[t.corner[k]]; };
        compressed.push_back(area(base, v(0), v(1), v(2)) <
                             0.9 * area(model.base.positions_rest, v(0), v(1), v(2)));
    }
    double now = 0.0, rest = 0.0;
    for (const auto& t : model.triangles) {
        const auto inside = [&](Index v) { return bool(compressed[model.attachments.places[v].triangle]); };
        if (!inside(t[0]) || !inside(t[1]) || !inside(t[2])) continue;
        now += area(positions, t[0], t[1], t[2]);
        rest += area(model.positions_rest, t[0], t[1], t[2]);
    }
    return rest > 0.0 ? static_cast<float>(now / rest) : 1.0f;
}

}  // namespace

std::vector<Vec3> solved_positions(const Pose& pose, std::span<const Vec3> offset) {
    std::vector<Vec3> positions(pose.attachment);
    for_each_index(positions.size(), kLeastSteps, [&](size_t v) { positions[v] += offset[v]; });
    return positions;
}

void show(const Model& model, const Settings& settings, const Input& input, const State& state,
          Picture& picture, bool in_viewport) {
    show_pose(model, settings, input, make_pose(model, input), state, picture, in_viewport);
}

void show_pose(const Model& model, const Settings& settings, const Input& input, const Pose& pose,
               const State& state, Picture& picture, bool in_viewport) {
    check(model, state);
    const SolveTeam team = team_for(model, settings.threads);
    const std::vector<Vec3> offset = OffsetFrames(model, settings, input, pose).in_object(state);
    show_frame(model.base, shown_mesh(model, in_viewport), model.stretch, pose.base, pose.frames,
               solved_positions(pose, offset), offset, picture);
}

Measures measure(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
                 const State& state) {
    return measure_pose(model, settings, paint, input, make_pose(model, input), state);
}

Measures measure_pose(const Model& model, const Settings& settings, const Paint& paint, const Input& input,
                      const Pose& given, const State& state) {
    check(settings);
    check(model, paint);
    check(model, state);
    const std::optional<Pose> guided = guided_pose(model, paint, given);
    const Pose& pose = guided ? *guided : given;
    const std::vector<Vec3> offset = OffsetFrames(model, settings, input, pose).in_object(state);
    const std::vector<Vec3> positions = solved_positions(pose, offset);
    Measures out;
    const std::vector<float> radii = attachment_radii(model, settings, paint);
    for (size_t v = 0; v < positions.size(); ++v) {
        out.offsets.push_back(pose.frames[model.attachments.places[v].triangle].to_local(offset[v]));
        const float length = glm::length(offset[v]);
        out.largest_offset = std::max(out.largest_offset, length);
        if (model.attached[v] && radii[v] > 0.0f) {
            out.attachment_violation = std::max(out.attachment_violation, (length - radii[v]) / radii[v]);
        }
    }
    std::vector<float> wanted(model.distance.rest);
    const std::vector<float> scales =
        rest_scales(model, settings, state.reference, pose, pair_lengths(model, pose.attachment));
    for (size_t i = 0; i < wanted.size(); ++i) wanted[i] *= settings.prestretch * scale_of(scales, i);
    const LengthError before = length_error(wanted, pair_lengths(model.distance, to_rows(pose.attachment)));
    const LengthError after = length_error(wanted, pair_lengths(model.distance, to_rows(positions)));
    out.edge_error_before_rms = before.rms;
    out.edge_error_before_max = before.largest;
    out.edge_error_after_rms = after.rms;
    out.edge_error_after_max = after.largest;
    out.compressed_area_before = compressed_area(model, pose.base, pose.attachment);
    out.compressed_area_after = compressed_area(model, pose.base, positions);
    return out;
}

}  // namespace rumple::wrinkle_mesh
