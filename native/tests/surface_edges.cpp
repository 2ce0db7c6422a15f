// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <tuple>

#include "tests/meshes.h"

namespace rumple::tests {
namespace {

// What OpenMesh finds is what sorting the sides of all polygons finds: on open and closed meshes, over welded
// seams, and where two fans touch in a vertex.
TEST(Topology, TheEdgesOfOpenMeshAreThoseOfTheSortedSides) {
    MeshData tips;
    for (const Vec3& p : {Vec3(0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(-1, 0, 0), Vec3(0, -1, 0)})
        tips.positions.push_back(p);
    tips.add_polygon({0, 1, 2});
    tips.add_polygon({0, 3, 4});
    for (const MeshData& mesh :
         {grid(5, 4, 0.1f), triangulated(tube(6, 5, 0.4f, 1.0f)), cube(), seam_split_cube(), tips}) {
        const Surface surface = build(mesh);
        const std::vector<Edge> expected = collect_edges(surface.welded);
        ASSERT_EQ(surface.edges.size(), expected.size());
        for (size_t e = 0; e < expected.size(); ++e) {
            const Edge &found = surface.edges[e], &edge = expected[e];
            EXPECT_EQ(std::tuple(found.a, found.b, found.left, found.right),
                      std::tuple(edge.a, edge.b, edge.left, edge.right));
        }
    }
}

}  // namespace
}  // namespace rumple::tests
