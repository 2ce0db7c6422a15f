// SPDX-License-Identifier: GPL-3.0-or-later
// A base with its layers, and poses for them.
#pragma once

#include "systems/wrinkle_mesh/layers.h"
#include "tests/wrinkle_mesh_cloth.h"

namespace rumple::tests {

// A base and its layers, all solved with the same settings unless it is said.
struct Stack {
    MeshData mesh;
    std::shared_ptr<const wrinkle_mesh::Layers> layers;

    explicit Stack(MeshData data, Index levels = 2)
        : mesh(std::move(data)),
          layers(wrinkle_mesh::build_layers(tests::build(mesh), levels, 1, 4'000'000)) {}

    size_t count() const { return layers->layers.size(); }
    wrinkle_mesh::LayersState solve(const wrinkle_mesh::Input& input,
                                    const std::vector<wrinkle_mesh::Settings>& settings,
                                    const wrinkle_mesh::LayersState* before = nullptr,
                                    std::vector<wrinkle_mesh::Report>* reports = nullptr,
                                    std::vector<wrinkle_mesh::Paint> paint = {}) const {
        std::vector<wrinkle_mesh::Report> unused;
        paint.resize(count());
        return wrinkle_mesh::solve(*layers, settings, paint, input, before, reports ? *reports : unused);
    }
    wrinkle_mesh::Picture show(const Pose3& animated, const Pose3& positions,
                               const wrinkle_mesh::LayersState& state) const {
        wrinkle_mesh::Picture picture;
        wrinkle_mesh::show(*layers, animated, positions, state, picture);
        return picture;
    }
    template <typename Move>
    Pose3 moved(Move&& move) const {
        return each_moved(mesh.positions, move);
    }
    Pose3 squeezed(float factor) const {
        return moved([=](const Vec3& p) { return p * Vec3(factor, 1.0f, 1.0f); });
    }
};

inline std::vector<wrinkle_mesh::Settings> alike(size_t layers, const wrinkle_mesh::Settings& settings = {}) {
    return std::vector<wrinkle_mesh::Settings>(layers, settings);
}

}  // namespace rumple::tests
