// SPDX-License-Identifier: GPL-3.0-or-later
// Chapter 4's reference triangles, as every system hands them to Python.
#pragma once

#include <pybind11/stl.h>

#include <optional>

#include "bindings/arrays.h"
#include "bindings/choices.h"
#include "surface/adaptive_reference.h"

namespace rumple::bindings {

// The settings of the reference triangles among those of a system. of: Settings& -> ReferenceSettings&.
template <typename Settings, typename Of>
void bind_reference_settings(py::class_<Settings>& settings, Of of) {
    const auto bind = [&](const char* name, float ReferenceSettings::*field, const char* doc) {
        settings.def_property(
            name, [of, field](Settings& s) { return of(s).*field; },
            [of, field](Settings& s, float value) { of(s).*field = value; }, doc);
    };
    bind("window", &ReferenceSettings::window,
         "seconds; labels compare with the pose so long ago; 0: the previous frame");
    bind("relaxation", &ReferenceSettings::relaxation,
         "share per 1/30 s by which compressed reference triangles give in, 0..1");
    bind("growth", &ReferenceSettings::growth,
         "most length of a reference triangle over the rest pose's, >= 1");
    bind("growth_time", &ReferenceSettings::growth_time,
         "seconds in which a reference triangle takes over a longer shape, >= 0");
    settings.def_property(
        "reference",
        [of](Settings& s) {
            const Reference reference = of(s).reference;
            return reference == Reference::kRestPose     ? "REST"
                   : reference == Reference::kFirstFrame ? "FIRST_FRAME"
                                                         : "STATIC_REST";
        },
        [of](Settings& s, const std::string& name) {
            of(s).reference = chosen<Reference>(name, "reference",
                                                {{"REST", Reference::kRestPose},
                                                 {"FIRST_FRAME", Reference::kFirstFrame},
                                                 {"STATIC_REST", Reference::kStaticRest}});
        },
        "REST, FIRST_FRAME or STATIC_REST");
}

// The state of the reference triangles as plain arrays, and back.
py::dict reference_arrays(const ReferenceState& state);
ReferenceState reference_from(const py::dict& from);

// ... of a system whose rest shape may stay: None and the empty state.
py::object reference_or_none(const ReferenceState& state);
ReferenceState reference_or_empty(const std::optional<py::dict>& from);

// The array of that name in a stored state. Throws InvalidInput where there is none.
py::array stored_array(const py::dict& from, const char* name);

py::array clip_labels(const Surface& surface, const ReferenceModel& model, const ReferenceSettings& settings,
                      const py::array& times, const py::array& positions, bool raw);

// label_clip() of a system. model_of: const Model& -> const ReferenceModel&; of: Settings& ->
// ReferenceSettings&.
template <typename Model, typename Settings, typename ModelOf, typename Of>
void bind_label_clip(py::module_& module, ModelOf model_of, Of of) {
    module.def(
        "label_clip",
        [model_of, of](const Model& model, Settings& settings, const py::array& times,
                       const py::array& positions, bool raw) {
            return clip_labels(model.base, model_of(model), of(settings), times, positions, raw);
        },
        py::arg("model"), py::arg("settings"), py::arg("times"), py::arg("positions"), py::arg("raw") = false,
        "Labels of a whole clip in one cut, (f, t) uint8: 0 compress, 1 rest, 2 stretch. times: (f,) "
        "float64,\n"
        "seconds, ascending. positions: (f n, 3) float32, frame after frame. raw: every triangle's cheapest\n"
        "label for itself. Cost: about 1 ms and half a megabyte per frame and 1,000 triangles.");
}

// When a frame is and what is known ahead of it, as Python says it. The arrays must outlive the moment.
Moment make_moment(double time, const std::optional<py::array>& labels,
                   const std::optional<py::array>& next_positions, double next_time);

}  // namespace rumple::bindings
