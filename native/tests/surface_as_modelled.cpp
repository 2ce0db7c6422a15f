// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of finding a mesh as it was modelled.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "surface/output/as_modelled.h"
#include "surface/output/coarse.h"
#include "surface/refine/refinement.h"
#include "tests/meshes.h"
#include "tests/refusals.h"

namespace rumple::tests {
namespace {

// One subdivision without smoothing, its vertices in Blender's order: those of the mesh, of the edges, of the
// faces.
MeshData subdivided(const MeshData& mesh) {
    MeshData out;
    out.positions = mesh.positions;
    std::map<std::pair<Index, Index>, Index> middle;
    const auto edge = [&](Index a, Index b) {
        const auto [found, made] =
            middle.try_emplace(std::minmax(a, b), static_cast<Index>(out.positions.size()));
        if (made) out.positions.push_back(0.5f * (mesh.positions[a] + mesh.positions[b]));
        return found->second;
    };
    const Index faces = static_cast<Index>(mesh.polygon_start.size()) - 1;
    const auto corner = [&](Index face, Index k) {
        const Index begin = mesh.polygon_start[face], size = mesh.polygon_start[face + 1] - begin;
        return mesh.corner_vertex[begin + (k + size) % size];
    };
    const auto corners = [&](Index face) { return mesh.polygon_start[face + 1] - mesh.polygon_start[face]; };
    for (Index face = 0; face < faces; ++face)
        for (Index k = 0; k < corners(face); ++k) edge(corner(face, k), corner(face, k + 1));
    for (Index face = 0; face < faces; ++face) {
        Vec3 sum(0.0f);
        for (Index k = 0; k < corners(face); ++k) sum += mesh.positions[corner(face, k)];
        const Index centre = static_cast<Index>(out.positions.size());
        out.positions.push_back(sum / float(corners(face)));
        for (Index k = 0; k < corners(face); ++k) {
            const Index v = corner(face, k);
            out.add_polygon({v, edge(v, corner(face, k + 1)), centre, edge(corner(face, k - 1), v)});
        }
    }
    return out;
}

// The polygons, each from its lowest vertex on.
std::vector<std::vector<Index>> polygons_of(const std::vector<Index>& start,
                                            const std::vector<Index>& vertex) {
    std::vector<std::vector<Index>> out;
    for (size_t p = 0; p + 1 < start.size(); ++p) {
        std::vector<Index> one(vertex.begin() + start[p], vertex.begin() + start[p + 1]);
        std::ranges::rotate(one, std::ranges::min_element(one));
        out.push_back(std::move(one));
    }
    std::ranges::sort(out);
    return out;
}

std::optional<MeshBefore> undivided_of(const MeshData& mesh) {
    return undivided(build(mesh, false).welded);
}

// Its vertices in another order.
MeshData renumbered(const MeshData& mesh, unsigned seed) {
    std::vector<Index> place(mesh.positions.size());
    std::iota(place.begin(), place.end(), 0);
    std::mt19937 random(seed);
    for (size_t k = place.size() - 1; k > 0; --k) std::swap(place[k], place[random() % (k + 1)]);
    MeshData out = mesh;
    for (size_t v = 0; v < place.size(); ++v) out.positions[place[v]] = mesh.positions[v];
    for (Index& v : out.corner_vertex) v = place[v];
    return out;
}

// A pyramid over a pentagon, without a bottom: triangles and a vertex of five.
MeshData pyramid() {
    MeshData mesh;
    for (Index k = 0; k < 5; ++k) {
        const float angle = 2.0f * std::numbers::pi_v<float> * float(k) / 5.0f;
        mesh.positions.push_back({std::cos(angle), std::sin(angle), 0.0f});
    }
    mesh.positions.push_back({0.0f, 0.0f, 1.0f});
    for (Index k = 0; k < 5; ++k) mesh.add_polygon({k, (k + 1) % 5, 5});
    return mesh;
}

// With one face more, a pentagon.
MeshData closed_pyramid() {
    MeshData mesh = pyramid();
    mesh.add_polygon({4, 3, 2, 1, 0});
    return mesh;
}

std::vector<MeshData> samples() {
    return {grid(1, 1, 1.0f),
            grid(3, 2, 0.1f),
            grid(4, 4, 0.1f),
            tube(8, 6, 1.0f, 2.0f),
            tube(5, 3, 1.0f, 2.0f),
            cube(),
            pyramid(),
            closed_pyramid(),
            with_part(tube(6, 4, 1.0f, 2.0f), grid(2, 2, 0.1f), Vec3(5.0f))};
}

TEST(Undivided, ASubdivisionIsTakenBackExactly) {
    for (const MeshData& mesh : samples()) {
        const auto found = undivided_of(subdivided(mesh));
        ASSERT_TRUE(found);
        EXPECT_EQ(polygons_of(found->mesh.polygon_start, found->mesh.corner_vertex),
                  polygons_of(mesh.polygon_start, mesh.corner_vertex));
        std::vector<Index> same(mesh.positions.size());
        std::iota(same.begin(), same.end(), 0);
        EXPECT_EQ(found->vertex, same);
    }
}

TEST(Undivided, TwoSubdivisionsAreTakenBackOneAfterTheOther) {
    for (const MeshData& mesh : samples()) {
        const auto once = undivided_of(subdivided(subdivided(mesh)));
        ASSERT_TRUE(once);
        const auto twice = undivided(once->mesh);
        ASSERT_TRUE(twice);
        EXPECT_EQ(polygons_of(twice->mesh.polygon_start, twice->mesh.corner_vertex),
                  polygons_of(mesh.polygon_start, mesh.corner_vertex));
    }
}

// Where only one answer exists, the order of the vertices does not matter. (A cube has two: itself and its
// dual.)
TEST(Undivided, AnotherOrderOfTheVerticesGivesTheSameMesh) {
    for (const MeshData& mesh : {pyramid(), grid(3, 2, 0.1f)}) {
        for (const unsigned seed : {1u, 2u, 3u}) {
            const MeshData dense = renumbered(subdivided(mesh), seed);
            const auto found = undivided_of(dense);
            ASSERT_TRUE(found);
            ASSERT_EQ(found->vertex.size(), mesh.positions.size());
            for (const Index v : found->vertex)
                EXPECT_EQ(std::ranges::count(mesh.positions, dense.positions[v]), 1);
        }
    }
}

TEST(Undivided, WhatWasNotSubdividedIsNot) {
    MeshData hole = subdivided(grid(3, 3, 0.1f)), split = hole;
    hole.corner_vertex.resize(hole.corner_vertex.size() - 4);
    hole.polygon_start.pop_back();
    hole.triangle_corner.resize(hole.triangle_corner.size() - 6);
    for (const MeshData& mesh :
         {grid(3, 4, 0.1f), tube(8, 5, 1.0f, 2.0f), tube(7, 6, 1.0f, 2.0f), cube(),
          triangulated(subdivided(cube())), pyramid(), hole, with_part(split, grid(3, 1, 0.1f), Vec3(5.0f))})
        EXPECT_FALSE(undivided_of(mesh));
}

// Three quads around a triangular hole. Subdivided, the three middles of its edges become one vertex, which
// closes it. Six quads meet there, and each of them looks like one of a subdivision.
TEST(Undivided, AnEdgeHasNoMoreThanTwoPolygons) {
    MeshData mesh;
    for (const float radius : {1.0f, 2.0f}) {
        for (Index k = 0; k < 3; ++k) {
            const float angle = 2.0f * std::numbers::pi_v<float> * float(k) / 3.0f;
            mesh.positions.push_back({radius * std::cos(angle), radius * std::sin(angle), 0.0f});
        }
    }
    for (Index k = 0; k < 3; ++k) mesh.add_polygon({k, k + 3, (k + 1) % 3 + 3, (k + 1) % 3});
    const MeshData dense = subdivided(mesh);
    PolygonMesh closed{Index(dense.positions.size()), dense.polygon_start, dense.corner_vertex};
    ASSERT_TRUE(undivided(closed));
    std::vector<Index> inner;
    for (size_t v = 6; v < dense.positions.size(); ++v)
        if (glm::length(dense.positions[v]) < 0.6f) inner.push_back(Index(v));
    ASSERT_EQ(inner.size(), 3u);
    for (Index& v : closed.corner_vertex)
        if (std::ranges::count(inner, v)) v = inner[0];
    EXPECT_FALSE(undivided(closed));
}

TEST(Undivided, PartsThatMeetAtAVertexAgreeAboutIt) {
    const MeshData one =
        subdivided(grid(1, 1, 1.0f));  // 4 corners, 4 middles of edges, the middle of the face
    PolygonMesh both{18, one.polygon_start, one.corner_vertex};
    for (size_t c = 0; c < one.corner_vertex.size(); ++c)
        both.corner_vertex.push_back(9 + one.corner_vertex[c]);
    for (Index p = 1; p <= 4; ++p) both.polygon_start.push_back(16 + 4 * p);
    for (const auto& [shared, agree] : {std::pair(0, true), {4, false}}) {  // a corner, a middle of the first
        PolygonMesh joined = both;
        for (Index& v : joined.corner_vertex)
            if (v == 9) v = shared;
        EXPECT_EQ(undivided(joined).has_value(), agree);
    }
}

// Every quad is cut, along a diagonal that is chosen by chance, and the triangles are in an order by chance.
MeshData cut_by_chance(const MeshData& mesh, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<std::array<Index, 3>> triangles;
    for (size_t c = 0; c < mesh.corner_vertex.size(); c += 4) {
        const Index* v = &mesh.corner_vertex[c];
        const size_t k = random() % 2;
        triangles.push_back({v[k], v[k + 1], v[k + 2]});
        triangles.push_back({v[k], v[k + 2], v[(k + 3) % 4]});
    }
    for (size_t t = triangles.size() - 1; t > 0; --t) std::swap(triangles[t], triangles[random() % (t + 1)]);
    MeshData out;
    out.positions = mesh.positions;
    for (const auto& [a, b, c] : triangles) out.add_polygon({a, b, c});
    return out;
}

// Of equilateral triangles.
MeshData triangle_sheet(Index count) {
    MeshData sheet = triangulated(grid(count, count, 0.1f));
    for (Vec3& p : sheet.positions) p = Vec3(p.x - 0.5f * p.y, std::sqrt(0.75f) * p.y, 0.0f);
    return sheet;
}

TEST(JoinedTriangles, QuadsThatWereCutAreFoundAgain) {
    for (const MeshData& mesh :
         {grid(5, 4, 0.1f), tube(16, 10, 0.1f, 0.4f), cube(), shaken(grid(9, 7, 0.1f), 0.012f, 5)}) {
        for (const unsigned seed : {1u, 2u, 3u}) {
            const auto found = joined_triangles(build(cut_by_chance(mesh, seed)));
            ASSERT_TRUE(found);
            EXPECT_EQ(polygons_of(found->mesh.polygon_start, found->mesh.corner_vertex),
                      polygons_of(mesh.polygon_start, mesh.corner_vertex));
        }
    }
}

TEST(JoinedTriangles, ATriangleWithoutAPartnerStaysAndALooseVertexHasNoPart) {
    MeshData mesh = triangulated(grid(5, 4, 0.1f));
    mesh.corner_vertex.resize(mesh.corner_vertex.size() - 3);
    mesh.triangle_corner.resize(mesh.triangle_corner.size() - 3);
    mesh.polygon_start.pop_back();
    mesh.positions.insert(mesh.positions.begin(), Vec3(0.0f));  // loose
    for (Index& v : mesh.corner_vertex) ++v;
    const auto found = joined_triangles(build(mesh));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->mesh.polygons(), 20);
    EXPECT_EQ(found->mesh.corners(), 19 * 4 + 3);
    EXPECT_EQ(found->mesh.vertex_count, 30);
    EXPECT_EQ(found->vertex.front(), 1);
}

TEST(JoinedTriangles, WhatWasModelledOfTrianglesOrQuadsIsLeftAlone) {
    for (const MeshData& mesh : {triangle_sheet(8), pyramid(), grid(5, 4, 0.1f), closed_pyramid()})
        EXPECT_FALSE(joined_triangles(build(mesh)));
}

TEST(AsModelled, ASubdividedMeshThatWasCutIsJoinedAndThenUndivided) {
    const MeshData mesh = tube(12, 9, 0.08f, 0.4f);
    const auto coarse = build_as_modelled(build(cut_by_chance(subdivided(mesh), 4)), 0.03f, 1.0f);
    const PolygonMesh& found = coarse->surface.welded;
    EXPECT_EQ(polygons_of(found.polygon_start, found.corner_vertex),
              polygons_of(mesh.polygon_start, mesh.corner_vertex));
}

TEST(AsModelled, NarrowFacesAreRefused) {
    const auto narrow = [](float width) {  // a sheet, subdivided, with a strip of this width
        MeshData mesh = grid(3, 9, 0.1f);
        for (Vec3& p : mesh.positions) p.x = std::min(p.x, 0.2f + width);
        return build(subdivided(mesh));
    };
    EXPECT_EQ(build_as_modelled(narrow(0.07f), 0.06f, 1.0f)->base_vertex.size(), 40u);
    EXPECT_EQ(build_as_modelled(narrow(0.01f), 0.06f, 1.0f)->base_vertex.size(), 40u) << "they are a few";
    expect_refused([&] { build_as_modelled(narrow(0.05f), 0.06f, 1.0f); }, {"even faces"});
}

TEST(AsModelled, ASubdivisionIsTakenBackToWidenNarrowFacesToo) {
    MeshData mesh = grid(4, 4, 0.1f);
    for (Vec3& p : mesh.positions) p.y *= 0.4f;  // edges of 100 and 40, subdivided 50 and 20 mm
    EXPECT_EQ(build_as_modelled(build(subdivided(mesh)), 0.03f, 1.0f)->base_vertex.size(), 25u);
}

TEST(AsModelled, SubdivisionsAreTakenBackUntilTheEdgesAreLongEnough) {
    const MeshData mesh = tube(12, 9, 0.08f, 0.4f), dense = subdivided(subdivided(mesh));
    const Surface surface = build(dense);
    for (const auto& [least, vertices] : {std::pair(0.015f, 24u * 19u), {0.03f, 12u * 10u}}) {
        const auto coarse = build_as_modelled(surface, least, 1.0f);
        EXPECT_EQ(coarse->base_vertex.size(), vertices);
        EXPECT_GE(coarse->mean_edge, least);
    }
    expect_refused([&] { build_as_modelled(surface, 0.05f, 1.0f); }, {"modelled"});
    expect_refused([&] { build_as_modelled(surface, 0.001f, 1.0f); }, {"needs no other"});
    expect_refused([&] { build_as_modelled(surface, 0.0f, 1.0f); }, {"least_edge"});
    expect_refused([&] { build_as_modelled(surface, 0.02f, 0.039f); }, {"most_edge"});
}

TEST(AsModelled, TheSmoothSurfaceOfTheCoarseMeshRunsThroughTheDenseOne) {
    const MeshData dense = subdivided(tube(12, 9, 0.08f, 0.4f));
    const Surface surface = build(dense);
    const auto coarse = build_as_modelled(surface, 0.03f, 1.0f);
    const std::vector<Vec3> at = coarse_positions(*coarse, surface, dense.positions);
    EXPECT_EQ(at, coarse->surface.positions_rest) << "at rest it is the rest shape, to the bit";
    std::vector<Vec3> smooth(at.size());
    apply<Vec3>(coarse->limit, at, smooth);
    for (size_t v = 0; v < at.size(); ++v) {
        const Vec3& wanted = dense.positions[coarse->base_vertex[v]];
        EXPECT_NEAR(std::hypot(smooth[v].y, smooth[v].z), std::hypot(wanted.y, wanted.z), 3e-4f);
    }
}

// ---- edges that are too long

TEST(AsModelled, AMeshWithLongEdgesIsSubdividedUntilTheyAreShortEnough) {
    const MeshData mesh = tube(12, 9, 0.08f, 0.4f);  // mean edge 0.043
    const Surface surface = build(mesh);
    for (const auto& [most, vertices] : {std::pair(0.04f, 24u * 19u), {0.02f, 48u * 37u}}) {
        const auto coarse = build_as_modelled(surface, most / 2.0f, most);
        EXPECT_EQ(coarse->base_vertex.size(), vertices);
        EXPECT_LE(coarse->mean_edge, most);
    }
    expect_refused([&] { build_as_modelled(surface, 0.02f, 0.05f); }, {"needs no other"});
}

TEST(AsModelled, APartOfAMeshMayBeSolvedAsItIs) {
    const Surface surface = build(tube(12, 9, 0.08f, 0.4f));
    const auto coarse = build_as_modelled(surface, 0.02f, 1.0f, true);
    EXPECT_EQ(coarse->surface.welded.corner_vertex, surface.welded.corner_vertex);
}

// A part may join vertices that the whole mesh does not: there faces overlap at the seam. Its rows were read
// as of the whole mesh's vertices, and cloth was metres away.
TEST(AsModelled, APartThatIsJoinedOtherwiseThanTheWholeMeshStaysWhereItIs) {
    MeshData mesh;  // two squares, the vertices between them twice
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}, {2, 1, 0}};
    mesh.add_polygon({0, 1, 3, 5});
    mesh.add_polygon({2, 6, 7, 4});
    const Surface part = build(mesh, true), base = build(mesh, false);
    ASSERT_NE(part.welded.vertex_count, base.welded.vertex_count);
    const auto of_part = build_as_modelled(part, 0.25f, 0.6f);
    const auto whole = of_whole_base(*of_part, part, base);
    EXPECT_EQ(coarse_positions(*whole, base, mesh.positions),
              coarse_positions(*of_part, part, mesh.positions));
}

