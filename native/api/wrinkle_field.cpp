// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/wrinkle_field.h"

#include <algorithm>

#include "api/sound.h"
#include "base/expect.h"
#include "base/tolerances.h"

using namespace rumple;
using namespace rumple::api;
using namespace rumple::wrinkle_field;

// Limits for the values of a given state. Solved states have phases up to half a turn, and unit directions.
constexpr double kMostPhase = 1e3;
constexpr double kMostDirection = 2.0;

static_assert(kProfileIntervals == RUMPLE_PROFILE_INTERVALS);
static_assert(sizeof(Profile) == sizeof(rumple_wrinkle_field_profile));

// Lists all fields once, for both directions: see api/settings.h.
template <typename Pair>
static void pair_fields(rumple_wrinkle_field_settings& c, Settings& native, const Pair& pair) {
    pair(c.wavelength, native.wavelength);
    pair(c.strength, native.strength);
    pair(c.buckling_threshold, native.buckling_threshold);
    pair(c.keep_length, native.keep_length);
    pair(c.rate, native.rate);
    pair(c.rounds, native.rounds);
    pair(c.start_rounds, native.start_rounds);
    pair(c.irregularity, native.irregularity);
    pair(c.bend_radius, native.bend_radius);
    pair(c.seed, native.seed);
    pair(c.aligned_start, native.aligned_start);
    pair(c.threads, native.threads);
    pair(c.dissolve, native.dissolve);
    pair_reference(c.rest, native.rest, pair);
}

rumple_wrinkle_field::rumple_wrinkle_field(std::shared_ptr<const Model> built)
    : model(std::move(built)),
      shown(model->shown),
      first_directions(wrinkle_field::first_directions(*model)) {
    for (const Model::Neighbour& n : model->neighbours) {
        neighbours.push_back(n.vertex);
        gradients.push_back(n.gradient);
    }
    for (const Triangle& triangle : model->base.triangles) {
        for (const Index corner : triangle.corner)
            triangles.push_back(model->base.welded.corner_vertex[corner]);
    }
}

namespace rumple::api {

Settings field_settings(const rumple_wrinkle_field_settings* settings) {
    return native_of<Settings>(settings, "settings");
}

Profile profile_in(const rumple_wrinkle_field_profile* profile) {
    Profile out;
    std::copy_n(given(profile, "profile").height, out.height.size(), out.height.begin());
    std::copy_n(profile->slope, out.slope.size(), out.slope.begin());
    expect_range("profile height", out.height, -1.001, 1.001);  // 1, with rounding errors
    expect_range("profile slope", out.slope, -1e3, 1e3);
    return out;
}

const Paint& paint_in(const rumple_wrinkle_field& model, const rumple_wrinkle_field_paint* paint) {
    static const Paint nothing;
    const auto* of = of_model(paint, model, "paint");
    return of ? of->paint : nothing;
}

}  // namespace rumple::api

// ---- the model

rumple_wrinkle_field_plan rumple_wrinkle_field_plan_default(void) {
    rumple_wrinkle_field_plan plan{};
    const Plan native;
    plan.output = int32_t(native.output);
    plan.fine = fine_plan(native.fine);
    plan.true_lengths = native.true_lengths;
    return plan;
}

rumple_status rumple_wrinkle_field_build(const rumple_surface* base, const rumple_wrinkle_field_plan* plan,
                                         rumple_wrinkle_field** model) {
    return made(model, "model", [&] {
        const Surface& surface = given(base, "base").surface;
        const rumple_wrinkle_field_plan& from = given(plan, "plan");
        Plan native;
        native.output = choice(from.output, Output::kGeometry, "output");
        native.fine = fine_source(from.fine);
        native.attachment = attachment_kind(from.fine);
        native.uv = rows<Vec2>(from.uv, from.uv_count, "uv");
        native.true_lengths = from.true_lengths;
        return new rumple_wrinkle_field(build(surface, native));
    });
}

void rumple_wrinkle_field_free(rumple_wrinkle_field* model) {
    delete model;
}

const rumple_shown_mesh* rumple_wrinkle_field_shown(const rumple_wrinkle_field* model) {
    return model ? &model->shown : nullptr;
}

rumple_status rumple_wrinkle_field_get_view(const rumple_wrinkle_field* model,
                                            rumple_wrinkle_field_view* view) {
    return guarded([&] {
        const rumple_wrinkle_field& h = given(model, "model");
        const Model& m = *h.model;
        given(view, "view") = {.vertex_count = count(m.base.positions_rest),
                               .neighbour_count = count(h.neighbours),
                               .base_vertex_count = m.base.display.vertex_count,
                               .triangle_count = count(m.base.triangles),
                               .uv_count = count(m.uv),
                               .neighbour_start = m.neighbour_start.data(),
                               .neighbours = h.neighbours.data(),
                               .gradients = flat<float>(h.gradients),
                               .tangent_rest = flat<float>(m.tangent_rest),
                               .bitangent_rest = flat<float>(m.bitangent_rest),
                               .welded_of = m.base.welded_of.data(),
                               .triangles = h.triangles.data(),
                               .uv = flat<float>(m.uv),
                               .uv_fan = m.uv_fan.data(),
                               .first_directions = flat<float>(h.first_directions)};
    });
}

