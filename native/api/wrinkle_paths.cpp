// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/wrinkle_paths.h"

#include "api/sound.h"
#include "base/expect.h"

using namespace rumple;
using namespace rumple::api;
using namespace rumple::wrinkle_paths;

// Lists all fields once, for both directions: see api/settings.h.
template <typename Pair>
static void pair_fields(rumple_wrinkle_paths_settings& c, Settings& native, const Pair& pair) {
    pair_reference(c.rest, native.rest, pair);
    pair(c.smoothing, native.smoothing);
    pair(c.threshold, native.threshold);
    pair(c.reach, native.reach);
    pair(c.width, native.width);
    pair(c.spacing, native.spacing);
    pair(c.alignment, native.alignment);
    pair(c.bend_radius, native.bend_radius);
    pair(c.hem_rings, native.hem_rings);
    pair(c.growth_limit, native.growth_limit);
    pair(c.fade, native.fade);
    pair(c.persistent, native.persistent);
    pair(c.seed, native.seed);
    pair.choose("profile", c.profile, native.profile, Profile::kSine);
    pair.choose("direction", c.direction, native.direction, Direction::kBoth);
    pair(c.height, native.height);
    pair(c.threads, native.threads);
}
static_assert(int(Profile::kSpline) == RUMPLE_FOLD_SPLINE && int(Profile::kSine) == RUMPLE_FOLD_SINE);

const PathArrays& rumple_wrinkle_paths_state::arrays() const {
    std::call_once(flattened_, [this] {
        PathArrays& a = arrays_;
        for (const Path& path : state.paths) {
            a.id.push_back(path.id);
            a.fade.push_back(path.fade);
            for (const PathPoint& p : path.points) {
                a.triangle_edge.insert(a.triangle_edge.end(), {p.triangle, p.edge});
                a.at.push_back(p.at);
            }
            a.start.push_back(static_cast<Index>(a.at.size()));
        }
    });
    return arrays_;
}

namespace rumple::api {

Settings paths_settings(const rumple_wrinkle_paths_settings* settings) {
    return native_of<Settings>(settings, "settings");
}

Input input_of(const FrameArrays& arrays) {
    return {arrays.frame_time(), arrays.positions};
}

}  // namespace rumple::api

namespace {

template <typename T>
size_t bytes(const std::vector<T>& values) {
    return values.size() * sizeof(T);
}

// flat: the copy of the paths for a view.
size_t bytes_of(const State& state, const PathArrays& flat) {
    size_t points = 0;
    for (const Path& path : state.paths) points += bytes(path.points);
    return state.reference.bytes() + bytes(state.compression) + bytes(state.width) + bytes(state.shapes) +
           bytes(state.paths) + points + bytes(flat.id) + bytes(flat.fade) + bytes(flat.start) +
           bytes(flat.triangle_edge) + bytes(flat.at);
}

std::vector<Path> paths_of(const rumple_wrinkle_paths_state_view& from) {
    const auto id = values(from.path_id, from.path_id_count, "path_id");
    const auto fade = values(from.path_fade, from.path_fade_count, "path_fade");
    const auto start = values(from.path_start, from.path_start_count, "path_start");
    const auto place = rows<std::array<Index, 2>>(from.point_triangle_edge, from.point_triangle_edge_count,
                                                  "point_triangle_edge");
    const auto at = rows<Vec2>(from.point_at, from.point_at_count, "point_at");
    expect_rows("path_fade", fade.size(), id.size());
    expect_rows("path_start", start.size(), id.size() + 1);
    expect_rows("point_at", at.size(), place.size());
    std::vector<Path> paths;
    for (size_t i = 0; i < id.size(); ++i) {
        if (start[i] < 0 || start[i + 1] < start[i] || size_t(start[i + 1]) > at.size())
            throw InvalidInput("path_start: path " + std::to_string(i) + " is not within the points");
        Path path{id[i], fade[i], {}};
        for (Index p = start[i]; p < start[i + 1]; ++p)
            path.points.push_back({place[p][0], place[p][1], at[p]});
        paths.push_back(std::move(path));
    }
    return paths;
}

// Ids must be ascending, as paths are created, and below next_id.
void check_ids(const std::vector<Path>& paths, Index next_id) {
    Index least = 0;
    for (const Path& path : paths) {
        if (path.id < least || path.id >= next_id) {
            throw InvalidInput("path_id: expected " + std::to_string(least) + " to " +
                               std::to_string(next_id - 1) + ", got " + std::to_string(path.id));
        }
        least = path.id + 1;
    }
    expect_within("next_id", next_id, 0, kMostPathIds);
}

}  // namespace

