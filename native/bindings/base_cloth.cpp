// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>

#include "bindings/arrays.h"
#include "bindings/module.h"
#include "surface/cloth/cover.h"
#include "surface/cloth/pins.h"
#include "surface/cloth/swing.h"

namespace rumple::bindings {
namespace {

using namespace base_cloth;

std::shared_ptr<Collider> make_collider(const py::array& positions, const py::array& triangles) {
    const auto points = vectors(positions, "positions");
    const auto flat = scalars<Index>(triangles, "triangles", 3);
    std::vector<std::array<Index, 3>> corners(flat.size() / 3);
    for (size_t t = 0; t < corners.size(); ++t) corners[t] = {flat[3 * t], flat[3 * t + 1], flat[3 * t + 2]};
    const py::gil_scoped_release release;
    return std::make_shared<Collider>(points, corners);
}

Paint make_paint(const Model& model, const py::dict& painted) {
    Paint paint;
    for (const auto& [key, value] : painted) {
        const std::string name = py::str(key);
        if (name != "follow" && name != "room") continue;  // of the wrinkles on top
        const auto values = scalars<float>(py::cast<py::array>(value), name.c_str(), 0);
        if (values.size() != size_t(model.surface.display.vertex_count)) {
            throw InvalidInput(name + ": expected " + std::to_string(model.surface.display.vertex_count) +
                               " values, got " + std::to_string(values.size()));
        }
        (name == "follow" ? paint.follow : paint.room).assign(values.begin(), values.end());
    }
    return paint;
}

// of_frame(positions, bodies): solves it.
template <typename OfFrame>
py::tuple solved(const py::array& positions, const Collider* collider,
                 const std::optional<py::array>& body_positions, OfFrame&& of_frame) {
    const auto points = vectors(positions, "positions");
    if (collider && !body_positions) throw InvalidInput("body_positions: expected an array, got None");
    const std::span<const Vec3> body =
        collider ? vectors(*body_positions, "body_positions") : std::span<const Vec3>();
    Result result;
    {
        const py::gil_scoped_release release;
        std::optional<PosedCollider> bodies;
        if (collider) bodies.emplace(*collider, body);
        result = of_frame(points, bodies ? &*bodies : nullptr);
    }
    return py::make_tuple(to_numpy(result.positions), to_numpy<float>(result.gap, 0),
                          to_numpy<Index>(result.body_hint, 0), std::move(result.state), result.report);
}

py::array_t<float> cover(const Surface& surface, const CoverModel& model, const Collider& collider,
                         const py::array& body_positions, const py::array& positions, const py::array& hints,
                         float thickness, float depth) {
    const auto points = vectors(positions, "positions"), body = vectors(body_positions, "body_positions");
    const auto near = scalars<Index>(hints, "hints", 0);
    std::vector<Vec3> lifts(points.size());
    {
        const py::gil_scoped_release release;
        const PosedCollider bodies(collider, body);
        lifts = lifts_over(surface, model, {thickness, depth}, bodies, points, near);
    }
    return to_numpy(lifts);
}

void bind_cover(py::module_& module) {
    py::class_<CoverModel, std::shared_ptr<CoverModel>>(module, "ClothCover", "Made by build_cloth_cover.");
    module.def(
        "build_cloth_cover",
        [](const Surface& surface) {
            const py::gil_scoped_release release;
            return std::make_shared<CoverModel>(build_cover(surface));
        },
        py::arg("surface"), "The points of the smooth surface of a coarse mesh that are to stay off bodies.");
    module.def(
        "cover_bodies", &cover, py::arg("surface"), py::arg("cover"), py::arg("collider"),
        py::arg("body_positions"), py::arg("positions"), py::arg("hints"), py::arg("thickness"),
        py::arg("depth"),
        "(n, 3) float32: how far every vertex has to move, outwards, for the smooth surface to stay off the\n"
        "bodies. positions: (n, 3) float32 of the cloth, object space. hints: (n,) int32, a triangle of the\n"
        "collider near it or -1. thickness, depth: object units; what is deeper inside stays there.");
}

py::tuple solve_frame(const Model& model, const Settings& settings, const Paint& paint,
                      const py::array& positions, const Collider* collider,
                      const std::optional<py::array>& body_positions, const State* state) {
    return solved(positions, collider, body_positions, [&](auto points, const PosedCollider* bodies) {
        return solve(model, settings, paint, points, bodies, state);
    });
}

py::tuple swing_frame(const Model& model, const Settings& settings, const Swing& swing_settings,
                      const Paint& paint, const py::array& positions, const Collider* collider,
                      const std::optional<py::array>& body_positions, const State* state) {
    return solved(positions, collider, body_positions, [&](auto points, const PosedCollider* bodies) {
        return swing(model, settings, swing_settings, paint, points, bodies, state);
    });
}

Vec3 vector_of(const std::array<float, 3>& v) {
    return {v[0], v[1], v[2]};
}

void bind_swing(py::module_& module) {
    py::class_<Swing>(module, "BaseClothSwing", "What swing_base_cloth needs beside BaseClothSettings.")
        .def(py::init<>())
        .def_readwrite("seconds", &Swing::seconds, "since the frame before, >= 0")
        .def_readwrite("longest_step", &Swing::longest_step, "of time, s, > 0")
        .def_readwrite("newton_steps", &Swing::newton_steps, "of every time step, >= 1")
        .def_readwrite("damping", &Swing::damping, "of the velocity beside the animated one, 1/s, >= 0")
        .def_readwrite("locomotion", &Swing::locomotion,
                       "share of the garment's motion as a whole that the inertia feels, 0..1")
        .def_readwrite("drag", &Swing::drag,
                       "density of the air x coefficient / (2 mass per area), 1/object unit, >= 0")
        .def_property(
            "wind", [](const Swing& s) { return py::make_tuple(s.wind.x, s.wind.y, s.wind.z); },
            [](Swing& s, const std::array<float, 3>& wind) { s.wind = vector_of(wind); },
            "three floats, object space, object units / s")
        .def(
            "place",
            [](Swing& s, const std::array<std::array<float, 3>, 3>& rows, const std::array<float, 3>& shift) {
                for (int row = 0; row < 3; ++row)
                    for (int column = 0; column < 3; ++column)
                        s.placement.matrix[column][row] = rows[row][column];
                s.placement.shift = vector_of(shift);
            },
            py::arg("matrix"), py::arg("shift"),
            "From the object space of the frame before to that of this one: (3, 3), then (3,) object units.");
}

void bind_settings(py::module_& module) {
    py::class_<Settings>(module, "BaseClothSettings",
                         "Settings of the base cloth; see docs/base_cloth.md. Stiffness is per mass: object\n"
                         "units^2 / s^2. Lengths are object units.")
        .def(py::init<>())
        .def_readwrite("stretch", &Settings::stretch, "of what is longer than at rest, > 0")
        .def_readwrite("strain_limit", &Settings::strain_limit,
                       "strain beyond which stretch is ten times as stiff")
        .def_readwrite("shear", &Settings::shear,
                       "of the diagonals of quads that are longer than at rest, >= 0")
        .def_readwrite("compression", &Settings::compression, "k1: of what is shorter than at rest, >= 0")
        .def_readwrite("compression_limit", &Settings::compression_limit,
                       "c_l: length over rest length below which k2 counts, 0..1")
        .def_readwrite("folded", &Settings::folded, "k2: of what is shorter than c_l, >= 0")
        .def_readwrite("smoothing", &Settings::smoothing,
                       "against displacements that differ between neighbours")
        .def_readwrite("slack", &Settings::slack,
                       "length of the cloth over that of the modelled garment, > 0")
        .def_readwrite("follow", &Settings::follow, "pull back to the animation, 1/s^2, > 0")
        .def_readwrite("room", &Settings::room, "farthest that a vertex leaves its animated place, >= 0")
        .def_property(
            "gravity",
            [](const Settings& s) { return py::make_tuple(s.gravity.x, s.gravity.y, s.gravity.z); },
            [](Settings& s, const std::array<float, 3>& g) { s.gravity = vector_of(g); },
            "three floats, object space, object units / s^2")
        .def_property(
            "thickness", [](const Settings& s) { return s.clearance.thickness; },
            [](Settings& s, float value) { s.clearance.thickness = value; }, "how far cloth stays off bodies")
        .def_property(
            "unknown", [](const Settings& s) { return s.clearance.unknown; },
            [](Settings& s, float value) { s.clearance.unknown = value; },
            "how far cloth may go inwards where no body is found")
        .def_property(
            "reach", [](const Settings& s) { return s.clearance.reach; },
            [](Settings& s, float value) { s.clearance.reach = value; }, "bodies farther away do not count")
        .def_property(
            "depth", [](const Settings& s) { return s.clearance.depth; },
            [](Settings& s, float value) { s.clearance.depth = value; },
            "what is deeper inside a body stays there")
        .def_property(
            "spread", [](const Settings& s) { return s.clearance.spread; },
            [](Settings& s, float value) { s.clearance.spread = value; },
            "length over which what is known of bodies fades")
        .def_readwrite("steps", &Settings::steps, "Newton steps from a given state")
        .def_readwrite("start_steps", &Settings::start_steps, "Newton steps from the animation")
        .def_readwrite("gradients", &Settings::gradients, "most conjugate gradients of a step");
}

void bind_collider(py::module_& module) {
    py::class_<Collider, std::shared_ptr<Collider>>(module, "Collider", "Bodies that cloth stays outside of.")
        .def(py::init(&make_collider), py::arg("positions"), py::arg("triangles"),
             "positions: (b, 3) float32, any pose. triangles: (t, 3) int32, counter-clockwise from outside.")
        .def_property_readonly("vertex_count", &Collider::vertex_count);
}

void bind_model(py::module_& module) {
    py::class_<Model, std::shared_ptr<Model>>(module, "BaseClothModel", "Made by build_base_cloth.");
    module.def(
        "build_base_cloth",
        [](const Surface& surface) {
            const py::gil_scoped_release release;
            return std::const_pointer_cast<Model>(build(surface));
        },
        py::arg("surface"), "The springs and contacts of a coarse mesh at rest.");
    module.def(
        "suggest_follow",
        [](const Surface& surface, const std::array<float, 3>& up) {
            return to_numpy<float>(suggest_follow(surface, {up[0], up[1], up[2]}), 0);
        },
        py::arg("surface"), py::arg("up"),
        "(n,) float32: how firmly every vertex follows the animation, 0 to 1: collars, waistbands and cuffs, "
        "found\n"
        "from the open borders at rest. up: unit, object space.");
    module.def("count_openings", &count_openings, py::arg("surface"),
               "Open borders that are not the outline of a sheet: a shirt has four, a head one.");
    py::class_<Paint>(module, "BaseClothPaint", "Painted factors.")
        .def(py::init(&make_paint), py::arg("model"), py::arg("painted") = py::dict(),
             "painted: follow, room -> (n,) float32, 0..1; other names are left alone.");
}

void bind_state_and_report(py::module_& module) {
    py::class_<State>(module, "BaseClothState", "What lives from frame to frame.")
        .def_property_readonly("offset", [](const State& s) { return to_numpy(s.offset); })
        .def_property_readonly("clearance", [](const State& s) { return to_numpy<float>(s.clearance, 0); })
        .def("woken", &woken,
             "A copy that is not held, for a solve with other settings. Of cloth that swings.")
        .def_property_readonly(
            "velocity", [](const State& s) { return to_numpy(s.motion.velocity); },
            "(w, 3) float32, object units / s; (0, 3) where it does not swing")
        .def_property_readonly("nbytes", &State::bytes);
    py::class_<Report>(module, "BaseClothReport", "How a solve went.")
        .def_readonly("steps", &Report::steps, "0: the pose was held")
        .def_readonly("gradients", &Report::gradients, "conjugate gradients of all steps")
        .def_readonly("moved", &Report::moved, "farthest way of a vertex in the last step")
        .def_readonly("offset_mean", &Report::offset_mean)
        .def_readonly("offset_max", &Report::offset_max)
        .def_readonly("taut", &Report::taut, "share of the springs that are longer than at rest")
        .def_readonly("touching", &Report::touching, "share of the vertices that rest on the inner surface")
        .def_readonly("body_known", &Report::body_known, "share of the vertices that have a body under them");
}

void bind_frames(py::module_& module) {
    module.def(
        "solve_base_cloth", &solve_frame, py::arg("model"), py::arg("settings"), py::arg("paint"),
        py::arg("positions"), py::arg("collider") = nullptr, py::arg("body_positions") = py::none(),
        py::arg("state") = nullptr,
        "Solve one frame; returns (positions, gap, body_hint, state, report): positions: (n, 3) float32 of "
        "the\n"
        "cloth, object space; gap: (n,) float32, its height above what is worn under it, object units;\n"
        "body_hint: (n,) int32, a triangle of the collider near it or -1; (0,) without one.\n"
        "positions: (n, 3) float32, animated. body_positions: (b, 3) float32 of the collider in this pose.\n"
        "state: of the frame before, or None.");
    module.def("swing_base_cloth", &swing_frame, py::arg("model"), py::arg("settings"), py::arg("swing"),
               py::arg("paint"), py::arg("positions"), py::arg("collider") = nullptr,
               py::arg("body_positions") = py::none(), py::arg("state") = nullptr,
               "One frame of cloth with inertia; as solve_base_cloth. Without a state that swings: its "
               "equilibrium,\nat rest.");
}

}  // namespace

void bind_base_cloth(py::module_& module) {
    bind_collider(module);
    bind_settings(module);
    bind_cover(module);
    bind_swing(module);
    bind_model(module);
    bind_state_and_report(module);
    bind_frames(module);
}

}  // namespace rumple::bindings
