// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>

#include "api/handles.h"
#include "api/sound.h"
#include "base/expect.h"
#include "rumple.h"
#include "surface/cloth/locomotion.h"
#include "surface/cloth/outer_side.h"
#include "surface/cloth/pins.h"
#include "surface/mesh/heal.h"
#include "surface/mesh/positions.h"
#include "surface/mesh/uneven.h"

using namespace rumple;
using namespace rumple::api;

rumple_surface_plan rumple_surface_plan_default(void) {
    rumple_surface_plan plan{};
    plan.weld_seams = SurfaceInput{}.weld_seams;
    return plan;
}

namespace {

SurfaceInput input_of(const rumple_surface_plan& plan) {
    SurfaceInput input;
    input.positions_rest = vectors(plan.positions_rest, plan.positions_rest_count, "positions_rest");
    input.polygon_start = values(plan.polygon_start, plan.polygon_start_count, "polygon_start");
    input.corner_vertex = values(plan.corner_vertex, plan.corner_vertex_count, "corner_vertex");
    rows<std::array<Index, 3>>(plan.triangle_corner, plan.triangle_corner_count, "triangle_corner");
    input.triangle_corner = {plan.triangle_corner, 3 * plan.triangle_corner_count};
    input.weld_seams = plan.weld_seams;
    check_coordinates("positions_rest", input.positions_rest);
    return input;
}

std::vector<Crease> creases_of(const rumple_surface_plan& plan) {
    const auto edges = rows<std::array<Index, 2>>(plan.crease_edge, plan.crease_edge_count, "crease_edge");
    const auto sharpness = values(plan.crease_sharpness, plan.crease_sharpness_count, "crease_sharpness");
    expect_rows("crease_sharpness", sharpness.size(), edges.size());
    std::vector<Crease> creases;
    for (size_t k = 0; k < edges.size(); ++k) creases.push_back({edges[k][0], edges[k][1], sharpness[k]});
    return creases;
}

// An argument `up`.
Vec3 direction(const float up[3]) {
    given(up, "up");
    expect_within("length of up", glm::length(Vec3(up[0], up[1], up[2])), 0.5, 2.0);
    return {up[0], up[1], up[2]};
}

}  // namespace

struct rumple_healed {
    HealedMesh mesh;
};

rumple_status rumple_healed_build(const rumple_surface_plan* plan, rumple_healed** healed) {
    return made(healed, "healed",
                [&] { return new rumple_healed{heal_mesh(input_of(given(plan, "plan")))}; });
}

void rumple_healed_free(rumple_healed* healed) {
    delete healed;
}

rumple_status rumple_healed_get_view(const rumple_healed* healed, rumple_healed_view* view) {
    return guarded([&] {
        const HealedMesh& m = given(healed, "healed").mesh;
        given(view, "view") = {.vertex_count = m.mesh.vertex_count,
                               .polygon_count = m.mesh.polygons(),
                               .corner_count = m.mesh.corners(),
                               .triangle_count = count(m.triangle_corner) / 3,
                               .turned_count = count(m.turned),
                               .cut_count = count(m.cut),
                               .doubled_count = count(m.doubled),
                               .repeated_count = count(m.repeated),
                               .polygon_start = m.mesh.polygon_start.data(),
                               .corner_vertex = m.mesh.corner_vertex.data(),
                               .triangle_corner = m.triangle_corner.data(),
                               .vertex_source = m.vertex_source.data(),
                               .corner_source = m.corner_source.data(),
                               .polygon_source = m.polygon_source.data(),
                               .turned = m.turned.data(),
                               .cut = flat<int32_t>(m.cut),
                               .doubled = flat<int32_t>(m.doubled),
                               .repeated = m.repeated.data()};
    });
}

rumple_status rumple_surface_build(const rumple_surface_plan* plan, rumple_surface** surface) {
    return made(surface, "surface", [&] {
        SurfaceInput input = input_of(given(plan, "plan"));
        const std::vector<Crease> creases = creases_of(*plan);
        input.creases = creases;
        return new rumple_surface(std::make_shared<const Surface>(build_surface(input)));
    });
}

void rumple_surface_free(rumple_surface* surface) {
    delete surface;
}

rumple_status rumple_surface_get_view(const rumple_surface* surface, rumple_surface_view* view) {
    return guarded([&] {
        const Surface& s = given(surface, "surface").surface;
        given(view, "view") = {s.display.vertex_count, s.welded.vertex_count, count(s.triangles),
                               count(s.warnings)};
    });
}

