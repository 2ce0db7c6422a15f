// SPDX-License-Identifier: GPL-3.0-or-later
#include <limits>

#include "api/handles.h"
#include "api/sound.h"
#include "base/expect.h"
#include "base/tolerances.h"
#include "rumple.h"
#include "surface/cloth/swing.h"

using namespace rumple;
using namespace rumple::api;
using base_cloth::Model;

struct rumple_base_cloth {
    std::shared_ptr<const Model> model;
};
struct rumple_base_cloth_paint {
    std::shared_ptr<const Model> model;
    base_cloth::Paint paint;
};
struct rumple_base_cloth_state {
    std::shared_ptr<const Model> model;
    base_cloth::Result result;
};

// Each of these functions lists all fields once, for both directions: see api/settings.h. They are in no
// namespace, so that they are found by the types of their arguments.
template <typename Pair>
static void pair_fields(rumple_base_cloth_settings& c, base_cloth::Settings& native, const Pair& pair) {
    pair(c.stretch, native.stretch);
    pair(c.strain_limit, native.strain_limit);
    pair(c.shear, native.shear);
    pair(c.compression, native.compression);
    pair(c.compression_limit, native.compression_limit);
    pair(c.folded, native.folded);
    pair(c.smoothing, native.smoothing);
    pair(c.tube_radius, native.tube_radius);
    pair(c.flat_share, native.flat_share);
    pair(c.hem_share, native.hem_share);
    pair(c.slack, native.slack);
    pair(c.hang, native.hang);
    pair(c.follow, native.follow);
    pair(c.room, native.room);
    pair(c.slide_room, native.slide_room);
    pair(c.friction, native.friction);
    pair(c.gravity, native.gravity);
    pair(c.thickness, native.clearance.thickness);
    pair(c.unknown, native.clearance.unknown);
    pair(c.reach, native.clearance.reach);
    pair(c.depth, native.clearance.depth);
    pair(c.spread, native.clearance.spread);
    pair(c.steps, native.steps);
    pair(c.start_steps, native.start_steps);
    pair(c.most_cg_iterations, native.most_cg_iterations);
}

template <typename Pair>
static void pair_fields(rumple_base_cloth_swing& c, base_cloth::Swing& native, const Pair& pair) {
    pair(c.seconds, native.seconds);
    pair(c.longest_step, native.longest_step);
    pair(c.newton_steps, native.newton_steps);
    pair(c.damping, native.damping);
    pair(c.locomotion, native.locomotion);
    pair(c.drag, native.drag);
    pair(c.wind, native.wind);
    pair(c.shift, native.placement.shift);
}

