// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/coarse.h"

#include "api/sound.h"
#include "base/expect.h"

using namespace rumple;
using namespace rumple::api;

namespace {

// The part of a base mesh that a coarse one represents. Throws InvalidInput if it is of another mesh.
const Surface& part_of(const rumple_surface* base, const rumple_surface* part) {
    const Surface &whole = given(base, "base").surface, &from = given(part, "part").surface;
    expect_count("part", size_t(from.display.vertex_count), size_t(whole.display.vertex_count),
                 "vertices of the base mesh");
    return from;
}

}  // namespace

rumple_status rumple_coarse_build(const rumple_surface* base, float spacing, rumple_coarse** coarse) {
    return rumple_coarse_build_of(base, base, spacing, coarse);
}

rumple_status rumple_coarse_build_of(const rumple_surface* base, const rumple_surface* part, float spacing,
                                     rumple_coarse** coarse) {
    return made(coarse, "coarse", [&] {
        const Surface& from = part_of(base, part);
        return new rumple_coarse{of_whole_base(*build_coarse(from, spacing), from, base->surface),
                                 base->shared};
    });
}

rumple_status rumple_coarse_as_modelled(const rumple_surface* base, const rumple_surface* part,
                                        float least_edge, float most_edge, rumple_coarse** coarse) {
    return made(coarse, "coarse", [&] {
        const Surface& from = part_of(base, part);
        const bool is_whole = from.display.polygons() == base->surface.display.polygons();
        const auto made = build_as_modelled(from, least_edge, most_edge, !is_whole);
        return new rumple_coarse{of_whole_base(*made, from, base->surface), base->shared};
    });
}

void rumple_coarse_free(rumple_coarse* coarse) {
    delete coarse;
}

rumple_status rumple_coarse_get_view(const rumple_coarse* coarse, rumple_coarse_view* view) {
    return guarded([&] {
        const rumple_coarse& c = given(coarse, "coarse");
        given(view, "view") = {count(c.mesh->base_vertex), c.mesh->mean_edge, c.mesh->base_vertex.data()};
    });
}

rumple_status rumple_coarse_surface(const rumple_coarse* coarse, rumple_surface** surface) {
    return made(surface, "surface", [&] {
        const auto& mesh = given(coarse, "coarse").mesh;
        return new rumple_surface(std::shared_ptr<const Surface>(mesh, &mesh->surface));
    });
}

rumple_status rumple_coarse_positions(const rumple_coarse* coarse, const float* positions,
                                      size_t positions_count, float* out, size_t out_count) {
    return guarded([&] {
        const rumple_coarse& c = given(coarse, "coarse");
        const auto to = output<Vec3>(out, out_count, c.mesh->base_vertex.size(), "out");
        write(sound(coarse_positions(*c.mesh, *c.base, vectors(positions, positions_count, "positions"))),
              to);
    });
}

rumple_status rumple_coarse_paint(const rumple_coarse* coarse, const float* values, size_t values_count,
                                  float* out, size_t out_count) {
    return guarded([&] {
        const rumple_coarse& c = given(coarse, "coarse");
        expect_rows("values", values_count, size_t(c.base->display.vertex_count));
        const auto to = output<float>(out, out_count, c.mesh->base_vertex.size(), "out");
        apply<float>(c.mesh->paint_from_base, rows<float>(values, values_count, "values"), to);
    });
}
