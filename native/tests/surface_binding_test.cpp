// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <map>

#include "surface/refine/triangle_tree.h"
#include "tests/surface_laws.h"

namespace rumple::tests {
namespace {

Vec3 position_of(const Surface& surface, const SurfacePoint& place) {
    const std::array<Index, 3> corners = welded_vertices(surface, place.triangle);
    return place.interpolate([&](int k) { return surface.positions_rest[corners[k]]; });
}

void expect_inside(const SurfacePoint& place) {
    EXPECT_GE(place.b0, 0.0f);
    EXPECT_GE(place.b1, 0.0f);
    EXPECT_LE(place.b0 + place.b1, 1.0f + 1e-6f);
}

std::vector<Vec3> random_points(int count, float extent, unsigned seed) {
    std::mt19937 random(seed);
    const auto next = [&] { return extent * (static_cast<float>(random() % 20001) / 10000.0f - 1.0f); };
    std::vector<Vec3> points;
    for (int i = 0; i < count; ++i) {
        const float x = next(), y = next(), z = next();
        points.push_back({x, y, z});
    }
    return points;
}

// --- Closest points ---

TEST(ClosestPoints, AreThoseOfBruteForce) {
    MeshData soup = shaken(triangulated(tube(12, 9, 0.8f, 2.0f)), 0.15f, 11);
    soup.positions[20] = soup.positions[21];  // a zero-length edge and its flat triangles
    for (const Surface& surface : {build(soup), build(cube()), build(mixed())}) {
        const auto queries = random_points(400, 2.5f, 4);
        std::vector<float> distance(queries.size());
        const auto places = closest_points(surface, queries, distance);
        for (std::size_t i = 0; i < queries.size(); ++i) {
            TrianglePoint best = closest_point(surface, 0, queries[i]);
            for (Index t = 1; t < static_cast<Index>(surface.triangles.size()); ++t) {
                const TrianglePoint point = closest_point(surface, t, queries[i]);
                if (point.squared_distance < best.squared_distance) best = point;
            }
            EXPECT_EQ(places[i].triangle, best.place.triangle) << i;
            EXPECT_FLOAT_EQ(distance[i], static_cast<float>(std::sqrt(best.squared_distance)));
            expect_inside(places[i]);
            EXPECT_NEAR(glm::length(position_of(surface, places[i]) - queries[i]), distance[i], 1e-5f);
        }
    }
}

TEST(ClosestPoints, OfOneTriangleBeatEverySample) {
    // Independent of the formula: no sampled point of the triangle is closer.
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 0.2f, 0.1f}, {0.1f, 0.8f, -0.3f}};
    mesh.add_polygon({0, 1, 2});
    const Surface surface = build(mesh);
    for (const Vec3& query : random_points(200, 1.5f, 8)) {
        const double found = std::sqrt(closest_point(surface, 0, query).squared_distance);
        double sampled = 10.0;
        for (int i = 0; i <= 60; ++i) {
            for (int j = 0; i + j <= 60; ++j) {
                const Vec3 p = position_of(surface, {0, i / 60.0f, j / 60.0f});
                sampled = std::min(sampled, static_cast<double>(glm::length(p - query)));
            }
        }
        EXPECT_LE(found, sampled + 1e-6);
        EXPECT_GE(found, sampled - 0.03);  // the samples lie that close together
    }
}

TEST(ClosestPoints, TiesGoToTheLowestTriangle) {
    const Surface surface = build(grid(6, 6, 1.0f));
    std::vector<Vec3> queries;
    for (const Vec3& p : surface.positions_rest) queries.push_back(p + Vec3(0, 0, 0.5f));
    std::vector<float> distance(queries.size());
    const auto places = closest_points(surface, queries, distance);
    std::vector<Index> lowest(queries.size(), kNone);  // triangle around each vertex
    for (Index t = static_cast<Index>(surface.triangles.size()); t-- > 0;) {
        for (Index c : surface.triangles[t].corner) lowest[surface.welded.corner_vertex[c]] = t;
    }
    for (std::size_t v = 0; v < queries.size(); ++v) {
        EXPECT_EQ(places[v].triangle, lowest[v]) << v;
        EXPECT_EQ(distance[v], 0.5f);
    }
}

// --- Places of refined vertices ---

TEST(Locate, LinearPositionsOfFlatPolygonsAreFoundAgain) {
    for (const MeshData& mesh : {cube(), triangulated(mixed()), tube(6, 3, 0.4f, 1.0f), seam_split_cube()}) {
        const Surface surface = build(mesh);
        for (const FineMesh& fine : {refine_subdivision(surface.welded, 2), refine_regular(surface, 3),
                                     refine_longest_edge(surface, 0.3f, 100000)}) {
            const auto linear = apply_rows(fine.vertex_from_parent, surface.positions_rest);
            const auto places = locate_on_parents(surface, fine);
            ASSERT_EQ(places.size(), linear.size());
            for (std::size_t v = 0; v < places.size(); ++v) {
                ASSERT_NE(places[v].triangle, kNone);
                expect_inside(places[v]);
                EXPECT_LT(glm::length(position_of(surface, places[v]) - linear[v]), 2e-6f);
            }
        }
    }
}

