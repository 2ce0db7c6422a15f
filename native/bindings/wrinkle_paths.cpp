// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_paths.h"

#include <pybind11/stl.h>

#include <optional>

#include "bindings/arrays.h"
#include "bindings/choices.h"
#include "bindings/module.h"
#include "bindings/reference.h"

namespace rumple::bindings {
namespace {

using namespace wrinkle_paths;

template <typename Choice>
using Names = std::initializer_list<std::pair<const char*, Choice>>;

constexpr Names<Direction> kDirections = {
    {"OUTWARD", Direction::kOutward}, {"INWARD", Direction::kInward}, {"BOTH", Direction::kBoth}};
constexpr Names<Profile> kProfiles = {{"SPLINE", Profile::kSpline},
                                      {"QUARTIC", Profile::kQuartic},
                                      {"CIRCULAR_ARCS", Profile::kCircularArcs},
                                      {"SINE", Profile::kSine}};

template <typename Choice>
const char* name_of(Choice choice, Names<Choice> names) {
    for (const auto& [name, value] : names) {
        if (value == choice) return name;
    }
    return "";
}

// A setting that Python knows by the names of its choices.
template <typename Choice>
void bind_choice(py::class_<Settings>& settings, const char* name, Choice Settings::*field,
                 Names<Choice> names, const char* doc) {
    settings.def_property(
        name, [field, names](const Settings& s) { return name_of(s.*field, names); },
        [field, names, name](Settings& s, const std::string& value) {
            s.*field = chosen(value, name, names);
        },
        doc);
}

void bind_settings(py::module_& module) {
    py::class_<Settings> settings(module, "WrinklePathsSettings",
                                  "Settings of a solve; see docs/wrinkle_paths.md. Lengths in object units.");
    settings.def(py::init<>())
        .def_readwrite("smoothing", &Settings::smoothing, "of the triangles' shapes in time, seconds, >= 0")
        .def_readwrite("threshold", &Settings::threshold, "tau: compression from which folds live, > 1")
        .def_readwrite("reach", &Settings::reach, "folds go on down to this share of tau's compression, 0..1")
        .def_readwrite("width", &Settings::width, "L_min: width of the tightest fold, object units, > 0")
        .def_readwrite("spacing", &Settings::spacing, "of seeds from folds, in widths, > 0")
        .def_readwrite("alignment", &Settings::alignment, "alpha of eq. 5.2, >= 0")
        .def_readwrite("hem_rings", &Settings::hem_rings,
                       "rings over which compression and height fade towards open borders, >= 0")
        .def_readwrite("growth_limit", &Settings::growth_limit,
                       "most change of a fold's length, share per 1/30 s, >= 0")
        .def_readwrite("fade", &Settings::fade, "seconds in which a fold rises and sinks, >= 0")
        .def_readwrite("persistent", &Settings::persistent, "False: every frame is traced anew")
        .def_readwrite("seed", &Settings::seed, "of the places where folds may start")
        .def_readwrite("height", &Settings::height, "factor on the height that keeps the arc length, >= 0")
        .def_readwrite("threads", &Settings::threads, "0: chosen by size; never changes the result");
    bind_reference_settings(settings, [](Settings& s) -> ReferenceSettings& { return s; });
    bind_choice(settings, "direction", &Settings::direction, kDirections, "OUTWARD, INWARD or BOTH");
    bind_choice(settings, "profile", &Settings::profile, kProfiles, "SPLINE, QUARTIC, CIRCULAR_ARCS or SINE");
}

// ---- the state as plain arrays

py::dict state_arrays(const State& state) {
    std::vector<Index> id, start{0}, triangle_edge;
    std::vector<float> fade, at;
    for (const Path& path : state.paths) {
        id.push_back(path.id);
        fade.push_back(path.fade);
        for (const PathPoint& p : path.points) {
            triangle_edge.insert(triangle_edge.end(), {p.triangle, p.edge});
            at.insert(at.end(), {p.at.x, p.at.y});
        }
        start.push_back(static_cast<Index>(at.size() / 2));
    }
    py::dict out = reference_arrays(state);
    out["shapes"] = to_numpy<float>(state.shapes, 3);
    out["compression"] = to_numpy<float>(state.compression, 0);
    out["next_id"] = state.next_id;
    out["path_id"] = to_numpy<Index>(id, 0);
    out["path_fade"] = to_numpy<float>(fade, 0);
    out["path_start"] = to_numpy<Index>(start, 0);
    out["point_triangle_edge"] = to_numpy<Index>(triangle_edge, 2);
    out["point_at"] = to_numpy<float>(at, 2);
    return out;
}

void expect_size(const char* name, size_t got, size_t expected) {
    if (got == expected) return;
    throw InvalidInput(std::string(name) + ": expected " + std::to_string(expected) + " values, got " +
                       std::to_string(got));
}

State state_from(const py::dict& from) {
    State state;
    static_cast<ReferenceState&>(state) = reference_from(from);
    state.next_id = py::cast<Index>(from["next_id"]);
    const auto shapes = vectors(stored_array(from, "shapes"), "shapes");
    const auto compression = scalars<float>(stored_array(from, "compression"), "compression", 0);
    for (const Vec3& s : shapes) state.shapes.push_back({s.x, s.y, s.z});
    state.compression.assign(compression.begin(), compression.end());

    const auto id = scalars<Index>(stored_array(from, "path_id"), "path_id", 0);
    const auto fade = scalars<float>(stored_array(from, "path_fade"), "path_fade", 0);
    const auto start = scalars<Index>(stored_array(from, "path_start"), "path_start", 0);
    const auto place = scalars<Index>(stored_array(from, "point_triangle_edge"), "point_triangle_edge", 2);
    const auto at = scalars<float>(stored_array(from, "point_at"), "point_at", 2);
    expect_size("path_fade", fade.size(), id.size());
    expect_size("path_start", start.size(), id.size() + 1);
    expect_size("point_at", at.size(), place.size());
    for (size_t i = 0; i < id.size(); ++i) {
        if (start[i] < 0 || start[i + 1] < start[i] || size_t(start[i + 1]) > at.size() / 2)
            throw InvalidInput("path_start: path " + std::to_string(i) + " is not within the points");
        Path path{id[i], fade[i], {}};
        for (Index p = start[i]; p < start[i + 1]; ++p)
            path.points.push_back({place[2 * p], place[2 * p + 1], {at[2 * p], at[2 * p + 1]}});
        state.paths.push_back(std::move(path));
    }
    return state;
}

size_t state_bytes(const State& state) {
    size_t points = 0;
    for (const Path& path : state.paths) points += path.points.size();
    return state.bytes() + state.compression.size() * sizeof(float) +
           state.shapes.size() * sizeof(FlatTriangle) + state.paths.size() * sizeof(Path) +
           points * sizeof(PathPoint);
}

void bind_values(py::module_& module) {
    py::class_<Model, std::shared_ptr<Model>>(
        module, "WrinklePathsModel", "A base and the fine mesh shown on it. Made by build_wrinkle_paths.")
        .def_property_readonly(
            "shown", [](const Model& m) -> const ShownMesh& { return m.shown; },
            py::return_value_policy::reference_internal, "The ShownMesh.")
        .def_property_readonly("triangle_count", [](const Model& m) { return m.net.triangles(); })
        .def_property_readonly(
            "triangle_vertex", [](const Model& m) { return to_numpy<Index>(m.net.vertex, 3); },
            "(t, 3) int32: welded vertices of the base's triangles.");
    py::class_<Paint>(module, "WrinklePathsPaint", "Painted factors of the base's vertices.")
        .def(py::init([](const Model& model, const py::dict& painted) {
                 Paint paint;
                 for (const auto& [key, value] : painted) {
                     const std::string name = py::str(key);
                     std::vector<float>* values =
                         chosen<std::vector<float>*>(name, "paint", {{"mask", &paint.mask}});
                     const auto given = scalars<float>(py::cast<py::array>(value), name.c_str(), 0);
                     expect_size(name.c_str(), given.size(), size_t(model.base.display.vertex_count));
                     values->assign(given.begin(), given.end());
                 }
                 return paint;
             }),
             py::arg("model"), py::arg("painted") = py::dict(),
             "painted: mask -> (n,) float32 of the base's vertices, 0..1: where folds may start.");
    py::class_<State>(module, "WrinklePathsState", "What lives from frame to frame.")
        .def(py::init(&state_from), py::arg("arrays"), "From what `arrays` gave.")
        .def_property_readonly("arrays", &state_arrays,
                               "A dict of plain arrays that the same state can be made of, to the bit.")
        .def_property_readonly(
            "time", [](const State& s) { return s.time; }, "seconds")
        .def_property_readonly(
            "labels", [](const State& s) { return to_numpy<std::uint8_t>(s.labels, 0); },
            "(t,) uint8: 0 compress, 1 rest, 2 stretch.")
        .def_property_readonly("path_count", [](const State& s) { return s.paths.size(); })
        .def_property_readonly("nbytes", &state_bytes);
    py::class_<Report>(module, "WrinklePathsReport", "How a solve went.")
        .def_readonly("paths", &Report::paths)
        .def_readonly("born", &Report::born)
        .def_readonly("died", &Report::died)
        .def_readonly("merging", &Report::merging,
                      "paths that are being cut back to where they cross an older one")
        .def_readonly("compressed", &Report::compressed, "triangles by label")
        .def_readonly("stretched", &Report::stretched)
        .def_readonly("collapsed_triangles", &Report::collapsed_triangles)
        .def_readonly("moved_mean", &Report::moved_mean, "of path points along the surface, in widths")
        .def_readonly("moved_most", &Report::moved_most, "... 99th percentile");
    py::class_<Picture, ShownFrame>(module, "WrinklePathsPicture", "The shown mesh of one frame.")
        .def_property_readonly("height", [](const Picture& p) { return to_numpy<float>(p.height, 0); });
    py::class_<Packed>(module, "WrinklePathsLists", "Whom the folds reach: the three buffers of section 7.2.")
        .def_property_readonly(
            "triangle_start", [](const Packed& p) { return to_numpy<Index>(p.triangle_start, 0); },
            "(t + 1,) int32: where the ranges of every triangle begin.")
        .def_property_readonly(
            "ranges", [](const Packed& p) { return to_numpy<Index>(p.ranges, 2); },
            "(r, 2) int32: first piece and end of the pieces that reach the triangle.")
        .def_property_readonly(
            "ends", [](const Packed& p) { return to_numpy<float>(p.ends, 8); },
            "(e, 8) float32: piece i runs from end i to end i + 1; at, width, along, height. For fold_height "
            "of\n"
            "shaders/shared/wrinkle_paths.glsl.");
    py::class_<Curves>(module, "WrinklePathsCurves", "The paths as lines in space.")
        .def_property_readonly("start", [](const Curves& c) { return to_numpy<Index>(c.start, 0); })
        .def_property_readonly("id", [](const Curves& c) { return to_numpy<Index>(c.id, 0); })
        .def_property_readonly("positions", [](const Curves& c) { return to_numpy(c.positions); })
        .def_property_readonly("width", [](const Curves& c) { return to_numpy<float>(c.width, 0); })
        .def_property_readonly("height", [](const Curves& c) { return to_numpy<float>(c.height, 0); });
}

Input make_input(const py::array& positions, double time) {
    Input input;
    input.positions = vectors(positions, "positions");
    input.time = time;
    return input;
}

py::tuple solve_frame(const Model& model, const Settings& settings, const Paint& paint,
                      const py::array& positions, double time, const State* state,
                      const std::optional<py::array>& labels, const std::optional<py::array>& next_positions,
                      double next_time) {
    Input input = make_input(positions, time);
    static_cast<Moment&>(input) = make_moment(time, labels, next_positions, next_time);
    Report report;
    State next;
    {
        const py::gil_scoped_release release;
        next = solve(model, settings, paint, input, state, report);
    }
    return py::make_tuple(std::move(next), report);
}

}  // namespace

void bind_wrinkle_paths(py::module_& module) {
    bind_settings(module);
    bind_values(module);
    module.def(
        "build_wrinkle_paths",
        [](const Surface& base, const std::string& source, Index level, Index segments, float longest_edge,
           Index most_vertices, const std::string& attachment) {
            const FineSource fine = fine_source(source, level, segments, longest_edge, most_vertices);
            const AttachmentKind kind = attachment_kind(attachment);
            const py::gil_scoped_release release;
            return std::const_pointer_cast<Model>(build(base, fine, kind));
        },
        py::arg("base"), py::arg("source") = "SUBDIVISION", py::arg("level") = 3, py::arg("segments") = 8,
        py::arg("longest_edge") = 0.005f, py::arg("most_vertices") = 4'000'000,
        py::arg("attachment") = "LIMIT",
        "Make the fine mesh that folds are shown on.\n\n"
        "source: SUBDIVISION (level), REGULAR (segments) or EDGE_LENGTH (longest_edge). attachment: LINEAR, "
        "PN or\n"
        "LIMIT. Edges of 3/8 of the width show every fold.");
    module.def(
        "solve_wrinkle_paths", &solve_frame, py::arg("model"), py::arg("settings"), py::arg("paint"),
        py::arg("positions"), py::arg("time"), py::arg("state") = nullptr, py::arg("labels") = py::none(),
        py::arg("next_positions") = py::none(), py::arg("next_time") = 0.0,
        "Solve one frame; returns (state, report). positions: (n, 3) float32, deformed base, object space.\n"
        "time: seconds. state: of the frame before, or None for the canonical start. labels: (t,) uint8 of\n"
        "label_clip. next_positions, next_time: the frame to come, to look ahead when labels are cut.");
    bind_label_clip<Model, Settings>(
        module, [](const Model& m) -> const ReferenceModel& { return m; },
        [](Settings& s) -> ReferenceSettings& { return s; });
    module.def(
        "show_wrinkle_paths",
        [](const Model& model, const Settings& settings, const py::array& positions, const State& state) {
            const Input input = make_input(positions, state.time);
            const py::gil_scoped_release release;
            Picture picture;
            show(model, settings, input, state, picture);
            return picture;
        },
        py::arg("model"), py::arg("settings"), py::arg("positions"), py::arg("state"),
        "The shown mesh for a frame and its state.");
    module.def(
        "wrinkle_path_lists",
        [](const Model& model, const Settings& settings, const py::array& positions, const State& state) {
            const Input input = make_input(positions, state.time);
            const py::gil_scoped_release release;
            return pack(model, settings, input, state);
        },
        py::arg("model"), py::arg("settings"), py::arg("positions"), py::arg("state"),
        "For every triangle the pieces of folds that reach it.");
    module.def(
        "wrinkle_path_curves",
        [](const Model& model, const Settings& settings, const py::array& positions, const State& state) {
            const Input input = make_input(positions, state.time);
            const py::gil_scoped_release release;
            return curves(model, settings, input, state);
        },
        py::arg("model"), py::arg("settings"), py::arg("positions"), py::arg("state"),
        "The smoothed paths as lines in object space, with width and height at every point.");
    module.def(
        "wrinkle_path_fault",
        [](const Model& model, const State& state) { return fault(model, state.paths); }, py::arg("model"),
        py::arg("state"), "Empty when every path lies on the surface; else what is wrong.");
    module.def(
        "wrinkle_path_stretches",
        [](const Model& model, const py::array& positions, const State& state) {
            std::vector<Vec3> welded(size_t(model.base.welded.vertex_count));
            weld_positions(model.base, vectors(positions, "positions"), welded);
            std::vector<Vec2> values;
            for (const Stretch& s : stretches(model, state, welded))
                values.push_back({s.compression, s.stretch});
            return to_numpy<float>(values, 2);
        },
        py::arg("model"), py::arg("positions"), py::arg("state"),
        "(t, 2) float32: compression (1 / lambda_min) and stretch of every triangle from its reference.");
}

}  // namespace rumple::bindings