namespace {

rumple_base_cloth_report report_of(const base_cloth::Report& r) {
    return {r.steps, r.cg_iterations, r.moved, r.offset_mean, r.offset_max, r.taut, r.touching, r.body_known};
}

const base_cloth::State* state_in(const rumple_base_cloth_state* state) {
    return state ? &state->result.state : nullptr;
}

// ---- what is kept, as plain arrays

constexpr double kAnyTriangle = double(std::numeric_limits<Index>::max()) + 1.0;

rumple_base_cloth_kept kept_of(const base_cloth::State& s) {
    const base_cloth::Motion& m = s.motion;
    return {.offset = flat<float>(s.offset),
            .offset_count = s.offset.size(),
            .length = s.length.data(),
            .length_count = s.length.size(),
            .clearance = s.clearance.data(),
            .clearance_count = s.clearance.size(),
            .ahead_height = s.ahead_height.data(),
            .ahead_height_count = s.ahead_height.size(),
            .body_hint = s.body_hint.data(),
            .body_hint_count = s.body_hint.size(),
            .contact_hint = s.contact_hint.data(),
            .contact_hint_count = s.contact_hint.size(),
            .position = flat<float>(m.position),
            .position_count = m.position.size(),
            .velocity = flat<float>(m.velocity),
            .velocity_count = m.velocity.size(),
            .animated = flat<float>(m.animated),
            .animated_count = m.animated.size(),
            .animated_before = flat<float>(m.animated_before),
            .animated_before_count = m.animated_before.size(),
            .moved = s.moved,
            .seconds = m.seconds,
            .fastest = m.fastest,
            .gravity = {m.gravity.x, m.gravity.y, m.gravity.z},
            .wind = {m.wind.x, m.wind.y, m.wind.z},
            .air = flat<float>(m.air),
            .air_count = m.air.size(),
            .push = flat<float>(m.push),
            .push_count = m.push.size()};
}

std::vector<Vec3> kept_vectors(const float* data, size_t count, size_t expected, const char* name) {
    expect_rows(name, count, expected);
    std::vector<Vec3> out = copied(vectors(data, count, name));
    expect_finite<Vec3>(name, out, "vertex");
    expect_range(name, floats_of(out), -kFarthestCoordinate, kFarthestCoordinate);
    return out;
}

std::vector<Vec3> kept_vectors_or_none(const float* data, size_t count, size_t expected, const char* name) {
    return kept_vectors(data, count, count > 0 ? expected : 0, name);
}

std::vector<float> kept_numbers(const float* data, size_t count, size_t expected, const char* name) {
    expect_rows(name, count, expected);
    std::vector<float> out = copied(values(data, count, name));
    expect_finite<float>(name, out, "number");
    return out;
}

// triangles: the number of triangles that a hint may refer to. Hints into the cloth are used without a check,
// so they must be valid. Hints into a body are checked when used, because the body may have changed.
std::vector<Index> kept_hints(const int32_t* data, size_t count, size_t expected, double triangles,
                              const char* name) {
    expect_rows_or_none(name, count, expected);
    std::vector<Index> out = copied(values(data, count, name));
    for (const Index hint : out) expect_within(name, hint, kNone, triangles - 1.0);
    return out;
}

Vec3 kept_vector(const float* data, const char* name) {
    for (int k = 0; k < 3; ++k) expect_within(name, data[k], -kFarthestCoordinate, kFarthestCoordinate);
    return {data[0], data[1], data[2]};
}

base_cloth::Motion motion_of(size_t vertices, const rumple_base_cloth_kept& from) {
    base_cloth::Motion m;
    m.position = kept_vectors_or_none(from.position, from.position_count, vertices, "position");
    m.velocity = kept_vectors(from.velocity, from.velocity_count, m.position.size(), "velocity");
    m.animated = kept_vectors(from.animated, from.animated_count, m.position.size(), "animated");
    m.animated_before =
        kept_vectors(from.animated_before, from.animated_before_count, m.position.size(), "animated_before");
    m.air = kept_vectors_or_none(from.air, from.air_count, m.position.size(), "air");
    m.push = kept_vectors_or_none(from.push, from.push_count, m.position.size(), "push");
    m.seconds = from.seconds;
    m.fastest = from.fastest;
    m.gravity = kept_vector(from.gravity, "gravity");
    m.wind = kept_vector(from.wind, "wind");
    expect_within("seconds", m.seconds, 0.0, kFarthestCoordinate);
    expect_within("fastest", m.fastest, 0.0, base_cloth::Motion{}.fastest);
    return m;
}

base_cloth::State state_of(const Model& model, const rumple_base_cloth_kept& from) {
    const size_t vertices = model.area.size();
    base_cloth::State s;
    s.motion = motion_of(vertices, from);
    s.offset =
        kept_vectors(from.offset, from.offset_count, s.motion.position.empty() ? vertices : 0, "offset");
    s.length = kept_numbers(from.length, from.length_count, model.springs.size(), "length");
    s.clearance = kept_numbers(from.clearance, from.clearance_count, vertices, "clearance");
    s.ahead_height = kept_numbers(from.ahead_height, from.ahead_height_count, vertices, "ahead_height");
    s.body_hint = kept_hints(from.body_hint, from.body_hint_count, vertices, kAnyTriangle, "body_hint");
    expect_rows("contact_hint", from.contact_hint_count, vertices);
    s.contact_hint = kept_hints(from.contact_hint, from.contact_hint_count, vertices,
                                double(model.surface.triangles.size()), "contact_hint");
    s.moved = from.moved;
    expect_within("moved", s.moved, 0.0, kFarthestCoordinate);
    return s;
}

base_cloth::Paint paint_in(const rumple_base_cloth_paint* paint) {
    return paint ? paint->paint : base_cloth::Paint{};
}

}  // namespace

