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
Lanes target_length(const Settings& settings, const Lanes& s, const Lanes& rest,
                    const Lanes& at_attachments) {
    Lanes target = s * rest;
    target += settings.stretch_relief * most(at_attachments - target, Lanes{});
    target -= within(target - at_attachments, Lanes{}, settings.buckling_threshold * target);
    return least(settings.compression_limit * at_attachments, target);
}

// Unit: thicknesses. If cloth is this far above the surface worn under it, all of its extra width is
// available for folds.
constexpr float kRoomToSpare = 3.0f;

// Unit: fine edges. A body is searched within this distance around a vertex.
constexpr float kBodyReach = 2.0f;

// How far a vertex may move inwards over a body; `unknown` if the body gives no bound. A border of the body
// must stay below the cloth between its vertices. Within an edge of the border the bound is as over skin;
// farther away it falls at 45 degrees.
float gap_above(const BodyContact& body, float thickness, float edge, float unknown) {
    const float above = body.distance - thickness;
    if (!body.border) return glm::mix(unknown, above, body.weight);
    const float cone = std::min(above + std::max(body.beside - edge, 0.0f), unknown);
    return glm::mix(unknown, cone, smooth_step(-edge, -0.5f * edge, body.distance));
}

// Least cosine between cloth and body. At a smaller one, a vertex does not move out any farther.
constexpr float kMostAslant = 0.5f;

// Share of the thickness: how much lower the shown surface may be between vertices and still be off a body.
constexpr float kMostSunk = 0.5f;

// If vertices are off a convex body, the surface between them may still enter it. On a body of radius R, the
// middle of the side between two vertices at an angle t is lower by R t^2 / 8, and the smooth surface is
// lower than its vertices by R t^2 / 6. The part of it above half of the thickness is added to the vertices'
// distance.
void lower_gaps_of_surface(const Model& model, float thickness, Pose& pose) {
    std::vector<float> sunk(pose.attachment.size(), 0.0f);
    for_each_pair(model.distance, [&](size_t, Index a, Index b) {
        if (pose.body[a] == kNone || pose.body[b] == kNone) return;
        const Vec3 side = pose.attachment[b] - pose.attachment[a];
        const float of_side = glm::dot(side, pose.floor[b] - pose.floor[a]) / 6.0f;
        for (const Index v : {a, b}) sunk[v] = std::max(sunk[v], of_side);
    });
    for (size_t v = 0; v < sunk.size(); ++v) pose.gap[v] -= std::max(sunk[v] - kMostSunk * thickness, 0.0f);
}

// How far every vertex may move inwards. Attachments inside a body are first moved out of it.
void find_gaps(const Model& model, const Input& input, Pose& pose) {
    if (input.gap.empty()) return;
    expect_count("gap", input.gap.size(), model.base.display.vertex_count, "values");
    if (input.bodies)
        expect_count("body_hint", input.body_hint.size(), model.base.display.vertex_count, "values");
    const float off = input.thickness + input.inner;
    pose.gap.assign(pose.attachment.size(), 0.0f);
    if (input.bodies) {
        pose.body.assign(pose.attachment.size(), kNone);
        pose.floor = pose.normal;
    }
    const std::vector<float> gaps = gaps_at(model.base, model.attachments, input.gap);
    for_each_index(pose.attachment.size(), input.bodies ? kLeastSearches : kLeastSteps, [&](size_t v) {
        const SurfacePoint& place = model.attachments.places[v];
        if (place.triangle == kNone) return;
        float gap = gaps[v];
        const Index hint = input.bodies ? hint_at(model.base, place.triangle, input.body_hint) : kNone;
        if (hint != kNone) {
            const float reach = kBodyReach * model.local_edge[v] + off;
            const BodyContact body =
                input.bodies->closest_around(pose.attachment[v], pose.normal[v], reach, hint,
                                             interpolate(model.base, place, model.base.positions_rest));
            if (body.triangle != kNone) gap = gap_above(body, off, model.local_edge[v], gap);
            pose.body[v] = body.triangle;
            // The normal of the body replaces the cloth's own normal. Otherwise cloth that slides over a heel
            // would enter it.
            if (body.triangle != kNone && !body.border)
                pose.floor[v] = glm::normalize(glm::mix(pose.normal[v], body.normal, body.weight));
        }
        pose.gap[v] = gap;
    });
    if (input.bodies && input.shown) lower_gaps_of_surface(model, input.thickness, pose);
    const bool only_look = input.bodies && input.shown && !input.looked_below;
    for_each_index(pose.attachment.size(), kLeastSteps, [&](size_t v) {
        const float gap = pose.gap[v];
        // A gap is measured along the body's normal, but cloth may move out in another direction, and then it
        // moves farther. This is not needed if the next layer searches again, or if the layer below was
        // already put out of bodies.
        const float out = only_look ? std::max(glm::dot(pose.normal[v], pose.floor[v]), kMostAslant) : 1.0f;
        if (gap < 0.0f) pose.attachment[v] -= gap / out * pose.normal[v];
        pose.gap[v] = std::max(gap, 0.0f);
    });
}

}  // namespace

