// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_mesh_layers.h"

#include <pybind11/stl.h>

#include "bindings/arrays.h"
#include "bindings/module.h"
#include "systems/wrinkle_mesh_transfer.h"

namespace rumple::bindings {
namespace {

using namespace wrinkle_mesh;

struct LayersPaint {
    std::vector<Paint> layers;
};

void scale(std::vector<float>& values, const std::vector<float>& by) {
    if (values.empty()) values.assign(by.size(), 1.0f);
    for (size_t v = 0; v < values.size(); ++v) values[v] *= by[v];
}

// strength: for every layer the name of the painted values that scale its radius.
LayersPaint make_paint(const Layers& model, const py::dict& painted,
                       const std::vector<std::string>& strength) {
    LayersPaint paint;
    paint.layers.resize(model.layers.size());
    if (strength.size() != model.layers.size()) {
        throw InvalidInput("strength: expected " + std::to_string(model.layers.size()) +
                           " names, one per layer, got " + std::to_string(strength.size()));
    }
    for (const auto& [key, value] : painted) {
        const std::string name = py::str(key);
        const auto base_values = scalars<float>(py::cast<py::array>(value), name.c_str(), 0);
        if (base_values.size() != size_t(model.base.display.vertex_count)) {
            throw InvalidInput(name + ": expected " + std::to_string(model.base.display.vertex_count) +
                               " values, got " + std::to_string(base_values.size()));
        }
        const std::vector<std::vector<float>> values = carry_paint(model, base_values);
        for (size_t k = 0; k < paint.layers.size(); ++k) {
            Paint& layer = paint.layers[k];
            if (name == "radius" || name == strength[k]) scale(layer.radius, values[k]);
            if (name == "prestretch") layer.prestretch = values[k];
            if (name == "bending") layer.bending = values[k];
            if (name == "inside") layer.inside = values[k];
        }
    }
    return paint;
}

// What a solve is made from. The arrays must outlive it.
struct Frame {
    Input input;
    std::optional<PosedCollider> bodies;

