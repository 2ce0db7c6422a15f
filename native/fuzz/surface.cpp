// SPDX-License-Identifier: GPL-3.0-or-later
// Bases, coarse meshes, shown meshes and frames.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "world.h"

namespace rumple::fuzz {

double next_time = 0.0;

namespace {

void keep_surface(World& world, rumple_surface* surface, std::vector<float> rest, std::int32_t corners) {
    if (!surface) return;
    rumple_surface_view view;
    require(CALL(rumple_surface_get_view, surface, &view) == RUMPLE_OK, "no view", "rumple_surface_get_view");
    require(view.welded_vertex_count <= view.vertex_count, "welded", "rumple_surface_get_view");
    for (std::int32_t w = -1; w <= view.warning_count; ++w) {
        const char* warning = CALL(rumple_surface_warning, surface, w);
        require((warning != nullptr) == (w >= 0 && w < view.warning_count), "warning", "surface");
        require(!warning || std::strlen(warning) > 8, "warning without words", "surface");
    }
    auto base = std::make_shared<Base>();
    base->rest = std::move(rest);
    base->rest.resize(size_t(view.vertex_count) * 3);
    base->vertices = view.vertex_count;
    base->welded = view.welded_vertex_count;
    base->triangles = view.triangle_count;
    base->corners = corners;
    // The number of corners of a coarse mesh is unknown, but it has only triangles.
    base->polygons = corners == 0 ? view.triangle_count : (corners - view.triangle_count) / 2;
    world.surfaces.add(surface, std::move(base), 0);
}

// Creases for a number of sides of polygons. kind: 0 to 12.
struct Creases {
    std::vector<std::int32_t> ends;
    std::vector<float> sharpness;

