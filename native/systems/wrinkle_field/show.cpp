// SPDX-License-Identifier: GPL-3.0-or-later
// Section 6 of Loviscach 2006: the field for shaders and fine meshes.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/expect.h"
#include "base/tolerances.h"
#include "systems/wrinkle_field/wrinkle_field.h"

namespace rumple::wrinkle_field {
namespace {

using Corners = std::array<Index, 3>;  // welded vertices

// The plane wave of a vertex at a point of the deformed surface, radians.
float phase_at(const Waves& waves, std::span<const float> phase, Index vertex, const Vec3& point) {
    return glm::dot(waves.wave_vector[vertex], point - waves.positions[vertex]) + phase[vertex];
}

float between(const std::array<float, kProfileIntervals + 1>& table, const formulas::ProfilePlace& place) {
    return table[place.index] + place.fraction * (table[place.index + 1] - table[place.index]);
}

using Weights = std::array<float, 3>;

Vec3 point_at(const Corners& corners, const Weights& weights, std::span<const Vec3> values) {
    Vec3 sum(0.0f);
    for (int k = 0; k < 3; ++k) sum += weights[k] * values[corners[k]];
    return sum;
}

// Equations (5) and (8). weights: barycentric coordinates of the point.
Height height_at(const Waves& waves, const Profile& profile, std::span<const float> phase,
                 const Corners& corners, const Weights& weights, const Vec3& point) {
    Height out{0.0f, Vec3(0.0f)};
    for (int k = 0; k < 3; ++k) {
        const Index v = corners[k];
        const formulas::ProfilePlace at = formulas::profile_place(phase_at(waves, phase, v, point));
        const float weight = weights[k] * waves.height[v];
        out.height += weight * between(profile.height, at);
        out.gradient += weight * at.sign * between(profile.slope, at) * waves.wave_vector[v];
    }
    return out;
}

void fill_corners(const Model& model, const Waves& waves, std::span<const float> phase, Picture& picture) {
    const Index triangles = static_cast<Index>(model.base.triangles.size());
    for (Index t = 0; t < triangles; ++t) {
        const Corners corners = welded_vertices(model.base, t);
        Vec3 turns;  // whole turns, which are removed
        for (int wave = 0; wave < 3; ++wave) {
            float sum = 0.0f;
            for (const Index v : corners) {
                sum += phase_at(waves, phase, corners[wave], waves.positions[v]);
            }
            turns[wave] = formulas::kTwoPi * std::floor(sum / 3.0f / formulas::kTwoPi + 0.5f);
        }
        for (int corner = 0; corner < 3; ++corner) {
            Vec3 phases, weight(0.0f);
            for (int wave = 0; wave < 3; ++wave) {
                const Vec3& point = waves.positions[corners[corner]];
                phases[wave] = phase_at(waves, phase, corners[wave], point) - turns[wave];
                picture.corner_wave_vector[wave].push_back(waves.wave_vector[corners[wave]]);
            }
            weight[corner] = waves.height[corners[corner]];
            picture.corner_phase.push_back(phases);
            picture.corner_weight.push_back(weight);
        }
    }
}

// Equation (11) for every triangle, averaged over the fans by area. Separate gradients for the triangles
// would tear the texture at the edges.
void fill_uv_gradients(const Model& model, std::span<const Vec3> positions, Picture& picture) {
    if (model.uv.empty()) return;
    std::vector<Vec3> u_sum(model.uv.size(), Vec3(0.0f)), v_sum = u_sum;
    std::vector<float> area_sum(model.uv.size(), 0.0f);
    const Index triangles = static_cast<Index>(model.base.triangles.size());
    for (Index t = 0; t < triangles; ++t) {
        const Corners corners = welded_vertices(model.base, t);
        const Vec3 b = positions[corners[1]] - positions[corners[0]];
        const Vec3 c = positions[corners[2]] - positions[corners[0]];
        const formulas::UvSlopes slopes = formulas::uv_slopes(b, c, model.uv[3 * t + 1] - model.uv[3 * t],
                                                              model.uv[3 * t + 2] - model.uv[3 * t]);
        for (int k = 0; k < 3; ++k) {
            const Index fan = model.uv_fan[3 * t + k];
            u_sum[fan] += slopes.u;
            v_sum[fan] += slopes.v;
            area_sum[fan] += slopes.area;
        }
    }
    for (const Index fan : model.uv_fan) {
        const float scale = area_sum[fan] > 0.0f ? 1.0f / area_sum[fan] : 0.0f;
        picture.corner_u_gradient.push_back(scale * u_sum[fan]);
        picture.corner_v_gradient.push_back(scale * v_sum[fan]);
    }
}

// The fine mesh: attached, then moved along the interpolated normal by equation (5). gap: as for show().
void displace(const Model& model, const Waves& waves, const Profile& profile, std::span<const float> phase,
              std::span<const float> gap, Picture& picture) {
    const size_t fine = model.attachments.places.size();
    std::vector<Vec3> positions(fine), offset(fine, Vec3(0.0f));
    attach(model.base, model.attachments, waves.positions, waves.normals, positions);
    std::vector<float> inwards(fine, std::numeric_limits<float>::infinity());
    if (!gap.empty()) inwards = gaps_at(model.base, model.attachments, gap);
    for (size_t v = 0; v < fine; ++v) {
        const SurfacePoint& place = model.attachments.places[v];
        const Corners corners = welded_vertices(model.base, place.triangle);
        const Weights weights = place.weights();
        const Vec3 normal = point_at(corners, weights, waves.normals);
        const float length = glm::length(normal);
        if (length < kShortestNormal) continue;
        // Evaluate at the attached position, not in the flat triangle. On an irregular mesh the smooth
        // surface has the point elsewhere, and straight crests would wobble.
        const Height at = height_at(waves, profile, phase, corners, weights, positions[v]);
        offset[v] = std::max(at.height, -inwards[v]) / length * normal;
        positions[v] += offset[v];
    }
    show_frame(model.base, model.shown, model.stretch, waves.positions,
               triangle_frames(model.base, waves.positions), positions, offset, picture);
}

// At every shown vertex: amplitude, direction and phase of the strongest wave there.
void fill_points(const Model& model, const Waves& waves, std::span<const float> phase, Picture& picture) {
    for (const SurfacePoint& place : model.shown.places) {
        if (place.triangle == kNone) {
            picture.amplitude.push_back(0.0f);
            picture.direction.push_back(Vec3(0.0f));
            picture.phase.push_back(0.0f);
            continue;
        }
        const Corners corners = welded_vertices(model.base, place.triangle);
        const Weights weights = place.weights();
        int nearest = 0;
        float amplitude = 0.0f;
        for (int k = 0; k < 3; ++k) {
            amplitude += weights[k] * waves.height[corners[k]];
            if (weights[k] > weights[nearest]) nearest = k;
        }
        const Index v = corners[nearest];
        picture.amplitude.push_back(amplitude);
        picture.direction.push_back(waves.direction[v].x * model.tangent_rest[v] +
                                    waves.direction[v].y * model.bitangent_rest[v]);
        picture.phase.push_back(
            formulas::wrapped(phase_at(waves, phase, v, point_at(corners, weights, waves.positions))));
    }
}

}  // namespace

Height evaluate(const Model& model, const Waves& waves, const Profile& profile, std::span<const float> phase,
                const SurfacePoint& place) {
    const Corners corners = welded_vertices(model.base, place.triangle);
    const Weights weights = place.weights();
    return height_at(waves, profile, phase, corners, weights, point_at(corners, weights, waves.positions));
}

Waves shown_waves(const Model& model, const Settings& settings, const Profile& profile, const Paint& paint,
                  std::span<const Vec3> positions, const State& state) {
    return shown_waves(model, settings, profile, paint, make_pose(model, positions), state);
}

Waves shown_waves(const Model& model, const Settings& settings, const Profile& profile, const Paint& paint,
                  const Pose& pose, const State& state) {
    expect_count("state", state.phase.size(), model.base.positions_rest.size(), "welded vertices");
    Waves estimated = estimate_waves(model, settings, paint, pose, state.direction,
                                     reference_stretches(model, state.reference, pose));
    return shown_waves(model, settings, profile, std::move(estimated), state);
}

Waves shown_waves(const Model& model, const Settings& settings, const Profile& profile, Waves waves,
                  const State& state) {
    expect_count("state", state.phase.size(), model.base.positions_rest.size(), "welded vertices");
    if (model.output == Output::kGeometry && settings.keep_length) keep_length(profile, waves);
    if (settings.dissolve) dissolve(model, settings, state.phase, waves);
    return waves;
}

Picture show(const Model& model, const Waves& waves, const Profile& profile, std::span<const Vec3> positions,
             const State& state, std::span<const float> gap) {
    if (!gap.empty()) expect_count("gap", gap.size(), model.base.display.vertex_count, "vertices");
    Picture picture;
    if (model.output == Output::kGeometry) {
        displace(model, waves, profile, state.phase, gap, picture);
    } else {
        measure_stretch(model.base, model.stretch, waves.positions, model.shown.places, picture.stretch);
        picture.positions.assign(positions.begin(), positions.end());
        picture.local_offset.assign(positions.size(), Vec3(0.0f));
        picture.offset = picture.local_offset;
        fill_corners(model, waves, state.phase, picture);
        fill_uv_gradients(model, waves.positions, picture);
    }
    fill_points(model, waves, state.phase, picture);
    return picture;
}

}  // namespace rumple::wrinkle_field
