// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_mesh.h"

#include <pybind11/stl.h>

#include "bindings/arrays.h"
#include "bindings/choices.h"
#include "bindings/module.h"
#include "bindings/reference.h"

namespace rumple::bindings {
namespace {

using namespace wrinkle_mesh;
using ModelHandle = std::shared_ptr<const Model>;

ModelHandle make_model(const Surface& base, const std::string& source, Index level, Index segments,
                       float longest_edge, Index most_vertices, const Surface* own,
                       const std::optional<py::array>& attached, float farthest,
                       const std::string& attachment, Index display_steps, bool adaptive) {
    Source from;
    if (source == "OBJECT") {
        if (!own) throw InvalidInput("own: expected a Surface, got None");
        from.own = own;
        from.most_vertices = most_vertices;
    } else {
        static_cast<FineSource&>(from) = fine_source(source, level, segments, longest_edge, most_vertices);
    }
    from.farthest = farthest;
    from.adaptive = adaptive;
    if (attached) {
        from.attached = scalars<std::uint8_t>(*attached, "attached", 0);
        if (own && from.attached.size() != size_t(own->display.vertex_count)) {
            throw InvalidInput("attached: expected " + std::to_string(own->display.vertex_count) +
                               " values, got " + std::to_string(from.attached.size()));
        }
    }
    const AttachmentKind kind = attachment_kind(attachment);
    const py::gil_scoped_release release;
    return build(base, from, kind, display_steps);
}

Paint make_paint(const Model& model, const py::dict& painted) {
    Paint paint;
    for (const auto& [key, value] : painted) {
        const std::string name = py::str(key);
        std::vector<float>* values = chosen<std::vector<float>*>(name, "paint",
                                                                 {{"radius", &paint.radius},
                                                                  {"prestretch", &paint.prestretch},
                                                                  {"bending", &paint.bending},
                                                                  {"inside", &paint.inside}});
        const auto base_values = scalars<float>(py::cast<py::array>(value), name.c_str(), 0);
        if (base_values.size() != size_t(model.base.display.vertex_count)) {
            throw InvalidInput(name + ": expected " + std::to_string(model.base.display.vertex_count) +
                               " values, got " + std::to_string(base_values.size()));
        }
        *values = carry_paint(model, base_values);
    }
    return paint;
}

glm::mat3 make_matrix(const std::optional<py::array>& rows) {
    glm::mat3 matrix(1.0f);
    if (!rows) return matrix;
    const auto flat = scalars<float>(*rows, "world_from_object", 3);
    if (flat.size() != 9)
        throw InvalidInput("world_from_object: expected shape (3, 3), got " + describe(*rows));
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) matrix[c][r] = flat[3 * r + c];
    }
    return matrix;
}

Input make_input(const py::array& positions, const std::optional<py::array>& world_from_object,
                 const Moment& moment = {}) {
    return {vectors(positions, "positions"), make_matrix(world_from_object), moment};
}

struct Solved {
    State state;
    Report report;
};

Solved solve_frame(const Model& model, const Settings& settings, const Paint& paint,
                   const py::array& positions, const State* state,
                   const std::optional<py::array>& world_from_object, bool reference, const Moment& moment) {
    const Input input = make_input(positions, world_from_object, moment);
    const py::gil_scoped_release release;
    Solved out;
    out.state = (reference ? solve_reference : solve)(model, settings, paint, input, state, out.report);
    return out;
}

Picture show_frame(const Model& model, const Settings& settings, const py::array& positions,
                   const State& state, const std::optional<py::array>& world_from_object) {
    const Input input = make_input(positions, world_from_object);
    const py::gil_scoped_release release;
    Picture picture;
    show(model, settings, input, state, picture);
    return picture;
}

Measures measure_frame(const Model& model, const Settings& settings, const Paint& paint,
                       const py::array& positions, const State& state,
                       const std::optional<py::array>& world_from_object) {
    const Input input = make_input(positions, world_from_object);
    const py::gil_scoped_release release;
    return measure(model, settings, paint, input, state);
}