// ---- the model

rumple_fine_plan rumple_wrinkle_paths_plan_default(void) {
    FineSource source;
    source.level = 3;
    source.segments = 8;
    source.longest_edge = 0.005f;
    return fine_plan(source);
}

rumple_status rumple_wrinkle_paths_build(const rumple_surface* base, const rumple_fine_plan* plan,
                                         rumple_wrinkle_paths** model) {
    return made(model, "model", [&] {
        const Surface& surface = given(base, "base").surface;
        const rumple_fine_plan& from = given(plan, "plan");
        auto built = build(surface, fine_source(from), attachment_kind(from));
        const ShownMesh& shown = built->shown;
        return new rumple_wrinkle_paths{std::move(built), rumple_shown_mesh(shown)};
    });
}

void rumple_wrinkle_paths_free(rumple_wrinkle_paths* model) {
    delete model;
}

const rumple_shown_mesh* rumple_wrinkle_paths_shown(const rumple_wrinkle_paths* model) {
    return model ? &model->shown : nullptr;
}

rumple_status rumple_wrinkle_paths_get_view(const rumple_wrinkle_paths* model,
                                            rumple_wrinkle_paths_view* view) {
    return guarded([&] {
        const Model& m = *given(model, "model").model;
        given(view, "view") = {m.triangles.net.triangles(), m.triangles.net.vertex.data()};
    });
}

rumple_wrinkle_paths_settings rumple_wrinkle_paths_settings_default(void) {
    return default_of<rumple_wrinkle_paths_settings, Settings>();
}

rumple_status rumple_wrinkle_paths_paint_build(const rumple_wrinkle_paths* model,
                                               const rumple_wrinkle_paths_painted* painted,
                                               rumple_wrinkle_paths_paint** paint) {
    return made(paint, "paint", [&] {
        const rumple_wrinkle_paths& m = given(model, "model");
        const rumple_wrinkle_paths_painted& from = given(painted, "painted");
        const Surface& base = m.model->base;
        Paint made{api::painted(from.mask, from.mask_count, base, "mask"),
                   api::painted(from.width, from.width_count, base, "width", kLeastWidth),
                   copied(vectors(from.along, from.along_count, "along"))};
        if (!made.along.empty()) check_along(base, made.along);
        return new rumple_wrinkle_paths_paint{m.model, std::move(made)};
    });
}

void rumple_wrinkle_paths_paint_free(rumple_wrinkle_paths_paint* paint) {
    delete paint;
}

// ---- frames

rumple_status rumple_wrinkle_paths_pose_build(const rumple_wrinkle_paths* model, const rumple_pose* frame,
                                              rumple_wrinkle_paths_pose** pose) {
    return made_pose(model, frame, pose,
                     [](const auto& m, const auto& arrays) { return make_pose(m, arrays.positions); });
}

void rumple_wrinkle_paths_pose_free(rumple_wrinkle_paths_pose* pose) {
    delete pose;
}

void rumple_wrinkle_paths_state_free(rumple_wrinkle_paths_state* state) {
    delete state;
}

rumple_status rumple_wrinkle_paths_state_get_view(const rumple_wrinkle_paths_state* state,
                                                  rumple_wrinkle_paths_state_view* view) {
    return guarded([&] {
        const State& s = given(state, "state").state;
        const PathArrays& a = state->arrays();
        given(view, "view") = {.reference = view_of(s.reference),
                               .shapes = flat<float>(s.shapes),
                               .shapes_count = s.shapes.size(),
                               .compression = s.compression.data(),
                               .compression_count = s.compression.size(),
                               .width = s.width.data(),
                               .width_count = s.width.size(),
                               .path_id = a.id.data(),
                               .path_id_count = a.id.size(),
                               .path_fade = a.fade.data(),
                               .path_fade_count = a.fade.size(),
                               .path_start = a.start.data(),
                               .path_start_count = a.start.size(),
                               .point_triangle_edge = a.triangle_edge.data(),
                               .point_triangle_edge_count = a.at.size(),
                               .point_at = flat<float>(a.at),
                               .point_at_count = a.at.size(),
                               .next_id = s.next_id,
                               .bytes = bytes_of(s, a)};
    });
}