TEST(AsModelled, ASubdividedMeshHasTheSmoothSurfaceOfTheBase) {
    const MeshData mesh = tube(12, 9, 0.08f, 0.4f);
    const Surface surface = build(mesh);
    const auto coarse = build_as_modelled(surface, 0.01f, 0.03f);
    const std::vector<Vec3> at = coarse_positions(*coarse, surface, mesh.positions);
    EXPECT_EQ(at, coarse->surface.positions_rest) << "at rest it is the rest shape, to the bit";
    const SparseRows of_base = subdivision_stencils(surface.welded, 1, true);
    std::vector<Vec3> smooth(at.size()), wanted(at.size());
    apply<Vec3>(coarse->limit, at, smooth);
    apply<Vec3>(of_base, mesh.positions, wanted);
    for (size_t v = 0; v < at.size(); ++v) EXPECT_LT(glm::distance(smooth[v], wanted[v]), 1e-3f);
}

TEST(AsModelled, QuadsWithLongEdgesThatWereCutAreJoinedAndThenSubdivided) {
    const auto coarse = build_as_modelled(build(cut_by_chance(tube(12, 9, 0.08f, 0.4f), 4)), 0.01f, 0.03f);
    EXPECT_EQ(coarse->base_vertex.size(), 24u * 19u);
    EXPECT_EQ(coarse->surface.welded.corners(), 4 * coarse->surface.welded.polygons());
}