void bind_settings(py::module_& module) {
    py::class_<Settings> settings(
        module, "WrinkleMeshSettings",
        "Settings of a solve; see docs/wrinkle_mesh.md. Lengths are relative to the fine edges.");
    bind_reference_settings(settings, [](Settings& s) -> ReferenceSettings& { return s.rest; });
    settings.def(py::init<>())
        .def_readwrite("radius", &Settings::radius,
                       "r in mean lengths of the fine edges around a vertex, >= 0")
        .def_readwrite("prestretch", &Settings::prestretch, "s: rest length over measured length, > 0")
        .def_readwrite("slack", &Settings::slack,
                       "of layers: length over rest length at which the base pulls taut, > 0")
        .def_readwrite("taut_range", &Settings::taut_range,
                       "of layers: over which, below that, s goes from slack to prestretch, >= 0; 0: nowhere")
        .def_readwrite("bending", &Settings::bending, "k_bending, 0..1")
        .def_property(
            "collision",
            [](const Settings& s) {
                return s.collision == Collision::kNone    ? "NONE"
                       : s.collision == Collision::kPlane ? "PLANE"
                                                          : "NEIGHBOURHOOD";
            },
            [](Settings& s, const std::string& name) {
                s.collision = chosen<Collision>(name, "collision",
                                                {{"NONE", Collision::kNone},
                                                 {"PLANE", Collision::kPlane},
                                                 {"NEIGHBOURHOOD", Collision::kNeighbourhood}});
            },
            "NONE, PLANE or NEIGHBOURHOOD")
        .def_readwrite("inside", &Settings::inside, "depth of the collision floor in radii, 0..1")
        .def_readwrite("stretch_relief", &Settings::stretch_relief,
                       "share of the base's stretch given in to, 0..1")
        .def_readwrite("buckling_threshold", &Settings::buckling_threshold,
                       "compression of the base that bears no folds, share of the length, 0..1")
        .def_readwrite("compression_limit", &Settings::compression_limit,
                       "most rest length per length of the base, >= 1")
        .def_readwrite("hem_rings", &Settings::hem_rings, "rings over which r fades at open borders, >= 0")
        .def_readwrite("iterations", &Settings::iterations, "passes from a given state")
        .def_readwrite("start_iterations", &Settings::start_iterations, "passes from the canonical start")
        .def_readwrite("damping", &Settings::damping, "share of the former offset that is kept, 0..1")
        .def_property(
            "offset_space",
            [](const Settings& s) { return s.offset_space == OffsetSpace::kTriangle ? "TRIANGLE" : "WORLD"; },
            [](Settings& s, const std::string& name) {
                s.offset_space = chosen<OffsetSpace>(
                    name, "offset_space",
                    {{"TRIANGLE", OffsetSpace::kTriangle}, {"WORLD", OffsetSpace::kWorld}});
            },
            "TRIANGLE or WORLD")
        .def_readwrite("tangential_pull", &Settings::tangential_pull,
                       "share of its way along the surface that a pass pulls a vertex back, 0..1")
        .def_readwrite("normal_pull", &Settings::normal_pull, "the same off the surface, 0..1")
        .def_readwrite("apart", &Settings::apart,
                       "share of the distance to its own cloth that a vertex may go towards it, 0..0.5")
        .def_readwrite("slide", &Settings::slide,
                       "share of the heights of its triangles that a vertex may go along the surface, 0..0.5")
        .def_readwrite("nudge", &Settings::nudge,
                       "size of the random push of unbuckled vertices, in fine edges")
        .def_readwrite("seed", &Settings::seed, "of that push")
        .def_readwrite("threads", &Settings::threads, "0: chosen by size; never changes the result");
}

