// SPDX-License-Identifier: GPL-3.0-or-later
// Curves and drawings of the Wrinkle Paths.
#include "api/sound.h"
#include "api/wrinkle_paths.h"
#include "base/expect.h"
#include "systems/wrinkle_paths/curves.h"
#include "systems/wrinkle_paths/preview.h"

using namespace rumple;
using namespace rumple::api;
using namespace rumple::wrinkle_paths;

struct rumple_curves {
    RidingCurves curves;
};
struct rumple_drawing {
    std::shared_ptr<const Model> model;
    Drawing drawing;  // without the surface, only the lists
    bool has_surface;
};

void rumple_curves_free(rumple_curves* curves) {
    delete curves;
}

rumple_status rumple_curves_get_view(const rumple_curves* curves, rumple_curves_view* view) {
    return guarded([&] {
        const RidingCurves& riding = given(curves, "curves").curves;
        const Curves& c = riding.curves;
        given(view, "view") = {count(c.id),
                               count(c.positions),
                               count(riding.corners),
                               c.start.data(),
                               c.id.data(),
                               flat<float>(c.positions),
                               c.width.data(),
                               c.height.data(),
                               flat<int32_t>(riding.corners),
                               flat<float>(riding.weights),
                               flat<float>(riding.local_offset)};
    });
}

rumple_status rumple_wrinkle_paths_trace(const rumple_wrinkle_paths* model,
                                         const rumple_wrinkle_paths_settings* settings,
                                         const rumple_wrinkle_paths_pose* pose,
                                         const rumple_wrinkle_paths_state* state, rumple_curves** traced) {
    return made(traced, "curves", [&] {
        const rumple_wrinkle_paths& m = given(model, "model");
        const State& at = given_of_model(state, m, "state").state;
        RidingCurves lines;
        lines.curves = curves(*m.model, paths_settings(settings), given_of_model(pose, m, "pose").pose, at);
        return new rumple_curves{sound(std::move(lines))};
    });
}

rumple_status rumple_wrinkle_paths_ride(const rumple_wrinkle_paths* model,
                                        const rumple_wrinkle_paths_settings* settings,
                                        const rumple_wrinkle_paths_pose* pose, const float* animated,
                                        size_t animated_count, const rumple_wrinkle_paths_state* state,
                                        rumple_curves** ridden) {
    return made(ridden, "curves", [&] {
        const rumple_wrinkle_paths& m = given(model, "model");
        const State& at = given_of_model(state, m, "state").state;
        return new rumple_curves{
            sound(ride(*m.model, paths_settings(settings), given_of_model(pose, m, "pose").pose, at,
                       vectors(animated, animated_count, "animated")))};
    });
}

rumple_status rumple_wrinkle_paths_stretches(const rumple_wrinkle_paths* model,
                                             const rumple_wrinkle_paths_pose* pose,
                                             const rumple_wrinkle_paths_state* state, float* out,
                                             size_t out_count) {
    return guarded([&] {
        const rumple_wrinkle_paths& m = given(model, "model");
        const State& at = given_of_model(state, m, "state").state;
        const auto to = output<Vec2>(out, out_count, size_t(m.model->triangles.net.triangles()), "stretches");
        const std::vector<Stretch> found =
            stretches(*m.model, at, given_of_model(pose, m, "pose").pose.base.positions);
        for (size_t t = 0; t < to.size(); ++t) to[t] = {found[t].compression, found[t].stretch};
    });
}

rumple_status rumple_wrinkle_paths_ellipses(const rumple_wrinkle_paths* model,
                                            const rumple_wrinkle_paths_pose* pose,
                                            const rumple_wrinkle_paths_state* state, float size, float* out,
                                            size_t out_count) {
    return guarded([&] {
        const rumple_wrinkle_paths& m = given(model, "model");
        const auto to =
            output<Ellipse>(out, out_count, size_t(m.model->triangles.net.triangles()), "ellipses");
        expect_within("size", size, 0.0, 1e6);
        write(sound(ellipses(*m.model, given_of_model(pose, m, "pose").pose,
                             given_of_model(state, m, "state").state, size)),
              to);
    });
}

