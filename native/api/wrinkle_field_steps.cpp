// SPDX-License-Identifier: GPL-3.0-or-later
// The steps of a frame of the Wrinkle Field.
#include <algorithm>
#include <glm/gtc/type_ptr.hpp>

#include "api/sound.h"
#include "api/wrinkle_field.h"
#include "base/expect.h"

using namespace rumple;
using namespace rumple::api;
using namespace rumple::wrinkle_field;

namespace {

size_t welded_count(const rumple_wrinkle_field& model) {
    return model.model->base.positions_rest.size();
}

const Waves& waves_in(const rumple_waves* waves, const rumple_wrinkle_field& model) {
    return given_of_model(waves, model, "waves").waves;
}

}  // namespace

void rumple_waves_free(rumple_waves* waves) {
    delete waves;
}

rumple_status rumple_waves_get_view(const rumple_waves* waves, rumple_waves_view* view) {
    return guarded([&] {
        const Waves& w = given(waves, "waves").waves;
        given(view, "view") = {
            count(w.positions),         flat<float>(w.positions), flat<float>(w.normals),
            flat<float>(w.wave_vector), w.height.data(),          w.fullness.data(),
            w.compression.data(),       w.gather.data(),          flat<float>(w.direction)};
    });
}

rumple_status rumple_wrinkle_field_estimate_waves(const rumple_wrinkle_field* model,
                                                  const rumple_wrinkle_field_settings* settings,
                                                  const rumple_wrinkle_field_paint* paint,
                                                  const float* positions, size_t positions_count,
                                                  const rumple_wrinkle_field_state* before,
                                                  rumple_waves** waves) {
    return made(waves, "waves", [&] {
        const rumple_wrinkle_field& m = given(model, "model");
        const auto at = vectors(positions, positions_count, "positions");
        const auto* from = of_model(before, m, "state");
        const Settings options = field_settings(settings);
        const Paint& painted = paint_in(m, paint);
        if (!from)
            return new rumple_waves{m.model, sound(estimate_waves(*m.model, options, painted, at, {}))};
        return new rumple_waves{
            m.model, sound(estimate_waves(*m.model, options, painted, at, from->state.direction,
                                          reference_stretches(*m.model, from->state.reference, at)))};
    });
}

rumple_status rumple_wrinkle_field_shown_waves(const rumple_wrinkle_field* model,
                                               const rumple_wrinkle_field_settings* settings,
                                               const rumple_wrinkle_field_profile* profile,
                                               const rumple_wrinkle_field_paint* paint,
                                               const float* positions, size_t positions_count,
                                               const rumple_wrinkle_field_state* state,
                                               rumple_waves** waves) {
    return made(waves, "waves", [&] {
        const rumple_wrinkle_field& m = given(model, "model");
        return new rumple_waves{
            m.model, sound(shown_waves(*m.model, field_settings(settings), profile_in(profile),
                                       paint_in(m, paint), vectors(positions, positions_count, "positions"),
                                       given_of_model(state, m, "state").state))};
    });
}

rumple_status rumple_wrinkle_field_get_wave_parameters(const rumple_wrinkle_field* model,
                                                       const rumple_wrinkle_field_settings* settings,
                                                       const rumple_wrinkle_field_paint* paint,
                                                       const rumple_wrinkle_field_wave_parameters* asked) {
    return guarded([&] {
        const rumple_wrinkle_field& m = given(model, "model");
        const rumple_wrinkle_field_wave_parameters& out = given(asked, "parameters");
        const size_t n = welded_count(m);
        const auto wavelength = output<float>(out.wavelength, out.count, n, "wavelength");
        const auto mask = output<float>(out.mask, out.count, n, "mask");
        const auto rest_wrinkle = output<Vec2>(out.rest_wrinkle, out.count, n, "rest_wrinkle");
        const auto turn = output<Vec2>(out.turn, out.count, n, "turn");
        const WaveParameters found = wave_parameters(*m.model, field_settings(settings), paint_in(m, paint));
        write(found.wavelength, wavelength);
        write(found.mask, mask);
        write(found.rest_wrinkle, rest_wrinkle);
        write(found.turn, turn);
    });
}

rumple_status rumple_wrinkle_field_weld_pose(const rumple_wrinkle_field* model, const float* positions,
                                             size_t positions_count, float* welded, float* normals,
                                             size_t welded_count_) {
    return guarded([&] {
        const rumple_wrinkle_field& m = given(model, "model");
        const auto points = output<Vec3>(welded, welded_count_, welded_count(m), "welded");
        const auto directions = output<Vec3>(normals, welded_count_, welded_count(m), "normals");
        const Pose pose = weld_pose(*m.model, vectors(positions, positions_count, "positions"));
        write(pose.positions, points);
        write(pose.normals, directions);
    });
}

