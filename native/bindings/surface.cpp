// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>

#include <algorithm>

#include "bindings/arrays.h"
#include "bindings/choices.h"
#include "bindings/module.h"
#include "surface/shown_mesh.h"

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

// (rows, k) values through a linear map whose columns are `expected` values of `what`.
py::array_t<float> carry(const SparseRows& rows, const py::array& values, size_t expected, const char* what) {
    if (values.ndim() != 2 || values.shape(0) != py::ssize_t(expected)) {
        throw InvalidInput(std::string(what) + ": expected shape (" + std::to_string(expected) +
                           ", k), got " + describe(values));
    }
    const py::ssize_t width = values.shape(1);
    const auto from = scalars<float>(values, what, width);
    py::array_t<float> out({py::ssize_t(rows.rows()), width});
    float* to = out.mutable_data();
    for (Index r = 0; r < rows.rows(); ++r, to += width) {
        std::fill(to, to + width, 0.0f);
        for (Index k = rows.start[r]; k < rows.start[r + 1]; ++k) {
            const float* row = &from[size_t(rows.index[k]) * width];
            for (py::ssize_t c = 0; c < width; ++c) to[c] += rows.weight[k] * row[c];
        }
    }
    return out;
}

py::array_t<float> barycentrics(const ShownMesh& shown) {
    std::vector<Vec2> weights;
    for (const SurfacePoint& place : shown.places) weights.push_back({place.b0, place.b1});
    return to_numpy<float>(weights, 2);
}

void bind_shown_frame(py::module_& module) {
    module.def(
        "embed_frame",
        [](const Surface& base, const ShownMesh& shown, const py::array& positions, ShownFrame& frame) {
            const auto points = vectors(positions, "positions");
            const py::gil_scoped_release release;
            embed_frame(base, shown, points, frame);
        },
        py::arg("base"), py::arg("shown"), py::arg("positions"), py::arg("frame"),
        "Embeds a frame in other positions, (n, 3) float32, of the base: its local_offset anew.");
    py::class_<ShownFrame>(module, "ShownFrame",
                           "What every system shows of a frame; d vertices of the shown mesh.")
        .def_property_readonly(
            "positions", [](const ShownFrame& f) { return to_numpy(f.positions); }, "(d, 3) object space")
        .def_property_readonly(
            "local_offset", [](const ShownFrame& f) { return to_numpy(f.local_offset); },
            "(d, 3) from the linear embedding, in the frame of the deformed base triangle")
        .def_property_readonly(
            "offset", [](const ShownFrame& f) { return to_numpy(f.offset); },
            "(d, 3) from the unwrinkled surface, object space")
        .def_property_readonly(
            "stretch_min", [](const ShownFrame& f) { return to_numpy<float>(f.stretch.minimum, 0); },
            "(d,) smaller principal stretch of the base, 1 at rest")
        .def_property_readonly(
            "stretch_max", [](const ShownFrame& f) { return to_numpy<float>(f.stretch.maximum, 0); }, "(d,)")
        .def_property_readonly(
            "stretch_direction", [](const ShownFrame& f) { return to_numpy(f.stretch.direction); },
            "(d, 3) of strongest compression, unit, object space");
}

void bind_shown_mesh(py::module_& module) {
    py::class_<ShownMesh>(module, "ShownMesh",
                          "The mesh that is shown in place of the base: d vertices, q polygons.")
        .def_property_readonly("vertex_count", [](const ShownMesh& m) { return m.mesh.vertex_count; })
        .def_property_readonly(
            "polygon_start", [](const ShownMesh& m) { return to_numpy<Index>(m.mesh.polygon_start, 0); },
            "(q + 1,) int32.")
        .def_property_readonly(
            "corner_vertex", [](const ShownMesh& m) { return to_numpy<Index>(m.mesh.corner_vertex, 0); },
            "(k,) int32.")
        .def_property_readonly(
            "polygon_source", [](const ShownMesh& m) { return to_numpy<Index>(m.polygon_source, 0); },
            "(q,) int32: polygon of the base, or of the own mesh.")
        .def_property_readonly(
            "edges", [](const ShownMesh& m) { return to_numpy<Index>(m.edges, 2); },
            "(e, 2) int32: shown edges that lie on a source edge.")
        .def_property_readonly(
            "edge_sources", [](const ShownMesh& m) { return to_numpy<Index>(m.edge_sources, 2); },
            "(e, 2) int32: the vertices of that source edge.")
        .def_property_readonly(
            "positions_rest", [](const ShownMesh& m) { return to_numpy(m.positions_rest); },
            "(d, 3) float32, object space.")
        .def_property_readonly(
            "triangle_vertex", [](const ShownMesh& m) { return to_numpy<Index>(m.embedding, 3); },
            "(d, 3) int32: the base vertices that every shown vertex is embedded in.")
        .def_property_readonly("barycentric", &barycentrics,
                               "(d, 2) float32: weights of the second and third of them.")
        .def(
            "carry_points",
            [](const ShownMesh& m, const py::array& values, size_t vertices) {
                return carry(m.vertex_from_source, values, vertices, "point values");
            },
            py::arg("values"), py::arg("source_vertices"),
            "(n, k) float32 of the source's vertices -> (d, k), linear.")
        .def(
            "carry_corners",
            [](const ShownMesh& m, const py::array& values, size_t corners) {
                return carry(m.corner_from_source, values, corners, "corner values");
            },
            py::arg("values"), py::arg("source_corners"),
            "(c, k) float32 of the source's corners -> corners of the shown mesh; seams stay sharp.");
}

}  // namespace

FineSource fine_source(const std::string& source, Index level, Index segments, float longest_edge,
                       Index most_vertices) {
    using Kind = FineSource::Kind;
    FineSource out;
    out.kind = chosen<Kind>(source, "source",
                            {{"SUBDIVISION", Kind::kSubdivision},
                             {"REGULAR", Kind::kRegular},
                             {"EDGE_LENGTH", Kind::kLongestEdge}});
    out.level = level;
    out.segments = segments;
    out.longest_edge = longest_edge;
    out.most_vertices = most_vertices;
    return out;
}

AttachmentKind attachment_kind(const std::string& name) {
    return chosen<AttachmentKind>(name, "attachment",
                                  {{"LINEAR", AttachmentKind::kLinear},
                                   {"PN", AttachmentKind::kPnTriangle},
                                   {"LIMIT", AttachmentKind::kLimit}});
}

void bind_surface(py::module_& module) {
    bind_shown_mesh(module);
    bind_shown_frame(module);
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
