// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_paths_preview.h"

#include "bindings/arrays.h"
#include "bindings/module.h"

namespace rumple::bindings {

using namespace wrinkle_paths;

void bind_wrinkle_paths_preview(py::module_& module) {
    py::class_<Drawing>(module, "WrinklePathsDrawing", "What the viewport draws a frame from, on the GPU.")
        .def_property_readonly(
            "flat", [](const Drawing& d) { return to_numpy(d.flat); },
            "(w, 3) float32: welded vertices of the deformed base. Heights are measured over them.")
        .def_property_readonly(
            "smooth", [](const Drawing& d) { return to_numpy(d.smooth); },
            "(w, 3) float32: their places on the surface that the fine mesh is attached to.")
        .def_property_readonly(
            "normal", [](const Drawing& d) { return to_numpy(d.normal); }, "(w, 3) float32, unit.")
        .def_readonly("curved", &Drawing::curved, "False: straight triangles, for a linear attachment.")
        .def_property_readonly(
            "hem", [](const Drawing& d) { return to_numpy<float>(d.hem, 0); },
            "(w,) float32: factor on the folds.")
        .def_property_readonly(
            "parts", [](const Drawing& d) { return to_numpy<Index>(d.parts, 4); },
            "(t, 4) int32: parts that a triangle and its edges (from corners 0, 1, 2) are cut into.")
        .def_property_readonly(
            "stand_in", [](const Drawing& d) { return to_numpy(d.stand_in); },
            "(n, 3) float32: the way from every vertex of the base to `smooth`.")
        .def_property_readonly(
            "lists", [](const Drawing& d) -> const Packed& { return d.lists; },
            py::return_value_policy::reference_internal, "The WrinklePathsLists.");
    module.def(
        "draw_wrinkle_paths",
        [](const Model& model, const Settings& settings, const py::array& positions, const State& state) {
            Input input;
            input.positions = vectors(positions, "positions");
            input.time = state.time;
            const py::gil_scoped_release release;
            return draw(model, settings, input, state);
        },
        py::arg("model"), py::arg("settings"), py::arg("positions"), py::arg("state"),
        "What the viewport draws a frame from.");
    module.def(
        "drawn_wrinkle_paths",
        [](const Model& model, const Settings& settings, const Drawing& drawing, const py::array& triangle,
           const py::array& weights) {
            const auto t = scalars<Index>(triangle, "triangle", 0);
            const auto b = vectors2(weights, "weights");
            std::vector<float> out;
            for (size_t i = 0; i < t.size(); ++i) {
                const Drawn d = drawn_at(model, settings, drawing, {t[i], b[i].x, b[i].y});
                out.insert(out.end(), {d.position.x, d.position.y, d.position.z, d.height, d.normal.x,
                                       d.normal.y, d.normal.z});
            }
            return to_numpy<float>(out, 7);
        },
        py::arg("model"), py::arg("settings"), py::arg("drawing"), py::arg("triangle"), py::arg("weights"),
        "(n, 7) float32: position, height and normal that the shaders make of places: their twin, for "
        "tests.\n"
        "triangle: (n,) int32. weights: (n, 2) float32, of corners 1 and 2.");
}

}  // namespace rumple::bindings