rumple_status rumple_wrinkle_field_stretches(const rumple_wrinkle_field* model,
                                             const rumple_wrinkle_field_state* state, const float* positions,
                                             size_t positions_count, float* stretches, size_t stretches_count,
                                             bool* adapts) {
    return guarded([&] {
        const rumple_wrinkle_field& m = given(model, "model");
        const auto out = output<Vec3>(stretches, stretches_count, welded_count(m), "stretches");
        const std::vector<Vec3> found =
            reference_stretches(*m.model, given_of_model(state, m, "state").state.reference,
                                vectors(positions, positions_count, "positions"));
        given(adapts, "adapts") = !found.empty();
        write(sound(found), out);
    });
}

rumple_status rumple_wrinkle_field_random_phases(const rumple_wrinkle_field* model, uint32_t seed,
                                                 float* phase, size_t phase_count) {
    return guarded([&] {
        const rumple_wrinkle_field& m = given(model, "model");
        const auto out = output<float>(phase, phase_count, welded_count(m), "phase");
        write(random_phases(*m.model, seed), out);
    });
}

rumple_status rumple_wrinkle_field_relax(const rumple_wrinkle_field* model,
                                         const rumple_wrinkle_field_settings* settings,
                                         const rumple_waves* waves, int32_t rounds, bool align_first,
                                         float* phase, size_t phase_count) {
    return guarded([&] {
        const rumple_wrinkle_field& m = given(model, "model");
        const Waves& over = waves_in(waves, m);
        const Settings options = field_settings(settings);
        check(options);
        expect_within("rounds", rounds, 0, 1e6);
        expect_finite("phase", values<float>(phase, phase_count, "phase"), "vertex");
        const auto out = output<float>(phase, phase_count, welded_count(m), "phase");
        std::vector<float> phases(out.begin(), out.end());
        if (align_first) align(*m.model, options, over, rounds, phases);
        relax(*m.model, options, over, rounds, phases);
        write(sound(std::move(phases)), out);
    });
}

rumple_status rumple_wrinkle_field_misfit(const rumple_wrinkle_field* model, const rumple_waves* waves,
                                          const float* phase, size_t phase_count, float* found) {
    return guarded([&] {
        const rumple_wrinkle_field& m = given(model, "model");
        expect_rows("phase", phase_count, welded_count(m));
        const auto phases = values(phase, phase_count, "phase");
        expect_finite("phase", phases, "vertex");
        given(found, "misfit") = misfit(*m.model, waves_in(waves, m), phases);
    });
}

rumple_status rumple_wrinkle_field_evaluate(const rumple_wrinkle_field* model, const rumple_waves* waves,
                                            const rumple_wrinkle_field_profile* profile, const float* phase,
                                            size_t phase_count, const int32_t* triangles,
                                            const float* barycentric, size_t place_count, float* heights,
                                            float* gradients) {
    return guarded([&] {
        const rumple_wrinkle_field& m = given(model, "model");
        const Waves& over = waves_in(waves, m);
        const Profile shape = profile_in(profile);
        expect_rows("phase", phase_count, welded_count(m));
        const auto phases = values(phase, phase_count, "phase");
        const auto which = values(triangles, place_count, "triangles");
        const auto weights = rows<Vec2>(barycentric, place_count, "barycentric");
        const auto height = output<float>(heights, place_count, place_count, "heights");
        const auto gradient = output<Vec3>(gradients, place_count, place_count, "gradients");
        expect_finite("phase", phases, "vertex");
        expect_finite("barycentric", weights, "place");
        expect_places(which, weights, m.model->base.triangles.size());
        for (size_t i = 0; i < place_count; ++i) {
            const Height at = evaluate(*m.model, over, shape, phases, {which[i], weights[i].x, weights[i].y});
            height[i] = at.height;
            gradient[i] = at.gradient;
        }
    });
}

rumple_status rumple_probe_formula(int32_t formula, const float* arguments, size_t count, float* out) {
    return guarded([&] {
        using Case = std::array<float, 16>;
        const auto in = rows<Case>(arguments, count, "arguments");
        const auto results = output<Case>(out, count, count, "out");
        for (size_t i = 0; i < count; ++i) {
            const glm::mat4 y = formulas::probe_formula(formula, glm::make_mat4(in[i].data()));
            std::copy_n(glm::value_ptr(y), 16, results[i].data());
        }
    });
}
