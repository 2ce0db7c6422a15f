// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_field.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <glm/gtc/type_ptr.hpp>

#include "base/expect.h"
#include "bindings/arrays.h"
#include "bindings/choices.h"
#include "bindings/module.h"
#include "bindings/reference.h"

namespace rumple::bindings {
namespace {

using namespace wrinkle_field;

template <typename T>
std::vector<T> copied(std::span<const T> values) {
    return {values.begin(), values.end()};
}

std::shared_ptr<Model> make_model(const Surface& base, const std::string& output,
                                  const std::optional<py::array>& uv, const std::string& source, Index level,
                                  Index segments, float longest_edge, Index most_vertices,
                                  const std::string& attachment, bool true_lengths) {
    Plan plan;
    plan.output =
        chosen<Output>(output, "output", {{"SHADING", Output::kShading}, {"GEOMETRY", Output::kGeometry}});
    plan.fine = fine_source(source, level, segments, longest_edge, most_vertices);
    plan.attachment = attachment_kind(attachment);
    plan.true_lengths = true_lengths;
    if (uv) plan.uv = vectors2(*uv, "uv");
    const py::gil_scoped_release release;
    return std::const_pointer_cast<Model>(build(base, plan));
}

Paint make_paint(const py::dict& painted) {
    Paint paint;
    for (const auto& [key, value] : painted) {
        const std::string name = py::str(key);
        const auto array = py::cast<py::array>(value);
        if (name == "rest_wrinkle") {
            paint.rest_wrinkle = copied(vectors(array, "rest_wrinkle"));
        } else {
            *chosen<std::vector<float>*>(name, "paint",
                                         {{"mask", &paint.mask}, {"wavelength", &paint.wavelength}}) =
                copied(scalars<float>(array, name.c_str(), 0));
        }
    }
    return paint;
}

Profile make_profile(const std::string& kind, const std::optional<py::array>& height) {
    if (kind == "CURVE") {
        if (!height) throw InvalidInput("height: expected the values of the drawn curve, got None");
        return drawn(scalars<float>(*height, "height", 0));
    }
    return chosen<Profile (*)()>(
        kind, "profile", {{"SINE", sine}, {"ACCORDION", accordion}, {"PENCIL_PLEATS", pencil_pleats}})();
}

// A view for NumPy's sake of what the property returns as a copy.
template <typename Class>
auto numpy(std::vector<Vec3> Class::*member) {
    return [member](const Class& c) { return to_numpy(c.*member); };
}
template <typename Class>
auto numpy(std::vector<Vec2> Class::*member) {
    return [member](const Class& c) { return to_numpy<float>(c.*member, 2); };
}
template <typename Class>
auto numpy(std::vector<float> Class::*member) {
    return [member](const Class& c) { return to_numpy<float>(c.*member, 0); };
}

void bind_settings(py::module_& module) {
    py::class_<Settings> settings(module, "WrinkleFieldSettings",
                                  "Settings of a solve; see docs/wrinkle_field.md.");
    bind_reference_settings(settings, [](Settings& s) -> ReferenceSettings& { return s.rest; });
    settings.def(py::init<>())
        .def_readwrite("wavelength", &Settings::wavelength, "W in rest space, object units, > 0")
        .def_readwrite("strength", &Settings::strength, "factor on the amplitude of equation (2), >= 0")
        .def_readwrite("keep_length", &Settings::keep_length,
                       "geometry: waves no longer than the cloth at rest")
        .def_readwrite("dissolve", &Settings::dissolve, "waves that disagree with their neighbours are lower")
        .def_readwrite("rate", &Settings::rate, "epsilon / (2 pi^2) of equation (6), 0..1; stable below 1")
        .def_readwrite("rounds", &Settings::rounds, "of relaxation, from a given state, >= 0")
        .def_readwrite("start_rounds", &Settings::start_rounds, "from the canonical start, >= 0")
        .def_readwrite("irregularity", &Settings::irregularity, "0: tidy cloth, 1: skin")
        .def_readwrite("seed", &Settings::seed, "of the first phases and of the irregularity")
        .def_readwrite("aligned_start", &Settings::aligned_start, "False: random first phases, as printed")
        .def_readwrite("threads", &Settings::threads, "0: chosen by size; never changes the result");
}

std::vector<Index> welded_triangles(const Model& model) {
    std::vector<Index> vertices;
    for (const Triangle& triangle : model.base.triangles) {
        for (const Index corner : triangle.corner) {
            vertices.push_back(model.base.welded.corner_vertex[corner]);
        }
    }
    return vertices;
}

// One case per row through one of the shared formulas.
py::array_t<float> probe_formula(int formula, const py::array& arguments) {
    const std::span<const float> in = scalars<float>(arguments, "arguments", 16);
    std::vector<float> out(in.size());
    for (size_t i = 0; i < in.size(); i += 16) {
        const glm::mat4 y = formulas::probe_formula(formula, glm::make_mat4(&in[i]));
        std::copy_n(glm::value_ptr(y), 16, &out[i]);
    }
    return to_numpy<float>(out, 16);
}

void bind_model(py::module_& module) {
    py::class_<Model, std::shared_ptr<Model>>(
        module, "WrinkleFieldModel",
        "Neighbourhoods of a base at rest, and the mesh to show. Made by build_wrinkle_field.")
        .def_property_readonly(
            "shown", [](const Model& m) -> const ShownMesh& { return m.shown; },
            py::return_value_policy::reference_internal, "The ShownMesh.")
        .def_property_readonly(
            "vertex_count", [](const Model& m) { return m.base.positions_rest.size(); },
            "Welded vertices: w below.")
        .def_property_readonly(
            "neighbour_start", [](const Model& m) { return to_numpy<Index>(m.neighbour_start, 0); },
            "(w + 1,) int32")
        .def_property_readonly(
            "neighbours",
            [](const Model& m) {
                std::vector<Index> vertices;
                for (const Model::Neighbour& n : m.neighbours) vertices.push_back(n.vertex);
                return to_numpy<Index>(vertices, 0);
            },
            "(n,) int32 welded vertices")
        .def_property_readonly(
            "gradients",
            [](const Model& m) {
                std::vector<Vec2> gradients;
                for (const Model::Neighbour& n : m.neighbours) gradients.push_back(n.gradient);
                return to_numpy<float>(gradients, 2);
            },
            "(n, 2) float32: M of equation (1) is the sum of v' (x) gradient")
        .def_property_readonly("tangent_rest", numpy(&Model::tangent_rest), "(w, 3) float32")
        .def_property_readonly("bitangent_rest", numpy(&Model::bitangent_rest), "(w, 3) float32")
        .def_property_readonly(
            "welded_of", [](const Model& m) { return to_numpy<Index>(m.base.welded_of, 0); },
            "(n,) int32: the welded vertex of every vertex of the base")
        .def_property_readonly(
            "triangles", [](const Model& m) { return to_numpy<Index>(welded_triangles(m), 3); },
            "(t, 3) int32 welded vertices of the base's triangles, as they were given")
        .def_property_readonly(
            "uv", [](const Model& m) { return to_numpy<float>(m.uv, 2); },
            "(3 t, 2) float32, per corner of every triangle in turn; or empty")
        .def_property_readonly(
            "uv_fan", [](const Model& m) { return to_numpy<Index>(m.uv_fan, 0); },
            "(3 t,) int32: corners of one fan share their gradient of uv; or empty")
        .def_property_readonly(
            "first_directions", [](const Model& m) { return to_numpy<float>(first_directions(m), 2); },
            "(w, 2) float32: k that a clip starts from, rest frame")
        .def(
            "weld_pose",
            [](const Model& m, const py::array& positions) {
                const Pose pose = weld_pose(m, vectors(positions, "positions"));
                return py::make_tuple(to_numpy(pose.positions), to_numpy(pose.normals));
            },
            py::arg("positions"),
            "Positions (n, 3) float32 of the base's vertices -> positions and unit normals (or zero) of the\n"
            "welded ones, two (w, 3) float32.");

    module.def(
        "build_wrinkle_field", &make_model, py::arg("base"), py::arg("output") = "SHADING",
        py::arg("uv") = py::none(), py::arg("source") = "SUBDIVISION", py::arg("level") = 2,
        py::arg("segments") = 4, py::arg("longest_edge") = 0.01f, py::arg("most_vertices") = 4'000'000,
        py::arg("attachment") = "LIMIT", py::arg("true_lengths") = true,
        "What the rest pose fixes (Loviscach 2006, section 3).\n\n"
        "output: SHADING (the base's triangles; uv: (c, 2) float32 per corner of the base, for parallax) or\n"
        "GEOMETRY (a fine mesh, made as by build_wrinkle_mesh). true_lengths False: projected lengths in\n"
        "equation (1), as printed.");
}

}  // namespace

void bind_wrinkle_field(py::module_& module) {
    bind_settings(module);
    bind_model(module);
    module.attr("PROFILE_INTERVALS") = kProfileIntervals;
    py::class_<Paint>(module, "WrinkleFieldPaint", "Painted values of the base's vertices.")
        .def(
            py::init(&make_paint), py::arg("painted") = py::dict(),
            "painted: any of mask (n,) 0..1, wavelength (n,) factor > 0, rest_wrinkle (n, 3) shorter than 1, "
            "float32.");
    py::class_<Profile>(module, "WrinkleFieldProfile", "f and df/dphi of the wave, section 6.3.")
        .def(py::init(&make_profile), py::arg("kind"), py::arg("height") = py::none(),
             "kind: SINE, ACCORDION, PENCIL_PLEATS or CURVE (height: PROFILE_INTERVALS + 1 values in -1..1 "
             "from "
             "crest to valley).")
        .def_property_readonly("height",
                               [](const Profile& p) {
                                   return to_numpy<float>(
                                       std::vector<float>(p.height.begin(), p.height.end()), 0);
                               })
        .def_property_readonly("slope", [](const Profile& p) {
            return to_numpy<float>(std::vector<float>(p.slope.begin(), p.slope.end()), 0);
        });
    py::class_<State>(module, "WrinkleFieldState", "What lives from frame to frame.")
        .def(py::init([](const py::array& phase, const py::array& direction, const py::array& offset,
                         const std::optional<py::dict>& reference) {
                 return State{
                     copied(scalars<float>(phase, "phase", 0)), copied(vectors2(direction, "direction")),
                     copied(scalars<float>(offset, "solved_offset", 0)), reference_or_empty(reference)};
             }),
             py::arg("phase"), py::arg("direction"), py::arg("solved_offset"),
             py::arg("reference") = py::none())
        .def_property_readonly(
            "reference", [](const State& s) { return reference_or_none(s.reference); },
            "Of an adaptive rest shape: a dict of plain arrays; else None.")
        .def_property_readonly("solved_offset", numpy(&State::solved_offset),
                               "(neighbours,) float32, radians: when it was last relaxed")
        .def("woken", &woken, "The same phases with no vertex held: for a solve with other settings.")
        .def_property_readonly("phase", numpy(&State::phase), "(w,) float32, radians")
        .def_property_readonly("direction", numpy(&State::direction), "(w, 2) float32, rest frame")
        .def_property_readonly("nbytes", [](const State& s) {
            return (s.phase.size() + s.solved_offset.size()) * sizeof(float) +
                   s.direction.size() * sizeof(Vec2) + s.reference.bytes();
        });
    py::class_<Report>(module, "WrinkleFieldReport", "How a solve went.")
        .def_readonly("rounds", &Report::rounds)
        .def_readonly("misfit_before", &Report::misfit_before, "RMS phase error over edges, turns, 0..0.5")
        .def_readonly("misfit_after", &Report::misfit_after)
        .def_readonly("largest_change", &Report::largest_change, "of a phase since the state given, radians")
        .def_readonly("wrinkled", &Report::wrinkled, "vertices")
        .def_readonly("collapsed", &Report::collapsed, "vertices without a wave for that reason");
    py::class_<Waves>(module, "WrinkleFieldWaves",
                      "The field of a frame before its phases; w welded vertices.")
        .def_property_readonly("positions", numpy(&Waves::positions), "(w, 3), deformed, object space")
        .def_property_readonly("normals", numpy(&Waves::normals), "(w, 3), unit or zero")
        .def_property_readonly("wave_vector", numpy(&Waves::wave_vector), "(w, 3), radians per object unit")
        .def_property_readonly("height", numpy(&Waves::height), "(w,) h, object units")
        .def_property_readonly("fullness", numpy(&Waves::fullness), "(w,) h over W/4 before strength")
        .def_property_readonly("compression", numpy(&Waves::compression), "(w,) r")
        .def_property_readonly("gather", numpy(&Waves::gather), "(w,) rest length over length along the wave")
        .def_property_readonly("direction", numpy(&Waves::direction), "(w, 2) k in the rest frame");
    py::class_<Picture, ShownFrame>(
        module, "WrinkleFieldPicture",
        "The shown mesh of one frame (d vertices) and its waves (corners of its triangles).")
        .def_property_readonly("amplitude", numpy(&Picture::amplitude), "(d,) object units")
        .def_property_readonly("direction", numpy(&Picture::direction), "(d, 3) unit, rest space")
        .def_property_readonly("phase", numpy(&Picture::phase), "(d,) radians")
        .def_property_readonly("corner_phase", numpy(&Picture::corner_phase), "(3 t, 3) radians")
        .def_property_readonly("corner_weight", numpy(&Picture::corner_weight), "(3 t, 3) object units")
        .def_property_readonly(
            "corner_wave_vector",
            [](const Picture& p) {
                return py::make_tuple(to_numpy(p.corner_wave_vector[0]), to_numpy(p.corner_wave_vector[1]),
                                      to_numpy(p.corner_wave_vector[2]));
            },
            "three (3 t, 3), radians per object unit")
        .def_property_readonly("corner_u_gradient", numpy(&Picture::corner_u_gradient), "(3 t, 3) or empty")
        .def_property_readonly("corner_v_gradient", numpy(&Picture::corner_v_gradient), "(3 t, 3) or empty");

    py::class_<Wishes>(module, "WrinkleFieldWishes", "What settings and paint ask of the w welded vertices.")
        .def_property_readonly("wavelength", numpy(&Wishes::wavelength), "(w,) W, object units")
        .def_property_readonly("mask", numpy(&Wishes::mask), "(w,) factor on the amplitude")
        .def_property_readonly("rest_wrinkle", numpy(&Wishes::rest_wrinkle), "(w, 2) q, rest frame")
        .def_property_readonly("turn", numpy(&Wishes::turn), "(w, 2) (cos, sin) of the turn away from k");
    module.def("wishes_wrinkle_field", &wishes, py::arg("model"), py::arg("settings"), py::arg("paint"),
               "What settings and paint ask of every welded vertex, whatever the pose.");
    module.def("probe_formula", &probe_formula, py::arg("formula"), py::arg("arguments"),
               "For tests: (n, 16) float32 through shaders/shared/wrinkle_field_probe.glsl.");

    module.def(
        "crush_wrinkle_field",
        [](const Model& model, const Settings& settings, const Paint& paint, const py::array& positions,
           const State* state) {
            const auto deformed = vectors(positions, "positions");
            const py::gil_scoped_release release;
            if (!state) return crush(model, settings, paint, deformed, {});
            return crush(model, settings, paint, deformed, state->direction,
                         reference_stretches(model, state->reference, deformed));
        },
        py::arg("model"), py::arg("settings"), py::arg("paint"), py::arg("positions"),
        py::arg("state") = nullptr, "Section 4.2: the waves of a frame without their phases.");
    module.def(
        "reference_stretches",
        [](const Model& model, const State& state, const py::array& positions) {
            return to_numpy(reference_stretches(model, state.reference, vectors(positions, "positions")));
        },
        py::arg("model"), py::arg("state"), py::arg("positions"),
        "(w, 3) float32: the stretch (xx, xy, yy) of every welded vertex from the reference triangles "
        "around\n"
        "it, rest frame; empty where the rest shape does not adapt.");
    module.def(
        "relax_wrinkle_field",
        [](const Model& model, const Settings& settings, const Waves& waves, int rounds,
           const py::array& phase, bool align_first) {
            auto phases = copied(scalars<float>(phase, "phase", 0));
            expect_count("phase", phases.size(), waves.height.size(), "values");
            const py::gil_scoped_release release;
            if (align_first) align(model, settings, waves, rounds, phases);
            relax(model, settings, waves, rounds, phases);
            const py::gil_scoped_acquire acquire;
            return to_numpy<float>(phases, 0);
        },
        py::arg("model"), py::arg("settings"), py::arg("waves"), py::arg("rounds"), py::arg("phase"),
        py::arg("align") = false, "Section 5.2: so many rounds of equation (6), from phases (w,) float32.");
    module.def(
        "misfit_wrinkle_field",
        [](const Model& model, const Waves& waves, const py::array& phase) {
            return misfit(model, waves, scalars<float>(phase, "phase", 0));
        },
        py::arg("model"), py::arg("waves"), py::arg("phase"), "RMS phase error over edges, turns.");
    module.def(
        "random_phases",
        [](const Model& model, std::uint32_t seed) { return to_numpy<float>(random_phases(model, seed), 0); },
        py::arg("model"), py::arg("seed"), "(w,) float32: the phases that a clip starts from.");
    module.def(
        "evaluate_wrinkle_field",
        [](const Model& model, const Waves& waves, const Profile& profile, const py::array& phase,
           const py::array& triangles, const py::array& barycentric) {
            const auto phases = scalars<float>(phase, "phase", 0);
            const auto which = scalars<Index>(triangles, "triangles", 0);
            const auto weights = vectors2(barycentric, "barycentric");
            expect_count("phase", phases.size(), waves.height.size(), "values");
            expect_count("barycentric", weights.size(), which.size(), "places");
            std::vector<float> heights;
            std::vector<Vec3> gradients;
            for (size_t i = 0; i < which.size(); ++i) {
                expect_within("triangle " + std::to_string(i), which[i], 0,
                              double(model.base.triangles.size()) - 1.0);
                const Height at =
                    evaluate(model, waves, profile, phases, {which[i], weights[i].x, weights[i].y});
                heights.push_back(at.height);
                gradients.push_back(at.gradient);
            }
            return py::make_tuple(to_numpy<float>(heights, 0), to_numpy(gradients));
        },
        py::arg("model"), py::arg("waves"), py::arg("profile"), py::arg("phase"), py::arg("triangles"),
        py::arg("barycentric"),
        "Equations (5) and (8) at places on the base: triangles (p,) int32, barycentric (p, 2) float32, "
        "weights\n"
        "of a triangle's corners 1 and 2. Returns heights (p,) and gradients (p, 3), object units and "
        "space.");
    module.def(
        "solve_wrinkle_field",
        [](const Model& model, const Settings& settings, const Paint& paint, const py::array& positions,
           const State* state, double time, const std::optional<py::array>& labels,
           const std::optional<py::array>& next_positions, double next_time) {
            const auto deformed = vectors(positions, "positions");
            const Moment moment = make_moment(time, labels, next_positions, next_time);
            Report report;
            State after;
            {
                const py::gil_scoped_release release;
                after = solve(model, settings, paint, deformed, state, report, moment);
            }
            return py::make_tuple(std::move(after), report);
        },
        py::arg("model"), py::arg("settings"), py::arg("paint"), py::arg("positions"),
        py::arg("state") = nullptr, py::arg("time") = 0.0, py::arg("labels") = py::none(),
        py::arg("next_positions") = py::none(), py::arg("next_time") = 0.0,
        "Solve one frame; returns (state, report). positions: (n, 3) float32, deformed base, object space.\n"
        "state: of the frame before, or None for the canonical start. The rest is for a rest shape that "
        "adapts:\ntime: seconds. labels: (t,) uint8 of label_clip. next_positions, next_time: the frame to "
        "come, to look\nahead when labels are cut.");
    bind_label_clip<Model, Settings>(
        module, [](const Model& m) -> const ReferenceModel& { return m.triangles; },
        [](Settings& s) -> ReferenceSettings& { return s.rest; });
    module.def(
        "shown_waves_wrinkle_field",
        [](const Model& model, const Settings& settings, const Profile& profile, const Paint& paint,
           const py::array& positions, const State& state) {
            const auto deformed = vectors(positions, "positions");
            const py::gil_scoped_release release;
            return shown_waves(model, settings, profile, paint, deformed, state);
        },
        py::arg("model"), py::arg("settings"), py::arg("profile"), py::arg("paint"), py::arg("positions"),
        py::arg("state"),
        "The waves that show_wrinkle_field draws. positions: (n, 3) float32, deformed base, object space.\n"
        "Its arrays have a row for every one of the w welded vertices.");
    module.def(
        "show_wrinkle_field",
        [](const Model& model, const Settings& settings, const Profile& profile, const Paint& paint,
           const py::array& positions, const State& state, const std::optional<py::array>& gap) {
            const auto deformed = vectors(positions, "positions");
            const auto room = gap ? scalars<float>(*gap, "gap", 0) : std::span<const float>();
            const py::gil_scoped_release release;
            return show(model, settings, profile, paint, deformed, state, room);
        },
        py::arg("model"), py::arg("settings"), py::arg("profile"), py::arg("paint"), py::arg("positions"),
        py::arg("state"), py::arg("gap") = py::none(),
        "The shown mesh for a frame and its state, and the waves for shaders. gap: (n,) float32, how far "
        "the\nwaves of a fine mesh may go inwards, object units; None: as far as outwards.");
}

}  // namespace rumple::bindings