// ---- settings and paint

rumple_wrinkle_field_settings rumple_wrinkle_field_settings_default(void) {
    return default_of<rumple_wrinkle_field_settings, Settings>();
}

rumple_status rumple_wrinkle_field_profile_build(int32_t kind, const float* drawn_height, size_t drawn_count,
                                                 rumple_wrinkle_field_profile* profile) {
    return guarded([&] {
        constexpr Profile (*kMade[])() = {sine, accordion, pencil_pleats};
        const bool is_drawn = choice(kind, RUMPLE_PROFILE_CURVE, "kind") == RUMPLE_PROFILE_CURVE;
        const Profile made = is_drawn ? drawn(values(drawn_height, drawn_count, "height")) : kMade[kind]();
        rumple_wrinkle_field_profile& out = given(profile, "profile");
        std::copy(made.height.begin(), made.height.end(), out.height);
        std::copy(made.slope.begin(), made.slope.end(), out.slope);
    });
}

rumple_status rumple_wrinkle_field_paint_build(const rumple_wrinkle_field* model,
                                               const rumple_wrinkle_field_painted* painted,
                                               rumple_wrinkle_field_paint** paint) {
    return made(paint, "paint", [&] {
        const Surface& base = given(model, "model").model->base;
        const rumple_wrinkle_field_painted& from = given(painted, "painted");
        Paint made;
        made.mask = api::painted(from.mask, from.mask_count, base, "mask", 0.0, kMostPainted);
        made.wavelength = api::painted(from.wavelength, from.wavelength_count, base, "wavelength",
                                       kLeastPaintedWavelength, kMostPainted);
        made.rest_wrinkle = copied(vectors(from.rest_wrinkle, from.rest_wrinkle_count, "rest_wrinkle"));
        if (!made.rest_wrinkle.empty()) check_rest_wrinkle(*model->model, made.rest_wrinkle);
        made.along = copied(vectors(from.along, from.along_count, "along"));
        if (!made.along.empty()) check_along(base, made.along);
        return new rumple_wrinkle_field_paint{model->model, std::move(made)};
    });
}

void rumple_wrinkle_field_paint_free(rumple_wrinkle_field_paint* paint) {
    delete paint;
}

// ---- frames

void rumple_wrinkle_field_state_free(rumple_wrinkle_field_state* state) {
    delete state;
}

rumple_status rumple_wrinkle_field_state_get_view(const rumple_wrinkle_field_state* state,
                                                  rumple_wrinkle_field_state_view* view) {
    return guarded([&] {
        const State& s = given(state, "state").state;
        const size_t bytes = (s.phase.size() + s.solved_offset.size()) * sizeof(float) +
                             s.direction.size() * sizeof(Vec2) + s.reference.bytes();
        given(view, "view") = {
            s.phase.data(),         s.phase.size(),         flat<float>(s.direction), s.direction.size(),
            s.solved_offset.data(), s.solved_offset.size(), view_of(s.reference),     bytes};
    });
}

rumple_status rumple_wrinkle_field_state_build(const rumple_wrinkle_field* model,
                                               const rumple_wrinkle_field_state_view* arrays,
                                               rumple_wrinkle_field_state** state) {
    return made(state, "state", [&] {
        const rumple_wrinkle_field& m = given(model, "model");
        const rumple_wrinkle_field_state_view& from = given(arrays, "arrays");
        expect_rows("phase", from.phase_count, m.model->base.positions_rest.size());
        expect_rows("direction", from.direction_count, m.model->base.positions_rest.size());
        expect_rows_or_none("solved_offset", from.solved_offset_count, m.neighbours.size());
        State read{copied(values(from.phase, from.phase_count, "phase")),
                   copied(rows<Vec2>(from.direction, from.direction_count, "direction")),
                   copied(values(from.solved_offset, from.solved_offset_count, "solved_offset")),
                   state_of(from.reference)};
        expect_finite<float>("phase", read.phase, "vertex");
        expect_finite<Vec2>("direction", read.direction, "vertex");
        expect_range("phase", read.phase, -kMostPhase, kMostPhase);
        expect_range("direction", floats_of(read.direction), -kMostDirection, kMostDirection);
        expect_numbers("solved_offset", read.solved_offset);
        if (!read.reference.empty()) check_reference(m.model->base, read.reference);
        return new rumple_wrinkle_field_state{m.model, std::move(read)};
    });
}

rumple_status rumple_wrinkle_field_state_activated(const rumple_wrinkle_field_state* state,
                                                   rumple_wrinkle_field_state** activated) {
    return made(activated, "activated", [&] {
        const State& from = given(state, "state").state;
        return new rumple_wrinkle_field_state{state->model, wrinkle_field::activated(from)};
    });
}

