// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "api/wrinkle_field.h"
#include "systems/wrinkle_field/brush.h"

using namespace rumple;
using namespace rumple::api;
using namespace rumple::wrinkle_field;

static_assert(kLongestPainted == RUMPLE_LONGEST_PAINTED);

struct rumple_canvas {
    std::shared_ptr<const Model> model;
    Canvas canvas;
};
struct rumple_twins {
    std::shared_ptr<const Model> model;
    std::vector<SurfacePoint> places;
};
struct rumple_lines {
    Lines lines;
};

// Lists all fields once, for both directions: see api/settings.h.
template <typename Pair>
static void pair_fields(rumple_dab& c, Dab& native, const Pair& pair) {
    pair.choose("touch", c.touch, native.touch, Touch::kSmooth);
    pair(c.centre, native.centre);
    pair(c.normal, native.normal);
    pair(c.view, native.view);
    pair(c.direction, native.direction);
    pair(c.across, native.across);
    pair(c.radius, native.radius);
    pair(c.strength, native.strength);
    pair(c.length, native.length);
    pair.choose("falloff", c.falloff, native.falloff, Falloff::kConstant);
}

template <typename Pair>
static void pair_fields(rumple_scatter& c, Scatter& native, const Pair& pair) {
    pair(c.seed, native.seed);
    pair(c.density, native.density);
    pair(c.size, native.size);
    pair(c.length, native.length);
}

rumple_status rumple_canvas_build(const rumple_wrinkle_field* model, const float* positions,
                                  size_t positions_count, rumple_canvas** canvas) {
    return made(canvas, "canvas", [&] {
        const rumple_wrinkle_field& m = given(model, "model");
        return new rumple_canvas{m.model,
                                 lay_out(*m.model, vectors(positions, positions_count, "positions"))};
    });
}

void rumple_canvas_free(rumple_canvas* canvas) {
    delete canvas;
}

rumple_status rumple_twins_build(const rumple_wrinkle_field* model, int32_t* found, rumple_twins** twins) {
    return made(twins, "twins", [&] {
        const rumple_wrinkle_field& m = given(model, "model");
        auto* out = new rumple_twins{m.model, find_twins(*m.model)};
        if (found) {
            *found = int32_t(std::count_if(out->places.begin(), out->places.end(),
                                           [](const SurfacePoint& p) { return p.triangle != kNone; }));
        }
        return out;
    });
}

void rumple_twins_free(rumple_twins* twins) {
    delete twins;
}

rumple_dab rumple_dab_default(void) {
    return default_of<rumple_dab, Dab>();
}

rumple_status rumple_dab_apply(const rumple_canvas* canvas, const rumple_dab* dab, const rumple_twins* twins,
                               float* painted, size_t painted_count) {
    return guarded([&] {
        const rumple_canvas& c = given(canvas, "canvas");
        const auto* mirrored = of_model(twins, c, "twins");
        const auto out = output<Vec3>(painted, painted_count, painted_count, "painted");
        std::vector<Vec3> after(out.begin(), out.end());  // a copy, in case an argument is refused
        apply(*c.model, c.canvas, native_of<Dab>(dab, "dab"),
              mirrored ? std::span(mirrored->places) : std::span<const SurfacePoint>(), after);
        write(after, out);
    });
}

rumple_scatter rumple_scatter_default(void) {
    return default_of<rumple_scatter, Scatter>();
}

rumple_status rumple_scatter_paint(const rumple_wrinkle_field* model, const rumple_scatter* settings,
                                   float* painted, size_t painted_count) {
    return guarded([&] {
        const Model& m = *given(model, "model").model;
        const auto out = output<Vec3>(painted, painted_count, size_t(m.base.display.vertex_count), "painted");
        write(scatter(m, native_of<Scatter>(settings, "scatter")), out);
    });
}

void rumple_lines_free(rumple_lines* lines) {
    delete lines;
}

rumple_status rumple_lines_get_view(const rumple_lines* lines, rumple_lines_view* view) {
    return guarded([&] {
        const Lines& l = given(lines, "lines").lines;
        given(view, "view") = {count(l.strength), flat<float>(l.ends), l.strength.data()};
    });
}

rumple_status rumple_canvas_draw(const rumple_canvas* canvas, const float* painted, size_t painted_count,
                                 bool across, rumple_lines** lines) {
    return made(lines, "lines", [&] {
        const rumple_canvas& c = given(canvas, "canvas");
        return new rumple_lines{draw(*c.model, c.canvas, vectors(painted, painted_count, "painted"), across)};
    });
}
