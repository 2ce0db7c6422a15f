// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_paths_curves.h"

#include <pybind11/stl.h>

#include <optional>

#include "bindings/arrays.h"
#include "bindings/module.h"

namespace rumple::bindings {

using namespace wrinkle_paths;

void bind_wrinkle_paths_curves(py::module_& module) {
    py::class_<RidingCurves, Curves>(module, "WrinklePathsRidingCurves",
                                     "The paths on the crests of their folds, in terms of the posed base.")
        .def_property_readonly(
            "corners", [](const RidingCurves& c) { return to_numpy<Index>(c.corners, 3); },
            "(p, 3) int32: the base's vertices as the artist has them, around every point.")
        .def_property_readonly(
            "weights", [](const RidingCurves& c) { return to_numpy<float>(c.weights, 2); },
            "(p, 2) float32: of the second and the third of them.")
        .def_property_readonly(
            "local_offset", [](const RidingCurves& c) { return to_numpy(c.local_offset); },
            "(p, 3) float32, in the frame of the deformed triangle, object units.");
    module.def(
        "ride_wrinkle_paths",
        [](const Model& model, const Settings& settings, const py::array& positions, const State& state,
           const std::optional<py::array>& animated) {
            Input input;
            input.positions = vectors(positions, "positions");
            input.time = state.time;
            const auto ridden = animated ? vectors(*animated, "animated") : std::span<const Vec3>();
            const py::gil_scoped_release release;
            return ride(model, settings, input, state, ridden);
        },
        py::arg("model"), py::arg("settings"), py::arg("positions"), py::arg("state"),
        py::arg("animated") = py::none(),
        "The paths as curves along the crests, which ride on any pose of the base. positions: (n, 3) "
        "float32,\n"
        "deformed base, object space. animated: the same of what they are to ride on, where that is not "
        "what\n"
        "was solved over.");
    module.def(
        "wrinkle_path_ellipses",
        [](const Model& model, const py::array& positions, const State& state, float size) {
            const auto posed = vectors(positions, "positions");
            std::vector<Ellipse> values;
            {
                const py::gil_scoped_release release;
                values = ellipses(model, posed, state, size);
            }
            return to_numpy<float>(values, 9);
        },
        py::arg("model"), py::arg("positions"), py::arg("state"), py::arg("size") = 0.8f,
        "(t, 9) float32: centre and two semi-axes, compressed and stretched, of what became of a circle on "
        "every\n"
        "reference triangle. size: its radius over that of the inscribed circle. Object space.");
}

}  // namespace rumple::bindings
