// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/wrinkle_mesh.h"

#include "api/sound.h"
#include "base/expect.h"
#include "systems/wrinkle_mesh/passes.h"
#include "systems/wrinkle_mesh/pose.h"

using namespace rumple;
using namespace rumple::api;
using namespace rumple::wrinkle_mesh;

struct rumple_wrinkle_mesh {
    std::shared_ptr<const Model> model;
    ShownMeshes shown;
};
struct rumple_wrinkle_mesh_paint {
    std::shared_ptr<const Model> model;
    Paint paint;
};
struct rumple_wrinkle_mesh_pose {
    std::shared_ptr<const Model> model;
    FrameArrays arrays;
    Pose pose;
};
struct rumple_wrinkle_mesh_state {
    std::shared_ptr<const Model> model;
    State state;
};
struct rumple_wrinkle_mesh_passes {
    std::shared_ptr<const Model> model;
    Passes passes;
};

// Lists all fields once, for both directions: see api/settings.h.
template <typename Pair>
static void pair_fields(rumple_wrinkle_mesh_settings& c, Settings& native, const Pair& pair) {
    pair(c.radius, native.radius);
    pair(c.prestretch, native.prestretch);
    pair(c.bending, native.bending);
    pair.choose("collision", c.collision, native.collision, Collision::kNeighbourhood);
    pair(c.inside, native.inside);
    pair(c.stretch_relief, native.stretch_relief);
    pair(c.buckling_threshold, native.buckling_threshold);
    pair(c.compression_limit, native.compression_limit);
    pair(c.hem_rings, native.hem_rings);
    pair(c.iterations, native.iterations);
    pair(c.start_iterations, native.start_iterations);
    pair(c.damping, native.damping);
    pair.choose("offset_space", c.offset_space, native.offset_space, OffsetSpace::kWorld);
    pair(c.tangential_pull, native.tangential_pull);
    pair(c.normal_pull, native.normal_pull);
    pair(c.slack, native.slack);
    pair(c.taut_range, native.taut_range);
    pair(c.hang, native.hang);
    pair(c.bend_radius, native.bend_radius);
    pair(c.contact_gather, native.contact_gather);
    pair(c.apart, native.apart);
    pair(c.slide, native.slide);
    pair(c.nudge, native.nudge);
    pair(c.seed, native.seed);
    pair(c.threads, native.threads);
    pair_reference(c.rest, native.rest, pair);
}

namespace rumple::api {

Settings mesh_settings(const rumple_wrinkle_mesh_settings* settings) {
    return native_of<Settings>(settings, "settings");
}

Paint mesh_painted(const rumple_wrinkle_mesh_painted& from, const Surface& base) {
    Paint paint;
    paint.radius = painted(from.radius, from.radius_count, base, "radius");
    paint.prestretch = painted(from.prestretch, from.prestretch_count, base, "prestretch");
    paint.bending = painted(from.bending, from.bending_count, base, "bending");
    paint.inside = painted(from.inside, from.inside_count, base, "inside");
    paint.worn = painted(from.worn, from.worn_count, base, "worn");
    const auto along = vectors(from.along, from.along_count, "along");
    if (!along.empty()) paint.guide = build_guide_lines(base, along);
    return paint;
}

rumple_wrinkle_mesh_view view_of(const Model& m) {
    return {m.solved.vertex_count,        int32_t(m.distance.size() + m.bending.size()),
            count(m.unattached_distance), m.base.display.vertex_count,
            m.base.welded.vertex_count,   m.local_edge.data(),
            m.unattached_distance.data(), m.base.welded_of.data()};
}

rumple_wrinkle_mesh_state_view view_of(const State& s) {
    const size_t bytes =
        s.offset.size() * sizeof(Vec3) + s.solved_length.size() * sizeof(float) + s.reference.bytes();
    return {flat<float>(s.offset),  s.offset.size(),      s.solved_length.data(),
            s.solved_length.size(), view_of(s.reference), bytes};
}

State state_of(const Model& model, const rumple_wrinkle_mesh_state_view& from) {
    expect_rows("offset", from.offset_count, size_t(model.solved.vertex_count));
    expect_rows_or_none("solved_length", from.solved_length_count,
                        model.distance.size() + model.bending.size());
    State read{copied(vectors(from.offset, from.offset_count, "offset")),
               copied(values(from.solved_length, from.solved_length_count, "solved_length")),
               state_of(from.reference)};
    expect_finite<Vec3>("offset", read.offset, "vertex");
    expect_range("offset", floats_of(read.offset), -kFarthestCoordinate, kFarthestCoordinate);
    expect_numbers("solved_length", read.solved_length);
    if (!read.reference.empty()) check_reference(model.base, read.reference);
    return read;
}

rumple_wrinkle_mesh_report report_of(const Report& r) {
    return {r.iterations, r.error_before,        r.error_after, r.largest_error,
            r.active,     r.collapsed_triangles, r.kept_apart};
}

}  // namespace rumple::api

