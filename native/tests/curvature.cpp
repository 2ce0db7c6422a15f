// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/curvature.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/meshes.h"

namespace rumple::tests {
namespace {

constexpr float kRadius = 0.08f, kLength = 0.8f;

// In the middle half of a tube along x: at its ends there are neighbours on one side only.
void expect_of_tube(const MeshData& mesh) {
    const Surface surface = build(mesh);
    const std::vector<float> curvature = curvature_at_rest(surface);
    for (size_t v = 0; v < curvature.size(); ++v) {
        const float along = surface.positions_rest[v].x / kLength;
        if (along < 0.25f || along > 0.75f) continue;
        EXPECT_NEAR(curvature[v] * kRadius, 1.0f, 0.07f) << v;
    }
}

TEST(Curvature, OfATubeIsOneOverItsRadiusWhateverItsDensity) {
    expect_of_tube(tube(16, 20, kRadius, kLength));
    expect_of_tube(tube(48, 60, kRadius, kLength));
}

TEST(Curvature, OfWhatIsFlatIsNone) {
    for (const float value : curvature_at_rest(build(grid(12, 9, 0.03f)))) EXPECT_EQ(value, 0.0f);
}

TEST(Curvature, SmallFoldsOfTheModelDoNotCount) {
    const float length = 0.03f;  // of a fold, of a sheet of a metre
    MeshData mesh = grid(100, 100, 0.01f);
    for (Vec3& p : mesh.positions) p.z = 0.003f * std::sin(2.0f * 3.14159265f / length * p.x);
    for (const float value : curvature_at_rest(build(mesh))) EXPECT_LT(value, 0.1f / 0.07f);
}

TEST(Curvature, ScalesWithTheGarmentAndTakesWhatHasNoArea) {
    MeshData mesh = tube(16, 20, kRadius, kLength);
    const std::vector<float> once = curvature_at_rest(build(mesh));
    for (Vec3& p : mesh.positions) p *= 4.0f;
    const std::vector<float> larger = curvature_at_rest(build(mesh));
    for (size_t v = 0; v < once.size(); ++v) EXPECT_NEAR(4.0f * larger[v], once[v], 1e-3f * once[v]);
    for (Vec3& p : mesh.positions) p.y = p.z = 0.0f;
    for (const float value : curvature_at_rest(build(mesh))) EXPECT_EQ(value, 0.0f);
}

}  // namespace
}  // namespace rumple::tests
