// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>

#include "bindings/arrays.h"
#include "bindings/module.h"
#include "surface/topology.h"

namespace rumple::bindings {
namespace {

Surface make_surface(const py::array& positions_rest, const py::array& polygon_start,
                     const py::array& corner_vertex, const py::array& triangle_corner, bool weld_seams) {
    SurfaceInput input;
    input.positions_rest = vectors(positions_rest, "positions_rest");
    input.polygon_start = scalars<Index>(polygon_start, "polygon_start", 0);
    input.corner_vertex = scalars<Index>(corner_vertex, "corner_vertex", 0);
    input.triangle_corner = scalars<Index>(triangle_corner, "triangle_corner", 3);
    input.weld_seams = weld_seams;
    const py::gil_scoped_release release;
    return build_surface(input);
}

}  // namespace

void bind_surface(py::module_& module) {
    py::class_<Surface>(module, "Surface", "A checked base mesh at rest. Made by build_surface.")
        .def_property_readonly(
            "vertex_count", [](const Surface& s) { return s.display.vertex_count; },
            "Vertices as the artist has them.")
        .def_property_readonly(
            "welded_vertex_count", [](const Surface& s) { return s.welded.vertex_count; },
            "Vertices after seams were joined.")
        .def_readonly("warnings", &Surface::warnings, "What was tolerated, in words.");

    module.def("build_surface", &make_surface, py::arg("positions_rest"), py::arg("polygon_start"),
               py::arg("corner_vertex"), py::arg("triangle_corner"), py::arg("weld_seams") = true,
               "Check a polygon mesh and join its seams.\n\n"
               "positions_rest: (n, 3) float32, object space. polygon_start: (p + 1,) int32, the first "
               "corner of every\n"
               "polygon and the number of corners. corner_vertex: (c,) int32. triangle_corner: (t, 3) int32, "
               "the corners\n"
               "of a triangulation of every polygon. weld_seams: join border vertices at one place.\n"
               "Raises ValueError naming the first bad element.");
}

}  // namespace rumple::bindings
