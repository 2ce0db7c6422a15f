// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/wrinkle_layers.h"

#include "api/sound.h"
#include "api/wrinkle_mesh.h"
#include "base/expect.h"
#include "base/tolerances.h"

using namespace rumple;
using namespace rumple::api;
using namespace rumple::wrinkle_mesh;

namespace {

size_t layer_number(int32_t layer, size_t layers) {
    if (layer < 0 || size_t(layer) >= layers) {
        throw InvalidInput("layer: expected 0 to " + std::to_string(layers - 1) + ", got " +
                           std::to_string(layer));
    }
    return size_t(layer);
}

void scale(std::vector<float>& values, const std::vector<float>& by) {
    if (values.empty()) values.assign(by.size(), 1.0f);
    for (size_t v = 0; v < values.size(); ++v) values[v] *= by[v];
}

// Copies a painted factor of all layers to each layer.
void spread(const Layers& model, const std::vector<float>& base_values, PaintedPart part,
            std::vector<Paint>& layers) {
    if (base_values.empty()) return;
    const std::vector<std::vector<float>> carried = carry_paint(model, base_values);
    for (size_t k = 0; k < layers.size(); ++k) layers[k].*part = carried[k];
}

std::vector<Paint> paint_of(const Layers& model, const rumple_wrinkle_layers_painted& from) {
    std::vector<Paint> layers(model.layers.size());
    const Paint all = mesh_painted(from.all, model.base);
    for (const PaintedPart part : kPaintedParts) spread(model, all.*part, part, layers);
    layers[0].guide = all.guide;
    const auto strength = values(from.strength, from.strength_count, "strength");
    if (!strength.empty()) expect_rows("strength", strength.size(), layers.size());
    for (size_t k = 0; k < strength.size(); ++k) {
        if (!strength[k]) continue;
        const size_t vertices = size_t(model.base.display.vertex_count);
        scale(layers[k].radius,
              carry_paint(model, painted(strength[k], vertices, model.base, "strength"))[k]);
    }
    return layers;
}

}  // namespace

rumple_wrinkle_layers_plan rumple_wrinkle_layers_plan_default(void) {
    return {2, 1, 1, FineSource{}.most_vertices};
}

rumple_status rumple_wrinkle_layers_build(const rumple_surface* base, const rumple_wrinkle_layers_plan* plan,
                                          rumple_wrinkle_layers** model) {
    return made(model, "model", [&] {
        const rumple_surface& from = given(base, "base");
        const rumple_wrinkle_layers_plan& how = given(plan, "plan");
        auto built =
            build_layers(from.surface, how.levels, how.display_steps, how.most_vertices, how.viewport_steps);
        ShownMeshes shown(*built);
        return new rumple_wrinkle_layers{std::move(built), std::move(shown), from.shared};
    });
}

void rumple_wrinkle_layers_free(rumple_wrinkle_layers* model) {
    delete model;
}

const rumple_shown_mesh* rumple_wrinkle_layers_shown(const rumple_wrinkle_layers* model, bool in_viewport) {
    return model ? model->shown.in(in_viewport) : nullptr;
}

rumple_status rumple_wrinkle_layers_get_view(const rumple_wrinkle_layers* model,
                                             rumple_wrinkle_layers_view* view) {
    return guarded([&] {
        const Layers& m = *given(model, "model").model;
        Index solved = 0;
        for (const auto& layer : m.layers) solved += layer->solved.vertex_count;
        const auto& finest = m.layers.back()->triangles;
        given(view, "view") = {count(m.layers), solved, count(finest), flat<int32_t>(finest)};
    });
}

rumple_status rumple_wrinkle_layers_get_layer(const rumple_wrinkle_layers* model, int32_t layer,
                                              rumple_wrinkle_mesh_view* view) {
    return guarded([&] {
        const Layers& m = *given(model, "model").model;
        given(view, "view") = view_of(*m.layers[layer_number(layer, m.layers.size())]);
    });
}

rumple_status rumple_wrinkle_layers_paint_build(const rumple_wrinkle_layers* model,
                                                const rumple_wrinkle_layers_painted* painted,
                                                rumple_wrinkle_layers_paint** paint) {
    return made(paint, "paint", [&] {
        const Layers& m = *given(model, "model").model;
        return new rumple_wrinkle_layers_paint{model->model, paint_of(m, given(painted, "painted"))};
    });
}

void rumple_wrinkle_layers_paint_free(rumple_wrinkle_layers_paint* paint) {
    delete paint;
}

// ---- frames

void rumple_wrinkle_layers_state_free(rumple_wrinkle_layers_state* state) {
    delete state;
}

rumple_status rumple_wrinkle_layers_state_get_view(const rumple_wrinkle_layers_state* state,
                                                   rumple_wrinkle_layers_state_view* view) {
    return guarded([&] {
        const LayersState& s = given(state, "state").state;
        size_t bytes = s.solved.size() * sizeof(Vec3);
        for (const State& layer : s.layers) bytes += view_of(layer).bytes;
        given(view, "view") = {count(s.layers), count(s.solved), flat<float>(s.solved), bytes};
    });
}

