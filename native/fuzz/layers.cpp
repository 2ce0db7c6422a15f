// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Layers, and their transfer to the base mesh.
#include "damage.h"
#include "world.h"

namespace rumple::fuzz {
namespace {

constexpr std::int32_t kMost[] = {800, 800, 800, 300, -1};

void build_model(World& world, Bytes& bytes) {
    const auto base = world.surfaces.pick(bytes);
    rumple_wrinkle_layers_plan plan = CALL(rumple_wrinkle_layers_plan_default);
    plan.levels = bytes.whole(0, 2);
    plan.display_steps = bytes.whole(0, 1);
    plan.viewport_steps = bytes.whole(0, 1);
    plan.most_vertices = kMost[bytes.below(std::size(kMost))];
    const auto* model = world.layers.add(
        MAKE(rumple_wrinkle_layers, rumple_wrinkle_layers_build, base.handle, &plan), base.base, 0, base.id);
    rumple_wrinkle_layers_view view;
    if (!model || CALL(rumple_wrinkle_layers_get_view, model->handle, &view) != RUMPLE_OK) return;
    for (std::int32_t layer = -1; layer <= view.layer_count; ++layer) {
        rumple_wrinkle_mesh_view of_layer;
        const rumple_status status = CALL(rumple_wrinkle_layers_get_layer, model->handle, layer, &of_layer);
        require((status == RUMPLE_OK) == (layer >= 0 && layer < view.layer_count), "layer", "get_layer");
        if (status != RUMPLE_OK) continue;
        expect_finite("local edge", of_layer.local_edge, size_t(of_layer.solved_vertex_count));
        if (layer + 1 == view.layer_count) {
            expect_within("finest triangle", view.finest_triangles, 3 * size_t(view.finest_triangle_count), 0,
                          of_layer.solved_vertex_count - 1);
        }
    }
    for (const bool in_viewport : {false, true})
        check_shown(CALL(rumple_wrinkle_layers_shown, model->handle, in_viewport), bytes);
}

void build_paint(World& world, Bytes& bytes) {
    const auto model = world.layers.pick(bytes);
    rumple_wrinkle_layers_view view{};
    CALL(rumple_wrinkle_layers_get_view, model.handle, &view);
    std::vector<std::vector<float>> keep;
    const Base& base = model.base ? *model.base : Base();
    rumple_wrinkle_layers_painted painted{mesh_painted(base, keep, bytes), nullptr, 0};
    const std::vector<float> strength = values(size_t(base.vertices), 0.0f, 1.0f, bytes);
    std::vector<const float*> of_layers;
    for (std::int32_t k = 0; k < view.layer_count; ++k)
        of_layers.push_back(bytes.byte() % 2 == 1 ? strength.data() : nullptr);
    painted.strength = of_layers.data();
    painted.strength_count = bytes.hostile() ? of_layers.size() / 2 : of_layers.size();
    world.layers_paints.add(
        MAKE(rumple_wrinkle_layers_paint, rumple_wrinkle_layers_paint_build, model.handle, &painted),
        model.base, model.model);
}

void keep_state(World& world, rumple_wrinkle_layers_state* state, const std::shared_ptr<const Base>& base,
                int model) {
    rumple_wrinkle_layers_state_view view;
    const auto* kept = world.layers_states.add(state, base, model);
    if (!kept || CALL(rumple_wrinkle_layers_state_get_view, kept->handle, &view) != RUMPLE_OK) return;
    expect_finite("solved", view.solved, 3 * size_t(view.solved_count));
    for (std::int32_t layer = -1; layer <= view.layer_count; ++layer) {
        rumple_wrinkle_mesh_state_view of_layer;
        if (CALL(rumple_wrinkle_layers_state_get_layer, kept->handle, layer, &of_layer) == RUMPLE_OK)
            check_mesh_state(of_layer);
    }
}

void solve(World& world, Bytes& bytes) {
    const auto model = world.layers.pick(bytes);
    rumple_wrinkle_layers_view view{};
    CALL(rumple_wrinkle_layers_get_view, model.handle, &view);
    const auto paint = world.layers_paints.pick_of(model.model, bytes);
    const auto before = world.layers_states.pick_of(model.model, bytes);
    const auto vertices = model.base ? size_t(model.base->vertices) : 3;
    std::vector<rumple_wrinkle_mesh_settings> settings(size_t(view.layer_count), mesh_settings(bytes));
    if (bytes.byte() % 4 == 3 && !settings.empty()) settings.back() = mesh_settings(bytes);
    const Floats positions(model.base ? pose_of(model.base->rest, bytes) : std::vector<float>(9), 3, bytes);
    const Floats gap(values(vertices, 0.0f, 0.2f, bytes), 1, bytes);
    std::vector<std::int32_t> near(vertices, 0);
    for (int k = bytes.below(4); k > 0; --k) near[size_t(bytes.below(int(vertices)))] = bytes.whole(-1, 4);
    const Numbers hints(near, 1, bytes);
    std::vector<float> keep;
    rumple_wrinkle_layers_input input = CALL(rumple_wrinkle_layers_input_default);
    input.positions = positions.pointer;
    input.positions_count = positions.count;
    input.gap = gap.pointer;
    input.gap_count = bytes.byte() % 2 == 1 ? gap.count : 0;
    if (bytes.byte() % 2 == 1) input.bodies = bodies(world, keep, bytes);
    input.body_hint = hints.pointer;
    input.body_hint_count = hints.count;
    input.thickness = bytes.real(0.0f, 0.1f);
    input.inner = 2.0f * input.thickness;  // from the same bytes, so that kept inputs keep their meaning
    std::vector<rumple_wrinkle_mesh_report> reports(settings.size());
    auto* state =
        MAKE(rumple_wrinkle_layers_state, rumple_wrinkle_layers_solve, model.handle, settings.data(),
             settings.size(), paint.handle, &input, before.handle, reports.data(), reports.size());
    expect_of_model(state ? RUMPLE_OK : RUMPLE_INVALID, model.model, "layers", paint, before);
    for (size_t k = 0; state && k < reports.size(); ++k)
        expect_finite("layer report", &reports[k].error_before, 4);
    keep_state(world, state, model.base, model.model);
}

void show(World& world, Bytes& bytes) {
    const auto model = world.layers.pick(bytes);
    const auto state = world.layers_states.pick_of(model.model, bytes);
    const std::vector<float> rest = model.base ? model.base->rest : std::vector<float>(9);
    const Floats animated(pose_of(rest, bytes), 3, bytes), positions(pose_of(rest, bytes), 3, bytes);
    auto* frame =
        MAKE(rumple_frame, rumple_wrinkle_layers_show, model.handle, animated.pointer, animated.count,
             positions.pointer, positions.count, state.handle, bytes.byte() % 2 == 1);
    expect_of_model(frame ? RUMPLE_OK : RUMPLE_INVALID, model.model, "layers", state);
    add_frame(world, frame, model.base, model.model);
}

// Restores a state as from a file: a copy of its arrays, possibly damaged, for a model that may be another
// one.
void restore(World& world, Bytes& bytes) {
    const auto from = world.layers_states.pick(bytes);
    const auto model = world.layers.pick(bytes);
    rumple_wrinkle_layers_state_view view{};
    if (CALL(rumple_wrinkle_layers_state_get_view, from.handle, &view) != RUMPLE_OK) return;
    std::vector<rumple_wrinkle_mesh_state_view> layers(size_t(view.layer_count));
    for (std::int32_t k = 0; k < view.layer_count; ++k)
        CALL(rumple_wrinkle_layers_state_get_layer, from.handle, k, &layers[size_t(k)]);
    Damage damage(bytes);
    for (auto& layer : layers) damage(layer);
    damage(view.solved, view.solved_count, 3);
    const size_t lost = bytes.hostile() ? 1 : 0;
    keep_state(
        world,
        MAKE(rumple_wrinkle_layers_state, rumple_wrinkle_layers_state_build, model.handle, layers.data(),
             layers.size() - (layers.empty() ? 0 : lost), view.solved, size_t(view.solved_count)),
        model.base, model.model);
}

void activate(World& world, Bytes& bytes) {
    const auto state = world.layers_states.pick(bytes);
    keep_state(world, MAKE(rumple_wrinkle_layers_state, rumple_wrinkle_layers_state_activated, state.handle),
               state.base, state.model);
    restore(world, bytes);
}

// All steps: a base mesh, a coarse mesh in its place, and layers on the coarse mesh.
void build_transfer(World& world, Bytes& bytes) {
    const auto dense = world.surfaces.pick(bytes);
    if (dense.handle && bytes.byte() < 200)
        world.coarses.add(MAKE(rumple_coarse, rumple_coarse_build, dense.handle, 0.5f), dense.base, dense.id);
    const auto coarse = world.coarses.pick_of(dense.id, bytes);
    auto* surface = MAKE(rumple_surface, rumple_coarse_surface, coarse.handle);
    rumple_wrinkle_layers_plan layers_plan = CALL(rumple_wrinkle_layers_plan_default);
    layers_plan.levels = bytes.whole(0, 1);
    layers_plan.most_vertices = 2000;
    auto* built = MAKE(rumple_wrinkle_layers, rumple_wrinkle_layers_build, surface, &layers_plan);
    rumple_surface_view view{};
    if (surface) CALL(rumple_surface_get_view, surface, &view);
    rumple_coarse_view coarse_view{};
    CALL(rumple_coarse_get_view, coarse.handle, &coarse_view);
    auto base = std::make_shared<Base>();
    for (std::int32_t v = 0; v < coarse_view.vertex_count; ++v) {
        const float* at = &coarse.base->rest[size_t(coarse_view.base_vertex[v]) * 3];
        base->rest.insert(base->rest.end(), at, at + 3);
    }
    base->vertices = view.vertex_count;
    base->triangles = view.triangle_count;
    RUN(rumple_surface_free, surface);
    const auto* on = world.layers.add(built, base, 0);
    const auto layers = on && bytes.byte() < 240 ? *on : world.layers.pick(bytes);
    rumple_wrinkle_transfer_plan plan = CALL(rumple_wrinkle_transfer_plan_default);
    plan.level = bytes.whole(0, 1);
    plan.display_steps = bytes.whole(0, 1);
    plan.viewport_steps = bytes.whole(0, 1);
    plan.most_vertices = kMost[bytes.below(std::size(kMost))];
    auto* made = MAKE(rumple_wrinkle_transfer, rumple_wrinkle_transfer_build, dense.handle, coarse.handle,
                      layers.handle, &plan);
    require(!made || coarse.model == dense.id, "took a coarse mesh of another one", "transfer");
    const auto* model = world.transfers.add(made, dense.base, layers.model);
    for (const bool in_viewport : {false, true}) {
        if (model) check_shown(CALL(rumple_wrinkle_transfer_shown, model->handle, in_viewport), bytes);
    }
}

void show_transfer(World& world, Bytes& bytes) {
    const auto model = world.transfers.pick(bytes);
    if (bytes.byte() % 2 == 0) solve(world, bytes);
    const auto state = world.layers_states.pick_of(model.model, bytes);
    const Floats animated(model.base ? pose_of(model.base->rest, bytes) : std::vector<float>(9), 3, bytes);
    auto* frame = MAKE(rumple_frame, rumple_wrinkle_transfer_show, model.handle, animated.pointer,
                       animated.count, state.handle, bytes.byte() % 2 == 1);
    expect_of_model(frame ? RUMPLE_OK : RUMPLE_INVALID, model.model, "transfer", state);
    add_frame(world, frame, model.base, model.model);
}

void free_one(World& world, Bytes& bytes) {
    free_one_of(bytes, world.layers, world.layers_paints, world.layers_states, world.transfers);
}

}  // namespace

const std::vector<Operation> kLayers = {build_model, solve,          solve,         show,    build_paint,
                                        activate,    build_transfer, show_transfer, free_one};

}  // namespace rumple::fuzz
