// SPDX-License-Identifier: GPL-3.0-or-later
// Equation (1) at one vertex of a pose. Internal to wrinkle_field.
#pragma once

#include <optional>

#include "systems/wrinkle_field/wrinkle_field.h"

namespace rumple::wrinkle_field {

// M from the rest frame of a vertex to its deformed frame (t', b').
struct Neighbourhood {
    Vec3 tangent;
    Vec3 bitangent;
    glm::mat2 m;
};

// positions: of the welded vertices, deformed. normal: of the vertex there. None without a normal, in this
// pose or at rest.
inline std::optional<Neighbourhood> regress(const Model& model, std::span<const Vec3> positions,
                                            const Vec3& normal, size_t v) {
    if (normal == Vec3(0.0f) || model.tangent_rest[v] == Vec3(0.0f)) return {};
    const Index begin = model.neighbour_start[v], end = model.neighbour_start[v + 1];
    const Vec3 t =
        formulas::tangent_towards(positions[model.neighbours[begin].vertex] - positions[v], normal);
    Neighbourhood out{t, glm::cross(normal, t), glm::mat2(0.0f)};
    for (Index i = begin; i < end; ++i) {
        const Model::Neighbour& n = model.neighbours[i];
        const Vec3 displacement = positions[n.vertex] - positions[v];
        out.m += glm::outerProduct(
            formulas::tangent_space(displacement, out.tangent, out.bitangent, model.true_lengths),
            n.gradient);
    }
    return out;
}

}  // namespace rumple::wrinkle_field
