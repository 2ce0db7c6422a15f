// SPDX-License-Identifier: GPL-3.0-or-later
// How far vertices lie from open borders, and the fade at hems that goes by it.
#include <gtest/gtest.h>

#include <algorithm>

#include "surface/mesh/border_rings.h"
#include "tests/meshes.h"

namespace rumple::tests {
namespace {

std::vector<Index> rings_of(const Surface& surface) {
    std::vector<std::array<Index, 2>> edges;
    for (const Edge& edge : surface.edges) edges.push_back({edge.a, edge.b});
    return border_rings(edges, surface.boundary_vertex);
}

TEST(BorderRings, AreTheFewestEdgesToAnOpenBorder) {
    constexpr Index kWide = 7, kHigh = 5;
    const std::vector<Index> ring = rings_of(build(grid(kWide, kHigh, 0.1f)));
    for (Index j = 0; j <= kHigh; ++j) {
        for (Index i = 0; i <= kWide; ++i)
            EXPECT_EQ(ring[i + j * (kWide + 1)], std::min({i, j, kWide - i, kHigh - j})) << i << ", " << j;
    }
}

TEST(BorderRings, AClosedMeshAndALooseVertexHaveNone) {
    for (const Index ring : rings_of(build(cube()))) EXPECT_EQ(ring, kNone);
    MeshData loose = grid(2, 2, 0.1f);
    loose.positions.push_back({9, 9, 9});
    const std::vector<Index> ring = rings_of(build(loose));
    EXPECT_EQ(ring.back(), kNone);
    EXPECT_EQ(ring[4], 1);  // the middle
}

TEST(BorderRings, TheFadeRisesFromTheBorderToTheLastRing) {
    EXPECT_EQ(hem_fade(0, 3), 0.0f);
    EXPECT_EQ(hem_fade(1, 2), 0.5f);
    for (Index ring = 0; ring < 4; ++ring) EXPECT_LT(hem_fade(ring, 4), hem_fade(ring + 1, 4));
    for (const Index ring : {Index(3), Index(8), kNone}) EXPECT_EQ(hem_fade(ring, 3), 1.0f);
    EXPECT_EQ(hem_fade(0, 0), 1.0f) << "no rings: no fade";
}

}  // namespace
}  // namespace rumple::tests