namespace {

Source source_of(const rumple_wrinkle_mesh_plan& plan) {
    Source source;
    if (plan.fine.source == RUMPLE_FINE_OBJECT) {
        source.own = &given(plan.own, "own").surface;
        source.most_vertices = plan.fine.most_vertices;
    } else {
        static_cast<FineSource&>(source) = fine_source(plan.fine);
    }
    source.attached = values(plan.attached, plan.attached_count, "attached");
    if (source.own && !source.attached.empty())
        expect_count("attached", source.attached.size(), size_t(source.own->display.vertex_count), "values");
    source.farthest = plan.farthest;
    source.adaptive = plan.adaptive;
    return source;
}

Input input_of(const FrameArrays& arrays) {
    return {arrays.positions, arrays.world_from_object, arrays.frame_time()};
}

Paint paint_in(const rumple_wrinkle_mesh* model, const rumple_wrinkle_mesh_paint* paint) {
    const auto* of = of_model(paint, *model, "paint");
    return of ? of->paint : Paint{};
}

}  // namespace

rumple_wrinkle_mesh_plan rumple_wrinkle_mesh_plan_default(void) {
    rumple_wrinkle_mesh_plan plan{};
    const Source source;
    plan.fine = fine_plan(source);
    plan.farthest = source.farthest;
    plan.display_steps = 1;
    plan.viewport_steps = 1;
    plan.adaptive = source.adaptive;
    return plan;
}

rumple_status rumple_wrinkle_mesh_build(const rumple_surface* base, const rumple_wrinkle_mesh_plan* plan,
                                        rumple_wrinkle_mesh** model) {
    return made(model, "model", [&] {
        const Surface& surface = given(base, "base").surface;
        const Source source = source_of(given(plan, "plan"));
        auto built =
            build(surface, source, attachment_kind(plan->fine), plan->display_steps, plan->viewport_steps);
        ShownMeshes shown(*built);
        return new rumple_wrinkle_mesh{std::move(built), std::move(shown)};
    });
}

void rumple_wrinkle_mesh_free(rumple_wrinkle_mesh* model) {
    delete model;
}

const rumple_shown_mesh* rumple_wrinkle_mesh_shown(const rumple_wrinkle_mesh* model, bool in_viewport) {
    return model ? model->shown.in(in_viewport) : nullptr;
}

rumple_status rumple_wrinkle_mesh_get_view(const rumple_wrinkle_mesh* model, rumple_wrinkle_mesh_view* view) {
    return guarded([&] { given(view, "view") = view_of(*given(model, "model").model); });
}

rumple_wrinkle_mesh_settings rumple_wrinkle_mesh_settings_default(void) {
    return default_of<rumple_wrinkle_mesh_settings, Settings>();
}

rumple_status rumple_wrinkle_mesh_paint_build(const rumple_wrinkle_mesh* model,
                                              const rumple_wrinkle_mesh_painted* painted,
                                              rumple_wrinkle_mesh_paint** paint) {
    return made(paint, "paint", [&] {
        const Model& m = *given(model, "model").model;
        Paint carried = mesh_painted(given(painted, "painted"), m.base);
        for (const PaintedPart part : kPaintedParts) {
            if (!(carried.*part).empty()) carried.*part = carry_paint(m, carried.*part);
        }
        return new rumple_wrinkle_mesh_paint{model->model, std::move(carried)};
    });
}

void rumple_wrinkle_mesh_paint_free(rumple_wrinkle_mesh_paint* paint) {
    delete paint;
}

// ---- frames

void rumple_wrinkle_mesh_state_free(rumple_wrinkle_mesh_state* state) {
    delete state;
}