    Frame(const py::array& positions, const std::optional<py::array>& gap, const Collider* collider,
          const std::optional<py::array>& body_positions, const std::optional<py::array>& body_hint,
          float thickness) {
        input.positions = vectors(positions, "positions");
        if (gap) input.gap = scalars<float>(*gap, "gap", 0);
        input.thickness = thickness;
        if (!collider) return;
        if (!body_positions) throw InvalidInput("body_positions: expected an array, got None");
        if (!body_hint) throw InvalidInput("body_hint: expected an array, got None");
        input.body_hint = scalars<Index>(*body_hint, "body_hint", 0);
        bodies.emplace(*collider, vectors(*body_positions, "body_positions"));
        input.bodies = &*bodies;
    }
};

void bind_coarse(py::module_& module) {
    py::class_<CoarseMesh, std::shared_ptr<CoarseMesh>>(
        module, "CoarseMesh", "A coarse mesh that stands for a dense one. Made by build_coarse.")
        .def_property_readonly(
            "surface", [](const CoarseMesh& m) -> const Surface& { return m.surface; },
            py::return_value_policy::reference_internal, "Its Surface: triangles.")
        .def_property_readonly(
            "dense_vertex", [](const CoarseMesh& m) { return to_numpy<Index>(m.dense_vertex, 0); },
            "(m,) int32: of every vertex a vertex of the dense mesh.")
        .def_property_readonly(
            "mean_edge",
            [](const CoarseMesh& m) {
                double sum = 0.0;
                for (const Edge& e : m.surface.edges)
                    sum += glm::distance(m.surface.positions_rest[e.a], m.surface.positions_rest[e.b]);
                return sum / double(m.surface.edges.size());
            },
            "Mean length of its edges, object units.")
        .def(
            "positions",
            [](const CoarseMesh& m, const Surface& dense, const py::array& positions) {
                return to_numpy(coarse_positions(m, dense, vectors(positions, "positions")));
            },
            py::arg("dense"), py::arg("positions"),
            "(n, 3) float32 of the dense mesh's vertices -> (m, 3), such that the smooth surfaces lie on one "
            "another.");
    module.def(
        "build_coarse",
        [](const Surface& dense, float spacing) {
            const py::gil_scoped_release release;
            return std::const_pointer_cast<CoarseMesh>(build_coarse(dense, spacing));
        },
        py::arg("dense"), py::arg("spacing"),
        "spacing: about the mean length of its edges, object units. Raises ValueError where the mesh is too "
        "small for it.");
}

void bind_transfer(py::module_& module) {
    py::class_<Transfer, std::shared_ptr<Transfer>>(
        module, "WrinkleTransfer",
        "What shows layers over a coarse mesh on the dense one. Made by "
        "build_wrinkle_transfer.")
        .def_property_readonly(
            "shown", [](const Transfer& m) -> const ShownMesh& { return m.shown; },
            py::return_value_policy::reference_internal, "The ShownMesh.");
    module.def(
        "build_wrinkle_transfer",
        [](const Surface& base, const CoarseMesh& coarse, const Layers& layers, Index level,
           Index display_steps, Index most_vertices) {
            const py::gil_scoped_release release;
            return std::const_pointer_cast<Transfer>(
                build_transfer(base, coarse, layers, level, display_steps, most_vertices));
        },
        py::arg("base"), py::arg("coarse"), py::arg("layers"), py::arg("level"), py::arg("display_steps") = 0,
        py::arg("most_vertices") = 4'000'000,
        "base: the dense mesh. level: its subdivisions that are moved; display_steps: of these that are "
        "shown.");
    module.def(
        "show_wrinkle_transfer",
        [](const Transfer& transfer, const CoarseMesh& coarse, const Layers& layers,
           const py::array& animated, const LayersState& state) {
            const auto at = vectors(animated, "animated");
            const py::gil_scoped_release release;
            Picture picture;
            show(transfer, coarse, layers, at, state, picture);
            return picture;
        },
        py::arg("transfer"), py::arg("coarse"), py::arg("layers"), py::arg("animated"), py::arg("state"),
        "The ShownFrame of a solved frame. animated: (n, 3) float32 of the dense mesh before it became "
        "cloth.");
}

}  // namespace

void bind_wrinkle_mesh_layers(py::module_& module) {
    py::class_<Layers, std::shared_ptr<Layers>>(
        module, "WrinkleMeshLayers", "Wrinkle Meshes, one on the other. Made by build_wrinkle_layers.")
        .def_property_readonly(
            "shown", [](const Layers& m) -> const ShownMesh& { return m.shown; },
            py::return_value_policy::reference_internal, "The ShownMesh.")
        .def_property_readonly(
            "finest_triangles",
            [](const Layers& m) { return to_numpy<Index>(m.layers.back()->triangles, 3); },
            "(t, 3) int32: of the vertices of WrinkleLayersState.solved.")
        .def_property_readonly("count", [](const Layers& m) { return m.layers.size(); })
        .def_property_readonly(
            "solved_vertex_count",
            [](const Layers& m) {
                Index sum = 0;
                for (const auto& layer : m.layers) sum += layer->solved.vertex_count;
                return sum;
            },
            "Of all layers.")
        .def(
            "local_edge",
            [](const Layers& m, size_t k) { return to_numpy<float>(m.layers.at(k)->local_edge, 0); },
            py::arg("layer"), "Per solved vertex of a layer: mean rest length of its edges.");
    module.def(
        "build_wrinkle_layers",
        [](const Surface& base, Index levels, Index display_steps, Index most_vertices) {
            const py::gil_scoped_release release;
            return std::const_pointer_cast<Layers>(build_layers(base, levels, display_steps, most_vertices));
        },
        py::arg("base"), py::arg("levels"), py::arg("display_steps") = 1,
        py::arg("most_vertices") = 4'000'000,
        "The base mesh and `levels` subdivisions of it, each a layer that is solved over the one before.");
    py::class_<LayersPaint>(module, "WrinkleLayersPaint", "Painted factors, carried to every layer.")
        .def(py::init(&make_paint), py::arg("model"), py::arg("painted"), py::arg("strength"),
             "painted: names -> (n,) float32 of the base's vertices, 0..1: radius, prestretch, bending, "
             "inside, and\n"
             "those in strength: for every layer the name of what scales its radius.");
    py::class_<LayersState>(module, "WrinkleLayersState", "What lives from frame to frame.")
        .def("woken", [](const LayersState& s) { return woken(s); })
        .def_property_readonly(
            "solved", [](const LayersState& s) { return to_numpy(s.solved); },
            "(v, 3) float32: the finest layer, object space.")
        .def(
            "offset", [](const LayersState& s, size_t k) { return to_numpy(s.layers.at(k).offset); },
            py::arg("layer"))
        .def_property_readonly("nbytes", [](const LayersState& s) {
            size_t bytes = 0;
            for (const State& layer : s.layers)
                bytes += layer.offset.size() * sizeof(Vec3) + layer.solved_length.size() * sizeof(float);
            return bytes + s.solved.size() * sizeof(Vec3);
        });
    module.def(
        "solve_wrinkle_layers",
        [](const Layers& model, const std::vector<Settings>& settings, const LayersPaint& paint,
           const py::array& positions, const std::optional<py::array>& gap, const Collider* collider,
           const std::optional<py::array>& body_positions, const std::optional<py::array>& body_hint,
           float thickness, const LayersState* state) {
            LayersState out;
            std::vector<Report> reports;
            const Frame frame(positions, gap, collider, body_positions, body_hint, thickness);
            {
                const py::gil_scoped_release release;
                out = solve(model, settings, paint.layers, frame.input, state, reports);
            }
            return py::make_tuple(std::move(out), reports);
        },
        py::arg("model"), py::arg("settings"), py::arg("paint"), py::arg("positions"),
        py::arg("gap") = py::none(), py::arg("collider") = nullptr, py::arg("body_positions") = py::none(),
        py::arg("body_hint") = py::none(), py::arg("thickness") = 0.0f, py::arg("state") = nullptr,
        "Solve one frame; returns (state, [report of each layer]). settings: one for each layer, coarse "
        "first.\n"
        "positions: (n, 3) float32, deformed base or base cloth, object space. gap: (n,) float32: how far "
        "each\n"
        "vertex may go inwards, object units. collider, body_positions: bodies in this pose; body_hint: of\n"
        "solve_base_cloth; thickness: how far cloth stays off them, object units.\n"
        "state: of the frame before, or None.");
    module.def(
        "show_wrinkle_layers",
        [](const Layers& model, const py::array& animated, const py::array& positions,
           const LayersState& state) {
            const auto from = vectors(animated, "animated"), at = vectors(positions, "positions");
            const py::gil_scoped_release release;
            Picture picture;
            show(model, from, at, state, picture);
            return picture;
        },
        py::arg("model"), py::arg("animated"), py::arg("positions"), py::arg("state"),
        "The ShownFrame of a solved frame. animated: (n, 3) float32 of the base before it became cloth, "
        "which the\n"
        "shown mesh is embedded in. positions: (n, 3) float32, as they were solved.");
    bind_coarse(module);
    bind_transfer(module);
}

}  // namespace rumple::bindings