std::vector<float> share_to_spare(const Input& input) {
    if (!input.bodies || input.gap.empty()) return {};
    const float room = std::max(kRoomToSpare * input.thickness, kShortestEdge);
    std::vector<float> share(input.gap.size(), 1.0f);
    for (size_t v = 0; v < share.size(); ++v)
        if (input.body_hint[v] != kNone) share[v] = smooth_step(0.0f, room, input.gap[v]);
    return share;
}

TriangleFrame smooth_frame(const TriangleFrame& triangle, const Vec3& interpolated_normal) {
    const float normal_length = glm::length(interpolated_normal);
    if (normal_length < kShortestNormal) return triangle;
    TriangleFrame frame;
    frame.normal = interpolated_normal / normal_length;
    const Vec3 tangent = triangle.tangent - glm::dot(triangle.tangent, frame.normal) * frame.normal;
    const float tangent_length = glm::length(tangent);
    if (tangent_length < kShortestNormal) return triangle;
    frame.tangent = tangent / tangent_length;
    frame.bitangent = glm::cross(frame.normal, frame.tangent);
    return frame;
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
    for (const TriangleFrame& frame : pose.frames) pose.collapsed += frame.normal == Vec3(0.0f);
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

Vec3 OffsetFrames::in_object(size_t v, const Vec3& stored) const {
    if (world_) return object_from_world_ * stored;
    return pose_.frames[model_.attachments.places[v].triangle].to_object(stored);
}

std::vector<float> attachment_radii(const Model& model, const Settings& settings, const Paint& paint) {
    std::vector<float> radii(model.local_edge.size());
    for_each_index(radii.size(), kLeastSteps, [&](size_t v) {
        const float fade = hem_fade(model.border_ring[v], settings.hem_rings);
        // Paint that was interpolated to a finer mesh may be slightly below 0 by rounding.
        radii[v] = settings.radius * model.local_edge[v] * std::max(painted(paint.radius, v), 0.0f) * fade;
    });
    return radii;
}

std::vector<float> pair_lengths(const Pairs& pairs, const std::vector<Row>& rows) {
    std::vector<float> lengths(pairs.size());
    for_each_four_shared(pairs.size(), [&](size_t first, size_t count) {
        const Vec3Lanes d = ways_along(pairs, rows, first, count);
        store_lanes(square_root(dot(d, d)), &lengths[first], count);
    });
    return lengths;
}

std::vector<float> pair_lengths(const Model& model, std::span<const Vec3> positions) {
    if (positions.empty()) return {};
    const std::vector<Row> rows = to_rows(positions);
    std::vector<float> lengths = pair_lengths(model.distance, rows);
    const std::vector<float> bending = pair_lengths(model.bending, rows);
    lengths.insert(lengths.end(), bending.begin(), bending.end());
    return lengths;
}

Targets make_targets(const Model& model, const Settings& settings, const Paint& paint,
                     std::span<const float> lengths, const Pose& pose,
                     const std::vector<float>& rest_scales) {
    Targets targets;
    const auto both = [](const std::vector<float>& values, const Pairs& pairs, size_t first, size_t count) {
        Lanes sum = all_lanes(2.0f);
        for (size_t k = 0; k < count && !values.empty(); ++k)
            sum[k] = values[pairs.a[first + k]] + values[pairs.b[first + k]];
        return 0.5f * sum;
    };
    // The extra width of cloth counts only where there is room for it. It does not count in cloth that hangs
    // free, which has enough width there.
    const auto spare_at = [&](const Pairs& pairs, size_t first, size_t count) {
        if (settings.prestretch <= 1.0f) return all_lanes(1.0f);
        return both(pose.to_spare, pairs, first, count) * both(paint.worn, pairs, first, count);
    };
    const bool by_tension = settings.taut_range > 0.0f && !pose.unwrinkled.empty();
    const bool straight_only = !pose.spare.empty();
    const std::vector<Row> rows = to_rows(pose.unwrinkled);
    const auto fill = [&](const Pairs& pairs, size_t begin, std::vector<float>& out) {
        out.resize(pairs.size());
        for_each_four_shared(pairs.size(), [&](size_t first, size_t count) {
            Lanes rest = load_lanes(&pairs.rest[first], count);
            if (!rest_scales.empty()) rest = load_lanes(&rest_scales[begin + first], count) * rest;
            const Lanes length = load_lanes(&lengths[begin + first], count);
            const Lanes painted_here =
                both(paint.prestretch, pairs, first, count) * spare_at(pairs, first, count);
            const Vec3Lanes way =
                by_tension || straight_only ? ways_along(pairs, rows, first, count) : Vec3Lanes();
            const Lanes s = by_tension ? pre_stretch(settings, painted_here, way, rest)
                                       : most_pre_stretch(settings, painted_here);
            Lanes target = target_length(settings, s, rest, length);
            if (straight_only)
                target = mix(target, least(target, length),
                             share_without_place(pairs, pose.spare, way, first, count));
            store_lanes(target, &out[first], count);
        });
    };
    fill(model.distance, 0, targets.distance);
    fill(model.bending, model.distance.size(), targets.bending);
    targets.stiffness.resize(model.bending.size());
    for_each_four_shared(model.bending.size(), [&](size_t first, size_t count) {
        store_lanes(settings.bending * both(paint.bending, model.bending, first, count),
                    &targets.stiffness[first], count);
    });
    return targets;
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