rumple_status rumple_wrinkle_mesh_state_get_view(const rumple_wrinkle_mesh_state* state,
                                                 rumple_wrinkle_mesh_state_view* view) {
    return guarded([&] { given(view, "view") = view_of(given(state, "state").state); });
}

rumple_status rumple_wrinkle_mesh_pose_build(const rumple_wrinkle_mesh* model, const rumple_pose* frame,
                                             rumple_wrinkle_mesh_pose** pose) {
    return made_pose(model, frame, pose,
                     [](const auto& m, const auto& arrays) { return make_pose(m, input_of(arrays)); });
}

void rumple_wrinkle_mesh_pose_free(rumple_wrinkle_mesh_pose* pose) {
    delete pose;
}

rumple_status rumple_wrinkle_mesh_state_build(const rumple_wrinkle_mesh* model,
                                              const rumple_wrinkle_mesh_state_view* arrays,
                                              rumple_wrinkle_mesh_state** state) {
    return made(state, "state", [&] {
        const rumple_wrinkle_mesh& m = given(model, "model");
        return new rumple_wrinkle_mesh_state{m.model, state_of(*m.model, given(arrays, "arrays"))};
    });
}

rumple_status rumple_wrinkle_mesh_state_activated(const rumple_wrinkle_mesh_state* state,
                                                  rumple_wrinkle_mesh_state** activated) {
    return made(activated, "activated", [&] {
        const State& from = given(state, "state").state;
        return new rumple_wrinkle_mesh_state{state->model, wrinkle_mesh::activated(from)};
    });
}

rumple_status rumple_wrinkle_mesh_solve(const rumple_wrinkle_mesh* model,
                                        const rumple_wrinkle_mesh_settings* settings,
                                        const rumple_wrinkle_mesh_paint* paint,
                                        const rumple_wrinkle_mesh_pose* pose,
                                        const rumple_wrinkle_mesh_state* before,
                                        rumple_wrinkle_mesh_report* report,
                                        rumple_wrinkle_mesh_state** state) {
    return made(state, "state", [&] {
        const rumple_wrinkle_mesh& m = given(model, "model");
        const auto* from = of_model(before, m, "state");
        const auto* touched = of_model(paint, m, "paint");
        const auto& at = given_of_model(pose, m, "pose");
        static const Paint nothing;
        Report how;
        State solved = sound_from(from ? &from->state : nullptr, [&](const State* last) {
            return solve_pose(*m.model, mesh_settings(settings), touched ? touched->paint : nothing,
                              input_of(at.arrays), at.pose, last, how);
        });
        if (report) *report = report_of(how);
        return new rumple_wrinkle_mesh_state{m.model, std::move(solved)};
    });
}

rumple_status rumple_wrinkle_mesh_show(const rumple_wrinkle_mesh* model,
                                       const rumple_wrinkle_mesh_settings* settings,
                                       const rumple_wrinkle_mesh_pose* pose,
                                       const rumple_wrinkle_mesh_state* state, bool in_viewport,
                                       rumple_frame** frame) {
    return made(frame, "frame", [&] {
        const rumple_wrinkle_mesh& m = given(model, "model");
        const auto& at = given_of_model(pose, m, "pose");
        Picture picture;
        show_pose(*m.model, mesh_settings(settings), input_of(at.arrays), at.pose,
                  given_of_model(state, m, "state").state, picture, in_viewport);
        return new_frame(m.model, sound(std::move(picture)), in_viewport);
    });
}

rumple_status rumple_wrinkle_mesh_measure(const rumple_wrinkle_mesh* model,
                                          const rumple_wrinkle_mesh_settings* settings,
                                          const rumple_wrinkle_mesh_paint* paint,
                                          const rumple_wrinkle_mesh_pose* pose,
                                          const rumple_wrinkle_mesh_state* state,
                                          rumple_wrinkle_mesh_measures* measures, float* offsets,
                                          size_t offsets_count) {
    return guarded([&] {
        const rumple_wrinkle_mesh& m = given(model, "model");
        const auto out =
            output<Vec3>(offsets, offsets_count, size_t(m.model->solved.vertex_count), "offsets");
        const auto& at = given_of_model(pose, m, "pose");
        const Measures found =
            measure_pose(*m.model, mesh_settings(settings), paint_in(model, paint), input_of(at.arrays),
                         at.pose, given_of_model(state, m, "state").state);
        const float sizes[] = {found.edge_error_before_rms,  found.edge_error_before_max,
                               found.edge_error_after_rms,   found.edge_error_after_max,
                               found.compressed_area_before, found.compressed_area_after,
                               found.attachment_violation,   found.largest_offset};
        if (!all_finite(sizes) || !all_finite(floats_of(found.offsets))) refuse_unsound();
        given(measures, "measures") = {found.edge_error_before_rms,  found.edge_error_before_max,
                                       found.edge_error_after_rms,   found.edge_error_after_max,
                                       found.compressed_area_before, found.compressed_area_after,
                                       found.attachment_violation,   found.largest_offset};
        write(found.offsets, out);
    });
}