void bind_model(py::module_& module) {
    py::class_<Model, std::shared_ptr<Model>>(
        module, "WrinkleMeshModel", "A fine mesh attached to a base at rest. Made by build_wrinkle_mesh.")
        .def_property_readonly(
            "shown", [](const Model& m) -> const ShownMesh& { return m.shown; },
            py::return_value_policy::reference_internal, "The ShownMesh.")
        .def_property_readonly("solved_vertex_count", [](const Model& m) { return m.solved.vertex_count; })
        .def_property_readonly(
            "pair_count", [](const Model& m) { return m.distance.size() + m.bending.size(); },
            "Distance and bending constraints.")
        .def_property_readonly(
            "local_edge", [](const Model& m) { return to_numpy<float>(m.local_edge, 0); },
            "Per solved vertex: mean rest length of its edges.")
        .def_property_readonly(
            "unattached_distance", [](const Model& m) { return to_numpy<float>(m.unattached_distance, 0); },
            "Own mesh: distance of its vertices to the base at rest.");

    module.def(
        "build_wrinkle_mesh",
        [](const Surface& base, const std::string& source, Index level, Index segments, float longest_edge,
           Index most_vertices, const Surface* own, const std::optional<py::array>& attached, float farthest,
           const std::string& attachment, Index display_steps, bool adaptive) {
            return std::const_pointer_cast<Model>(make_model(base, source, level, segments, longest_edge,
                                                             most_vertices, own, attached, farthest,
                                                             attachment, display_steps, adaptive));
        },
        py::arg("base"), py::arg("source") = "SUBDIVISION", py::arg("level") = 2, py::arg("segments") = 4,
        py::arg("longest_edge") = 0.01f, py::arg("most_vertices") = 4'000'000, py::arg("own") = nullptr,
        py::arg("attached") = py::none(), py::arg("farthest") = 0.0f, py::arg("attachment") = "LIMIT",
        py::arg("display_steps") = 1, py::arg("adaptive") = false,
        "Make the fine mesh and its constraints (Mueller and Chentanez 2010, section 3).\n\n"
        "source: SUBDIVISION (level), REGULAR (segments), EDGE_LENGTH (longest_edge) or OBJECT (own: a "
        "Surface at\n"
        "rest in the base's space; attached: (n,) uint8; farthest: refuse a mesh farther away, 0 any).\n"
        "attachment: LINEAR, PN or LIMIT. display_steps: unsolved subdivisions of the shown mesh.\n"
        "adaptive: for settings whose reference is not STATIC_REST.");
}

}  // namespace