TEST(AsModelled, PaintIsInterpolatedLinearlyOnASubdivisionAndTakenOverElsewhere) {
    const MeshData mesh = grid(2, 1, 0.1f);
    std::vector<float> paint;
    for (const Vec3& p : mesh.positions) paint.push_back(p.x < 0.05f ? 1.0f : 0.0f);
    const auto finer = build_as_modelled(build(mesh), 0.03f, 0.06f);
    std::vector<float> carried(finer->base_vertex.size());
    apply<float>(finer->paint_from_base, paint, carried);
    for (size_t v = 0; v < carried.size(); ++v) {
        const float x = finer->surface.positions_rest[v].x;
        EXPECT_EQ(carried[v], x < 0.025f ? 1.0f : x < 0.075f ? 0.5f : 0.0f) << "at " << x;
    }
    const MeshData dense = subdivided(mesh);
    const auto coarse = build_as_modelled(build(dense), 0.06f, 1.0f);
    std::vector<float> number(dense.positions.size()), taken(coarse->base_vertex.size());
    std::iota(number.begin(), number.end(), 0.0f);
    apply<float>(coarse->paint_from_base, number, taken);
    for (size_t v = 0; v < taken.size(); ++v) EXPECT_EQ(taken[v], float(coarse->base_vertex[v]));
}