const char* rumple_surface_warning(const rumple_surface* surface, int32_t number) {
    if (!surface || number < 0 || size_t(number) >= surface->surface.warnings.size()) return nullptr;
    return surface->surface.warnings[number].c_str();
}

rumple_status rumple_surface_count_openings(const rumple_surface* surface, int32_t* openings) {
    return guarded([&] { given(openings, "openings") = count_openings(given(surface, "surface").surface); });
}

rumple_status rumple_surface_is_uneven(const rumple_surface* surface, float width, bool* uneven) {
    return guarded([&] { given(uneven, "uneven") = is_uneven(given(surface, "surface").surface, width); });
}

rumple_status rumple_surface_outer_side(const rumple_surface* surface, uint8_t* outer, size_t outer_count,
                                        float* thickness) {
    return guarded([&] {
        const Surface& s = given(surface, "surface").surface;
        const auto out = output<uint8_t>(outer, outer_count, size_t(s.display.polygons()), "outer");
        float& median = given(thickness, "thickness");
        const OuterSide found = outer_side(s);
        std::ranges::copy(found.polygons, out.begin());
        median = found.thickness;
    });
}

rumple_status rumple_surface_suggest_follow(const rumple_surface* surface, const float up[3], float* follow,
                                            size_t follow_count) {
    return guarded([&] {
        const Surface& s = given(surface, "surface").surface;
        const Vec3 upwards = direction(up);
        const auto out = output<float>(follow, follow_count, size_t(s.display.vertex_count), "follow");
        write(suggest_follow(s, upwards), out);
    });
}

rumple_status rumple_surface_sewn_on(const rumple_surface* surface, const float up[3], uint8_t* sewn,
                                     size_t sewn_count) {
    return guarded([&] {
        const Surface& s = given(surface, "surface").surface;
        const Vec3 upwards = direction(up);
        const auto out = output<uint8_t>(sewn, sewn_count, size_t(s.display.polygons()), "sewn");
        std::ranges::copy(find_sewn_on(s, upwards), out.begin());
    });
}

// ---- the shown mesh

rumple_status rumple_shown_mesh_get_view(const rumple_shown_mesh* mesh, rumple_shown_mesh_view* view) {
    return guarded([&] {
        const ShownMesh& m = given(mesh, "mesh").mesh;
        given(view, "view") = {.vertex_count = m.mesh.vertex_count,
                               .polygon_count = m.mesh.polygons(),
                               .corner_count = m.mesh.corners(),
                               .edge_count = count(m.edges),
                               .solved_count = count(m.from_solved.index),
                               .polygon_start = m.mesh.polygon_start.data(),
                               .corner_vertex = m.mesh.corner_vertex.data(),
                               .polygon_source = m.polygon_source.data(),
                               .edges = flat<int32_t>(m.edges),
                               .edge_sources = flat<int32_t>(m.edge_sources),
                               .positions_rest = flat<float>(m.positions_rest),
                               .triangle_vertex = flat<int32_t>(m.embedding),
                               .barycentric = flat<float>(mesh->barycentric),
                               .solved_start = m.from_solved.start.data(),
                               .solved_vertex = m.from_solved.index.data(),
                               .solved_weight = m.from_solved.weight.data()};
    });
}

namespace {

struct Table {
    const float* values;
    size_t count;
    int32_t columns;
    size_t least;  // least number of rows that are read
};

// Writes a row of `rows` for every row of the output. row_of(r): its number, and the column that is counted
// from.
template <typename RowOf>
void carry(const SparseRows& rows, Index count, const RowOf& row_of, const Table& from, float* out,
           size_t out_count) {
    if (from.columns < 1)
        throw InvalidInput("columns: expected at least 1, got " + std::to_string(from.columns));
    values(from.values, from.count, "values");
    if (from.count < from.least) {
        throw InvalidInput("values: expected at least " + std::to_string(from.least) + " rows, got " +
                           std::to_string(from.count));
    }
    const size_t width = size_t(from.columns);
    float* to = output<float>(out, out_count, size_t(count), "out").data();
    for (Index number = 0; number < count; ++number, to += width) {
        std::fill(to, to + width, 0.0f);
        const auto [r, first] = row_of(number);
        for (Index k = rows.start[r]; k < rows.start[r + 1]; ++k) {
            const float* row = &from.values[size_t(first + rows.index[k]) * width];
            for (size_t c = 0; c < width; ++c) to[c] += rows.weight[k] * row[c];
        }
    }
}

}  // namespace