rumple_status rumple_wrinkle_paths_state_build(const rumple_wrinkle_paths* model,
                                               const rumple_wrinkle_paths_state_view* arrays,
                                               rumple_wrinkle_paths_state** state) {
    return made(state, "state", [&] {
        const rumple_wrinkle_paths& m = given(model, "model");
        const rumple_wrinkle_paths_state_view& from = given(arrays, "arrays");
        State made;
        made.reference = state_of(from.reference);
        made.shapes = copied(rows<FlatTriangle>(from.shapes, from.shapes_count, "shapes"));
        made.compression = copied(values(from.compression, from.compression_count, "compression"));
        made.width = copied(values(from.width, from.width_count, "width"));
        made.paths = paths_of(from);
        made.next_id = from.next_id;
        check(*m.model, made);
        check_ids(made.paths, made.next_id);
        return new rumple_wrinkle_paths_state(m.model, std::move(made));
    });
}

rumple_status rumple_wrinkle_paths_state_check(const rumple_wrinkle_paths_state* state) {
    return guarded([&] {
        const rumple_wrinkle_paths_state& s = given(state, "state");
        const std::string wrong = validate(*s.model, s.state.paths);
        if (!wrong.empty()) throw InvalidInput(wrong);
    });
}

rumple_status rumple_wrinkle_paths_solve(const rumple_wrinkle_paths* model,
                                         const rumple_wrinkle_paths_settings* settings,
                                         const rumple_wrinkle_paths_paint* paint,
                                         const rumple_wrinkle_paths_pose* pose,
                                         const rumple_wrinkle_paths_state* before,
                                         rumple_wrinkle_paths_report* report,
                                         rumple_wrinkle_paths_state** state) {
    return made(state, "state", [&] {
        const rumple_wrinkle_paths& m = given(model, "model");
        const auto* from = of_model(before, m, "state");
        const auto* touched = of_model(paint, m, "paint");
        static const Paint nothing;
        const auto& at = given_of_model(pose, m, "pose");
        Report how;
        State solved = sound_from(from ? &from->state : nullptr, [&](const State* last) {
            return solve(*m.model, paths_settings(settings), touched ? touched->paint : nothing,
                         input_of(at.arrays), at.pose, last, how);
        });
        if (report) {
            *report = {how.paths,
                       how.born,
                       how.died,
                       how.merging,
                       how.compressed,
                       how.stretched,
                       how.collapsed_triangles,
                       how.moved_mean,
                       how.moved_most};
        }
        return new rumple_wrinkle_paths_state(m.model, std::move(solved));
    });
}

rumple_status rumple_wrinkle_paths_show(const rumple_wrinkle_paths* model,
                                        const rumple_wrinkle_paths_settings* settings,
                                        const rumple_wrinkle_paths_pose* pose,
                                        const rumple_wrinkle_paths_state* state, rumple_frame** frame) {
    return made(frame, "frame", [&] {
        const rumple_wrinkle_paths& m = given(model, "model");
        Picture picture;
        show(*m.model, paths_settings(settings), given_of_model(pose, m, "pose").pose,
             given_of_model(state, m, "state").state, picture);
        return new_frame(m.model, sound(std::move(picture)));
    });
}

rumple_status rumple_frame_get_folds(const rumple_frame* frame, rumple_frame_folds_view* view) {
    return guarded([&] {
        const auto* p = std::get_if<Picture>(&given(frame, "frame").picture);
        if (!p) throw InvalidInput("frame: expected one of Wrinkle Paths");
        given(view, "view") = {count(p->height), p->height.data()};
    });
}

rumple_status rumple_wrinkle_paths_label_clip(const rumple_wrinkle_paths* model,
                                              const rumple_wrinkle_paths_settings* settings,
                                              const double* times, size_t times_count, const float* positions,
                                              size_t positions_count, bool raw, uint8_t* labels,
                                              size_t labels_count) {
    return guarded([&] {
        const Model& m = *given(model, "model").model;
        label(m.base, m.triangles, paths_settings(settings).rest,
              {times, times_count, positions, positions_count, raw}, labels, labels_count);
    });
}
