// SPDX-License-Identifier: GPL-3.0-or-later
// The Wrinkle Mesh.
#include "damage.h"
#include "world.h"

namespace rumple::fuzz {
namespace {

void build_model(World& world, Bytes& bytes) {
    const auto base = world.surfaces.pick(bytes), own = world.surfaces.pick(bytes);
    rumple_wrinkle_mesh_plan plan = CALL(rumple_wrinkle_mesh_plan_default);
    plan.fine = fine_plan(plan.fine, bytes);
    plan.own = own.handle;
    const size_t vertices = own.base ? size_t(own.base->vertices) : 3;
    const Argument<std::uint8_t> attached(std::vector<std::uint8_t>(vertices, std::uint8_t(bytes.byte() % 3)),
                                          1, bytes);
    plan.attached = attached.pointer;
    plan.attached_count = bytes.byte() % 2 == 1 ? attached.count : 0;
    plan.farthest = bytes.real(0.0f, 2.0f);
    plan.display_steps = bytes.whole(0, 1);
    plan.viewport_steps = bytes.whole(0, 1);
    plan.adaptive = bytes.byte() % 2 == 1;
    const auto* model = world.meshes.add(
        MAKE(rumple_wrinkle_mesh, rumple_wrinkle_mesh_build, base.handle, &plan), base.base, 0);
    rumple_wrinkle_mesh_view view;
    if (!model || CALL(rumple_wrinkle_mesh_get_view, model->handle, &view) != RUMPLE_OK) return;
    expect_finite("local edge", view.local_edge, size_t(view.solved_vertex_count));
    expect_finite("unattached", view.unattached_distance, size_t(view.unattached_count));
    for (const bool in_viewport : {false, true})
        check_shown(CALL(rumple_wrinkle_mesh_shown, model->handle, in_viewport), bytes);
}

void build_paint(World& world, Bytes& bytes) {
    const auto model = world.meshes.pick(bytes);
    std::vector<std::vector<float>> keep;
    const auto painted = mesh_painted(model.base ? *model.base : Base(), keep, bytes);
    world.mesh_paints.add(
        MAKE(rumple_wrinkle_mesh_paint, rumple_wrinkle_mesh_paint_build, model.handle, &painted), model.base,
        model.model);
}

void build_pose(World& world, Bytes& bytes) {
    const auto model = world.meshes.pick(bytes);
    const Posed posed(model.base ? *model.base : Base(), bytes);
    world.mesh_poses.add(
        MAKE(rumple_wrinkle_mesh_pose, rumple_wrinkle_mesh_pose_build, model.handle, &posed.pose), model.base,
        model.model);
}

void keep_state(World& world, rumple_wrinkle_mesh_state* state, const std::shared_ptr<const Base>& base,
                int model) {
    rumple_wrinkle_mesh_state_view view;
    const auto* kept = world.mesh_states.add(state, base, model);
    if (kept && CALL(rumple_wrinkle_mesh_state_get_view, kept->handle, &view) == RUMPLE_OK)
        check_mesh_state(view);
}

// A frame: its pose, a solve, the shown mesh and its measures.
void solve(World& world, Bytes& bytes) {
    const auto model = world.meshes.pick(bytes);
    if (bytes.byte() % 4 != 3) build_pose(world, bytes);
    const auto pose = world.mesh_poses.pick_of(model.model, bytes);
    const auto paint = world.mesh_paints.pick_of(model.model, bytes);
    const auto before = world.mesh_states.pick_of(model.model, bytes);
    const auto settings = mesh_settings(bytes);
    bytes.byte();  // not used; the kept inputs have it
    rumple_wrinkle_mesh_report report;
    rumple_wrinkle_mesh_state* state =
        MAKE(rumple_wrinkle_mesh_state, rumple_wrinkle_mesh_solve, model.handle, &settings, paint.handle,
             pose.handle, before.handle, &report);
    expect_of_model(state ? RUMPLE_OK : RUMPLE_INVALID, model.model, "mesh", pose, paint, before);
    if (state) expect_finite("mesh report", &report.error_before, 4);
    keep_state(world, state, model.base, model.model);
}

// The constraints for a graphics card, which refers to vertices and passes that exist.
void check_passes(const rumple_wrinkle_mesh* model, const rumple_wrinkle_mesh_view& base,
                  const rumple_wrinkle_mesh_settings& settings, const rumple_wrinkle_mesh_paint* paint) {
    auto* passes =
        MAKE(rumple_wrinkle_mesh_passes, rumple_wrinkle_mesh_passes_build, model, &settings, paint);
    rumple_wrinkle_mesh_passes_view view;
    if (CALL(rumple_wrinkle_mesh_passes_get_view, passes, &view) == RUMPLE_OK) {
        const auto vertices = size_t(view.vertex_count), pairs = size_t(view.pair_count);
        for (const float* values : {view.radius, view.depth, view.push, view.noise})
            expect_finite("passes", values, vertices);
        for (const float* values : {view.rest, view.stretched, view.stiffness})
            expect_finite("pairs of passes", values, pairs);
        expect_within("pairs", view.pairs, 2 * pairs, 0, view.vertex_count);
        expect_within("of_pass", view.of_pass, pairs, 0, view.pass_count);
        expect_within("base_vertices", view.base_vertices, 3 * vertices, 0, base.welded_count);
    }
    RUN(rumple_wrinkle_mesh_passes_free, passes);
}

void show(World& world, Bytes& bytes) {
    const auto model = world.meshes.pick(bytes);
    const auto pose = world.mesh_poses.pick_of(model.model, bytes);
    const auto state = world.mesh_states.pick_of(model.model, bytes);
    const auto settings = mesh_settings(bytes);
    auto* frame = MAKE(rumple_frame, rumple_wrinkle_mesh_show, model.handle, &settings, pose.handle,
                       state.handle, bytes.byte() % 2 == 1);
    expect_of_model(frame ? RUMPLE_OK : RUMPLE_INVALID, model.model, "mesh", pose, state);
    add_frame(world, frame, model.base, model.model);
    rumple_wrinkle_mesh_view view{};
    CALL(rumple_wrinkle_mesh_get_view, model.handle, &view);
    const auto paint = world.mesh_paints.pick_of(model.model, bytes);
    rumple_wrinkle_mesh_measures measures;
    Written offsets(size_t(view.solved_vertex_count), 3, bytes);
    const rumple_status status = CALL(rumple_wrinkle_mesh_measure, model.handle, &settings, paint.handle,
                                      pose.handle, state.handle, &measures, offsets.pointer(), offsets.count);
    offsets.check(status, "offsets");
    expect_of_model(status, model.model, "measure", pose, paint, state);
    if (status == RUMPLE_OK)
        expect_finite("measures", &measures.edge_error_before_rms, sizeof measures / sizeof(float));
    check_passes(model.handle, view, settings, paint.handle);
    std::vector<float> welded(3 * size_t(view.welded_count)), normals(welded), smooth(welded);
    const std::vector<float> positions(3 * size_t(view.base_vertex_count), 1.0f);
    CALL(rumple_wrinkle_mesh_weld_pose, model.handle, positions.data(), size_t(view.base_vertex_count),
         welded.data(), normals.data(), smooth.data(), size_t(view.welded_count));
    expect_finite("welded", welded.data(), welded.size());
    expect_finite("normals", normals.data(), normals.size());
    expect_finite("smooth", smooth.data(), smooth.size());
}

// Restores a state as from a file: a copy of its arrays, possibly damaged, for a model that may be another
// one.
void restore(World& world, Bytes& bytes) {
    const auto from = world.mesh_states.pick(bytes);
    const auto model = world.meshes.pick(bytes);
    rumple_wrinkle_mesh_state_view view{};
    if (CALL(rumple_wrinkle_mesh_state_get_view, from.handle, &view) != RUMPLE_OK) return;
    Damage damage(bytes);
    damage(view);
    keep_state(world,
               MAKE(rumple_wrinkle_mesh_state, rumple_wrinkle_mesh_state_build, model.handle,
                    bytes.hostile() ? nullptr : &view),
               model.base, model.model);
}

void activate(World& world, Bytes& bytes) {
    const auto state = world.mesh_states.pick(bytes);
    auto* activated = MAKE(rumple_wrinkle_mesh_state, rumple_wrinkle_mesh_state_activated, state.handle);
    world.mesh_states.add(activated, state.base, state.model);
}

void label(World& world, Bytes& bytes) {
    const auto model = world.meshes.pick(bytes);
    const Clip clip(model.base ? *model.base : Base(), bytes);
    const auto settings = mesh_settings(bytes);
    clip.check(CALL(rumple_wrinkle_mesh_label_clip, model.handle, &settings, clip.times.pointer,
                    clip.times.count, clip.positions.pointer, clip.positions.count, bytes.byte() % 2 == 1,
                    clip.out(), clip.labels.size()));
}

void free_one(World& world, Bytes& bytes) {
    free_one_of(bytes, world.meshes, world.mesh_paints, world.mesh_poses, world.mesh_states);
}

}  // namespace

rumple_wrinkle_mesh_settings mesh_settings(Bytes& bytes) {
    rumple_wrinkle_mesh_settings s = CALL(rumple_wrinkle_mesh_settings_default);
    bytes.vary(s.radius, s.prestretch, s.bending, s.collision, s.inside, s.stretch_relief,
               s.buckling_threshold, s.compression_limit, s.hem_rings, s.iterations, s.start_iterations,
               s.damping, s.offset_space, s.tangential_pull, s.normal_pull, s.slack, s.taut_range,
               s.bend_radius, s.apart, s.slide, s.nudge, s.seed, s.threads);
    const int rest = bytes.byte();
    if (rest % 4 == 3) vary(s.rest, bytes);
    s.contact_gather = float(rest) / 255.0f;  // from the same byte, so that kept inputs keep their meaning
    return s;
}

rumple_wrinkle_mesh_painted mesh_painted(const Base& base, std::vector<std::vector<float>>& keep,
                                         Bytes& bytes) {
    rumple_wrinkle_mesh_painted painted{};
    const auto vertices = size_t(base.vertices);
    for (int k = 0; k < 4; ++k) keep.push_back(values(vertices, 0.0f, 1.0f, bytes));
    keep.push_back(values(3 * vertices, -0.57f, 0.57f, bytes));
    const auto count = [&] { return bytes.byte() % 2 == 0 ? 0 : bytes.hostile() ? vertices / 2 : vertices; };
    painted.radius = keep[0].data();
    painted.radius_count = count();
    painted.prestretch = keep[1].data();
    painted.prestretch_count = count();
    painted.bending = keep[2].data();
    painted.bending_count = count();
    painted.inside = keep[3].data();
    painted.inside_count = count();
    painted.along = keep[4].data();
    painted.along_count = count();
    painted.worn = keep[0].data();  // the same number as for the radius
    painted.worn_count = painted.radius_count;
    return painted;
}

void check_reference(const rumple_reference_view& view) {
    expect_finite("reference", view.reference, 3 * view.reference_count);
    expect_finite("past positions", view.past_positions, 3 * view.past_positions_count);
    for (size_t t = 0; t < view.labels_count; ++t) require(view.labels[t] <= 2, "label", "reference");
}

void check_mesh_state(const rumple_wrinkle_mesh_state_view& view) {
    expect_finite("state offset", view.offset, 3 * view.offset_count);
    check_reference(view.reference);
}

const std::vector<Operation> kMesh = {build_model, build_pose, solve,    solve, show,
                                      build_paint, restore,    activate, label, free_one};

}  // namespace rumple::fuzz
