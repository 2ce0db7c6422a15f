// SPDX-License-Identifier: GPL-3.0-or-later
// The Python module. No mathematics here.
#include "bindings/module.h"

PYBIND11_MODULE(rumple_native, module) {
    module.doc() =
        "Rumple's kernels: dynamic wrinkles on coarse animated meshes.\n\n"
        "Arrays are C-contiguous float32 or int32; lengths are in the units of the positions (metres).\n"
        "Bad input raises ValueError that names the argument and the first bad element.";
    module.attr("__version__") = RUMPLE_VERSION;
    rumple::bindings::bind_surface(module);
    rumple::bindings::bind_base_cloth(module);
    rumple::bindings::bind_wrinkle_maps(module);
    rumple::bindings::bind_wrinkle_mesh(module);
    rumple::bindings::bind_wrinkle_mesh_layers(module);
    rumple::bindings::bind_wrinkle_field(module);
    rumple::bindings::bind_wrinkle_field_brush(module);
    rumple::bindings::bind_wrinkle_paths(module);
    rumple::bindings::bind_wrinkle_paths_curves(module);
    rumple::bindings::bind_wrinkle_paths_preview(module);
}
