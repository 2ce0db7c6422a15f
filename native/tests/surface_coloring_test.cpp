// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "base/graph_coloring.h"
#include "tests/meshes.h"

namespace rumple::tests {
namespace {

struct Pairs {
    Index vertices = 0;
    std::vector<Index> a, b;

    Index largest_degree() const {
        std::vector<Index> degree(vertices, 0);
        for (std::size_t i = 0; i < a.size(); ++i) ++degree[a[i]], ++degree[b[i]];
        return *std::max_element(degree.begin(), degree.end());
    }
};

Pairs edges_of(const MeshData& mesh) {
    const Surface surface = build(mesh);
    Pairs pairs{surface.welded.vertex_count, {}, {}};
    for (const Edge& edge : surface.edges) {
        pairs.a.push_back(edge.a);
        pairs.b.push_back(edge.b);
    }
    return pairs;
}

Pairs random_pairs(Index vertices, Index count, unsigned seed) {
    std::mt19937 random(seed);
    Pairs pairs{vertices, {}, {}};
    while (static_cast<Index>(pairs.a.size()) < count) {
        const Index a = static_cast<Index>(random() % vertices), b = static_cast<Index>(random() % vertices);
        if (a == b) continue;
        pairs.a.push_back(a);
        pairs.b.push_back(b);
    }
    return pairs;
}

std::vector<Pairs> samples() {
    return {edges_of(grid(9, 7, 0.1f)), edges_of(triangulated(tube(11, 8, 0.1f, 1.0f))), edges_of(cube()),
            random_pairs(50, 400, 1), random_pairs(400, 800, 2)};
}

TEST(Coloring, NoTwoConstraintsOfOneColourShareAVertex) {
    for (const Pairs& pairs : samples()) {
        const auto color = color_constraints(pairs.vertices, pairs.a, pairs.b);
        ASSERT_EQ(color.size(), pairs.a.size());
        std::set<std::pair<Index, Index>> used;  // colour, vertex
        for (std::size_t i = 0; i < color.size(); ++i) {
            EXPECT_TRUE(used.insert({color[i], pairs.a[i]}).second) << "constraint " << i;
            EXPECT_TRUE(used.insert({color[i], pairs.b[i]}).second) << "constraint " << i;
        }
    }
}

TEST(Coloring, StaysWithinTheBoundAndLeavesNoGap) {
    for (const Pairs& pairs : samples()) {
        const auto color = color_constraints(pairs.vertices, pairs.a, pairs.b);
        const std::set<Index> colors(color.begin(), color.end());
        EXPECT_LE(static_cast<Index>(colors.size()), 2 * pairs.largest_degree() - 1);
        EXPECT_GE(static_cast<Index>(colors.size()), pairs.largest_degree());
        EXPECT_EQ(*colors.begin(), 0);
        EXPECT_EQ(*colors.rbegin(), static_cast<Index>(colors.size()) - 1);
    }
}

TEST(Coloring, FirstFitByHand) {
    // A path 0-1-2-3 and then the edge 0-3 that closes it.
    const std::vector<Index> a{0, 1, 2, 0}, b{1, 2, 3, 3};
    EXPECT_EQ(color_constraints(4, a, b), (std::vector<Index>{0, 1, 0, 1}));
    EXPECT_TRUE(color_constraints(4, {}, {}).empty());
}

}  // namespace
}  // namespace rumple::tests