rumple_status rumple_wrinkle_field_pose_build(const rumple_wrinkle_field* model, const rumple_pose* frame,
                                              rumple_wrinkle_field_pose** pose) {
    return made_pose(model, frame, pose,
                     [](const auto& m, const auto& arrays) { return make_pose(m, arrays.positions); });
}

void rumple_wrinkle_field_pose_free(rumple_wrinkle_field_pose* pose) {
    delete pose;
}

rumple_status rumple_wrinkle_field_solve(const rumple_wrinkle_field* model,
                                         const rumple_wrinkle_field_settings* settings,
                                         const rumple_wrinkle_field_paint* paint,
                                         const rumple_wrinkle_field_pose* pose,
                                         const rumple_wrinkle_field_state* before,
                                         rumple_wrinkle_field_report* report, rumple_waves** waves,
                                         rumple_wrinkle_field_state** state) {
    return made(state, "state", [&] {
        const rumple_wrinkle_field& m = given(model, "model");
        const auto* from = of_model(before, m, "state");
        const auto& at = given_of_model(pose, m, "pose");
        Report how;
        Waves field;
        State solved = sound_from(from ? &from->state : nullptr, [&](const State* last) {
            return solve(*m.model, field_settings(settings), paint_in(m, paint), at.pose, last, how,
                         at.arrays.frame_time(), &field);
        });
        if (report) {
            *report = {how.rounds,         how.misfit_before, how.misfit_after,
                       how.largest_change, how.wrinkled,      how.collapsed};
        }
        std::unique_ptr<rumple_wrinkle_field_state> made_state(
            new rumple_wrinkle_field_state{m.model, std::move(solved)});
        // Waves that are not finite are not returned. show() refuses such a frame.
        if (waves) *waves = is_sound(field) ? new rumple_waves{m.model, std::move(field)} : nullptr;
        return made_state.release();
    });
}

rumple_status rumple_wrinkle_field_show(const rumple_wrinkle_field* model,
                                        const rumple_wrinkle_field_settings* settings,
                                        const rumple_wrinkle_field_profile* profile,
                                        const rumple_wrinkle_field_paint* paint,
                                        const rumple_wrinkle_field_pose* pose, const float* gap,
                                        size_t gap_count, const rumple_waves* waves,
                                        const rumple_wrinkle_field_state* state, rumple_frame** frame) {
    return made(frame, "frame", [&] {
        const rumple_wrinkle_field& m = given(model, "model");
        const auto& at = given_of_model(pose, m, "pose");
        const auto inwards = values(gap, gap_count, "gap");
        expect_range("gap", inwards, 0.0, kFarthestCoordinate);
        const State& solved = given_of_model(state, m, "state").state;
        const Settings options = field_settings(settings);
        const Profile shape = profile_in(profile);
        const Paint& painted = paint_in(m, paint);
        const auto* estimated = of_model(waves, m, "waves");
        const Waves shown = estimated ? shown_waves(*m.model, options, shape, estimated->waves, solved)
                                      : shown_waves(*m.model, options, shape, painted, at.pose, solved);
        return new_frame(m.model, sound(show(*m.model, shown, shape, at.arrays.positions, solved, inwards)));
    });
}

rumple_status rumple_frame_get_waves(const rumple_frame* frame, rumple_frame_waves_view* view) {
    return guarded([&] {
        const auto* p = std::get_if<Picture>(&given(frame, "frame").picture);
        if (!p) throw InvalidInput("frame: expected one of a Wrinkle Field");
        given(view, "view") = {.vertex_count = count(p->positions),
                               .corner_count = count(p->corner_phase),
                               .uv_count = count(p->corner_u_gradient),
                               .amplitude = p->amplitude.data(),
                               .direction = flat<float>(p->direction),
                               .phase = p->phase.data(),
                               .corner_phase = flat<float>(p->corner_phase),
                               .corner_weight = flat<float>(p->corner_weight),
                               .corner_wave_vector_0 = flat<float>(p->corner_wave_vector[0]),
                               .corner_wave_vector_1 = flat<float>(p->corner_wave_vector[1]),
                               .corner_wave_vector_2 = flat<float>(p->corner_wave_vector[2]),
                               .corner_u_gradient = flat<float>(p->corner_u_gradient),
                               .corner_v_gradient = flat<float>(p->corner_v_gradient)};
    });
}

rumple_status rumple_wrinkle_field_label_clip(const rumple_wrinkle_field* model,
                                              const rumple_wrinkle_field_settings* settings,
                                              const double* times, size_t times_count, const float* positions,
                                              size_t positions_count, bool raw, uint8_t* labels,
                                              size_t labels_count) {
    return guarded([&] {
        const Model& m = *given(model, "model").model;
        label(m.base, m.triangles, field_settings(settings).rest,
              {times, times_count, positions, positions_count, raw}, labels, labels_count);
    });
}
