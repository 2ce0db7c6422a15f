// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pybind11/pybind11.h>

namespace rumple::bindings {

void bind_base_cloth(pybind11::module_& module);
void bind_surface(pybind11::module_& module);
void bind_wrinkle_maps(pybind11::module_& module);
void bind_wrinkle_mesh(pybind11::module_& module);
void bind_wrinkle_mesh_layers(pybind11::module_& module);
void bind_wrinkle_field(pybind11::module_& module);
void bind_wrinkle_field_brush(pybind11::module_& module);
void bind_wrinkle_paths(pybind11::module_& module);
void bind_wrinkle_paths_curves(pybind11::module_& module);
void bind_wrinkle_paths_preview(pybind11::module_& module);

}  // namespace rumple::bindings
