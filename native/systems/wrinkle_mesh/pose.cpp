// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_mesh/pose.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "base/expect.h"
#include "base/smooth_step.h"
#include "base/solve_team.h"
#include "surface/mesh/border_rings.h"
#include "surface/mesh/positions.h"

namespace rumple::wrinkle_mesh {
namespace {

// Vectors from vertex a to vertex b of pairs [first, first + count).
Vec3Lanes ways_along(const Pairs& pairs, const std::vector<Row>& rows, size_t first, size_t count) {
    std::array<Row, kLanes> way;
    for (size_t k = 0; k < count; ++k)
        way[k].xyz = rows[pairs.b[first + k]].xyz - rows[pairs.a[first + k]].xyz;
    return columns(way);
}

void store_pair_lengths(const Pairs& pairs, const std::vector<Row>& rows, std::span<float> out) {
    for_each_four_shared(pairs.size(), [&](size_t first, size_t count) {
        const Vec3Lanes d = ways_along(pairs, rows, first, count);
        store_lanes(square_root(dot(d, d)), &out[first], count);
    });
}

// The value of s for pairs on a base that is not taut.
Lanes most_pre_stretch(const Settings& settings, const Lanes& paint) {
    return all_lanes(1.0f) + (settings.prestretch - 1.0f) * paint;
}

Lanes mix(const Lanes& from, const Lanes& to, const Lanes& share) {
    return from * (all_lanes(1.0f) - share) + to * share;
}

// The value of s for pairs with this vector on the base without folds. Cloth that is pulled taut has no
// length to spare along the pull, and folds across it (tension field theory: Wagner 1929). So if the base is
// taut along a pair, s is at most Settings::slack. Along the direction in which its own weight pulls the
// cloth, s is at most the stretch of the base, or 1 if this is more.
Lanes pre_stretch(const Settings& settings, const Lanes& paint, const Vec3Lanes& way, const Lanes& rest) {
    const Lanes one = all_lanes(1.0f), shortest = all_lanes(kShortestEdge),
                length = square_root(dot(way, way));
    const Lanes strain = length / most(rest, shortest);
    const float low = settings.slack - settings.taut_range;
    const Lanes pulled = smooth_step(low, settings.slack, strain);
    const Lanes hanging = dot(way, Vec3Lanes(settings.hang)) / most(length, shortest);
    const Lanes s = most_pre_stretch(settings, paint);
    const Lanes taut = mix(s, least(all_lanes(settings.slack), s), pulled);
    return mix(taut, least(most(strain, one), taut), hanging * hanging);
}

// Four consecutive numbers of a tensor.
Lanes four_of(const Tensor3& tensor, size_t first) {
    static_assert(sizeof(Tensor3) == 6 * sizeof(float));
    Lanes out;
    std::memcpy(&out, reinterpret_cast<const char*>(&tensor) + first * sizeof(float), sizeof(out));
    return out;
}

// v . T v, for the mean of a tensor at both ends of each pair.
Lanes quadratic_of(const Pairs& pairs, const std::vector<SpareCloth>& spare, Tensor3 SpareCloth::*which,
                   const Vec3Lanes& v, size_t first, size_t count) {
    std::array<Row, kLanes> diagonal, off_diagonal;
    for (size_t k = 0; k < count; ++k) {
        const Tensor3 &a = spare[pairs.a[first + k]].*which, &b = spare[pairs.b[first + k]].*which;
        diagonal[k].xyz = four_of(a, 0) + four_of(b, 0);
        const Lanes last = four_of(a, 2) + four_of(b, 2);
        off_diagonal[k].xyz = __builtin_shufflevector(last, last, 1, 2, 3, 0);
    }
    const Vec3Lanes squares(v.x * v.x, v.y * v.y, v.z * v.z), products(v.y * v.z, v.z * v.x, v.x * v.y);
    return dot(columns(diagonal), squares) + 2.0f * dot(columns(off_diagonal), products);
}

// SpareCloth::share_without_place() for folds across pairs.
Lanes share_without_place(const Pairs& pairs, const std::vector<SpareCloth>& spare, const Vec3Lanes& way,
                          size_t first, size_t count) {
    const Lanes zero{};
    const Lanes whole = quadratic_of(pairs, spare, &SpareCloth::all, way, first, count);
    const Lanes part = quadratic_of(pairs, spare, &SpareCloth::without_place, way, first, count);
    return whole > zero ? within(part / whole, zero, all_lanes(1.0f)) : zero;
}

// The target length of pairs in this pose. In the paper it is always s l0. Here it follows a part of the
// base's stretch and a small compression. If the base collapses, it is limited relative to the base's length.
Lanes target_length(const Settings& settings, const Lanes& limit, const Lanes& s, const Lanes& rest,
                    const Lanes& at_attachments) {
    Lanes target = s * rest;
    target += settings.stretch_relief * most(at_attachments - target, Lanes{});
    target -= within(target - at_attachments, Lanes{}, settings.buckling_threshold * target);
    return least(limit * at_attachments, target);
}

// Settings::compression_limit of every vertex; empty if it is the same for all. A fold of the height h and
// the wavelength L takes up (pi h / 2 L)^2 of the length, so a wide fold needs room. Where cloth touches what
// is worn under it, it gathers less in wide folds, and narrow ones take up the rest.
std::vector<float> compression_limits(const Model& model, const Settings& settings, const Pose& pose) {
    if (settings.contact_gather >= 1.0f || pose.gap.empty()) return {};
    std::vector<float> limits(pose.gap.size());
    for_each_index(limits.size(), kLeastSteps, [&](size_t v) {
        const float room = smooth_step(0.0f, std::max(model.local_edge[v], kShortestEdge), pose.gap[v]);
        limits[v] =
            1.0f + (settings.compression_limit - 1.0f) * glm::mix(settings.contact_gather, 1.0f, room);
    });
    return limits;
}

// The mean of a value at both vertices of pairs; 1 without values.
Lanes mean_of(const std::vector<float>& values, const Pairs& pairs, size_t first, size_t count) {
    Lanes sum = all_lanes(2.0f);
    for (size_t k = 0; k < count && !values.empty(); ++k)
        sum[k] = values[pairs.a[first + k]] + values[pairs.b[first + k]];
    return 0.5f * sum;
}

// The share of the pre-stretch that counts. The extra width of cloth counts only where there is room for it.
// It does not count in cloth that hangs free, which has enough width there.
Lanes share_of_prestretch(const Settings& settings, const Paint& paint, const Pose& pose, const Pairs& pairs,
                          size_t first, size_t count) {
    const Lanes painted = mean_of(paint.prestretch, pairs, first, count);
    if (settings.prestretch <= 1.0f) return painted;
    return painted * (mean_of(pose.to_spare, pairs, first, count) * mean_of(paint.worn, pairs, first, count));
}

// target_length() of all pairs of one kind. unwrinkled: rows of Pose::unwrinkled. limits: from
// compression_limits(). lengths, rest_scales: of these pairs; rest_scales may be empty.
std::vector<float> target_lengths(const Settings& settings, const Paint& paint, const Pose& pose,
                                  const std::vector<Row>& unwrinkled, const std::vector<float>& limits,
                                  const Pairs& pairs, std::span<const float> lengths,
                                  std::span<const float> rest_scales) {
    const bool by_tension = settings.taut_range > 0.0f && !pose.unwrinkled.empty();
    const bool straight_only = !pose.spare.empty();
    std::vector<float> out(pairs.size());
    for_each_four_shared(pairs.size(), [&](size_t first, size_t count) {
        Lanes rest = load_lanes(&pairs.rest[first], count);
        if (!rest_scales.empty()) rest = load_lanes(&rest_scales[first], count) * rest;
        const Lanes length = load_lanes(&lengths[first], count);
        const Lanes share = share_of_prestretch(settings, paint, pose, pairs, first, count);
        const Vec3Lanes way =
            by_tension || straight_only ? ways_along(pairs, unwrinkled, first, count) : Vec3Lanes();
        const Lanes s =
            by_tension ? pre_stretch(settings, share, way, rest) : most_pre_stretch(settings, share);
        const Lanes limit =
            limits.empty() ? all_lanes(settings.compression_limit) : mean_of(limits, pairs, first, count);
        Lanes target = target_length(settings, limit, s, rest, length);
        if (straight_only)
            target =
                mix(target, least(target, length), share_without_place(pairs, pose.spare, way, first, count));
        store_lanes(target, &out[first], count);
    });
    return out;
}

}  // namespace

SurfaceFrame smooth_frame(const SurfaceFrame& triangle, const Vec3& interpolated_normal) {
    const float normal_length = glm::length(interpolated_normal);
    if (normal_length < kShortestNormal) return triangle;
    const SurfaceFrame smooth =
        frame_towards(interpolated_normal / normal_length, triangle.tangent, kShortestNormal);
    return smooth.normal == Vec3(0.0f) ? triangle : smooth;
}

void check(const Model& model, const Paint& paint) {
    const auto fits = [&](const char* name, const std::vector<float>& values) {
        if (values.empty() || values.size() == model.attached.size()) return;
        throw InvalidInput(std::string("paint.") + name + ": expected " +
                           std::to_string(model.attached.size()) +
                           " values, one per solved vertex, or none, got " + std::to_string(values.size()));
    };
    fits("radius", paint.radius);
    fits("prestretch", paint.prestretch);
    fits("bending", paint.bending);
    fits("inside", paint.inside);
    fits("worn", paint.worn);
    if (paint.guide)
        expect_count("paint.along", paint.guide->along.size(), size_t(model.base.welded.vertex_count),
                     "welded vertices");
}

std::optional<Pose> guided_pose(const Model& model, const Paint& paint, const Pose& pose) {
    if (!paint.guide || !pose.guided.empty()) return {};
    const std::vector<GuidedStrain> guided = guided_strain(*paint.guide, pose.base);
    const std::vector<SpareCloth> spare = spare_cloth(model.base, paint.guide->around, pose.base, 0.0f);
    std::vector<GuidedStrain> guided_of;
    std::vector<SpareCloth> spare_of;
    for (const Index w : model.base.welded_of) {
        guided_of.push_back(guided[w]);
        spare_of.push_back(spared_along(spare[w], guided[w]));
    }
    Pose out = pose;
    out.guided = carry(model, std::span<const GuidedStrain>(guided_of));
    out.spare = carry(model, std::span<const SpareCloth>(spare_of));
    if (out.unwrinkled.empty()) out.unwrinkled = out.attachment;
    return out;
}

void check(const Model& model, const State& state) {
    if (state.offset.size() == model.attached.size()) return;
    throw InvalidInput("state: expected " + std::to_string(model.attached.size()) + " offsets, got " +
                       std::to_string(state.offset.size()));
}

SolveTeam team_for(const Model& model, int threads) {
    return {threads, model.attached.size(), kVerticesForTeam};
}

Pose make_pose(const Model& model, const Input& input) {
    check_frame(model.base, input.positions);
    const SolveTeam team = team_for(model, input.threads);
    Pose pose;
    pose.base = weld_positions(model.base, input.positions);
    pose.base_normals = vertex_normals(model.base, pose.base);
    pose.frames = triangle_frames(model.base, pose.base);
    for (const SurfaceFrame& frame : pose.frames) pose.collapsed += frame.normal == Vec3(0.0f);
    const size_t vertices = model.attached.size();
    pose.attachment.resize(vertices);
    attach(model.base, model.attachments, pose.base, pose.base_normals, pose.attachment);
    pose.normal.resize(vertices);
    for_each_index(vertices, kLeastSteps, [&](size_t v) {
        const SurfacePoint& place = model.attachments.places[v];
        const Vec3 normal = interpolate(model.base, place, pose.base_normals);
        pose.normal[v] = direction_of_normals(normal);
        if (!model.rest_offset.empty()) {
            pose.attachment[v] +=
                smooth_frame(pose.frames[place.triangle], normal).to_object(model.rest_offset[v]);
        }
    });
    find_gaps(model, input, pose);
    return pose;
}

OffsetFrames::OffsetFrames(const Model& model, const Settings& settings, const Input& input, const Pose& pose)
    : model_(model),
      pose_(pose),
      world_(settings.offset_space == OffsetSpace::kWorld),
      world_from_object_(input.world_from_object),
      object_from_world_(glm::inverse(input.world_from_object)) {
    if (!world_) return;
    for (int column = 0; column < 3; ++column) {
        if (!is_finite(world_from_object_[column]) || !is_finite(object_from_world_[column]))
            throw InvalidInput("world_from_object: it has no inverse, or is not finite");
    }
}

Vec3 OffsetFrames::stored(size_t v, const Vec3& offset) const {
    if (world_) return world_from_object_ * offset;
    return pose_.frames[model_.attachments.places[v].triangle].to_local(offset);
}

std::vector<Vec3> OffsetFrames::in_object(const State& state) const {
    std::vector<Vec3> out(state.offset.size());
    for_each_index(out.size(), kLeastSteps, [&](size_t v) {
        const SurfaceFrame& frame = pose_.frames[model_.attachments.places[v].triangle];
        out[v] = world_ ? object_from_world_ * state.offset[v] : frame.to_object(state.offset[v]);
    });
    return out;
}

std::vector<float> attachment_radii(const Model& model, const Settings& settings, const Paint& paint) {
    std::vector<float> radii(model.local_edge.size());
    for_each_index(radii.size(), kLeastSteps, [&](size_t v) {
        const float fade = hem_fade(model.border_ring[v], settings.hem_rings);
        // The room of hems, carried to a finer mesh, may be slightly below 0 by rounding.
        radii[v] = settings.radius * model.local_edge[v] * std::max(painted(paint.radius, v), 0.0f) * fade;
    });
    return radii;
}

std::vector<float> pair_lengths(const Pairs& pairs, const std::vector<Row>& rows) {
    std::vector<float> lengths(pairs.size());
    store_pair_lengths(pairs, rows, lengths);
    return lengths;
}

std::vector<float> pair_lengths(const Model& model, std::span<const Vec3> positions) {
    if (positions.empty()) return {};
    const std::vector<Row> rows = to_rows(positions);
    std::vector<float> lengths(model.distance.size() + model.bending.size());
    store_pair_lengths(model.distance, rows, lengths);
    store_pair_lengths(model.bending, rows, std::span(lengths).subspan(model.distance.size()));
    return lengths;
}

Targets make_targets(const Model& model, const Settings& settings, const Paint& paint,
                     std::span<const float> lengths, const Pose& pose,
                     const std::vector<float>& rest_scales) {
    const std::vector<float> limits = compression_limits(model, settings, pose);
    const std::vector<Row> unwrinkled = to_rows(pose.unwrinkled);
    const auto targets_of = [&](const Pairs& pairs, size_t begin) {
        const std::span<const float> scales(rest_scales);
        return target_lengths(settings, paint, pose, unwrinkled, limits, pairs,
                              lengths.subspan(begin, pairs.size()),
                              scales.empty() ? scales : scales.subspan(begin, pairs.size()));
    };
    return {targets_of(model.distance, 0), targets_of(model.bending, model.distance.size()),
            bending_stiffness(model, settings, paint)};
}

std::vector<float> stretched_lengths(const Settings& settings, const Paint& paint, const Pairs& pairs) {
    const Pose without_layers;
    std::vector<float> out(pairs.size());
    for_each_four_shared(pairs.size(), [&](size_t first, size_t count) {
        const Lanes share = share_of_prestretch(settings, paint, without_layers, pairs, first, count);
        store_lanes(most_pre_stretch(settings, share) * load_lanes(&pairs.rest[first], count), &out[first],
                    count);
    });
    return out;
}

std::vector<float> bending_stiffness(const Model& model, const Settings& settings, const Paint& paint) {
    std::vector<float> stiffness(model.bending.size());
    for_each_four_shared(stiffness.size(), [&](size_t first, size_t count) {
        store_lanes(settings.bending * mean_of(paint.bending, model.bending, first, count), &stiffness[first],
                    count);
    });
    return stiffness;
}

LengthError length_error(std::span<const float> target, std::span<const float> lengths) {
    double sum = 0.0;
    LengthError error;
    const Lanes shortest = all_lanes(kShortestEdge);
    for_each_four(target.size(), [&](size_t first, size_t count) {
        const Lanes wanted = load_lanes(&target[first], count);
        const Lanes difference = load_lanes(&lengths[first], count) - wanted;
        const Lanes relative = most(difference, -difference) / most(wanted, shortest);
        for (size_t k = 0; k < count; ++k) {
            if (wanted[k] < kShortestEdge) continue;  // a collapsed pair has no target
            sum += double(relative[k]) * relative[k];
            error.largest = std::max(error.largest, relative[k]);
        }
    });
    error.rms = target.empty() ? 0.0f : static_cast<float>(std::sqrt(sum / double(target.size())));
    return error;
}

}  // namespace rumple::wrinkle_mesh