rumple_status rumple_shown_mesh_carry_points(const rumple_shown_mesh* mesh, const float* values,
                                             size_t values_count, int32_t columns, float* out,
                                             size_t out_count) {
    return guarded([&] {
        const rumple_shown_mesh& m = given(mesh, "mesh");
        const SparseRows& rows = m.mesh.vertex_from_source;
        const auto itself = [](Index r) { return std::pair(r, Index(0)); };
        carry(rows, rows.rows(), itself, {values, values_count, columns, m.source_vertices}, out, out_count);
    });
}

rumple_status rumple_shown_mesh_carry_corners(const rumple_shown_mesh* mesh, const float* values,
                                              size_t values_count, int32_t columns, float* out,
                                              size_t out_count) {
    return guarded([&] {
        const rumple_shown_mesh& m = given(mesh, "mesh");
        const ShiftedRows& rows = m.mesh.corner_from_source;
        const auto alike = [&](Index r) { return std::pair(rows.alike[r], rows.first[r]); };
        carry(rows.different, rows.rows(), alike, {values, values_count, columns, m.source_corners}, out,
              out_count);
    });
}

// ---- rigid parts

namespace {

void check_starts(std::span<const Index> starts, size_t points) {
    if (starts.empty()) throw InvalidInput("starts: expected at least one number, got none");
    if (starts.front() != 0)
        throw InvalidInput("starts: expected 0 first, got " + std::to_string(starts.front()) + " first");
    const auto fall = std::is_sorted_until(starts.begin(), starts.end());
    if (fall != starts.end())
        throw InvalidInput("starts: expected ascending numbers, got " + std::to_string(*fall) + " after " +
                           std::to_string(*(fall - 1)));
    expect_rows("from", points, size_t(starts.back()));
}

// The rotation row by row, then the translation.
std::array<float, 12> written_out(const base_cloth::RigidMotion& motion) {
    const glm::dmat3 r = glm::mat3_cast(motion.turn);
    const glm::dvec3 t = motion.centre + motion.displacement - r * motion.centre;
    return {float(r[0][0]), float(r[1][0]), float(r[2][0]), float(r[0][1]), float(r[1][1]), float(r[2][1]),
            float(r[0][2]), float(r[1][2]), float(r[2][2]), float(t.x),     float(t.y),     float(t.z)};
}

}  // namespace

rumple_status rumple_rigid_motions(const int32_t* starts, size_t starts_count, const float* from,
                                   size_t from_count, const float* to, size_t to_count, float* motions,
                                   size_t motions_count) {
    return guarded([&] {
        const std::span<const Index> begins = values(starts, starts_count, "starts");
        const std::span<const Vec3> before = vectors(from, from_count, "from");
        const std::span<const Vec3> after = vectors(to, to_count, "to");
        check_starts(begins, before.size());
        expect_rows("to", after.size(), before.size());
        check_coordinates("from", before);
        check_coordinates("to", after);
        const auto out = output<std::array<float, 12>>(motions, motions_count, begins.size() - 1, "motions");
        std::vector<std::array<float, 12>> found;
        for (size_t part = 0; part + 1 < begins.size(); ++part) {
            const auto first = size_t(begins[part]), points = size_t(begins[part + 1]) - first;
            const std::vector<float> alike(points, 1.0f);
            found.push_back(written_out(base_cloth::rigid_motion(alike, before.subspan(first, points),
                                                                 after.subspan(first, points))));
        }
        write(sound(std::move(found)), out);
    });
}

// ---- a frame

rumple_pose rumple_pose_default(void) {
    rumple_pose pose{};
    for (int k = 0; k < 3; ++k) pose.world_from_object[4 * k] = 1.0f;
    return pose;
}

void rumple_frame_free(rumple_frame* frame) {
    delete frame;
}

rumple_status rumple_frame_get_view(const rumple_frame* frame, rumple_frame_view* view) {
    return guarded([&] {
        const ShownFrame& f = given(frame, "frame").shown();
        given(view, "view") = {count(f.positions),
                               flat<float>(f.positions),
                               flat<float>(f.local_offset),
                               flat<float>(f.offset),
                               f.stretch.minimum.data(),
                               f.stretch.maximum.data(),
                               flat<float>(f.stretch.direction)};
    });
}

rumple_status rumple_frame_embed(rumple_frame* frame, const float* positions, size_t positions_count) {
    return guarded([&] {
        rumple_frame& f = given(frame, "frame");
        ShownFrame embedded = f.shown();  // a copy, in case an argument is refused
        embed_frame(f.base, f.mesh, vectors(positions, positions_count, "positions"), embedded);
        write(sound(std::move(embedded.local_offset)), std::span(f.shown().local_offset));
    });
}
