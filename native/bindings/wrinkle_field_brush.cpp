// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_field_brush.h"

#include <pybind11/stl.h>

#include <algorithm>

#include "bindings/arrays.h"
#include "bindings/choices.h"
#include "bindings/module.h"

namespace rumple::bindings {
namespace {

using namespace wrinkle_field;
using Triple = std::array<float, 3>;

struct Twins {
    std::vector<SurfacePoint> places;
};

Vec3 vector(const Triple& v) {
    return {v[0], v[1], v[2]};
}

Touch touch_kind(const std::string& name) {
    return chosen<Touch>(name, "touch",
                         {{"PAINT", Touch::kPaint}, {"ERASE", Touch::kErase}, {"SMOOTH", Touch::kSmooth}});
}

Falloff falloff_kind(const std::string& name) {
    return chosen<Falloff>(name, "falloff",
                           {{"SMOOTH", Falloff::kSmooth},
                            {"SHARP", Falloff::kSharp},
                            {"LINEAR", Falloff::kLinear},
                            {"CONSTANT", Falloff::kConstant}});
}

py::array_t<float> apply_dab(const Model& model, const Canvas& canvas, const py::array& painted,
                             const std::string& touch, const Triple& centre, const Triple& normal,
                             const Triple& view, const Triple& direction, bool across, float radius,
                             float strength, float length, const std::string& falloff, const Twins* twins) {
    Dab dab;
    dab.touch = touch_kind(touch);
    dab.centre = vector(centre);
    dab.normal = vector(normal);
    dab.view = vector(view);
    dab.direction = vector(direction);
    dab.across = across;
    dab.radius = radius;
    dab.strength = strength;
    dab.length = length;
    dab.falloff = falloff_kind(falloff);
    const std::span<const Vec3> before = vectors(painted, "painted");
    std::vector<Vec3> after(before.begin(), before.end());
    apply(model, canvas, dab, twins ? std::span(twins->places) : std::span<const SurfacePoint>(), after);
    return to_numpy(after);
}

}  // namespace

void bind_wrinkle_field_brush(py::module_& module) {
    module.attr("LONGEST_PAINTED") = kLongestPainted;
    py::class_<Canvas>(module, "WrinkleFieldCanvas", "A pose under the brush. Made by lay_out_canvas.");
    py::class_<Twins>(module, "WrinkleFieldTwins", "Mirror images in x = 0. Made by find_twins.")
        .def_property_readonly(
            "found",
            [](const Twins& twins) {
                return std::count_if(twins.places.begin(), twins.places.end(),
                                     [](const SurfacePoint& place) { return place.triangle != kNone; });
            },
            "Welded vertices that have one.");
    module.def(
        "lay_out_canvas",
        [](const Model& model, const py::array& positions) {
            return lay_out(model, vectors(positions, "positions"));
        },
        py::arg("model"), py::arg("positions"),
        "positions: (n, 3) float32, deformed base, in any space: the one that dabs are then given in.");
    module.def(
        "find_twins", [](const Model& model) { return Twins{find_twins(model)}; }, py::arg("model"),
        "Where the mirror image in x = 0 of every vertex lies on the rest surface.");
    module.def(
        "apply_dab", &apply_dab, py::arg("model"), py::arg("canvas"), py::arg("painted"), py::kw_only(),
        py::arg("touch") = "PAINT", py::arg("centre"), py::arg("normal"), py::arg("view"),
        py::arg("direction") = Triple{1.0f, 0.0f, 0.0f}, py::arg("across") = false, py::arg("radius"),
        py::arg("strength") = 1.0f, py::arg("length") = 0.7f, py::arg("falloff") = "SMOOTH",
        py::arg("twins") = nullptr,
        "Section 7: the brush set down once; returns painted anew.\n\n"
        "painted: (n, 3) float32 of the base's vertices, rest space, shorter than 1. touch: PAINT, ERASE or\n"
        "SMOOTH. centre, radius: the sphere that is touched. normal: of the surface at the centre. view: "
        "from\n"
        "the viewer to it. direction: of the stroke, parallel to the screen; the folds run along it or,\n"
        "with across, at right angles. strength 0..1, length 0..LONGEST_PAINTED, falloff: SMOOTH, SHARP,\n"
        "LINEAR or CONSTANT. twins: of find_twins() to paint the mirror image too.");
    module.def(
        "scatter_rest_wrinkles",
        [](const Model& model, std::uint32_t seed, float density, float size, float length) {
            return to_numpy(scatter(model, {seed, density, size, length}));
        },
        py::arg("model"), py::arg("seed") = 0, py::arg("density") = 0.5f, py::arg("size") = 0.1f,
        py::arg("length") = 0.7f,
        "Random rest-pose wrinkles, (n, 3) float32: a function of the arguments and the rest positions.\n\n"
        "density: share of the vertices, 0..1. size: over which they change, object units. length: of the "
        "longest.");
    module.def(
        "draw_rest_wrinkles",
        [](const Model& model, const Canvas& canvas, const py::array& painted, bool across) {
            const Lines lines = draw(model, canvas, vectors(painted, "painted"), across);
            return py::make_tuple(to_numpy(lines.ends), to_numpy<float>(lines.strength, 0));
        },
        py::arg("model"), py::arg("canvas"), py::arg("painted"), py::arg("across") = false,
        "Lines along the folds (or across them) for an overlay: ends (2 m, 3) and strengths (m,).");
}

}  // namespace rumple::bindings
