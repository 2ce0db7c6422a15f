// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Paths.
#include <algorithm>
#include <cmath>

#include "damage.h"
#include "world.h"

namespace rumple::fuzz {
namespace {

// Folds with a width that suits the mesh. Many narrow folds take seconds and find no more errors.
rumple_wrinkle_paths_settings paths_settings(const std::shared_ptr<const Base>& base, Bytes& bytes) {
    rumple_wrinkle_paths_settings s = CALL(rumple_wrinkle_paths_settings_default);
    s.width = 0.2f;
    bytes.vary(s.smoothing, s.threshold, s.reach, s.width, s.spacing, s.alignment, s.bend_radius, s.hem_rings,
               s.growth_limit, s.fade, s.persistent, s.seed, s.profile, s.direction, s.height, s.threads);
    if (bytes.byte() % 4 == 3) vary(s.rest, bytes);
    float size = 0.0f;
    for (size_t i = 0; base && i < base->rest.size(); ++i) size = std::max(size, std::abs(base->rest[i]));
    if (s.width > 0.0f) s.width = std::max(s.width, 0.1f * size);
    if (s.spacing > 0.0f) s.spacing = std::max(s.spacing, 0.5f);
    return s;
}

void build_model(World& world, Bytes& bytes) {
    const auto base = world.surfaces.pick(bytes);
    const rumple_fine_plan plan = fine_plan(CALL(rumple_wrinkle_paths_plan_default), bytes);
    const auto* model = world.paths.add(
        MAKE(rumple_wrinkle_paths, rumple_wrinkle_paths_build, base.handle, &plan), base.base, 0);
    rumple_wrinkle_paths_view view;
    if (!model || CALL(rumple_wrinkle_paths_get_view, model->handle, &view) != RUMPLE_OK) return;
    expect_within("paths triangle", view.triangle_vertex, 3 * size_t(view.triangle_count), 0,
                  base.base->welded - 1);
    check_shown(CALL(rumple_wrinkle_paths_shown, model->handle), bytes);
}

void build_paint(World& world, Bytes& bytes) {
    const auto model = world.paths.pick(bytes);
    const Floats mask(values(model.base ? size_t(model.base->vertices) : 3, 0.0f, 1.0f, bytes), 1, bytes);
    const Floats width(values(model.base ? size_t(model.base->vertices) : 3, 0.1f, 1.0f, bytes), 1, bytes);
    const Floats along(values(3 * (model.base ? size_t(model.base->vertices) : 3), -0.57f, 0.57f, bytes), 3,
                       bytes);
    const rumple_wrinkle_paths_painted painted{mask.pointer, mask.count,    width.pointer,
                                               width.count,  along.pointer, along.count};
    world.paths_paints.add(
        MAKE(rumple_wrinkle_paths_paint, rumple_wrinkle_paths_paint_build, model.handle, &painted),
        model.base, model.model);
}

void build_pose(World& world, Bytes& bytes) {
    const auto model = world.paths.pick(bytes);
    const Posed posed(model.base ? *model.base : Base(), bytes);
    world.paths_poses.add(
        MAKE(rumple_wrinkle_paths_pose, rumple_wrinkle_paths_pose_build, model.handle, &posed.pose),
        model.base, model.model);
}

void keep_state(World& world, rumple_wrinkle_paths_state* state, const std::shared_ptr<const Base>& base,
                int model, bool solved) {
    rumple_wrinkle_paths_state_view view;
    const auto* kept = world.paths_states.add(state, base, model);
    if (!kept || CALL(rumple_wrinkle_paths_state_get_view, kept->handle, &view) != RUMPLE_OK) return;
    expect_finite("shapes", view.shapes, 3 * view.shapes_count);
    expect_finite("compression", view.compression, view.compression_count);
    expect_finite("width", view.width, view.width_count);
    expect_finite("fade", view.path_fade, view.path_fade_count);
    expect_finite("point", view.point_at, 2 * view.point_at_count);
    expect_starts("path", view.path_start, view.path_start_count, std::int32_t(view.point_at_count));
    check_reference(view.reference);
    const rumple_status checked = CALL(rumple_wrinkle_paths_state_check, kept->handle);
    require(checked == RUMPLE_OK || !solved, "paths that do not lie on the surface", "paths");
}

void solve(World& world, Bytes& bytes) {
    const auto model = world.paths.pick(bytes);
    if (bytes.byte() % 4 != 3) build_pose(world, bytes);
    const auto pose = world.paths_poses.pick_of(model.model, bytes);
    const auto paint = world.paths_paints.pick_of(model.model, bytes);
    const auto before = world.paths_states.pick_of(model.model, bytes);
    const auto settings = paths_settings(model.base, bytes);
    rumple_wrinkle_paths_report report;
    auto* state = MAKE(rumple_wrinkle_paths_state, rumple_wrinkle_paths_solve, model.handle, &settings,
                       paint.handle, pose.handle, before.handle, &report);
    expect_of_model(state ? RUMPLE_OK : RUMPLE_INVALID, model.model, "paths", pose, paint, before);
    if (state) expect_finite("paths report", &report.moved_mean, 2);
    keep_state(world, state, model.base, model.model, true);
}

void show(World& world, Bytes& bytes) {
    const auto model = world.paths.pick(bytes);
    const auto pose = world.paths_poses.pick_of(model.model, bytes);
    const auto state = world.paths_states.pick_of(model.model, bytes);
    const auto settings = paths_settings(model.base, bytes);
    auto* frame =
        MAKE(rumple_frame, rumple_wrinkle_paths_show, model.handle, &settings, pose.handle, state.handle);
    expect_of_model(frame ? RUMPLE_OK : RUMPLE_INVALID, model.model, "paths", pose, state);
    rumple_frame_folds_view folds;
    if (frame && CALL(rumple_frame_get_folds, frame, &folds) == RUMPLE_OK)
        expect_finite("fold height", folds.height, size_t(folds.vertex_count));
    add_frame(world, frame, model.base, model.model);
}

void trace(World& world, Bytes& bytes) {
    const auto model = world.paths.pick(bytes);
    const auto pose = world.paths_poses.pick_of(model.model, bytes);
    const auto state = world.paths_states.pick_of(model.model, bytes);
    const auto settings = paths_settings(model.base, bytes);
    const Floats animated(model.base ? pose_of(model.base->rest, bytes) : std::vector<float>(9), 3, bytes);
    rumple_curves* curves =
        bytes.byte() % 2 == 0
            ? MAKE(rumple_curves, rumple_wrinkle_paths_trace, model.handle, &settings, pose.handle,
                   state.handle)
            : MAKE(rumple_curves, rumple_wrinkle_paths_ride, model.handle, &settings, pose.handle,
                   animated.pointer, bytes.byte() % 2 == 1 ? animated.count : 0, state.handle);
    expect_of_model(curves ? RUMPLE_OK : RUMPLE_INVALID, model.model, "curves", pose, state);
    const auto* kept = world.curves.add(curves, model.base, model.model);
    rumple_curves_view view;
    if (!kept || CALL(rumple_curves_get_view, kept->handle, &view) != RUMPLE_OK) return;
    const auto points = size_t(view.point_count), riding = size_t(view.riding_count);
    expect_starts("curves", view.start, size_t(view.curve_count) + 1, view.point_count);
    expect_finite("curve positions", view.positions, 3 * points);
    expect_finite("curve width", view.width, points);
    expect_finite("curve height", view.height, points);
    expect_within("curve corner", view.corners, 3 * riding, 0, model.base->vertices - 1);
    expect_finite("curve weights", view.weights, 2 * riding);
    expect_finite("curve offset", view.local_offset, 3 * riding);
}

void measure(World& world, Bytes& bytes) {
    const auto model = world.paths.pick(bytes);
    const auto pose = world.paths_poses.pick_of(model.model, bytes);
    const auto state = world.paths_states.pick_of(model.model, bytes);
    const size_t triangles = model.base ? size_t(model.base->triangles) : 3;
    Written stretches(triangles, 2, bytes), ellipses(triangles, 9, bytes);
    const rumple_status status = CALL(rumple_wrinkle_paths_stretches, model.handle, pose.handle, state.handle,
                                      stretches.pointer(), stretches.count);
    stretches.check(status, "stretches");
    expect_of_model(status, model.model, "stretches", pose, state);
    ellipses.check(CALL(rumple_wrinkle_paths_ellipses, model.handle, pose.handle, state.handle,
                        bytes.real(0.0f, 1.0f), ellipses.pointer(), ellipses.count),
                   "ellipses");
}

void draw(World& world, Bytes& bytes) {
    const auto model = world.paths.pick(bytes);
    const auto pose = world.paths_poses.pick_of(model.model, bytes);
    const auto state = world.paths_states.pick_of(model.model, bytes);
    const auto settings = paths_settings(model.base, bytes);
    rumple_drawing* made = bytes.byte() % 4 == 3 ? MAKE(rumple_drawing, rumple_wrinkle_paths_list,
                                                        model.handle, &settings, pose.handle, state.handle)
                                                 : MAKE(rumple_drawing, rumple_wrinkle_paths_draw,
                                                        model.handle, &settings, pose.handle, state.handle);
    expect_of_model(made ? RUMPLE_OK : RUMPLE_INVALID, model.model, "drawing", pose, state);
    const auto* drawing = world.drawings.add(made, model.base, model.model);
    rumple_drawing_view view;
    if (!drawing || CALL(rumple_drawing_get_view, drawing->handle, &view) != RUMPLE_OK) return;
    for (const float* of_three : {view.flat, view.smooth, view.normal})
        expect_finite("drawing", of_three, 3 * size_t(view.vertex_count));
    expect_finite("hem", view.hem, size_t(view.vertex_count));
    expect_finite("proxy", view.proxy_offset, 3 * size_t(view.base_vertex_count));
    expect_finite("fold end", view.ends, 8 * size_t(view.end_count));
    expect_starts("ranges", view.triangle_start, size_t(view.triangle_count) + 1, view.range_count);
    expect_within("range", view.ranges, 2 * size_t(view.range_count), 0, view.end_count);
    std::vector<std::int32_t> triangles;
    for (int k = 0; k < 3; ++k) triangles.push_back(bytes.whole(0, 3));
    const std::vector<float> places = values(6, 0.0f, 0.5f, bytes);
    const auto others = paths_settings(model.base, bytes);
    Written out(3, 7, bytes);
    out.check(CALL(rumple_drawing_evaluate, drawing->handle, &others, triangles.data(), places.data(), 3,
                   out.pointer()),
              "drawn");
}

void restore(World& world, Bytes& bytes) {
    const auto from = world.paths_states.pick(bytes);
    const auto model = world.paths.pick(bytes);
    rumple_wrinkle_paths_state_view view{};
    if (CALL(rumple_wrinkle_paths_state_get_view, from.handle, &view) != RUMPLE_OK) return;
    static_assert(sizeof view == 27 * 8, "a new array? damage it as well");
    Damage damage(bytes);
    damage(view.reference);
    damage(view.shapes, view.shapes_count, 3);
    damage(view.compression, view.compression_count);
    damage(view.width, view.width_count);
    damage(view.path_id, view.path_id_count);
    damage(view.path_fade, view.path_fade_count);
    damage(view.path_start, view.path_start_count);
    damage(view.point_triangle_edge, view.point_triangle_edge_count, 2);
    damage(view.point_at, view.point_at_count, 2);
    if (bytes.hostile()) view.next_id = bytes.whole(0, 3);
    keep_state(world, MAKE(rumple_wrinkle_paths_state, rumple_wrinkle_paths_state_build, model.handle, &view),
               model.base, model.model, false);
}

void label(World& world, Bytes& bytes) {
    const auto model = world.paths.pick(bytes);
    const Clip clip(model.base ? *model.base : Base(), bytes);
    const auto settings = paths_settings(model.base, bytes);
    clip.check(CALL(rumple_wrinkle_paths_label_clip, model.handle, &settings, clip.times.pointer,
                    clip.times.count, clip.positions.pointer, clip.positions.count, bytes.byte() % 2 == 1,
                    clip.out(), clip.labels.size()));
}

void free_one(World& world, Bytes& bytes) {
    free_one_of(bytes, world.paths, world.paths_paints, world.paths_poses, world.paths_states, world.curves,
                world.drawings);
}

}  // namespace

const std::vector<Operation> kPaths = {build_model, build_pose, solve,   solve, show,     trace,
                                       draw,        measure,    restore, label, free_one, build_paint};

}  // namespace rumple::fuzz
