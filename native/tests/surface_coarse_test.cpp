// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of the coarse mesh that stands for a dense one.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "surface/output/coarse.h"
#include "surface/refine/refinement.h"
#include "tests/meshes.h"
#include "tests/refusals.h"

namespace rumple::tests {
namespace {

constexpr float kSpacing = 0.03f;

MeshData dense_tube(Index around) {
    return tube(around, around, 0.08f, 0.5f);
}

double mean_edge(const Surface& surface) {
    double sum = 0.0;
    for (const Edge& e : surface.edges)
        sum += glm::distance(surface.positions_rest[e.a], surface.positions_rest[e.b]);
    return sum / double(surface.edges.size());
}

// Closed borders, by walking along them.
int borders(const Surface& surface) {
    std::map<Index, std::vector<Index>> along;
    for (const Edge& e : surface.edges) {
        if (e.right != kNone) continue;
        along[e.a].push_back(e.b);
        along[e.b].push_back(e.a);
    }
    int count = 0;
    std::set<Index> seen;
    for (const auto& [start, unused] : along) {
        if (seen.contains(start)) continue;
        ++count;
        std::vector<Index> front{start};
        while (!front.empty()) {
            const Index v = front.back();
            front.pop_back();
            if (seen.insert(v).second) front.insert(front.end(), along[v].begin(), along[v].end());
        }
    }
    return count;
}

// Of a closed surface 2, of a tube 0, of a sheet 1.
Index euler(const Surface& surface) {
    std::set<Index> used(surface.welded.corner_vertex.begin(), surface.welded.corner_vertex.end());
    return Index(used.size()) - Index(surface.edges.size()) + Index(surface.triangles.size());
}

float border_length(const Surface& surface) {
    float sum = 0.0f;
    for (const Edge& e : surface.edges) {
        if (e.right == kNone) sum += glm::distance(surface.positions_rest[e.a], surface.positions_rest[e.b]);
    }
    return sum;
}

TEST(Coarse, ItsBordersRunAlongThoseOfTheDenseMesh) {
    for (const MeshData& mesh : {grid(60, 40, 0.006f), dense_tube(80)}) {
        const Surface dense = build(mesh);
        const auto coarse = build_coarse(dense, kSpacing);
        EXPECT_NEAR(border_length(coarse->surface), border_length(dense), 0.05f * border_length(dense));
    }
}

// The corner of a sheet is a vertex of the coarse mesh: what lies beyond that does not turn with it.
TEST(Coarse, CornersOfASheetStayCorners) {
    for (unsigned seed = 0; seed < 6; ++seed) {
        const MeshData mesh = seed == 0 ? grid(60, 40, 0.006f) : shaken(grid(60, 40, 0.006f), 0.001f, seed);
        const auto coarse = build_coarse(build(mesh), kSpacing);
        const std::set<Index> chosen(coarse->base_vertex.begin(), coarse->base_vertex.end());
        for (const Index corner : {0, 60, 40 * 61, 40 * 61 + 60})
            EXPECT_TRUE(chosen.contains(corner)) << corner;
    }
}

// Borders of cells are ragged there: a third cell meets two others there and back.
TEST(Coarse, IrregularMeshesMakeNoHolesEither) {
    for (unsigned seed = 0; seed < 40; ++seed) {
        const auto sheet = build_coarse(build(shaken(grid(60, 40, 0.006f), 0.0029f, seed)), kSpacing);
        EXPECT_EQ(euler(sheet->surface), 1) << seed;
        EXPECT_EQ(borders(sheet->surface), 1) << seed;
    }
}

TEST(Coarse, HasTheSameTopologyAsTheDenseMesh) {
    const struct {
        MeshData mesh;
        Index euler;
        int borders;
    } cases[] = {{dense_tube(80), 0, 2},
                 {grid(60, 40, 0.006f), 1, 1},
                 {triangulated(dense_tube(50)), 0, 2},
                 {shaken(grid(60, 40, 0.006f), 0.002f, 7), 1, 1}};
    for (const auto& [mesh, wanted, loops] : cases) {
        const auto coarse = build_coarse(build(mesh), kSpacing);
        EXPECT_EQ(euler(coarse->surface), wanted);
        EXPECT_EQ(borders(coarse->surface), loops);
        EXPECT_TRUE(coarse->surface.warnings.empty());
    }
}

TEST(Coarse, ItsEdgesAreAboutTheSpacingWhateverTheDensity) {
    for (const Index around : {60, 90, 130}) {
        const auto coarse = build_coarse(build(dense_tube(around)), kSpacing);
        EXPECT_NEAR(mean_edge(coarse->surface), kSpacing, 0.2 * kSpacing) << around;
    }
}

TEST(Coarse, ItIsWoundAsTheDenseMesh) {
    const auto coarse = build_coarse(build(dense_tube(80)), kSpacing);
    for (Index t = 0; t < Index(coarse->surface.triangles.size()); ++t) {
        const auto [a, b, c] = welded_vertices(coarse->surface, t);
        const auto& p = coarse->surface.positions_rest;
        const Vec3 middle = (p[a] + p[b] + p[c]) / 3.0f;
        EXPECT_GT(glm::dot(glm::cross(p[b] - p[a], p[c] - p[a]), Vec3(0.0f, middle.y, middle.z)), 0.0f);
    }
}

TEST(Coarse, ItsVerticesAreOfTheDenseMeshAndEachIsOneOnce) {
    const Surface dense = build(dense_tube(80));
    const auto coarse = build_coarse(dense, kSpacing);
    const std::set<Index> once(coarse->base_vertex.begin(), coarse->base_vertex.end());
    EXPECT_EQ(once.size(), coarse->base_vertex.size());
    EXPECT_GE(*once.begin(), 0);
    EXPECT_LT(*once.rbegin(), dense.display.vertex_count);
}

TEST(Coarse, ItsSmoothSurfaceRunsThroughTheDenseMesh) {
    const MeshData mesh = dense_tube(80);
    const Surface dense = build(mesh);
    const auto coarse = build_coarse(dense, kSpacing);
    const SparseRows limit = subdivision_stencils(coarse->surface.welded, 0, true);
    const std::vector<Vec3> at = coarse_positions(*coarse, dense, mesh.positions);
    std::vector<Vec3> smooth(at.size());
    apply<Vec3>(limit, at, smooth);
    float cage = 0.0f, sum = 0.0f;
    for (size_t v = 0; v < at.size(); ++v) {
        const Vec3& wanted = mesh.positions[coarse->base_vertex[v]];
        const float beside = std::abs(std::hypot(smooth[v].y, smooth[v].z) - std::hypot(wanted.y, wanted.z));
        EXPECT_LT(beside, 0.001f);
        EXPECT_EQ(at[v], coarse->surface.positions_rest[v]) << "at rest it is the rest shape, to the bit";
        sum += beside;
        cage = std::max(cage, glm::distance(at[v], wanted));
    }
    EXPECT_LT(sum, 0.0002f * float(at.size()));
    EXPECT_GT(cage, 0.002f) << "without the correction it would run inside";
}

TEST(Coarse, RigidMotionCarriesItRigidly) {
    const MeshData mesh = dense_tube(60);
    const Surface dense = build(mesh);
    const auto coarse = build_coarse(dense, kSpacing);
    const auto turned = [](const Vec3& p) { return Vec3(-p.y, p.x, p.z) + Vec3(0.3f, -0.2f, 0.1f); };
    std::vector<Vec3> moved;
    for (const Vec3& p : mesh.positions) moved.push_back(turned(p));
    const std::vector<Vec3> at = coarse_positions(*coarse, dense, moved);
    for (size_t v = 0; v < at.size(); ++v)
        EXPECT_LT(glm::distance(at[v], turned(coarse->surface.positions_rest[v])), 2e-6f);
}

TEST(Coarse, WhereTheSidesOfASeamPartItIsInTheMiddle) {
    MeshData mesh = split_at_seams(grid(20, 20, 0.01f));
    const Surface dense = build(mesh);
    const auto coarse = build_coarse(dense, kSpacing);
    std::vector<Vec3> parted = mesh.positions;
    for (size_t v = 0; v < parted.size(); ++v)
        parted[v].z = v % 2 ? 0.004f : 0.0f;  // of every face two corners
    std::vector<Vec3> welded(dense.welded.vertex_count);
    weld_positions(dense, parted, welded);
    std::vector<Vec3> mean;
    for (const Index v : dense.welded_of) mean.push_back(welded[v]);
    EXPECT_NE(mean, parted);
    EXPECT_EQ(coarse_positions(*coarse, dense, parted), coarse_positions(*coarse, dense, mean));
}

// A sleeve of polygons of 8 by 50 mm, as sleeves are modelled, and one with edges as long as the spacing.
TEST(Coarse, AMeshThatIsNotSoDenseGivesEdgesOfTheSpacingToo) {
    for (const auto& [around, along] : {std::pair(60, 10), std::pair(17, 17)}) {
        const MeshData mesh = tube(around, along, 0.08f, 0.5f);
        const Surface dense = build(mesh);
        const auto coarse = build_coarse(dense, kSpacing);
        EXPECT_NEAR(mean_edge(coarse->surface), kSpacing, 0.2 * kSpacing) << around;
        EXPECT_EQ(euler(coarse->surface), 0);
        EXPECT_EQ(borders(coarse->surface), 2);
        EXPECT_TRUE(coarse->surface.warnings.empty());
        for (const Edge& e : coarse->surface.edges) {
            const auto& rest = coarse->surface.positions_rest;
            EXPECT_LT(glm::distance(rest[e.a], rest[e.b]), 2.5f * kSpacing) << around;
        }
    }
}

// There the vertices are chosen on the smooth surface, which is what is shown. The surface of a tube with 17
// vertices around runs 1.9 mm inside of them.
TEST(Coarse, ItsSmoothSurfaceIsThatOfAMeshThatIsNotSoDense) {
    const MeshData mesh = tube(17, 17, 0.08f, 0.5f);
    const Surface dense = build(mesh);
    const auto coarse = build_coarse(dense, kSpacing);
    const SparseRows limit = subdivision_stencils(dense.welded, 0, true);
    std::vector<Vec3> smooth(dense.positions_rest.size());
    apply<Vec3>(limit, dense.positions_rest, smooth);
    const float radius = std::hypot(smooth[17 * 8].y, smooth[17 * 8].z);
    EXPECT_LT(radius, 0.079f);
    const std::vector<Vec3> at = coarse_positions(*coarse, dense, mesh.positions);
    std::vector<Vec3> shown(at.size());
    apply<Vec3>(vertex_limit_stencils(coarse->surface), at, shown);
    for (const Vec3& p : shown) EXPECT_NEAR(std::hypot(p.y, p.z), radius, 0.001f);
}

// A torn piece of 5 by 5 cm would hang beside the garment, or fall. One of 8 by 8 cm is a part of its own.
TEST(Coarse, PartsStayApartAndASmallOneIsLeftOut) {
    for (const Index pieces : {5, 8}) {
        MeshData mesh = grid(40, 40, 0.006f);
        const Index first = Index(mesh.positions.size());
        add_part(mesh, grid(pieces, pieces, 0.01f), {0.05f, 0.05f, 0.002f});
        const auto coarse = build_coarse(build(mesh), kSpacing);
        EXPECT_EQ(euler(coarse->surface), pieces == 8 ? 2 : 1);
        EXPECT_EQ(borders(coarse->surface), pieces == 8 ? 2 : 1);
        const auto& corners = coarse->surface.welded.corner_vertex;
        const auto of_piece = [&](Index v) { return coarse->base_vertex[v] >= first; };
        EXPECT_EQ(std::ranges::any_of(corners, of_piece), pieces == 8);
    }
}

TEST(Coarse, RefusesWhatCannotBe) {
    const MeshData mesh = grid(8, 8, 0.01f);
    const Surface dense = build(mesh);
    for (const float spacing : {0.0f, -1.0f, kNan})
        expect_refused([&] { build_coarse(dense, spacing); }, {"spacing", "above 0"});
    expect_refused([&] { build_coarse(dense, 5.0f); }, {"too small", "5.0"});
    const auto coarse = build_coarse(dense, kSpacing);
    const std::vector<Vec3> fewer(mesh.positions.begin(), mesh.positions.end() - 1);
    expect_refused([&] { coarse_positions(*coarse, dense, fewer); }, {"positions", "81", "80"});
    for (const Index v : {0, 40, 80}) {
        std::vector<Vec3> lost = mesh.positions;
        lost[v].y = kNan;
        expect_refused([&] { coarse_positions(*coarse, dense, lost); },
                       {"vertex " + std::to_string(v), "finite"});
    }
}

}  // namespace
}  // namespace rumple::tests
