// SPDX-License-Identifier: GPL-3.0-or-later
// Folds of a hem uncover nothing.
#include <gtest/gtest.h>

#include "tests/wrinkle_mesh_stack.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_mesh;

constexpr float kHem = 0.48f;

// A sleeve whose hem covers the last two centimetres of another one.
MeshData over_the_end() {
    return with_part(tube(24, 10, 0.1f, 0.5f), tube(24, 10, 0.105f, 0.5f), {kHem, 0.0f, 0.0f});
}
bool is_inner(const Vec3& rest) {
    return glm::length(Vec2(rest.y, rest.z)) < 0.1025f;
}

// The outer sleeve is stretched along its length and pulls back. The inner sleeve's end is moved in by
// `back`. Returns the largest movement of the hem, and the mean movement of all vertices.
std::pair<float, float> drawn_back(float back) {
    const Stack stack(over_the_end());
    const Pose3 pose = stack.moved([&](const Vec3& p) {
        return is_inner(p) ? p - Vec3(back, 0, 0) : Vec3(kHem + 1.3f * (p.x - kHem), p.y, p.z);
    });
    Settings settings;
    settings.hem_rings = 0;
    const LayersState state = stack.solve({pose}, alike(3, settings));
    const std::vector<Vec3>& rest = stack.layers->layers.back()->positions_rest;
    const Pose3 still = stack
                            .solve({pose}, alike(3,
                                                 [&] {
                                                     Settings none = settings;
                                                     none.radius = 0.0f;
                                                     return none;
                                                 }()))
                            .solved;
    float most = 0.0f, sum = 0.0f;
    for (size_t v = 0; v < rest.size(); ++v) {
        const float way = glm::distance(state.solved[v], still[v]);
        sum += way / float(rest.size());
        if (std::abs(rest[v].x - kHem) < 1e-4f && !is_inner(rest[v])) most = std::max(most, way);
    }
    return {most, sum};
}

TEST(WrinkleMeshHems, LayersLeaveCoveredWhatTheBaseLeavesCovered) {
    for (const float back : {0.0f, 0.01f, 0.02f}) {
        const auto [hem, all] = drawn_back(back);
        EXPECT_LE(hem, 0.7f * std::max(0.0175f - back, 0.0f) + 5e-4f) << back;
        EXPECT_GT(all, 1e-3f);
    }
}

}  // namespace
}  // namespace rumple::tests
