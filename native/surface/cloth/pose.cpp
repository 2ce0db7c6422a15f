// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/pose.h"

#include <algorithm>
#include <cmath>

#include "base/expect.h"
#include "base/solve_team.h"
#include "base/tolerances.h"
#include "surface/mesh/positions.h"
#include "surface/output/attachments.h"

namespace rumple::base_cloth {
namespace {

constexpr float kPinned = 1.6e8f;  // follow of a pinned vertex, 1/s^2: springs on a skinned mesh pull hard

// An inner surface deeper than the radius of a tube would be inside out. Share of the radius.
constexpr float kWithinTube = 0.7f, kZeroCurvature = 1e-6f;

// Times Settings::tube_radius: how far a free hem has an effect, about a hand's width.
constexpr float kHemReach = 1.4f;
// The same for cloth that skinning folds in above a free hem.
constexpr float kFoldReach = 2.1f;

float painted(const std::vector<float>& values, Index display_vertex, float unpainted) {
    return values.empty() ? unpainted : values[display_vertex];
}

// The slack of a spring in a direction: none along the hang, for a garment is cut wider, not longer.
float slack_along(const Settings& settings, const Vec3& direction) {
    const float length = glm::length(direction);
    const float hang = length < kShortestEdge ? 0.0f : glm::dot(settings.hang, direction) / length;
    return 1.0f + (settings.slack - 1.0f) * (1.0f - hang * hang);
}

// A tube holds its section by bending, whose energy falls with the fourth power of its radius; along the
// tube, and where cloth is flat, it turns as it is pulled.
float share_of_curvature(const Settings& settings, float curvature) {
    const float tight = std::min(settings.tube_radius * curvature, 1.0f);
    return std::max(tight * tight * tight * tight, settings.flat_share);
}

// Per vertex, 0..1: how much it or the hem near it is held: pinned, or tucked under another part. What hangs
// free of the body has bones of its own.
std::vector<float> find_held(const Model& model, const Paint& paint, std::span<const float> room_factor) {
    const auto pinned = [&](Index v) { return painted(paint.follow, model.surface.representative[v], 0.0f); };
    std::vector<float> out;
    for (Index v = 0; v < static_cast<Index>(room_factor.size()); ++v) {
        const Index hem = model.near_hems[v].vertex;
        const bool is_free = room_factor[v] > 1.0f;
        const bool is_held = hem == kNone || is_free || model.tucked[hem];
        out.push_back(is_held ? 1.0f : std::max(pinned(v), pinned(hem)));
    }
    return out;
}

// Per vertex: share_of_smoothing().
std::vector<float> find_shares_of_smoothing(const Model& model, const Settings& settings,
                                            const Paint& paint) {
    std::vector<float> out;
    for (const NearHem& near : model.near_hems) {
        const Index hem = near.vertex == kNone ? 0 : model.surface.representative[near.vertex];
        const float held = painted(paint.follow, hem, 0.0f);
        out.push_back(share_of_smoothing(near, settings.hem_share, held, kHemReach * settings.tube_radius));
    }
    return out;
}

// How many times the room of other cloth a vertex has that hangs free; 1 of other cloth.
std::vector<float> find_room_factors(const Model& model, const Paint& paint) {
    std::vector<float> out;
    for (const Index v : model.surface.representative)
        out.push_back(std::max(painted(paint.room, v, 1.0f), 1.0f));
    return out;
}

// How far below what hangs free an inner surface may lie: by its room, but within its tubes. 0 of other
// cloth.
std::vector<float> find_free_depth(const Model& model, const Settings& settings,
                                   std::span<const float> room_factor) {
    std::vector<float> out;
    for (const float factor : room_factor) out.push_back(factor > 1.0f ? factor * settings.room : 0.0f);
    for (const Model::Spring& spring : model.springs) {
        const float within = kWithinTube / std::max(spring.curvature, kZeroCurvature);
        for (const Index v : {spring.a, spring.b}) out[v] = std::min(out[v], within);
    }
    return out;
}

// The animated positions and their tangent frames.
void place_animated(const Model& model, const Settings& settings, const Paint& paint,
                    std::span<const Vec3> positions, std::span<const float> room_factor, Pose& pose) {
    pose.animated = weld_positions(model.surface, positions);
    if (settings.start_steps > 0)  // else cloth is only moved out of bodies
        unfold_hems(model.surface, model.near_hems, find_held(model, paint, room_factor),
                    kFoldReach * settings.tube_radius, pose.animated);
    pose.normal = vertex_normals(model.surface, pose.animated);
    for (size_t v = 0; v < pose.animated.size(); ++v) {
        const Index to = model.frame_to[v];
        pose.frame.push_back(
            to == kNone ? SurfaceFrame{}
                        : frame_towards(pose.normal[v], pose.animated[to] - pose.animated[v], kShortestEdge));
    }
}

void place_follow(const Model& model, const Settings& settings, const Paint& paint,
                  std::span<const float> room_factor, Pose& pose) {
    for (size_t v = 0; v < room_factor.size(); ++v) {
        const float pinned = painted(paint.follow, model.surface.representative[v], 0.0f);
        const float follow = settings.follow / room_factor[v];  // as strong at the end of its room
        pose.follow.push_back(follow + (kPinned - follow) * pinned * pinned * pinned);
    }
}

// How far vertices may leave their animated places: what is set and painted, and what hems cover.
void place_room(const Model& model, const Settings& settings, const Paint& paint, const PosedCollider* bodies,
                std::span<const BodyContact> under, std::span<const Vec3> smooth, Pose& pose) {
    std::vector<float> hem_room = model.hem_room;
    const auto limit_to = [&](const std::vector<float>& over) {
        for (size_t v = 0; v < hem_room.size(); ++v) hem_room[v] = std::min(hem_room[v], over[v]);
    };
    const float most = std::ranges::max(paint.room.empty() ? std::vector{1.0f} : paint.room),
                unheld = std::max(settings.room * std::max(most, 1.0f), settings.slide_room);
    // If skinning moves the parts against one another, a hem covers less than at rest.
    if (!model.hem_overlaps.empty())
        limit_to(room_over_parts(model.surface, model.hems, model.hem_overlaps, pose.animated, pose.normal,
                                 unheld));
    if (bodies)
        limit_to(room_over_bodies(model.surface, model.hems, *bodies, under, smooth, pose.normal,
                                  settings.clearance.reach, unheld));
    for (size_t v = 0; v < hem_room.size(); ++v) {
        const float factor = painted(paint.room, model.surface.representative[v], 1.0f);
        const float room = std::min(settings.room * factor, hem_room[v]),
                    slide = std::min(settings.slide_room * std::min(factor, 1.0f), hem_room[v]);
        pose.room.push_back(room);
        if (room == 0.0f) pose.follow[v] = kPinned;  // no wall stands around a room of no size
        // A loose vertex has no surface to slide along; what has no room at all stays.
        const bool slides = room > 0.0f && slide > room && pose.normal[v] != Vec3(0.0f);
        pose.slide_share.push_back(slides ? room / slide : 1.0f);
    }
}

// Of every vertex the plane that keeps it before a body in front: an arm beside a flank. The animated garment
// is never behind it, so that cloth that has to come out of both sides has a place.
void look_ahead(const Settings& settings, const PosedCollider* bodies, Pose& pose) {
    pose.ahead.assign(pose.animated.size(), {Vec3(0.0f), Vec3(0.0f)});
    pose.ahead_height = pose.room;
    if (!bodies) return;
    const float thickness = settings.clearance.thickness;
    for_each_index(pose.ahead.size(), kLeastSearches, [&](size_t v) {
        if (pose.normal[v] == Vec3(0.0f)) return;
        const Vec3& a = pose.animated[v];
        const BodyAhead body = bodies->ahead(a, pose.normal[v], pose.room[v] + thickness, thickness);
        if (body.triangle == kNone) return;
        pose.ahead_height[v] = std::max(glm::dot(a - body.point, body.normal) - thickness, 0.0f);
        pose.ahead[v] = {a - pose.ahead_height[v] * body.normal, body.normal};
    });
}

// Height of a vertex over a place of another part, along its normal, in the animation; below it negative.
float height_over(const Model& model, const Pose& pose, const Overlap& overlap) {
    const Vec3& p = pose.animated[overlap.vertex];
    return glm::dot(p - interpolate(model.surface, overlap.place, pose.animated),
                    pose.normal[overlap.vertex]);
}

// Parts that lie over one another keep to their side of the middle between them. Where the animation has the
// outer one nearer to the inner one than the thickness, or below it, it comes out, as out of a body.
void keep_outer_parts_outside(const Model& model, const Settings& settings, Pose& pose) {
    for (const Overlap& overlap : model.overlaps) {
        const float height = height_over(model, pose, overlap);
        if (!overlap.outer || std::abs(height) > settings.clearance.depth) continue;
        float& inwards = pose.clearance[overlap.vertex];
        inwards = std::min({inwards, 0.5f * height, height - settings.clearance.thickness});
    }
}

void keep_inner_parts_inside(const Model& model, const Settings& settings, Pose& pose) {
    for (const Overlap& overlap : model.overlaps) {
        const float depth = -height_over(model, pose, overlap), outwards = std::max(0.5f * depth, 0.0f);
        const Index v = overlap.vertex;
        if (overlap.outer || std::abs(depth) > settings.clearance.depth) continue;
        if (outwards >= pose.ahead_height[v]) continue;
        pose.ahead_height[v] = outwards;
        pose.ahead[v] = {pose.animated[v] + outwards * pose.normal[v], -pose.normal[v]};
    }
}

// The room of every vertex, and the inner surface and bodies in front that bound it.
void place_bounds(const Model& model, const Settings& settings, const Paint& paint,
                  std::span<const float> room_factor, const PosedCollider* bodies,
                  std::vector<Index>& body_hint, Pose& pose) {
    std::vector<Vec3> smooth(pose.animated.size());
    apply<Vec3>(model.limit, pose.animated, smooth);
    Clearance found = clearance(model.clearance, settings.clearance, smooth, pose.normal,
                                find_free_depth(model, settings, room_factor), bodies, body_hint);
    place_room(model, settings, paint, bodies, found.bodies, smooth, pose);
    pose.clearance = std::move(found.inwards);
    pose.body_known = found.known;
    keep_outer_parts_outside(model, settings, pose);
    for (size_t v = 0; v < pose.animated.size(); ++v)
        pose.inner.push_back(pose.animated[v] - pose.clearance[v] * pose.normal[v]);
    place_facets(model.surface, pose);
    look_ahead(settings, bodies, pose);
    keep_inner_parts_inside(model, settings, pose);
}

void place_springs(const Model& model, const Settings& settings, const Paint& paint,
                   std::span<const float> room_factor, Pose& pose) {
    const std::vector<float> of_smoothing = find_shares_of_smoothing(model, settings, paint);
    pose.length.reserve(model.springs.size());
    for (const Model::Spring& spring : model.springs) {
        const Vec3 along = pose.animated[spring.b] - pose.animated[spring.a];
        pose.length.push_back(glm::length(along));
        pose.rest_length.push_back(slack_along(settings, along) * spring.rest);
        const float loose = std::min(room_factor[spring.a], room_factor[spring.b]);
        const float compression_scale = share_of_curvature(settings, spring.curvature) / std::sqrt(loose);
        pose.compression_scale.push_back(compression_scale);
        pose.smoothing.push_back(settings.smoothing * compression_scale *
                                 std::min(of_smoothing[spring.a], of_smoothing[spring.b]));
    }
    pose.rest_length.resize(in_fours(pose.rest_length.size()));
    pose.compression_scale.resize(pose.rest_length.size());
    pose.smoothing.resize(pose.rest_length.size());
}

// Stays outside of the inner surface, before what is ahead, and within the room around the animated place.
void project(const Pose& pose, const Plane& plane, size_t v, Vec3& p) {
    const float below = height_above(pose.ahead[v], p);
    if (below < 0.0f) p -= below * pose.ahead[v].normal;
    const float height = height_above(plane, p);
    if (height < 0.0f) p -= height * plane.normal;
    p = pose.within_room(v, p);
}

void describe(const Model& model, const Settings& settings, const Pose& pose, std::span<const Vec3> x,
              std::span<const Plane> planes, Result& out) {
    double sum = 0.0;
    size_t touching = 0, taut = 0, vertices = 0;
    for (size_t v = 0; v < x.size(); ++v) {
        if (model.triangle_of[v] == kNone) continue;  // loose
        ++vertices;
        const float moved = glm::distance(x[v], pose.animated[v]);
        sum += moved;
        out.report.offset_max = std::max(out.report.offset_max, moved);
        touching += height_above(planes[v], x[v]) < kTouching * settings.room;
    }
    for (size_t s = 0; s < model.springs.size(); ++s)
        taut += glm::distance(x[model.springs[s].a], x[model.springs[s].b]) > pose.rest_length[s];
    out.report.offset_mean = static_cast<float>(sum / double(std::max<size_t>(vertices, 1)));
    out.report.touching = float(touching) / float(std::max<size_t>(vertices, 1));
    out.report.body_known = pose.body_known;
    out.report.taut = float(taut) / float(std::max<size_t>(model.springs.size(), 1));
}

}  // namespace

bool matches(const Model& model, const State& state) {
    return state.length.size() == model.springs.size() && state.clearance.size() == model.area.size() &&
           state.ahead_height.size() == model.area.size();
}

bool same_pose(const Model& model, const Pose& pose, const State& state, float still) {
    for (size_t s = 0; s < model.springs.size(); ++s) {
        if (std::abs(pose.length[s] - state.length[s]) > kHeldStrain * model.springs[s].rest) return false;
    }
    for (size_t v = 0; v < pose.clearance.size(); ++v) {
        if (std::abs(pose.clearance[v] - state.clearance[v]) > still) return false;
        if (std::abs(pose.ahead_height[v] - state.ahead_height[v]) > still) return false;
    }
    return true;
}

void keep_pose(const Pose& pose, const State* held, State& state) {
    state.length = held ? held->length : pose.length;
    state.clearance = held ? held->clearance : pose.clearance;
    state.ahead_height = held ? held->ahead_height : pose.ahead_height;
}

double mean_length(const Model& model) {
    double sum = 0.0;
    for (const Model::Spring& spring : model.springs) sum += double(spring.rest);
    return sum / double(std::max<size_t>(model.springs.size(), 1));
}

Pose make_pose(const Model& model, const Settings& settings, const Paint& paint,
               std::span<const Vec3> positions, const PosedCollider* bodies, std::vector<Index>& body_hint) {
    check_frame(model.surface, positions);
    const std::vector<float> room_factor = find_room_factors(model, paint);
    Pose pose;
    place_animated(model, settings, paint, positions, room_factor, pose);
    place_follow(model, settings, paint, room_factor, pose);
    place_bounds(model, settings, paint, room_factor, bodies, body_hint, pose);
    place_springs(model, settings, paint, room_factor, pose);
    return pose;
}

void finish(const Model& model, const Settings& settings, const Pose& pose, std::span<const Plane> planes,
            bool has_bodies, std::span<Vec3> x, Result& out) {
    for (size_t v = 0; v < x.size(); ++v) project(pose, planes[v], v, x[v]);
    describe(model, settings, pose, x, planes, out);
    for (const Index welded : model.surface.welded_of) {
        out.positions.push_back(x[welded]);
        out.gap.push_back(std::max(height_above(planes[welded], x[welded]), 0.0f));
        if (has_bodies) out.body_hint.push_back(out.state.body_hint[welded]);
    }
}

}  // namespace rumple::base_cloth