// ---- bodies

rumple_status rumple_collider_build(const float* positions, size_t positions_count, const int32_t* triangles,
                                    size_t triangles_count, const float* rest, size_t rest_count,
                                    float worn_within, rumple_collider** collider) {
    return made(collider, "collider", [&] {
        const auto points = vectors(positions, positions_count, "positions");
        const auto corners = rows<std::array<Index, 3>>(triangles, triangles_count, "triangles");
        const auto at_rest = rows<Vec3>(rest, rest_count, "rest");
        return new rumple_collider{Collider(points, corners, at_rest, worn_within)};
    });
}

void rumple_collider_free(rumple_collider* collider) {
    delete collider;
}

int32_t rumple_collider_vertex_count(const rumple_collider* collider) {
    return collider ? collider->collider.vertex_count() : 0;
}

// ---- the cloth

rumple_status rumple_base_cloth_build(const rumple_surface* surface, rumple_base_cloth** model) {
    return made(model, "model",
                [&] { return new rumple_base_cloth{base_cloth::build(given(surface, "surface").surface)}; });
}

void rumple_base_cloth_free(rumple_base_cloth* model) {
    delete model;
}

rumple_base_cloth_settings rumple_base_cloth_settings_default(void) {
    return default_of<rumple_base_cloth_settings, base_cloth::Settings>();
}

rumple_base_cloth_swing rumple_base_cloth_swing_default(void) {
    auto swing = default_of<rumple_base_cloth_swing, base_cloth::Swing>();
    for (int k = 0; k < 3; ++k) swing.matrix[4 * k] = 1.0f;
    return swing;
}

rumple_status rumple_base_cloth_paint_build(const rumple_base_cloth* model,
                                            const rumple_base_cloth_painted* painted,
                                            rumple_base_cloth_paint** paint) {
    return made(paint, "paint", [&] {
        const Surface& base = given(model, "model").model->surface;
        const rumple_base_cloth_painted& from = given(painted, "painted");
        base_cloth::Paint made;
        made.follow = api::painted(from.follow, from.follow_count, base, "follow");
        made.room = api::painted(from.room, from.room_count, base, "room", 0.0, base_cloth::kMostRoomFactor);
        return new rumple_base_cloth_paint{model->model, std::move(made)};
    });
}

void rumple_base_cloth_paint_free(rumple_base_cloth_paint* paint) {
    delete paint;
}

void rumple_base_cloth_state_free(rumple_base_cloth_state* state) {
    delete state;
}

rumple_status rumple_base_cloth_state_get_view(const rumple_base_cloth_state* state,
                                               rumple_base_cloth_state_view* view) {
    return guarded([&] {
        const base_cloth::Result& r = given(state, "state").result;
        given(view, "view") = {.vertex_count = count(r.positions),
                               .welded_vertex_count = state->model->surface.welded.vertex_count,
                               .body_hint_count = count(r.body_hint),
                               .velocity_count = count(r.state.motion.velocity),
                               .offset_count = count(r.state.offset),
                               .clearance_count = count(r.state.clearance),
                               .bytes = r.state.bytes(),
                               .positions = flat<float>(r.positions),
                               .gap = r.gap.data(),
                               .body_hint = r.body_hint.data(),
                               .velocity = flat<float>(r.state.motion.velocity),
                               .offset = flat<float>(r.state.offset),
                               .clearance = r.state.clearance.data()};
    });
}