rumple_status rumple_wrinkle_mesh_label_clip(const rumple_wrinkle_mesh* model,
                                             const rumple_wrinkle_mesh_settings* settings,
                                             const double* times, size_t times_count, const float* positions,
                                             size_t positions_count, bool raw, uint8_t* labels,
                                             size_t labels_count) {
    return guarded([&] {
        const Model& m = *given(model, "model").model;
        if (!m.adaptive) throw InvalidInput("model: expected one that was built with adaptive");
        label(m.base, m.adaptive->triangles, mesh_settings(settings).rest,
              {times, times_count, positions, positions_count, raw}, labels, labels_count);
    });
}

// ---- for a solver on the graphics card

rumple_status rumple_wrinkle_mesh_passes_build(const rumple_wrinkle_mesh* model,
                                               const rumple_wrinkle_mesh_settings* settings,
                                               const rumple_wrinkle_mesh_paint* paint,
                                               rumple_wrinkle_mesh_passes** passes) {
    return made(passes, "passes", [&] {
        const rumple_wrinkle_mesh& m = given(model, "model");
        return new rumple_wrinkle_mesh_passes{
            m.model, collect_passes(*m.model, mesh_settings(settings), paint_in(model, paint))};
    });
}

void rumple_wrinkle_mesh_passes_free(rumple_wrinkle_mesh_passes* passes) {
    delete passes;
}

rumple_status rumple_wrinkle_mesh_passes_get_view(const rumple_wrinkle_mesh_passes* passes,
                                                  rumple_wrinkle_mesh_passes_view* view) {
    return guarded([&] {
        const Passes& p = given(passes, "passes").passes;
        given(view, "view") = {.vertex_count = count(p.vertex),
                               .triangle_count = count(p.triangles),
                               .pair_count = count(p.pairs),
                               .distance_count = p.distance_count,
                               .pass_count = p.count,
                               .limit_count = count(p.limit.index),
                               .curved = p.curved,
                               .triangles = flat<int32_t>(p.triangles),
                               .vertex = p.vertex.data(),
                               .base_vertices = flat<int32_t>(p.base_vertices),
                               .weights = flat<float>(p.weights),
                               .limit_start = p.limit.start.data(),
                               .limit_vertex = p.limit.index.data(),
                               .limit_weight = p.limit.weight.data(),
                               .radius = p.radius.data(),
                               .depth = p.depth.data(),
                               .push = p.push.data(),
                               .noise = p.noise.data(),
                               .pairs = flat<int32_t>(p.pairs),
                               .of_pass = p.pass.data(),
                               .rest = p.rest.data(),
                               .stretched = p.stretched.data(),
                               .stiffness = p.stiffness.data()};
    });
}

rumple_status rumple_wrinkle_mesh_weld_pose(const rumple_wrinkle_mesh* model, const float* positions,
                                            size_t positions_count, float* welded, float* normals,
                                            float* smooth, size_t welded_count) {
    return guarded([&] {
        const Model& m = *given(model, "model").model;
        const auto expected = size_t(m.base.welded.vertex_count);
        const auto out = output<Vec3>(welded, welded_count, expected, "welded");
        const auto directions = output<Vec3>(normals, welded_count, expected, "normals");
        const auto places = output<Vec3>(smooth, welded_count, expected, "smooth");
        const WeldedPose pose = weld_pose(m, vectors(positions, positions_count, "positions"));
        write(pose.positions, out);
        write(pose.normals, directions);
        write(pose.smooth, places);
    });
}
