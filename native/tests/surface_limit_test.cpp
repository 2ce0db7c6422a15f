// SPDX-License-Identifier: GPL-3.0-or-later
// limit_stencils() against subdivision_stencils(limit), which comes from other
// code of OpenSubdiv (vertex masks instead of patches).
#include <gtest/gtest.h>

#include "tests/surface_laws.h"

namespace rumple::tests {
namespace {

// The largest distance between the two over all vertices of a subdivision level.
float largest_difference(const Surface& surface, Index levels) {
    const FineMesh fine = refine_subdivision(surface.welded, levels);
    const auto places = locate_on_parents(surface, fine);
    const auto patches = apply_rows(limit_stencils(surface, places), surface.positions_rest);
    const auto masks = apply_rows(subdivision_stencils(surface.welded, levels, true), surface.positions_rest);
    EXPECT_EQ(patches.size(), masks.size());
    float largest = 0.0f;
    for (std::size_t v = 0; v < masks.size(); ++v) {
        largest = std::max(largest, glm::length(patches[v] - masks[v]));
    }
    return largest;
}

MeshData regular_polygon_fin(Index n) {  // a regular n-gon and a bent triangle at its first edge
    MeshData mesh;
    std::vector<Index> ring;
    for (Index i = 0; i < n; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / n;
        mesh.positions.push_back(Vec3(std::cos(angle), std::sin(angle), 0.0));
    }
    const Index begin = mesh.polygon_start.back();
    for (Index i = 0; i < n; ++i) mesh.corner_vertex.push_back(i);
    mesh.polygon_start.push_back(n);
    for (Index k = 1; k + 1 < n; ++k)
        mesh.triangle_corner.insert(mesh.triangle_corner.end(), {begin, k, k + 1});
    mesh.positions.push_back({2, 1.5f, 1});
    mesh.add_polygon({1, 0, n});
    return mesh;
}

// At a parametric place of a refined vertex both are the same point. All quads
// here are parallelograms and all polygons regular, so that the place closest to
// the linear position is the parametric one.
TEST(Limit, AgreesWithRefinedVertices) {
    for (Index levels : {0, 1, 2, 3, kExactLimitLevels}) {
        EXPECT_LT(largest_difference(build(cube()), levels), 1e-6f);
        EXPECT_LT(largest_difference(build(triangulated(cube())), levels), 1e-6f);
        EXPECT_LT(largest_difference(build(seam_split_cube()), levels), 1e-6f);
        EXPECT_LT(largest_difference(build(tube(5, 3, 0.5f, 2.0f)), levels), 1e-6f);
        EXPECT_LT(largest_difference(build(triangulated(mixed())), levels), 2e-6f);
        for (Index n : {3, 5, 6, 7}) {
            EXPECT_LT(largest_difference(build(regular_polygon_fin(n)), levels), 2e-6f) << n;
        }
    }
    EXPECT_LT(largest_difference(build(mixed()), 0),
              2e-6f);  // at its corners, whatever the shape of a polygon
}

// Masks at the vertices, and patches there. Beside a pentagon a mask would take a wrong corner for the
// opposite one; a loose vertex has no mask.
TEST(Limit, MasksOfVerticesAgreeWithPatches) {
    MeshData loose = mixed();
    loose.positions.insert(loose.positions.begin(), Vec3(9.0f));
    for (Index& v : loose.corner_vertex) ++v;
    for (const MeshData& mesh : {cube(), triangulated(cube()), mixed(), triangulated(mixed()), loose,
                                 regular_polygon_fin(5), MeshData(tube(5, 3, 0.5f, 2.0f))}) {
        const Surface surface = build(mesh);
        std::vector<SurfacePoint> places(surface.welded.vertex_count);
        for (Index t = 0; t < Index(surface.triangles.size()); ++t) {
            const auto [a, b, c] = welded_vertices(surface, t);
            places[a] = {t, 0.0f, 0.0f}, places[b] = {t, 1.0f, 0.0f}, places[c] = {t, 0.0f, 1.0f};
        }
        const auto patches = apply_rows(limit_stencils(surface, places), surface.positions_rest);
        const SparseRows rows = vertex_limit_stencils(surface);
        const auto masks = apply_rows(rows, surface.positions_rest);
        ASSERT_EQ(masks.size(), places.size());
        for (std::size_t v = 0; v < masks.size(); ++v) {
            EXPECT_LT(glm::length(patches[v] - masks[v]), 2e-6f) << v;
            EXPECT_EQ(places[v].triangle == kNone, rows.start[v] == rows.start[v + 1]) << v;
        }
    }
}

TEST(Limit, PatchesNearIrregularVerticesAreCloseEnough) {
    // Beyond kExactLimitLevels, Gregory patches: about a thousandth of an edge (2 and 1.2 m).
    EXPECT_LT(largest_difference(build(cube()), kExactLimitLevels + 2), 1e-3f * 2.0f);
    EXPECT_LT(largest_difference(build(regular_polygon_fin(5)), kExactLimitLevels + 2), 2e-3f * 1.2f);
}

// The square of a quad, whatever its shape at rest and whichever diagonal it is cut along.
TEST(Limit, PlacesInAQuadAreParametric) {
    const auto quad = [](bool other_diagonal) {
        MeshData mesh;
        mesh.positions = {{0, 0, 0}, {2, 0.1f, 0}, {1.3f, 1, 0.4f}, {0, 0.7f, 0}};
        mesh.add_polygon({0, 1, 2, 3});
        if (other_diagonal) mesh.triangle_corner = {0, 1, 3, 1, 2, 3};
        return mesh;
    };
    // (u, v) = (0.5, 0.25), in the square's triangle below either diagonal.
    const Surface first = build(quad(false)), second = build(quad(true));
    const SurfacePoint in_first{0, 0.25f, 0.25f};  // corners (0,0) (1,0) (1,1)
    const SurfacePoint in_second{0, 0.5f, 0.25f};  // corners (0,0) (1,0) (0,1)
    const FineMesh fine = refine_subdivision(first.welded, 2);
    const auto masks = apply_rows(subdivision_stencils(first.welded, 2, true), first.positions_rest);
    const Vec3* x = first.positions_rest.data();
    const Vec3 linear = 0.375f * x[0] + 0.375f * x[1] + 0.125f * x[2] + 0.125f * x[3];
    const auto all = apply_rows(fine.vertex_from_parent, first.positions_rest);
    std::size_t v = 0;
    while (v < all.size() && glm::length(all[v] - linear) > 1e-5f) ++v;
    ASSERT_LT(v, all.size());
    const auto one = apply_rows(limit_stencils(first, std::vector{in_first}), first.positions_rest);
    const auto other = apply_rows(limit_stencils(second, std::vector{in_second}), second.positions_rest);
    EXPECT_LT(glm::length(one[0] - masks[v]), 1e-6f);
    EXPECT_LT(glm::length(other[0] - masks[v]), 1e-6f);
}

TEST(Limit, RowsSumToOneAtRandomPlaces) {
    std::mt19937 random(5);
    const auto unit = [&] { return static_cast<float>(random() % 1001) / 1000.0f; };
    for (const MeshData& mesh : {mixed(), cube(), triangulated(mixed())}) {
        const Surface surface = build(mesh);
        std::vector<SurfacePoint> places;
        for (int i = 0; i < 500; ++i) {
            const float a = unit(), b = unit() * (1.0f - a);
            places.push_back({static_cast<Index>(random() % surface.triangles.size()), a, b});
        }
        const SparseRows rows = limit_stencils(surface, places);
        ASSERT_EQ(rows.rows(), 500);
        expect_rows_sum_to_one(rows, surface.welded.vertex_count);
    }
}

// Neighbouring places give neighbouring points, also across triangles and sub-faces.
TEST(Limit, IsContinuousAlongALineThroughAPolygon) {
    const Surface surface = build(mixed());
    std::vector<Vec3> line;
    const Vec3 from(1.2f, 1.0f, 0.28f), to(2.2f, 1.65f, 0.22f);  // across the pentagon
    for (int i = 0; i <= 400; ++i) line.push_back(glm::mix(from, to, i / 400.0f));
    std::vector<float> distance(line.size());
    const auto places = closest_points(surface, line, distance);
    const auto points = apply_rows(limit_stencils(surface, places), surface.positions_rest);
    const float step = glm::length(to - from) / 400.0f;
    for (std::size_t i = 1; i < points.size(); ++i) {
        EXPECT_LT(glm::length(points[i] - points[i - 1]), 5.0f * step) << i;
    }
}

TEST(Limit, AnUnattachedPlaceHasAnEmptyRow) {
    const Surface surface = build(cube());
    const std::vector<SurfacePoint> places{{}, {3, 0.2f, 0.3f}, {}};
    const SparseRows rows = limit_stencils(surface, places);
    ASSERT_EQ(rows.rows(), 3);
    EXPECT_EQ(rows.start[1], rows.start[0]);
    EXPECT_GT(rows.start[2], rows.start[1]);
    EXPECT_EQ(rows.start[3], rows.start[2]);
    EXPECT_EQ(limit_stencils(surface, {}).rows(), 0);
}

}  // namespace
}  // namespace rumple::tests
