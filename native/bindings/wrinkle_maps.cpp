// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_maps.h"

#include <pybind11/stl.h>

#include "bindings/arrays.h"
#include "bindings/choices.h"
#include "bindings/module.h"

namespace rumple::bindings {
namespace {

using namespace wrinkle_maps;

static_assert(sizeof(Bone) == 6 * sizeof(float));

std::span<const Bone> bones_of(const py::array& array, const char* name) {
    const std::span<const float> flat = scalars<float>(array, name, 6);
    return {reinterpret_cast<const Bone*>(flat.data()), flat.size() / 6};
}

std::vector<Bone> copied(const py::array& array, const char* name) {
    const std::span<const Bone> bones = bones_of(array, name);
    return {bones.begin(), bones.end()};
}

Tracked tracked_of(const std::string& name) {
    return chosen<Tracked>(name, "tracked",
                           {{"HEAD", Tracked::kHead}, {"TAIL", Tracked::kTail}, {"BOTH", Tracked::kBoth}});
}

std::shared_ptr<Model> make_model(const std::vector<std::string>& names,
                                  const std::vector<std::string>& tracked, const py::array& group,
                                  const py::array& neutral,
                                  const std::vector<std::pair<std::string, py::array>>& poses,
                                  const py::array& weight_start, const py::array& weight_bone,
                                  const py::array& weight) {
    Rig rig;
    rig.names = names;
    for (const std::string& name : tracked) rig.tracked.push_back(tracked_of(name));
    const auto groups = scalars<Index>(group, "group", 0);
    rig.group = {groups.begin(), groups.end()};
    rig.neutral = copied(neutral, "neutral");
    for (const auto& [name, bones] : poses) rig.poses.push_back({name, copied(bones, name.c_str())});
    const auto start = scalars<Index>(weight_start, "weight_start", 0);
    const auto bone = scalars<Index>(weight_bone, "weight_bone", 0);
    const auto value = scalars<float>(weight, "weight", 0);
    const SparseRows weights{
        {start.begin(), start.end()}, {bone.begin(), bone.end()}, {value.begin(), value.end()}};
    const py::gil_scoped_release release;
    return std::const_pointer_cast<Model>(build(rig, weights));
}

glm::mat4 matrix_of(const py::array& rows) {
    const auto flat = scalars<float>(rows, "root", 4);
    if (flat.size() != 16) throw InvalidInput("root: expected shape (4, 4), got " + describe(rows));
    glm::mat4 matrix;
    for (int r = 0; r < 4; ++r) {
        for (int c = 0; c < 4; ++c) matrix[c][r] = flat[4 * r + c];
    }
    return matrix;
}

py::array_t<float> make_masks(const Model& model, const Influences& influences, float gain,
                              const std::vector<float>& strength) {
    std::vector<float> out;
    {
        const py::gil_scoped_release release;
        out = masks(model, {gain, strength}, influences);
    }
    py::array_t<float> array({py::ssize_t(model.poses()), py::ssize_t(model.vertices())});
    std::copy(out.begin(), out.end(), array.mutable_data());
    return array;
}

// (n, 3) neutral normals and, of every pose, (n, 3) normals and (n,) masks.
py::array_t<float> blend_pixels(const py::array& neutral, const std::vector<py::array>& wrinkles,
                                const std::vector<py::array>& masks, const std::string& maps) {
    const Maps kind = chosen<Maps>(maps, "maps", {{"WHOLE", Maps::kWhole}, {"WRINKLES", Maps::kWrinkles}});
    const std::span<const Vec3> normals = vectors(neutral, "neutral");
    std::vector<std::span<const Vec3>> maps_of_poses;
    std::vector<std::span<const float>> masks_of_poses;
    for (const py::array& array : wrinkles) maps_of_poses.push_back(vectors(array, "wrinkles"));
    for (const py::array& array : masks) masks_of_poses.push_back(scalars<float>(array, "masks", 0));
    if (maps_of_poses.size() != masks_of_poses.size()) {
        throw InvalidInput("masks: expected " + std::to_string(wrinkles.size()) + " arrays, got " +
                           std::to_string(masks.size()));
    }
    for (size_t k = 0; k < maps_of_poses.size(); ++k) {
        if (maps_of_poses[k].size() == normals.size() && masks_of_poses[k].size() == normals.size()) continue;
        throw InvalidInput("pose " + std::to_string(k) + ": expected " + std::to_string(normals.size()) +
                           " normals and masks, got " + std::to_string(maps_of_poses[k].size()) + " and " +
                           std::to_string(masks_of_poses[k].size()));
    }
    std::vector<Vec3> out;
    std::vector<Vec3> w(maps_of_poses.size());
    std::vector<float> m(maps_of_poses.size());
    for (size_t p = 0; p < normals.size(); ++p) {
        for (size_t k = 0; k < w.size(); ++k) {
            w[k] = maps_of_poses[k][p];
            m[k] = masks_of_poses[k][p];
        }
        out.push_back(blend(kind, normals[p], w, m));
    }
    return to_numpy(out);
}

}  // namespace

void bind_wrinkle_maps(py::module_& module) {
    module.attr("MOST_POSES") = kMostPoses;
    py::class_<Model, std::shared_ptr<Model>>(module, "WrinkleMapsModel",
                                              "Reference poses and skin weights. Made by build_wrinkle_maps.")
        .def_property_readonly("vertex_count", &Model::vertices)
        .def_property_readonly("pose_count", &Model::poses)
        .def_property_readonly("bone_count", &Model::bones)
        .def_property_readonly(
            "moves", [](const Model& m) { return to_numpy<std::uint8_t>(m.moves, m.poses()); },
            "(b, o) uint8: 1 where a bone moves in a pose; elsewhere its influence is 0, alone")
        .def_property_readonly(
            "reach", [](const Model& m) { return to_numpy<float>(m.reach, m.poses()); },
            "(n, o) float32: sum of the weights of the bones that move in a pose, 0..1")
        .def_property_readonly(
            "weights",
            [](const Model& m) {
                return py::make_tuple(to_numpy<Index>(m.weights.start, 0),
                                      to_numpy<Index>(m.weights.index, 0),
                                      to_numpy<float>(m.weights.weight, 0));
            },
            "(start, bone, weight) as given, but summing to 1 and without the bones that are not listed")
        .def_readonly("unnormalised", &Model::unnormalised, "vertices whose weights did not sum to 1")
        .def_readonly("unbound", &Model::unbound, "vertices without any weight");
    py::class_<Influences>(module, "WrinkleMapsInfluences",
                           "Of the reference poses on every bone, in one frame.")
        .def_property_readonly(
            "pose",
            [](const Influences& at) {
                const size_t bones = at.rest.size();
                return to_numpy<float>(at.pose, py::ssize_t(bones ? at.pose.size() / bones : 0));
            },
            "(b, o) float32, 0..1")
        .def_property_readonly(
            "rest", [](const Influences& at) { return to_numpy<float>(at.rest, 0); }, "(b,) float32, 0..1");

    module.def(
        "build_wrinkle_maps", &make_model, py::arg("names"), py::arg("tracked"), py::arg("group"),
        py::arg("neutral"), py::arg("poses"), py::arg("weight_start"), py::arg("weight_bone"),
        py::arg("weight"),
        "Reference poses and skin weights (Dutreve et al. 2009, section 5).\n\n"
        "names: of the b bones. tracked: b of HEAD, TAIL, BOTH. group: (b,) int32, -1: on its own.\n"
        "neutral: (b, 6) float32, heads and tails in root space. poses: at most MOST_POSES of\n"
        "(name, (b, 6) float32). Weights of n vertices: weight_start (n + 1,) int32 into weight_bone int32\n"
        "(-1: a bone that is not listed) and weight float32.");
    module.def(
        "bones_in_root_space",
        [](const py::array& root, const py::array& bones) {
            return to_numpy<float>(in_root_space(matrix_of(root), bones_of(bones, "bones")), 6);
        },
        py::arg("root"), py::arg("bones"),
        "root: (4, 4) float32, from root space to the space of bones, (b, 6) float32.");
    module.def(
        "evaluate_wrinkle_maps",
        [](const Model& model, const py::array& bones) { return evaluate(model, bones_of(bones, "bones")); },
        py::arg("model"), py::arg("bones"), "Section 5.1. bones: (b, 6) float32, root space.");
    module.def(
        "presence_of_wrinkle_maps",
        [](const Model& model, const Influences& at) { return to_numpy<float>(presence(model, at), 0); },
        py::arg("model"), py::arg("influences"), "(o,) float32: how present each pose is as a whole.");
    module.def("masks_of_wrinkle_maps", &make_masks, py::arg("model"), py::arg("influences"),
               py::arg("gain") = 1.0f, py::arg("strength") = std::vector<float>(),
               "Section 5.2: (o, n) float32, 0..1. gain: 0.1..100; strength: 0..1 for each pose, empty: 1.");
    module.def("blend_wrinkle_maps", &blend_pixels, py::arg("neutral"), py::arg("wrinkles"), py::arg("masks"),
               py::arg("maps") = "WRINKLES",
               "Section 5.3, pixel by pixel: (n, 3) float32 unit normals in tangent space.\n"
               "neutral: (n, 3) float32; wrinkles: o of (n, 3); masks: o of (n,). maps: WHOLE or WRINKLES.");
}

}  // namespace rumple::bindings