rumple_status rumple_base_cloth_state_get_kept(const rumple_base_cloth_state* state,
                                               rumple_base_cloth_kept* kept) {
    return guarded([&] { given(kept, "kept") = kept_of(given(state, "state").result.state); });
}

rumple_status rumple_base_cloth_state_build(const rumple_base_cloth* model,
                                            const rumple_base_cloth_kept* kept,
                                            rumple_base_cloth_state** state) {
    return made(state, "state", [&] {
        const rumple_base_cloth& m = given(model, "model");
        base_cloth::Result result;
        result.state = state_of(*m.model, given(kept, "kept"));
        return new rumple_base_cloth_state{m.model, std::move(result)};
    });
}

rumple_status rumple_base_cloth_state_activated(const rumple_base_cloth_state* state,
                                                rumple_base_cloth_state** activated) {
    return made(activated, "activated", [&] {
        base_cloth::Result result = given(state, "state").result;
        result.state = base_cloth::activated(std::move(result.state));
        return new rumple_base_cloth_state{state->model, std::move(result)};
    });
}

rumple_status rumple_base_cloth_solve(const rumple_base_cloth* model,
                                      const rumple_base_cloth_settings* settings,
                                      const rumple_base_cloth_paint* paint, const float* positions,
                                      size_t positions_count, const rumple_bodies* bodies,
                                      const rumple_base_cloth_state* before, rumple_base_cloth_report* report,
                                      rumple_base_cloth_state** state) {
    return made(state, "state", [&] {
        const rumple_base_cloth& m = given(model, "model");
        const auto options = native_of<base_cloth::Settings>(settings, "settings");
        const auto points = vectors(positions, positions_count, "positions");
        const auto worn_over = posed(bodies);
        const auto painted = paint_in(of_model(paint, m, "paint"));
        auto solved = sound_from(state_in(of_model(before, m, "state")), [&](const base_cloth::State* from) {
            return base_cloth::solve(*m.model, options, painted, points, worn_over ? &*worn_over : nullptr,
                                     from);
        });
        if (report) *report = report_of(solved.report);
        return new rumple_base_cloth_state{m.model, std::move(solved)};
    });
}

rumple_status rumple_base_cloth_swing_solve(
    const rumple_base_cloth* model, const rumple_base_cloth_settings* settings,
    const rumple_base_cloth_swing* swing, const rumple_base_cloth_paint* paint, const float* positions,
    size_t positions_count, const rumple_bodies* bodies, const rumple_base_cloth_state* before,
    rumple_base_cloth_report* report, rumple_base_cloth_state** state) {
    return made(state, "state", [&] {
        const rumple_base_cloth& m = given(model, "model");
        const auto options = native_of<base_cloth::Settings>(settings, "settings");
        auto motion = native_of<base_cloth::Swing>(swing, "swing");
        motion.placement.matrix = matrix_of(swing->matrix);
        motion.air = vectors(swing->air, swing->air_count, "air");
        motion.push = vectors(swing->push, swing->push_count, "push");
        motion.resist = rows<Vec2>(swing->resist, swing->resist_count, "resist");
        const auto points = vectors(positions, positions_count, "positions");
        const auto worn_over = posed(bodies);
        const auto painted = paint_in(of_model(paint, m, "paint"));
        auto solved = sound_from(state_in(of_model(before, m, "state")), [&](const base_cloth::State* from) {
            return base_cloth::solve_swing(*m.model, options, motion, painted, points,
                                           worn_over ? &*worn_over : nullptr, from);
        });
        if (report) *report = report_of(solved.report);
        return new rumple_base_cloth_state{m.model, std::move(solved)};
    });
}