void bind_wrinkle_mesh(py::module_& module) {
    bind_settings(module);
    bind_model(module);
    py::class_<Paint>(module, "WrinkleMeshPaint", "Painted factors, carried to the solved vertices.")
        .def(py::init(&make_paint), py::arg("model"), py::arg("painted") = py::dict(),
             "painted: any of radius, prestretch, bending, inside -> (n,) float32 of the base's vertices, "
             "0..1.");
    py::class_<State>(module, "WrinkleMeshState", "What lives from frame to frame.")
        .def(py::init([](const py::array& offset, const py::array& lengths,
                         const std::optional<py::dict>& reference) {
                 const auto o = vectors(offset, "offset");
                 const auto l = scalars<float>(lengths, "solved_length", 0);
                 return State{{o.begin(), o.end()}, {l.begin(), l.end()}, reference_or_empty(reference)};
             }),
             py::arg("offset"), py::arg("solved_length"), py::arg("reference") = py::none())
        .def_property_readonly(
            "reference", [](const State& s) { return reference_or_none(s.reference); },
            "Of an adaptive rest shape: a dict of plain arrays; else None.")
        .def_property_readonly(
            "offset", [](const State& s) { return to_numpy(s.offset); }, "(v, 3) float32")
        .def_property_readonly("solved_length",
                               [](const State& s) { return to_numpy<float>(s.solved_length, 0); })
        .def("woken", &woken, "The same offsets with no vertex held: for a solve with other settings.")
        .def_property_readonly("nbytes", [](const State& s) {
            return s.offset.size() * sizeof(Vec3) + s.solved_length.size() * sizeof(float) +
                   s.reference.bytes();
        });
    py::class_<Report>(module, "WrinkleMeshReport", "How a solve went.")
        .def_readonly("iterations", &Report::iterations)
        .def_readonly("error_before", &Report::error_before, "RMS relative length error at the attachments")
        .def_readonly("error_after", &Report::error_after, "RMS relative length error, solved")
        .def_readonly("largest_error", &Report::largest_error)
        .def_readonly("active", &Report::active, "share of vertices that were solved, 0..1")
        .def_readonly("collapsed_triangles", &Report::collapsed_triangles)
        .def_readonly("kept_apart", &Report::kept_apart,
                      "vertices that its own cloth or a body in front kept from going on");
    py::class_<Measures>(module, "WrinkleMeshMeasures", "How good a frame is.")
        .def_readonly("edge_error_before_rms", &Measures::edge_error_before_rms)
        .def_readonly("edge_error_before_max", &Measures::edge_error_before_max)
        .def_readonly("edge_error_after_rms", &Measures::edge_error_after_rms)
        .def_readonly("edge_error_after_max", &Measures::edge_error_after_max)
        .def_readonly("compressed_area_before", &Measures::compressed_area_before)
        .def_readonly("compressed_area_after", &Measures::compressed_area_after)
        .def_readonly("attachment_violation", &Measures::attachment_violation)
        .def_readonly("largest_offset", &Measures::largest_offset)
        .def_property_readonly("offsets", [](const Measures& m) { return to_numpy(m.offsets); });

    module.def(
        "solve_wrinkle_mesh",
        [](const Model& model, const Settings& settings, const Paint& paint, const py::array& positions,
           const State* state, const std::optional<py::array>& world_from_object, bool reference, double time,
           const std::optional<py::array>& labels, const std::optional<py::array>& next_positions,
           double next_time) {
            Solved solved = solve_frame(model, settings, paint, positions, state, world_from_object,
                                        reference, make_moment(time, labels, next_positions, next_time));
            return py::make_tuple(std::move(solved.state), solved.report);
        },
        py::arg("model"), py::arg("settings"), py::arg("paint"), py::arg("positions"),
        py::arg("state") = nullptr, py::arg("world_from_object") = py::none(), py::arg("reference") = false,
        py::arg("time") = 0.0, py::arg("labels") = py::none(), py::arg("next_positions") = py::none(),
        py::arg("next_time") = 0.0,
        "Solve one frame; returns (state, report). positions: (n, 3) float32, deformed base, object space.\n"
        "state: of the frame before, or None for the canonical start. world_from_object: (3, 3) float32, "
        "used\n"
        "when offsets ride in world space. reference: the printed sequential sweeps, for tests. The rest is "
        "for a rest\n"
        "shape that adapts: time: seconds. labels: (t,) uint8 of label_clip. next_positions, next_time: the "
        "frame\n"
        "to come, to look ahead when labels are cut.");
    bind_label_clip<Model, Settings>(
        module,
        [](const Model& m) -> const ReferenceModel& {
            if (!m.adaptive) throw InvalidInput("model: expected one that was built with adaptive=True");
            return m.adaptive->triangles;
        },
        [](Settings& s) -> ReferenceSettings& { return s.rest; });
    module.def("show_wrinkle_mesh", &show_frame, py::arg("model"), py::arg("settings"), py::arg("positions"),
               py::arg("state"), py::arg("world_from_object") = py::none(),
               "The shown mesh for a frame and its state.");
    module.def("measure_wrinkle_mesh", &measure_frame, py::arg("model"), py::arg("settings"),
               py::arg("paint"), py::arg("positions"), py::arg("state"),
               py::arg("world_from_object") = py::none(),
               "Edge-length errors, areas and attachment violation of a frame.");
}

}  // namespace rumple::bindings