TEST(Locate, StaysOnAParentWhereAnotherSheetIsCloser) {
    // A bent quad whose bilinear middle lies nearer to a second sheet than to its own triangles.
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 1}, {1, 1, 0}, {0, 1, 1}};
    mesh.add_polygon({0, 1, 2, 3});
    for (const Vec3& p : grid(1, 1, 1.0f).positions) mesh.positions.push_back(p + Vec3(0, 0, 0.5f));
    mesh.add_polygon({4, 5, 7, 6});
    const Surface surface = build(mesh);
    const FineMesh fine = refine_subdivision(surface.welded, 1);
    std::map<Index, std::set<Index>> parents;  // fine vertex -> parent polygons
    for (Index p = 0; p < fine.mesh.polygons(); ++p) {
        for (Index c = fine.mesh.polygon_start[p]; c < fine.mesh.polygon_start[p + 1]; ++c) {
            parents[fine.mesh.corner_vertex[c]].insert(fine.polygon_parent[p]);
        }
    }
    const auto places = locate_on_parents(surface, fine);
    for (const auto& [v, polygons] : parents) {
        EXPECT_TRUE(polygons.count(surface.triangles[places[v].triangle].polygon)) << v;
    }
}

// --- Seams ---

TEST(Unweld, SplitsWhatWasSplit) {
    const MeshData mesh = seam_split_cube();
    const Surface surface = build(mesh);
    const Unwelded open = unweld(surface, refine_subdivision(surface.welded, 0));
    EXPECT_EQ(open.mesh.vertex_count, 24);
    expect_same_partition(open.mesh.corner_vertex, mesh.corner_vertex);
}

TEST(Unweld, IsWhatRefiningTheOpenMeshWouldGive) {
    // Topology: welding, refining and unwelding is refining the mesh with its seams open.
    MeshData half_open = tube(6, 4, 0.4f, 1.0f);  // a cut along the tube, open from one end to the middle
    for (Index j = 0; j <= 1; ++j) {
        half_open.positions.push_back(half_open.positions[6 * j]);
        half_open.corner_vertex[4 * (6 * j + 5) + 1] = 30 + j;  // face (5, j), its low end
        if (j > 0)
            half_open.corner_vertex[4 * (6 * (j - 1) + 5) + 2] = 30 + j;  // face (5, j - 1), its high end
    }
    for (const MeshData& mesh : {seam_split_cube(), half_open, split_at_seams(mixed())}) {
        const Surface welded = build(mesh), open = build(mesh, false);
        ASSERT_LT(welded.welded.vertex_count, open.welded.vertex_count);
        const auto check = [&](const FineMesh& fine, const FineMesh& expected) {
            const Unwelded result = unweld(welded, fine);
            expect_same_partition(result.mesh.corner_vertex, expected.mesh.corner_vertex);
            EXPECT_EQ(result.mesh.vertex_count, expected.mesh.vertex_count);
            EXPECT_EQ(result.mesh.polygon_start, fine.mesh.polygon_start);
            expect_rows_sum_to_one(result.vertex_from_display, welded.display.vertex_count);
            for (Index c = 0; c < fine.mesh.corners(); ++c) {
                ASSERT_EQ(result.fine_vertex[result.mesh.corner_vertex[c]], fine.mesh.corner_vertex[c]);
            }
            const auto linear = apply_rows(fine.vertex_from_parent, welded.positions_rest);
            const auto shown = apply_rows(result.vertex_from_display, mesh.positions);
            for (std::size_t v = 0; v < shown.size(); ++v) {
                EXPECT_LT(glm::length(shown[v] - linear[result.fine_vertex[v]]), 2e-6f);
            }
        };
        check(refine_subdivision(welded.welded, 2), refine_subdivision(open.welded, 2));
        check(refine_regular(welded, 3), refine_regular(open, 3));
        const FineMesh inner = refine_subdivision(welded.welded, 1),
                       open_inner = refine_subdivision(open.welded, 1);
        check(compose(refine_subdivision(inner.mesh, 1), inner),
              compose(refine_subdivision(open_inner.mesh, 1), open_inner));
    }
}

TEST(Unweld, WithoutSeamsChangesNothing) {
    const Surface surface = build(mixed());
    const FineMesh fine = refine_subdivision(surface.welded, 2);
    const Unwelded same = unweld(surface, fine);
    EXPECT_EQ(same.mesh.corner_vertex, fine.mesh.corner_vertex);
    EXPECT_EQ(same.mesh.vertex_count, fine.mesh.vertex_count);
}

}  // namespace
}  // namespace rumple::tests
