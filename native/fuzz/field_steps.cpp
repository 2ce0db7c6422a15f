// SPDX-License-Identifier: GPL-3.0-or-later
// The steps of a frame of the Wrinkle Field, and its brush.
#include "field.h"

namespace rumple::fuzz {
namespace {

std::vector<float> posed(const Entry<rumple_wrinkle_field>& model, Bytes& bytes) {
    return model.base ? pose_of(model.base->rest, bytes) : std::vector<float>(9);
}
size_t welded(const Entry<rumple_wrinkle_field>& model) {
    return model.base ? size_t(model.base->welded) : 3;
}

void estimate_waves(World& world, Bytes& bytes) {
    const auto model = world.fields.pick(bytes);
    const auto paint = world.field_paints.pick_of(model.model, bytes);
    const auto state = world.field_states.pick_of(model.model, bytes);
    const auto settings = field_settings(bytes);
    const auto profile = field_profile(bytes);
    const Floats positions(posed(model, bytes), 3, bytes);
    rumple_waves* waves =
        bytes.byte() % 2 == 0
            ? MAKE(rumple_waves, rumple_wrinkle_field_estimate_waves, model.handle, &settings, paint.handle,
                   positions.pointer, positions.count, state.handle)
            : MAKE(rumple_waves, rumple_wrinkle_field_shown_waves, model.handle, &settings, &profile,
                   paint.handle, positions.pointer, positions.count, state.handle);
    expect_of_model(waves ? RUMPLE_OK : RUMPLE_INVALID, model.model, "waves", paint, state);
    const auto* kept = world.waves.add(waves, model.base, model.model);
    rumple_waves_view view;
    if (!kept || CALL(rumple_waves_get_view, kept->handle, &view) != RUMPLE_OK) return;
    const auto count = size_t(view.vertex_count);
    for (const float* of_three : {view.positions, view.normals, view.wave_vector})
        expect_finite("waves", of_three, 3 * count);
    for (const float* of_one : {view.height, view.fullness, view.compression, view.gather})
        expect_finite("waves", of_one, count);
    expect_finite("waves", view.direction, 2 * count);
}

void parameters(World& world, Bytes& bytes) {
    const auto model = world.fields.pick(bytes);
    const auto paint = world.field_paints.pick_of(model.model, bytes);
    const auto settings = field_settings(bytes);
    const size_t count = welded(model);
    Written wavelength(count, 1, bytes), mask(count, 1, bytes), wrinkle(count, 2, bytes),
        turn(count, 2, bytes);
    const rumple_wrinkle_field_wave_parameters out{wavelength.pointer(), mask.pointer(), wrinkle.pointer(),
                                                   turn.pointer(), wavelength.count};
    const rumple_status status =
        CALL(rumple_wrinkle_field_get_wave_parameters, model.handle, &settings, paint.handle, &out);
    for (const Written* written : {&wavelength, &mask, &wrinkle, &turn}) written->check(status, "parameters");
}

void weld(World& world, Bytes& bytes) {
    const auto model = world.fields.pick(bytes);
    const auto state = world.field_states.pick_of(model.model, bytes);
    const Floats positions(posed(model, bytes), 3, bytes);
    Written at(welded(model), 3, bytes), normals(welded(model), 3, bytes), stretches(welded(model), 3, bytes);
    const rumple_status status = CALL(rumple_wrinkle_field_weld_pose, model.handle, positions.pointer,
                                      positions.count, at.pointer(), normals.pointer(), at.count);
    at.check(status, "welded");
    normals.check(status, "normals");
    bool adapts = false;
    stretches.check(CALL(rumple_wrinkle_field_stretches, model.handle, state.handle, positions.pointer,
                         positions.count, stretches.pointer(), stretches.count, &adapts),
                    "stretches");
}

void relax(World& world, Bytes& bytes) {
    const auto model = world.fields.pick(bytes);
    const auto waves = world.waves.pick_of(model.model, bytes);
    const auto settings = field_settings(bytes);
    Written phase(welded(model), 1, bytes);
    CALL(rumple_wrinkle_field_random_phases, model.handle, bytes.byte(), phase.pointer(), phase.count);
    if (bytes.hostile() && phase.count > 0) phase.data[0] = bytes.real(-3.0f, 3.0f);
    const rumple_status relaxed =
        CALL(rumple_wrinkle_field_relax, model.handle, &settings, waves.handle, bytes.whole(0, 6),
             bytes.byte() % 2 == 1, phase.pointer(), phase.count);
    expect_of_model(relaxed, model.model, "relax", waves);
    if (relaxed == RUMPLE_OK) expect_finite("relaxed", phase.data.data(), phase.count);
    float misfit = 0.0f;
    if (CALL(rumple_wrinkle_field_misfit, model.handle, waves.handle, phase.pointer(), phase.count,
             &misfit) == RUMPLE_OK)
        expect_finite("misfit", &misfit, 1);
    const auto profile = field_profile(bytes);
    std::vector<std::int32_t> triangles;
    for (int k = 0; k < 3; ++k) triangles.push_back(bytes.whole(0, 3));
    const std::vector<float> places = values(6, 0.0f, 0.5f, bytes);
    Written heights(3, 1, bytes), gradients(3, 3, bytes);
    const rumple_status status =
        CALL(rumple_wrinkle_field_evaluate, model.handle, waves.handle, &profile, phase.pointer(),
             phase.count, triangles.data(), places.data(), 3, heights.pointer(), gradients.pointer());
    heights.check(status, "heights");
    gradients.check(status, "gradients");
}

// Calls any formula with any numbers. Every result is allowed, but it must return.
void probe(World&, Bytes& bytes) {
    const std::vector<float> arguments = values(16, -2.0f, 2.0f, bytes);
    float out[16];
    CALL(rumple_probe_formula, bytes.whole(0, 20), arguments.data(), 1, out);
}

// ---- the brush

void build_canvas(World& world, Bytes& bytes) {
    const auto model = world.fields.pick(bytes);
    const Floats positions(posed(model, bytes), 3, bytes);
    world.canvases.add(
        MAKE(rumple_canvas, rumple_canvas_build, model.handle, positions.pointer, positions.count),
        model.base, model.model);
    std::int32_t found = 0;
    world.twins.add(MAKE(rumple_twins, rumple_twins_build, model.handle, &found), model.base, model.model);
}

void dab(World& world, Bytes& bytes) {
    const auto canvas = world.canvases.pick(bytes);
    const auto twins = world.twins.pick_of(canvas.model, bytes);
    rumple_dab d = CALL(rumple_dab_default);
    d.view[2] = d.normal[2] = 1.0f;
    d.direction[0] = 1.0f;
    d.radius = 1.0f;
    bytes.vary(d.touch, d.centre, d.normal, d.view, d.direction, d.across, d.radius, d.strength, d.length,
               d.falloff);
    std::vector<float> painted =
        values(canvas.base ? 3 * size_t(canvas.base->vertices) : 9, -0.3f, 0.3f, bytes);
    const size_t count = painted.size() / 3 - (bytes.hostile() ? 1 : 0);
    const std::vector<float> before = painted;
    const rumple_status status =
        CALL(rumple_dab_apply, canvas.handle, &d, twins.handle, painted.data(), count);
    expect_of_model(status, canvas.model, "dab", twins);
    if (status == RUMPLE_OK) expect_finite("painted", painted.data(), painted.size());
    auto* lines =
        MAKE(rumple_lines, rumple_canvas_draw, canvas.handle, painted.data(), count, bytes.byte() % 2 == 1);
    const auto* kept = world.lines.add(lines, canvas.base, canvas.model);
    rumple_lines_view view;
    if (!kept || CALL(rumple_lines_get_view, kept->handle, &view) != RUMPLE_OK) return;
    expect_finite("line", view.ends, 6 * size_t(view.line_count));
    expect_finite("line strength", view.strength, size_t(view.line_count));
}

void scatter(World& world, Bytes& bytes) {
    const auto model = world.fields.pick(bytes);
    rumple_scatter settings = CALL(rumple_scatter_default);
    bytes.vary(settings.seed, settings.density, settings.size, settings.length);
    Written painted(model.base ? size_t(model.base->vertices) : 3, 3, bytes);
    painted.check(CALL(rumple_scatter_paint, model.handle, &settings, painted.pointer(), painted.count),
                  "scattered");
}

void free_one(World& world, Bytes& bytes) {
    free_one_of(bytes, world.canvases, world.twins, world.lines, world.waves);
}

}  // namespace

const std::vector<Operation> kBrush = {estimate_waves, relax, build_canvas, dab,     scatter,
                                       parameters,     weld,  probe,        free_one};

}  // namespace rumple::fuzz
