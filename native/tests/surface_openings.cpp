// SPDX-License-Identifier: GPL-3.0-or-later
// What looks like a garment: it has openings to put it on through.
#include <gtest/gtest.h>

#include "surface/cloth/pins.h"
#include "tests/meshes.h"

namespace rumple::tests {
namespace {

Index openings(const MeshData& mesh) {
    return count_openings(build(mesh, true));
}

// A tube of length 0.5 m whose radius grows along it.
MeshData cone(float top, float hem) {
    MeshData mesh = tube(16, 8, 1.0f, 0.5f);
    for (Vec3& p : mesh.positions) p *= Vec3(1.0f, glm::mix(top, hem, 2.0f * p.x) * Vec2(1.0f));
    return mesh;
}

TEST(Openings, ASleeveHasTwoAndASheetNone) {
    EXPECT_EQ(openings(tube(16, 8, 0.05f, 0.5f)), 2);
    EXPECT_EQ(openings(grid(8, 8, 0.1f)), 0);
}

TEST(Openings, AWideHemIsNoOutlineWhereThereIsAWaist) {
    EXPECT_EQ(openings(cone(0.15f, 0.25f)), 2);
    EXPECT_EQ(openings(cone(0.15f, 0.6f)), 2);
}

TEST(Openings, PartsAreLookedAtOneByOne) {
    MeshData both = grid(8, 8, 0.1f);  // a cape beside a sleeve
    const MeshData sleeve = tube(16, 8, 0.05f, 0.5f);
    const auto first = static_cast<Index>(both.positions.size());
    for (const Vec3& p : sleeve.positions) both.positions.push_back(p + Vec3(0.0f, 0.0f, 2.0f));
    for (size_t c = 0; c < sleeve.corner_vertex.size(); c += 4) {
        const Index* v = &sleeve.corner_vertex[c];
        both.add_polygon({first + v[0], first + v[1], first + v[2], first + v[3]});
    }
    EXPECT_EQ(openings(both), 2);
}

}  // namespace
}  // namespace rumple::tests