TEST(AsModelled, ALooseVertexHasNoPartInASubdivisionAndACreaseStaysSharp) {
    MeshData mesh = grid(2, 2, 0.1f);
    for (Vec3& p : mesh.positions) p.z = p.x > 0.05f && p.x < 0.15f ? 0.1f : 0.0f;  // a roof
    mesh.positions.insert(mesh.positions.begin(), Vec3(5.0f));                      // loose
    for (Index& v : mesh.corner_vertex) ++v;
    const std::vector<Crease> ridge{{2, 5, kSharp}, {5, 8, kSharp}};
    SurfaceInput input = mesh.input();
    input.creases = ridge;
    const auto coarse = build_as_modelled(build_surface(input), 0.04f, 0.08f);
    EXPECT_EQ(coarse->base_vertex.size(), 25u);
    std::vector<Vec3> smooth(25);
    apply<Vec3>(coarse->limit, coarse->surface.positions_rest, smooth);
    float highest = 0.0f;
    for (const Vec3& p : smooth) highest = std::max(highest, p.z);
    EXPECT_NEAR(highest, 0.1f, 0.002f) << "rounded, the ridge would be at two thirds of it";
    for (const Index v : coarse->base_vertex) EXPECT_GT(v, 0);
}

}  // namespace
}  // namespace rumple::tests
