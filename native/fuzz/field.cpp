// SPDX-License-Identifier: GPL-3.0-or-later
// The Wrinkle Field: frames, and the steps of a frame.
#include "field.h"

#include "damage.h"

namespace rumple::fuzz {
namespace {

void build_model(World& world, Bytes& bytes) {
    const auto base = world.surfaces.pick(bytes);
    rumple_wrinkle_field_plan plan = CALL(rumple_wrinkle_field_plan_default);
    plan.output = bytes.whole(0, 1);
    plan.fine = fine_plan(plan.fine, bytes);
    plan.true_lengths = bytes.byte() % 4 != 3;
    const Floats uv(values(base.base ? size_t(base.base->corners) * 2 : 6, 0.0f, 1.0f, bytes), 2, bytes);
    plan.uv = uv.pointer;
    plan.uv_count = bytes.byte() % 2 == 1 ? uv.count : 0;
    const auto* model = world.fields.add(
        MAKE(rumple_wrinkle_field, rumple_wrinkle_field_build, base.handle, &plan), base.base, 0);
    rumple_wrinkle_field_view view;
    if (!model || CALL(rumple_wrinkle_field_get_view, model->handle, &view) != RUMPLE_OK) return;
    const auto welded = size_t(view.vertex_count);
    expect_starts("neighbours", view.neighbour_start, welded + 1, view.neighbour_count);
    expect_within("neighbour", view.neighbours, size_t(view.neighbour_count), 0, view.vertex_count - 1);
    expect_within("field triangle", view.triangles, 3 * size_t(view.triangle_count), 0,
                  view.vertex_count - 1);
    expect_finite("gradient", view.gradients, 2 * size_t(view.neighbour_count));
    expect_finite("tangent", view.tangent_rest, 3 * welded);
    expect_finite("bitangent", view.bitangent_rest, 3 * welded);
    expect_finite("first direction", view.first_directions, 2 * welded);
    check_shown(CALL(rumple_wrinkle_field_shown, model->handle), bytes);
}

void build_paint(World& world, Bytes& bytes) {
    const auto model = world.fields.pick(bytes);
    const auto vertices = model.base ? size_t(model.base->vertices) : 3;
    const std::vector<float> mask = values(vertices, 0.0f, 1.0f, bytes),
                             wavelength = values(vertices, 0.5f, 2.0f, bytes),
                             wrinkle = values(3 * vertices, -0.5f, 0.5f, bytes),
                             along = values(3 * vertices, -0.57f, 0.57f, bytes);
    const auto count = [&] { return bytes.byte() % 2 == 0 ? 0 : bytes.hostile() ? vertices / 2 : vertices; };
    rumple_wrinkle_field_painted painted{mask.data(),    count(), wavelength.data(), count(),
                                         wrinkle.data(), count(), along.data(),      count()};
    world.field_paints.add(
        MAKE(rumple_wrinkle_field_paint, rumple_wrinkle_field_paint_build, model.handle, &painted),
        model.base, model.model);
}

void build_pose(World& world, Bytes& bytes) {
    const auto model = world.fields.pick(bytes);
    const Posed posed(model.base ? *model.base : Base(), bytes);
    world.field_poses.add(
        MAKE(rumple_wrinkle_field_pose, rumple_wrinkle_field_pose_build, model.handle, &posed.pose),
        model.base, model.model);
}

void keep_state(World& world, rumple_wrinkle_field_state* state, const std::shared_ptr<const Base>& base,
                int model) {
    rumple_wrinkle_field_state_view view;
    const auto* kept = world.field_states.add(state, base, model);
    if (!kept || CALL(rumple_wrinkle_field_state_get_view, kept->handle, &view) != RUMPLE_OK) return;
    expect_finite("phase", view.phase, view.phase_count);
    expect_finite("direction", view.direction, 2 * view.direction_count);
    check_reference(view.reference);
}

void solve(World& world, Bytes& bytes) {
    const auto model = world.fields.pick(bytes);
    if (bytes.byte() % 4 != 3) build_pose(world, bytes);
    const auto pose = world.field_poses.pick_of(model.model, bytes);
    const auto paint = world.field_paints.pick_of(model.model, bytes);
    const auto before = world.field_states.pick_of(model.model, bytes);
    const auto settings = field_settings(bytes);
    rumple_wrinkle_field_report report;
    rumple_waves* waves = nullptr;
    auto* state = MAKE(rumple_wrinkle_field_state, rumple_wrinkle_field_solve, model.handle, &settings,
                       paint.handle, pose.handle, before.handle, &report, &waves);
    world.waves.add(waves, model.base, model.model);
    expect_of_model(state ? RUMPLE_OK : RUMPLE_INVALID, model.model, "field", pose, paint, before);
    if (state) expect_finite("field report", &report.misfit_before, 3);
    keep_state(world, state, model.base, model.model);
}

void show(World& world, Bytes& bytes) {
    const auto model = world.fields.pick(bytes);
    const auto pose = world.field_poses.pick_of(model.model, bytes);
    const auto paint = world.field_paints.pick_of(model.model, bytes);
    const auto state = world.field_states.pick_of(model.model, bytes);
    const auto settings = field_settings(bytes);
    const auto profile = field_profile(bytes);
    const Floats gap(values(model.base ? size_t(model.base->vertices) : 3, 0.0f, 0.2f, bytes), 1, bytes);
    const std::uint8_t given = bytes.byte();
    const rumple_waves* estimated = given % 4 == 3 ? world.waves.newest_of(model.model).handle : nullptr;
    auto* frame =
        MAKE(rumple_frame, rumple_wrinkle_field_show, model.handle, &settings, &profile, paint.handle,
             pose.handle, gap.pointer, given % 2 == 1 ? gap.count : 0, estimated, state.handle);
    expect_of_model(frame ? RUMPLE_OK : RUMPLE_INVALID, model.model, "field", pose, paint, state);
    rumple_frame_waves_view waves;
    if (frame && CALL(rumple_frame_get_waves, frame, &waves) == RUMPLE_OK) {
        const auto vertices = size_t(waves.vertex_count), corners = 3 * size_t(waves.corner_count);
        expect_finite("amplitude", waves.amplitude, vertices);
        expect_finite("shown direction", waves.direction, 3 * vertices);
        expect_finite("shown phase", waves.phase, vertices);
        for (const float* of_corners : {waves.corner_phase, waves.corner_weight, waves.corner_wave_vector_0,
                                        waves.corner_wave_vector_1, waves.corner_wave_vector_2})
            expect_finite("corner", of_corners, corners);
        expect_finite("u gradient", waves.corner_u_gradient, 3 * size_t(waves.uv_count));
        expect_finite("v gradient", waves.corner_v_gradient, 3 * size_t(waves.uv_count));
    }
    add_frame(world, frame, model.base, model.model);
}

void restore(World& world, Bytes& bytes) {
    const auto from = world.field_states.pick(bytes);
    const auto model = world.fields.pick(bytes);
    rumple_wrinkle_field_state_view view{};
    if (CALL(rumple_wrinkle_field_state_get_view, from.handle, &view) != RUMPLE_OK) return;
    static_assert(sizeof view == 16 * 8, "a new array? damage it as well");
    Damage damage(bytes);
    damage(view.phase, view.phase_count);
    damage(view.direction, view.direction_count, 2);
    damage(view.solved_offset, view.solved_offset_count);
    damage(view.reference);
    keep_state(world, MAKE(rumple_wrinkle_field_state, rumple_wrinkle_field_state_build, model.handle, &view),
               model.base, model.model);
}

void activate(World& world, Bytes& bytes) {
    const auto state = world.field_states.pick(bytes);
    auto* activated = MAKE(rumple_wrinkle_field_state, rumple_wrinkle_field_state_activated, state.handle);
    world.field_states.add(activated, state.base, state.model);
}

void label(World& world, Bytes& bytes) {
    const auto model = world.fields.pick(bytes);
    const Clip clip(model.base ? *model.base : Base(), bytes);
    const auto settings = field_settings(bytes);
    clip.check(CALL(rumple_wrinkle_field_label_clip, model.handle, &settings, clip.times.pointer,
                    clip.times.count, clip.positions.pointer, clip.positions.count, bytes.byte() % 2 == 1,
                    clip.out(), clip.labels.size()));
}

void free_one(World& world, Bytes& bytes) {
    free_one_of(bytes, world.fields, world.field_paints, world.field_poses, world.field_states);
}

}  // namespace

rumple_wrinkle_field_settings field_settings(Bytes& bytes) {
    rumple_wrinkle_field_settings s = CALL(rumple_wrinkle_field_settings_default);
    s.wavelength = 0.3f;
    bytes.vary(s.wavelength, s.strength, s.keep_length, s.rate, s.rounds, s.start_rounds, s.irregularity,
               s.bend_radius, s.seed, s.aligned_start, s.threads, s.dissolve, s.buckling_threshold);
    if (bytes.byte() % 4 == 3) vary(s.rest, bytes);
    return s;
}

rumple_wrinkle_field_profile field_profile(Bytes& bytes) {
    rumple_wrinkle_field_profile profile{};
    const Floats drawn(values(RUMPLE_PROFILE_INTERVALS + 1, -1.0f, 1.0f, bytes), 1, bytes);
    CALL(rumple_wrinkle_field_profile_build, bytes.whole(0, 3), drawn.pointer, drawn.count, &profile);
    expect_finite("profile", profile.height, 130);
    if (bytes.hostile()) profile.height[bytes.below(65)] = bytes.real(-1.0f, 1.0f);
    return profile;
}

const std::vector<Operation> kField = {build_model, build_pose, solve,    solve, show,
                                       build_paint, restore,    activate, label, free_one};

}  // namespace rumple::fuzz
