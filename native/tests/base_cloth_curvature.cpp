// SPDX-License-Identifier: GPL-3.0-or-later
// What tells tubes from panels: the curvature of the garment at rest along each spring.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/base_cloth_rig.h"

namespace rumple::tests {
namespace {

constexpr float kRadius = 0.08f, kLength = 0.8f;

// In the middle half of a tube along x: at its ends there are neighbours on one side only. Diagonals:
// between.
void expect_of_tube(const MeshData& mesh, float scale) {
    const Garment garment(mesh);
    for (const base_cloth::Model::Spring& spring : garment.model->springs) {
        const Vec3 &a = garment.model->surface.positions_rest[spring.a],
                   &b = garment.model->surface.positions_rest[spring.b];
        const float along = a.x / (scale * kLength);
        if (spring.diagonal || along < 0.25f || along > 0.75f) continue;
        EXPECT_NEAR(spring.curvature * scale * kRadius, a.x == b.x ? 1.0f : 0.0f, 0.02f);
    }
}

TEST(BaseClothCurvature, IsOneOverTheRadiusAroundATubeAndNoneAlongItWhateverItsDensityAndSize) {
    expect_of_tube(tube(16, 20, kRadius, kLength), 1.0f);
    expect_of_tube(tube(48, 60, kRadius, kLength), 1.0f);
    expect_of_tube(tube(16, 20, 50.0f * kRadius, 50.0f * kLength), 50.0f);
}

TEST(BaseClothCurvature, OfWhatIsFlatIsNone) {
    const Garment garment(grid(12, 9, 0.03f));
    for (const base_cloth::Model::Spring& spring : garment.model->springs) EXPECT_EQ(spring.curvature, 0.0f);
}

TEST(BaseClothCurvature, SmallFoldsOfTheModelDoNotCount) {
    const float length = 0.03f;  // of a fold, of a sheet of a metre
    MeshData mesh = grid(100, 100, 0.01f);
    for (Vec3& p : mesh.positions) p.z = 0.003f * std::sin(2.0f * 3.14159265f / length * p.x);
    const Garment garment(mesh);
    for (const base_cloth::Model::Spring& spring : garment.model->springs)
        EXPECT_LT(spring.curvature, 0.1f / 0.07f);
}

TEST(BaseClothCurvature, OfWhatHasNoAreaIsNone) {
    MeshData mesh = grid(6, 4, 0.03f);
    for (Vec3& p : mesh.positions) p.y = 0.0f;
    const Garment garment(mesh);
    for (const base_cloth::Model::Spring& spring : garment.model->springs) EXPECT_EQ(spring.curvature, 0.0f);
}

}  // namespace
}  // namespace rumple::tests