    Creases(const std::vector<std::int32_t>& corner, size_t count, int kind) : sharpness(count, float(kind)) {
        for (size_t k = 0; k < count; ++k)
            ends.insert(ends.end(), {corner[k], corner[(k + 1) % corner.size()]});
        if (count == 0) return;
        if (kind == 4) ends.back() = -1;
        if (kind == 5) ends.front() = std::numeric_limits<std::int32_t>::max();
        if (kind == 6) sharpness.back() = std::numeric_limits<float>::quiet_NaN();
        if (kind == 7) sharpness.pop_back();
        if (kind == 8) sharpness.front() = std::numeric_limits<float>::infinity();
        if (kind < 3) sharpness.back() += 0.375f;
    }
};

void build_surface(World& world, Bytes& bytes) {
    const Mesh from = mesh(bytes);
    const Floats positions(from.positions, 3, bytes);
    const Numbers start(from.start, 1, bytes), corner(from.corner, 1, bytes),
        triangle(from.triangle, 3, bytes);
    rumple_surface_plan plan = CALL(rumple_surface_plan_default);
    plan.positions_rest = positions.pointer;
    plan.positions_rest_count = positions.count;
    plan.polygon_start = start.pointer;
    plan.polygon_start_count = start.count;
    plan.corner_vertex = corner.pointer;
    plan.corner_vertex_count = corner.count;
    plan.triangle_corner = triangle.pointer;
    plan.triangle_corner_count = triangle.count;
    const int chosen = bytes.byte();
    plan.weld_seams = chosen % 4 != 3;
    // Read from the same byte, so that kept inputs keep their meaning: how many sides of the polygons are
    // creased, and how.
    const size_t creased = from.corner.size() * size_t(chosen / 4 % 5) / 4;
    const Creases creases(from.corner, creased, chosen / 20);
    plan.crease_edge = creases.ends.data();
    plan.crease_edge_count = creased;
    plan.crease_sharpness = creases.sharpness.data();
    plan.crease_sharpness_count = creases.sharpness.size();
    keep_surface(world, MAKE(rumple_surface, rumple_surface_build, bytes.hostile() ? nullptr : &plan),
                 positions.data, std::int32_t(from.corner.size()));
}

// Heals any mesh. A surface can be built from every healed mesh.
void heal_mesh(World& world, Bytes& bytes) {
    const Mesh from = mesh(bytes);
    rumple_surface_plan plan = CALL(rumple_surface_plan_default);
    plan.positions_rest = from.positions.data();
    plan.positions_rest_count = from.positions.size() / 3;
    plan.polygon_start = from.start.data();
    plan.polygon_start_count = from.start.size();
    plan.corner_vertex = from.corner.data();
    plan.corner_vertex_count = from.corner.size();
    plan.triangle_corner = from.triangle.data();
    plan.triangle_corner_count = from.triangle.size() / 3;
    const auto* healed = world.healed.add(
        MAKE(rumple_healed, rumple_healed_build, bytes.hostile() ? nullptr : &plan), nullptr, 0);
    rumple_healed_view view;
    if (!healed || CALL(rumple_healed_get_view, healed->handle, &view) != RUMPLE_OK) return;
    const auto vertices = std::int32_t(plan.positions_rest_count),
               corners = std::int32_t(plan.corner_vertex_count),
               polygons = std::int32_t(plan.polygon_start_count) - 1;
    expect_within("vertex source", view.vertex_source, size_t(view.vertex_count), 0, vertices - 1);
    expect_within("corner source", view.corner_source, size_t(view.corner_count), 0, corners - 1);
    expect_within("polygon source", view.polygon_source, size_t(view.polygon_count), 0, polygons - 1);
    expect_within("turned", view.turned, size_t(view.turned_count), 0, polygons - 1);
    expect_within("cut", view.cut, 2 * size_t(view.cut_count), 0, vertices - 1);
    expect_within("doubled", view.doubled, 2 * size_t(view.doubled_count), 0, polygons - 1);
    expect_within("repeated", view.repeated, size_t(view.repeated_count), 0, polygons - 1);
    std::vector<float> rest;
    for (std::int32_t v = 0; v < view.vertex_count; ++v) {
        const float* at = &from.positions[size_t(view.vertex_source[v]) * 3];
        rest.insert(rest.end(), at, at + 3);
    }
    plan.positions_rest = rest.data();
    plan.positions_rest_count = rest.size() / 3;
    plan.polygon_start = view.polygon_start;
    plan.polygon_start_count = size_t(view.polygon_count) + 1;
    plan.corner_vertex = view.corner_vertex;
    plan.corner_vertex_count = size_t(view.corner_count);
    plan.triangle_corner = view.triangle_corner;
    plan.triangle_corner_count = size_t(view.triangle_count);
    rumple_surface* surface = MAKE(rumple_surface, rumple_surface_build, &plan);
    require(surface || std::strstr(rumple_error(), "at one place") || view.polygon_count == 0, rumple_error(),
            "rumple_healed_build");
    keep_surface(world, surface, std::move(rest), view.corner_count);
}

// If the call is refused, nothing is written. hostile: for one polygon too many.
void find_outer_side(const Entry<rumple_surface>& surface, bool hostile) {
    const size_t polygons = size_t(surface.base ? surface.base->polygons : 3) + (hostile ? 1 : 0);
    std::vector<std::uint8_t> outer(polygons + 1, 7);
    float thickness = -1.0f;
    const bool found =
        CALL(rumple_surface_outer_side, surface.handle, outer.data(), polygons, &thickness) == RUMPLE_OK;
    for (size_t p = 0; p < outer.size(); ++p)
        require(found && p < polygons ? outer[p] <= 1 : outer[p] == 7, "outer", "rumple_surface_outer_side");
    require(found ? thickness >= 0.0f && std::isfinite(thickness) : thickness == -1.0f, "thickness",
            "rumple_surface_outer_side");
}

void measure_surface(World& world, Bytes& bytes) {
    const auto surface = world.surfaces.pick(bytes);
    std::int32_t openings = -1;
    if (CALL(rumple_surface_count_openings, surface.handle, &openings) == RUMPLE_OK)
        require(openings >= 0, "openings", "rumple_surface_count_openings");
    const float up[3] = {bytes.real(-1.0f, 1.0f), bytes.real(-1.0f, 1.0f), bytes.real(-1.0f, 1.0f)};
    bool uneven = false;
    CALL(rumple_surface_is_uneven, surface.handle, up[0], &uneven);
    Written follow(surface.base ? size_t(surface.base->vertices) : 3, 1, bytes);
    follow.check(CALL(rumple_surface_suggest_follow, surface.handle, up, follow.pointer(), follow.count),
                 "follow");
    const size_t polygons = surface.base ? size_t(surface.base->polygons) : 3;
    std::vector<std::uint8_t> sewn(polygons, 2);
    if (CALL(rumple_surface_sewn_on, surface.handle, up, sewn.data(), polygons) == RUMPLE_OK)
        for (const std::uint8_t one : sewn) require(one < 2, "not written", "rumple_surface_sewn_on");
    find_outer_side(surface, up[0] > 0.9f);
}

void move_parts(Bytes& bytes) {
    const std::vector<std::int32_t> starts{0, bytes.whole(0, 3), bytes.whole(0, 6)};
    std::vector<float> from, to;
    for (int k = 0; k < 18; ++k) {
        from.push_back(bytes.real(-1.0f, 1.0f));
        to.push_back(bytes.real(-1.0f, 1.0f));
    }
    const size_t points = starts[2] < 0 ? 6 : std::min(size_t(starts[2]), size_t(6));
    Written motions(2, 12, bytes);
    motions.check(CALL(rumple_rigid_motions, starts.data(), starts.size(), from.data(), points, to.data(),
                       points, motions.pointer(), motions.count),
                  "motions");
}

void build_coarse(World& world, Bytes& bytes) {
    const auto dense = world.surfaces.pick(bytes);
    const float spacing = bytes.real(0.1f, 0.8f);
    // From the same number, so that most kept inputs keep their meaning.
    auto* coarse = spacing < 0.6f   ? MAKE(rumple_coarse, rumple_coarse_build, dense.handle, spacing)
                   : spacing < 0.7f ? MAKE(rumple_coarse, rumple_coarse_build_of, dense.handle,
                                           world.surfaces.pick(bytes).handle, spacing)
                                    : MAKE(rumple_coarse, rumple_coarse_as_modelled, dense.handle,
                                           dense.handle, spacing - 0.65f, 2.5f * (spacing - 0.65f));
    const auto* kept = world.coarses.add(coarse, dense.base, dense.id);
    rumple_coarse_view view;
    if (!kept || CALL(rumple_coarse_get_view, kept->handle, &view) != RUMPLE_OK) return;
    expect_within("base vertex", view.base_vertex, size_t(view.vertex_count), 0, dense.base->vertices - 1);
    expect_finite("mean edge", &view.mean_edge, 1);
    const std::vector<float> paint(size_t(dense.base->vertices), 0.5f);
    std::vector<float> carried(size_t(view.vertex_count));
    require(CALL(rumple_coarse_paint, kept->handle, paint.data(), paint.size(), carried.data(),
                 carried.size()) == RUMPLE_OK,
            "refused", "coarse paint");
    for (const float value : carried) require(std::abs(value - 0.5f) < 1e-5f, "not carried", "coarse paint");
    std::vector<float> rest;
    for (std::int32_t v = 0; v < view.vertex_count; ++v) {
        const float* at = &dense.base->rest[size_t(view.base_vertex[v]) * 3];
        rest.insert(rest.end(), at, at + 3);
    }
    auto* surface = MAKE(rumple_surface, rumple_coarse_surface, kept->handle);
    keep_surface(world, surface, std::move(rest), 0);
}

void pose_coarse(World& world, Bytes& bytes) {
    const auto coarse = world.coarses.pick(bytes);
    rumple_coarse_view view{};
    CALL(rumple_coarse_get_view, coarse.handle, &view);
    const Floats positions(coarse.base ? pose_of(coarse.base->rest, bytes) : std::vector<float>(9), 3, bytes);
    Written out(size_t(view.vertex_count), 3, bytes);
    out.check(CALL(rumple_coarse_positions, coarse.handle, positions.pointer, positions.count, out.pointer(),
                   out.count),
              "coarse positions");
}

void embed_frame(World& world, Bytes& bytes) {
    const auto frame = world.frames.pick(bytes);
    const Floats positions(frame.base ? pose_of(frame.base->rest, bytes) : std::vector<float>(9), 3, bytes);
    CALL(rumple_frame_embed, frame.handle, positions.pointer, positions.count);
    rumple_frame_view view;
    if (CALL(rumple_frame_get_view, frame.handle, &view) == RUMPLE_OK)
        expect_finite("embedded", view.local_offset, size_t(view.vertex_count) * 3);
}

// A frame must refuse the view of another system.
void look_at_frame(World& world, Bytes& bytes) {
    const auto frame = world.frames.pick(bytes);
    rumple_frame_waves_view waves;
    rumple_frame_folds_view folds;
    const bool of_field = CALL(rumple_frame_get_waves, frame.handle, &waves) == RUMPLE_OK,
               of_paths = CALL(rumple_frame_get_folds, frame.handle, &folds) == RUMPLE_OK;
    require(!(of_field && of_paths), "of two systems", "frame");
}

// A call is watched from before its start. It may end with RUMPLE_STOPPED only if the stop was asked for.
void stop_one(World& world, Bytes& bytes) {
    rumple_stop* stop = MAKE(rumple_stop, rumple_stop_build);
    RUN(rumple_stop_watch, stop);
    asked_to_stop = bytes.below(2) == 0;
    if (asked_to_stop) RUN(rumple_stop_ask, stop);
    build_surface(world, bytes);
    RUN(rumple_stop_watch, nullptr);
    asked_to_stop = false;
    RUN(rumple_stop_ask, bytes.hostile() ? nullptr : stop);
    RUN(rumple_stop_free, stop);
}

void look_at_library(World& world, Bytes& bytes) {
    require(std::strcmp(CALL(rumple_version), RUMPLE_VERSION) == 0, "version", "rumple_version");
    require(CALL(rumple_struct_size, "rumple_pose") == sizeof(rumple_pose), "size", "rumple_struct_size");
    require(CALL(rumple_struct_size, bytes.hostile() ? nullptr : "rumple") == 0, "size",
            "rumple_struct_size");
    require(CALL(rumple_error) != nullptr, "NULL", "rumple_error");
    world.surfaces.free_one(bytes);
    RUN(rumple_surface_free, nullptr);
    stop_one(world, bytes);
    move_parts(bytes);
}

void free_one(World& world, Bytes& bytes) {
    free_one_of(bytes, world.frames, world.coarses, world.meshes, world.fields, world.healed);
}

}  // namespace

void check_shown(const rumple_shown_mesh* shown, Bytes& bytes) {
    rumple_shown_mesh_view view;
    if (CALL(rumple_shown_mesh_get_view, shown, &view) != RUMPLE_OK) return;
    const auto vertices = size_t(view.vertex_count), corners = size_t(view.corner_count);
    expect_starts("shown polygons", view.polygon_start, size_t(view.polygon_count) + 1, view.corner_count);
    expect_within("shown corner", view.corner_vertex, corners, 0, view.vertex_count - 1);
    expect_within("shown edge", view.edges, size_t(view.edge_count) * 2, 0, view.vertex_count - 1);
    expect_finite("shown rest", view.positions_rest, vertices * 3);
    expect_finite("barycentric", view.barycentric, vertices * 2);
    const int columns = 1 + bytes.below(3);
    // As many rows as any source can have here. The library reports how many it needs.
    const Floats from(values(6000 * size_t(columns), -1.0f, 1.0f, bytes), size_t(columns), bytes);
    Written points(vertices, size_t(columns), bytes), of_corners(corners, size_t(columns), bytes);
    if (from.pointer && from.count > 6001) return;
    const std::int32_t asked = bytes.hostile() ? bytes.below(2) - 1 : columns;
    const rumple_status carried = CALL(rumple_shown_mesh_carry_points, shown, from.pointer, from.count, asked,
                                       points.pointer(), points.count);
    require(carried != RUMPLE_OK || asked == columns, "columns", "rumple_shown_mesh_carry_points");
    CALL(rumple_shown_mesh_carry_corners, shown, from.pointer, from.count, asked, of_corners.pointer(),
         of_corners.count);
}

void add_frame(World& world, rumple_frame* frame, const std::shared_ptr<const Base>& base, int model) {
    rumple_frame_view view;
    if (!frame || CALL(rumple_frame_get_view, frame, &view) != RUMPLE_OK) return;
    const auto vertices = size_t(view.vertex_count);
    expect_finite("frame positions", view.positions, 3 * vertices);
    expect_finite("local offset", view.local_offset, 3 * vertices);
    expect_finite("offset", view.offset, 3 * vertices);
    expect_finite("stretch min", view.stretch_min, vertices);
    expect_finite("stretch max", view.stretch_max, vertices);
    expect_finite("stretch direction", view.stretch_direction, 3 * vertices);
    if (base) {  // in its own rest pose, because random calls seldom have a frame with positions that fit it
        require(CALL(rumple_frame_embed, frame, base->rest.data(), base->rest.size() / 3) == RUMPLE_OK,
                "embedded at rest", "frame");
        expect_finite("embedded", view.local_offset, 3 * vertices);
    }
    world.frames.add(frame, base, model);
}

Posed::Posed(const Base& base, Bytes& bytes) {
    positions = pose_of(base.rest, bytes);
    pose = CALL(rumple_pose_default);
    pose.positions = positions.data();
    pose.positions_count = positions.size() / 3;
    pose.time = bytes.hostile() ? double(bytes.real(-1.0f, 1.0f)) : next_time;
    next_time += 0.04;
    if (bytes.byte() % 8 == 7) {
        next = pose_of(base.rest, bytes);
        pose.next_positions = next.data();
        pose.next_positions_count = next.size() / 3;
        pose.next_time = bytes.hostile() ? double(bytes.real(-1.0f, 1.0f)) : next_time;
    }
    if (bytes.byte() % 8 == 7) {
        labels.assign(size_t(base.triangles), std::uint8_t(bytes.below(4)));
        pose.labels = labels.data();
        pose.labels_count = labels.size();
    }
    if (bytes.byte() % 8 == 7) pose.world_from_object[bytes.below(9)] = bytes.real(-2.0f, 2.0f);
    if (bytes.hostile()) --pose.positions_count;
}

Clip::Clip(const Base& base, Bytes& bytes)
    : times({0.0, 0.04, bytes.hostile() ? double(bytes.real(-1.0f, 1.0f)) : 0.08}, 1, bytes),
      positions(
          [&] {
              std::vector<float> all;
              for (int f = 0; f < 3; ++f) {
                  const std::vector<float> one = pose_of(base.rest, bytes);
                  all.insert(all.end(), one.begin(), one.end());
              }
              return all;
          }(),
          3, bytes),
      labels(3 * size_t(base.triangles), 9) {}

void Clip::check(rumple_status status) const {
    for (const std::uint8_t label : labels) {
        require(status == RUMPLE_OK ? label <= 2 : label == 9, "label", "label_clip");
    }
}

void vary(rumple_reference_settings& s, Bytes& bytes) {
    s.reference = bytes.whole(0, 2);
    bytes.vary(s.window, s.relaxation, s.growth, s.growth_time);
}

rumple_fine_plan fine_plan(rumple_fine_plan plan, Bytes& bytes) {
    constexpr std::int32_t kMost[] = {800, 800, 800, 300, 100, 0, -1, std::numeric_limits<int32_t>::min()};
    plan.source = bytes.whole(0, 3);
    plan.level = bytes.whole(0, 2);
    plan.segments = bytes.whole(1, 3);
    plan.longest_edge = bytes.real(0.1f, 0.5f);
    plan.most_vertices = kMost[bytes.below(std::size(kMost))];
    plan.attachment = bytes.whole(0, 2);
    return plan;
}

const std::vector<Operation> kSurface = {build_surface, heal_mesh,       measure_surface,
                                         build_coarse,  pose_coarse,     embed_frame,
                                         look_at_frame, look_at_library, free_one};

}  // namespace rumple::fuzz