rumple_status rumple_wrinkle_layers_state_get_layer(const rumple_wrinkle_layers_state* state, int32_t layer,
                                                    rumple_wrinkle_mesh_state_view* view) {
    return guarded([&] {
        const LayersState& s = given(state, "state").state;
        given(view, "view") = view_of(s.layers[layer_number(layer, s.layers.size())]);
    });
}

rumple_status rumple_wrinkle_layers_state_build(const rumple_wrinkle_layers* model,
                                                const rumple_wrinkle_mesh_state_view* layers,
                                                size_t layers_count, const float* solved, size_t solved_count,
                                                rumple_wrinkle_layers_state** state) {
    return made(state, "state", [&] {
        const rumple_wrinkle_layers& m = given(model, "model");
        const auto from = values(layers, layers_count, "layers");
        expect_rows("layers", from.size(), m.model->layers.size());
        LayersState read;
        for (size_t k = 0; k < from.size(); ++k)
            read.layers.push_back(state_of(*m.model->layers[k], from[k]));
        expect_rows("solved", solved_count, m.model->layers.back()->attached.size());
        read.solved = copied(vectors(solved, solved_count, "solved"));
        expect_finite<Vec3>("solved", read.solved, "vertex");
        expect_range("solved", floats_of(read.solved), -kFarthestCoordinate, kFarthestCoordinate);
        return new rumple_wrinkle_layers_state{m.model, std::move(read)};
    });
}

rumple_status rumple_wrinkle_layers_state_activated(const rumple_wrinkle_layers_state* state,
                                                    rumple_wrinkle_layers_state** activated) {
    return made(activated, "activated", [&] {
        const LayersState& from = given(state, "state").state;
        return new rumple_wrinkle_layers_state{state->model, wrinkle_mesh::activated(from)};
    });
}

rumple_wrinkle_layers_input rumple_wrinkle_layers_input_default(void) {
    return {};
}

rumple_status rumple_wrinkle_layers_solve(const rumple_wrinkle_layers* model,
                                          const rumple_wrinkle_mesh_settings* settings, size_t settings_count,
                                          const rumple_wrinkle_layers_paint* paint,
                                          const rumple_wrinkle_layers_input* input,
                                          const rumple_wrinkle_layers_state* before,
                                          rumple_wrinkle_mesh_report* reports, size_t reports_count,
                                          rumple_wrinkle_layers_state** state) {
    return made(state, "state", [&] {
        const rumple_wrinkle_layers& m = given(model, "model");
        const auto* from = of_model(before, m, "state");
        const auto* touched = of_model(paint, m, "paint");
        std::vector<Settings> options;
        for (const auto& one : values(settings, settings_count, "settings"))
            options.push_back(mesh_settings(&one));
        if (reports) expect_rows("reports", reports_count, m.model->layers.size());

        const rumple_wrinkle_layers_input& given_input = given(input, "input");
        Input over;
        over.positions = vectors(given_input.positions, given_input.positions_count, "positions");
        over.gap = values(given_input.gap, given_input.gap_count, "gap");
        over.thickness = given_input.thickness;
        over.inner = given_input.inner;
        expect_range("gap", over.gap, 0.0, kFarthestCoordinate);
        expect_within("thickness", over.thickness, 0.0, kFarthestCoordinate);
        expect_within("inner", over.inner, 0.0, kFarthestCoordinate);
        const auto worn_over = posed(&given_input.bodies);
        if (worn_over) {
            over.bodies = &*worn_over;
            over.body_hint = values(given_input.body_hint, given_input.body_hint_count, "body_hint");
        }
        std::vector<Report> how;
        const std::vector<Paint> nothing(touched ? 0 : m.model->layers.size());
        LayersState solved = sound_from(from ? &from->state : nullptr, [&](const LayersState* last) {
            return solve(*m.model, options, touched ? touched->layers : nothing, over, last, how);
        });
        for (size_t k = 0; reports && k < how.size(); ++k) reports[k] = report_of(how[k]);
        return new rumple_wrinkle_layers_state{m.model, std::move(solved)};
    });
}

rumple_status rumple_wrinkle_layers_show(const rumple_wrinkle_layers* model, const float* animated,
                                         size_t animated_count, const float* positions,
                                         size_t positions_count, const rumple_wrinkle_layers_state* state,
                                         bool in_viewport, rumple_frame** frame) {
    return made(frame, "frame", [&] {
        const rumple_wrinkle_layers& m = given(model, "model");
        const auto from = vectors(animated, animated_count, "animated");
        const auto at = vectors(positions, positions_count, "positions");
        Picture picture;
        show(*m.model, from, at, given_of_model(state, m, "state").state, picture, in_viewport);
        return new_frame(m.model, sound(std::move(picture)), in_viewport);
    });
}