// ---- drawings

void rumple_drawing_free(rumple_drawing* drawing) {
    delete drawing;
}

rumple_status rumple_drawing_get_view(const rumple_drawing* drawing, rumple_drawing_view* view) {
    return guarded([&] {
        const Drawing& d = given(drawing, "drawing").drawing;
        given(view, "view") = {.vertex_count = count(d.flat),
                               .base_vertex_count = count(d.proxy_offset),
                               .part_count = count(d.parts),
                               .triangle_count = count(d.lists.triangle_start) - 1,
                               .range_count = count(d.lists.ranges),
                               .end_count = count(d.lists.ends),
                               .curved = d.curved,
                               .flat = flat<float>(d.flat),
                               .smooth = flat<float>(d.smooth),
                               .normal = flat<float>(d.normal),
                               .hem = d.hem.data(),
                               .parts = flat<int32_t>(d.parts),
                               .proxy_offset = flat<float>(d.proxy_offset),
                               .triangle_start = d.lists.triangle_start.data(),
                               .ranges = flat<int32_t>(d.lists.ranges),
                               .ends = flat<float>(d.lists.ends)};
    });
}

rumple_status rumple_wrinkle_paths_draw(const rumple_wrinkle_paths* model,
                                        const rumple_wrinkle_paths_settings* settings,
                                        const rumple_wrinkle_paths_pose* pose,
                                        const rumple_wrinkle_paths_state* state, rumple_drawing** drawing) {
    return made(drawing, "drawing", [&] {
        const rumple_wrinkle_paths& m = given(model, "model");
        const State& at = given_of_model(state, m, "state").state;
        const auto& in = given_of_model(pose, m, "pose");
        return new rumple_drawing{
            m.model, sound(draw(*m.model, paths_settings(settings), input_of(in.arrays), in.pose, at)), true};
    });
}

rumple_status rumple_wrinkle_paths_list(const rumple_wrinkle_paths* model,
                                        const rumple_wrinkle_paths_settings* settings,
                                        const rumple_wrinkle_paths_pose* pose,
                                        const rumple_wrinkle_paths_state* state, rumple_drawing** drawing) {
    return made(drawing, "drawing", [&] {
        const rumple_wrinkle_paths& m = given(model, "model");
        const State& at = given_of_model(state, m, "state").state;
        Drawing lists;
        lists.lists = build_triangle_lists(*m.model, paths_settings(settings),
                                           given_of_model(pose, m, "pose").pose, at);
        return new rumple_drawing{m.model, sound(std::move(lists)), false};
    });
}

rumple_status rumple_drawing_evaluate(const rumple_drawing* drawing,
                                      const rumple_wrinkle_paths_settings* settings, const int32_t* triangles,
                                      const float* barycentric, size_t place_count, float* out) {
    return guarded([&] {
        const rumple_drawing& d = given(drawing, "drawing");
        if (!d.has_surface) throw InvalidInput("drawing: expected one of rumple_wrinkle_paths_draw()");
        const Settings options = paths_settings(settings);
        const auto which = values(triangles, place_count, "triangles");
        const auto weights = rows<Vec2>(barycentric, place_count, "barycentric");
        const auto to = output<std::array<float, 7>>(out, place_count, place_count, "out");
        expect_finite("barycentric", weights, "place");
        expect_places(which, weights, size_t(d.model->triangles.net.triangles()));
        for (size_t i = 0; i < which.size(); ++i) {
            const Drawn at = drawn_at(*d.model, options, d.drawing, {which[i], weights[i].x, weights[i].y});
            to[i] = {at.position.x, at.position.y, at.position.z, at.height,
                     at.normal.x,   at.normal.y,   at.normal.z};
        }
    });
}
