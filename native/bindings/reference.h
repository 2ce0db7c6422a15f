// SPDX-License-Identifier: GPL-3.0-or-later
// Chapter 4's reference triangles, as every system hands them to Python.
#pragma once

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

}  // namespace rumple::bindings
