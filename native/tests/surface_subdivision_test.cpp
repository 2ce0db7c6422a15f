// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "base/errors.h"
#include "surface/refine/subdivider.h"
#include "tests/surface_laws.h"

namespace rumple::tests {
namespace {

class EveryMesh : public testing::TestWithParam<std::tuple<MeshData (*)(), Index>> {
  protected:
    Surface surface_ = build(std::get<0>(GetParam())());
    Index levels_ = std::get<1>(GetParam());
};

INSTANTIATE_TEST_SUITE_P(Subdivision, EveryMesh,
                         testing::Combine(testing::Values(
                                              +[] { return cube(); }, +[] { return triangulated(cube()); },
                                              +[] { return seam_split_cube(); },
                                              +[] { return tube(5, 3, 0.5f, 2.0f); },
                                              +[] { return shaken(grid(4, 3, 0.5f), 0.1f, 7); },
                                              +[] { return triangulated(mixed()); }, +[] { return mixed(); }),
                                          testing::Values(0, 1, 2, 3)));

TEST_P(EveryMesh, KeepsTheLawsOfRefinement) {
    const FineMesh fine = refine_subdivision(surface_.welded, levels_);
    expect_refinement_laws(fine, surface_.welded, surface_.positions_rest);
    EXPECT_EQ(boundary_edges(fine.mesh), boundary_edges(surface_.welded) << levels_);
}

TEST_P(EveryMesh, StencilsSumToOneAndGoWithTheFineVertices) {
    const FineMesh fine = refine_subdivision(surface_.welded, levels_);
    for (bool limit : {false, true}) {
        const SparseRows rows = subdivision_stencils(surface_.welded, levels_, limit);
        ASSERT_EQ(rows.rows(), fine.mesh.vertex_count);
        expect_rows_sum_to_one(rows, surface_.welded.vertex_count);
        // Smoothing moves a vertex by less than an edge or so; another order would move it across the mesh.
        const auto smooth = apply_rows(rows, surface_.positions_rest);
        const auto linear = apply_rows(fine.vertex_from_parent, surface_.positions_rest);
        for (std::size_t v = 0; v < smooth.size(); ++v) EXPECT_LT(glm::length(smooth[v] - linear[v]), 1.3f);
    }
}

TEST_P(EveryMesh, StencilsAreThoseOfOpenSubdivToTheBit) {
    // They are summed by our own code, which can be stopped in the middle: OpenSubdiv's one call cannot.
    if (levels_ == 0) return;
    const UsedVertices used(surface_.welded);
    const Refiner refiner = make_refiner(surface_.welded, used);
    Far::TopologyRefiner::UniformOptions uniform(levels_);
    uniform.fullTopologyInLastLevel = true;
    refiner->RefineUniform(uniform);
    using Factory = Far::StencilTableFactoryReal<double>;
    Factory::Options options;
    options.generateIntermediateLevels = false;
    options.factorizeIntermediateLevels = true;
    options.generateControlVerts = false;
    options.maxLevel = unsigned(levels_);
    const std::unique_ptr<const Far::StencilTableReal<double>> table(Factory::Create(*refiner, options));
    const SparseRows expected = copy_rows(*table, used.vertex_of);
    const SparseRows rows = subdivision_stencils(surface_.welded, levels_, false);
    EXPECT_EQ(rows.start, expected.start);
    EXPECT_EQ(rows.index, expected.index);
    EXPECT_EQ(rows.weight, expected.weight);
}

TEST_P(EveryMesh, PieceSizesFollowTheScheme) {
    const FineMesh fine = refine_subdivision(surface_.welded, levels_);
    if (levels_ == 0) {
        EXPECT_EQ(fine.mesh.corner_vertex, surface_.welded.corner_vertex);
        EXPECT_EQ(fine.mesh.polygon_start, surface_.welded.polygon_start);
        return;
    }
    bool triangles = true;
    for (Index p = 0; p < surface_.welded.polygons(); ++p) triangles &= surface_.welded.polygon_size(p) == 3;
    for (Index p = 0; p < fine.mesh.polygons(); ++p) ASSERT_EQ(fine.mesh.polygon_size(p), triangles ? 3 : 4);
    const Index pieces = triangles ? surface_.welded.polygons() * 4 : surface_.welded.corners();
    EXPECT_EQ(fine.mesh.polygons(), pieces << 2 * (levels_ - 1));
}

TEST_P(EveryMesh, TwoStepsAreOne) {
    // Level by level through compose() is the same mesh, with the same corners and
    // maps, as all at once. Only vertices are numbered otherwise: OpenSubdiv numbers
    // the edges of a mesh that it is given in another order than those it made.
    if (levels_ == 0) return;
    const FineMesh once = refine_subdivision(surface_.welded, levels_);
    const FineMesh inner = refine_subdivision(surface_.welded, levels_ - 1);
    const FineMesh twice = compose(refine_subdivision(inner.mesh, 1), inner);
    expect_same_partition(once.mesh.corner_vertex, twice.mesh.corner_vertex);
    ASSERT_EQ(once.polygon_parent, twice.polygon_parent);
    ASSERT_EQ(once.corner_from_parent.index, twice.corner_from_parent.index);
    for (std::size_t k = 0; k < once.corner_from_parent.weight.size(); ++k) {
        ASSERT_NEAR(once.corner_from_parent.weight[k], twice.corner_from_parent.weight[k], 1e-6f);
    }
}

TEST(Subdivision, LinearRowsOfAPlanarQuadLieOnIt) {
    const Surface surface = build(grid(1, 1, 1.0f));
    const FineMesh fine = refine_subdivision(surface.welded, 3);
    std::set<std::pair<float, float>> places;
    for (const Vec3& p : apply_rows(fine.vertex_from_parent, surface.positions_rest)) {
        EXPECT_EQ(p.z, 0.0f);
        EXPECT_EQ(p.x * 8, std::round(p.x * 8));
        EXPECT_EQ(p.y * 8, std::round(p.y * 8));
        places.insert({p.x, p.y});
    }
    EXPECT_EQ(places.size(), 81u);
}

// --- By hand ---

// The row's weights, columns in order, as a dense vector.
std::vector<float> dense(const SparseRows& rows, Index r, Index columns) {
    std::vector<float> row(columns, 0.0f);
    for (Index k = rows.start[r]; k < rows.start[r + 1]; ++k) row[rows.index[k]] += rows.weight[k];
    return row;
}

// The fine vertex whose linear position is p.
Index vertex_at(const FineMesh& fine, const Surface& surface, const Vec3& p) {
    const auto x = apply_rows(fine.vertex_from_parent, surface.positions_rest);
    for (std::size_t v = 0; v < x.size(); ++v) {
        if (glm::length(x[v] - p) < 1e-5f) return static_cast<Index>(v);
    }
    ADD_FAILURE() << "no vertex there";
    return 0;
}

TEST(CatmullClark, CubeByHand) {
    const Surface surface = build(cube());
    const FineMesh fine = refine_subdivision(surface.welded, 1);
    const SparseRows rows = subdivision_stencils(surface.welded, 1, false);
    // Face point: the mean of its corners, here those with z = 1 (vertices 4 to 7).
    const auto face = dense(rows, vertex_at(fine, surface, {0, 0, 1}), 8);
    // Edge point: the mean of its ends and the two face points. Edge 6-7 (y = z = 1)
    // lies between the faces z = 1 (4 to 7) and y = 1 (2, 3, 6, 7).
    const auto edge = dense(rows, vertex_at(fine, surface, {0, 1, 1}), 8);
    // Vertex point of valence 3: (F + 2 R + (3 - 3) P) / 3, with F the mean of the
    // face points and R of the edge middles. Vertex 7; its edges lead to 3, 5 and 6,
    // each in two of three faces; 1, 2 and 4 are in one; 0 in none.
    //   F: 7: 1/4, neighbours 2/12, others 1/12.   R: 7: 1/2, neighbours 1/6.
    const auto vertex = dense(rows, vertex_at(fine, surface, {1, 1, 1}), 8);
    const float n = (2.0f / 12 + 2.0f / 6) / 3, o = 1.0f / 36, p = (0.25f + 1.0f) / 3;
    const std::vector<float> face_by_hand{0, 0, 0, 0, 0.25f, 0.25f, 0.25f, 0.25f};
    const std::vector<float> edge_by_hand{0, 0, 1.0f / 16, 1.0f / 16, 1.0f / 16, 1.0f / 16, 0.375f, 0.375f};
    const std::vector<float> vertex_by_hand{0, o, o, n, o, n, n, p};
    for (Index v = 0; v < 8; ++v) {
        EXPECT_NEAR(face[v], face_by_hand[v], 1e-6f) << v;
        EXPECT_NEAR(edge[v], edge_by_hand[v], 1e-6f) << v;
        EXPECT_NEAR(vertex[v], vertex_by_hand[v], 1e-6f) << v;
    }
}

TEST(CatmullClark, LimitOfARegularGridByHand) {
    // Bicubic B-spline: (1 4 1)/6 in each direction.
    const Surface surface = build(grid(4, 4, 1.0f));
    const auto row = dense(subdivision_stencils(surface.welded, 0, true), 12, 25);
    const float spline[5] = {0, 1.0f / 6, 4.0f / 6, 1.0f / 6, 0};
    for (Index j = 0; j < 5; ++j) {
        for (Index i = 0; i < 5; ++i) EXPECT_NEAR(row[i + 5 * j], spline[i] * spline[j], 1e-6f);
    }
    // On the boundary the curve's own spline; a corner with one face stays.
    const auto rim = dense(subdivision_stencils(surface.welded, 0, true), 2, 25);
    for (Index v = 0; v < 25; ++v) EXPECT_NEAR(rim[v], v < 5 ? spline[v] : 0.0f, 1e-6f);
    EXPECT_EQ(dense(subdivision_stencils(surface.welded, 0, true), 0, 25)[0], 1.0f);
}

TEST(Loop, RegularVertexAndEdgeByHand) {
    const Surface surface = build(triangulated(grid(4, 4, 1.0f)));
    const FineMesh fine = refine_subdivision(surface.welded, 1);
    const SparseRows rows = subdivision_stencils(surface.welded, 1, false);
    // Vertex 12 with valence 6: 5/8 and 1/16 for each neighbour.
    const auto vertex = dense(rows, vertex_at(fine, surface, {2, 2, 0}), 25);
    const std::set<Index> around{11, 13, 7, 17, 6, 18};  // the diagonals lead from (i, j) to (i + 1, j + 1)
    for (Index v = 0; v < 25; ++v) {
        EXPECT_NEAR(vertex[v], v == 12 ? 0.625f : around.count(v) ? 0.0625f : 0.0f, 1e-6f) << v;
    }
    // Edge 12-13: 3/8 for its ends, 1/8 for the two vertices opposite.
    const auto edge = dense(rows, vertex_at(fine, surface, {2.5f, 2, 0}), 25);
    for (Index v = 0; v < 25; ++v) {
        EXPECT_NEAR(edge[v], v == 12 || v == 13 ? 0.375f : v == 7 || v == 18 ? 0.125f : 0.0f, 1e-6f) << v;
    }
}

// --- Odd meshes ---

TEST(Subdivision, LeavesLooseVerticesOut) {
    MeshData mesh = grid(2, 2, 1.0f);
    mesh.positions.insert(mesh.positions.begin(), Vec3(9, 9, 9));  // vertex 0, so that all others shift
    for (Index& v : mesh.corner_vertex) ++v;
    const Surface surface = build(mesh), without = build(grid(2, 2, 1.0f));
    for (Index levels : {0, 2}) {
        const FineMesh fine = refine_subdivision(surface.welded, levels);
        const FineMesh plain = refine_subdivision(without.welded, levels);
        EXPECT_EQ(fine.mesh.corner_vertex, plain.mesh.corner_vertex);
        EXPECT_EQ(apply_rows(fine.vertex_from_parent, surface.positions_rest),
                  apply_rows(plain.vertex_from_parent, without.positions_rest));
        EXPECT_EQ(apply_rows(subdivision_stencils(surface.welded, levels, true), surface.positions_rest),
                  apply_rows(subdivision_stencils(without.welded, levels, true), without.positions_rest));
    }
}

TEST(Subdivision, ABowTieStaysSharp) {
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {-1, 0, 0}, {-1, -1, 0}, {0, -1, 0}};
    mesh.add_polygon({0, 1, 2, 3});
    mesh.add_polygon({0, 4, 5, 6});
    const Surface surface = build(mesh);
    const FineMesh fine = refine_subdivision(surface.welded, 2);
    expect_refinement_laws(fine, surface.welded, surface.positions_rest);
    const Index tie = vertex_at(fine, surface, {0, 0, 0});
    const auto smooth = apply_rows(subdivision_stencils(surface.welded, 2, true), surface.positions_rest);
    EXPECT_LT(glm::length(smooth[tie]), 1e-6f);
}

TEST(Subdivision, RefusesLevelsOutOfRange) {
    const Surface surface = build(cube());
    for (Index levels : {-1, kMostLevels + 1}) {
        EXPECT_THROW(refine_subdivision(surface.welded, levels), InvalidInput);
        EXPECT_THROW(subdivision_stencils(surface.welded, levels, true), InvalidInput);
    }
}

// --- compose() of rows ---

TEST(SparseRows, ComposeIsApplyingOneAfterTheOther) {
    const Surface surface = build(mixed());
    const FineMesh inner = refine_subdivision(surface.welded, 1);
    const SparseRows outer = subdivision_stencils(inner.mesh, 2, true);
    const SparseRows both = compose(outer, inner.vertex_from_parent);
    const auto stepwise = apply_rows(outer, apply_rows(inner.vertex_from_parent, surface.positions_rest));
    const auto at_once = apply_rows(both, surface.positions_rest);
    ASSERT_EQ(at_once.size(), stepwise.size());
    for (std::size_t v = 0; v < at_once.size(); ++v) EXPECT_LT(glm::length(at_once[v] - stepwise[v]), 2e-6f);
    for (Index r = 0; r < both.rows(); ++r) {
        for (Index k = both.start[r] + 1; k < both.start[r + 1]; ++k)
            EXPECT_LT(both.index[k - 1], both.index[k]);
    }
}

TEST(SparseRows, ComposeDropsExactZerosAndKeepsEmptyRows) {
    SparseRows inner, outer;
    inner.add(3, 1.0f), inner.end_row();
    inner.add(3, 1.0f), inner.add(1, 2.0f), inner.end_row();
    outer.add(0, 1.0f), outer.add(1, -1.0f), outer.end_row();  // column 3 cancels
    outer.end_row();
    const SparseRows both = compose(outer, inner);
    EXPECT_EQ(both.start, (std::vector<Index>{0, 1, 1}));
    EXPECT_EQ(both.index, (std::vector<Index>{1}));
    EXPECT_EQ(both.weight, (std::vector<float>{-2.0f}));
}

// --- find_alike() ---

SparseRows written_out(const ShiftedRows& rows) {
    SparseRows out;
    for (Index r = 0; r < rows.rows(); ++r) {
        const Index number = rows.alike[r];
        for (Index k = rows.different.start[number]; k < rows.different.start[number + 1]; ++k)
            out.add(rows.first[r] + rows.different.index[k], rows.different.weight[k]);
        out.end_row();
    }
    return out;
}

TEST(SparseRows, AlikeRowsAreStoredOnce) {
    SparseRows rows;
    rows.add(2, 0.5f), rows.add(3, 0.25f), rows.end_row();
    rows.end_row();
    rows.add(7, 0.5f), rows.add(8, 0.25f), rows.end_row();   // the first row, shifted by 5
    rows.add(7, 0.5f), rows.add(9, 0.25f), rows.end_row();   // other columns
    rows.add(7, 0.5f), rows.add(8, 0.125f), rows.end_row();  // another weight
    rows.add(3, 0.25f), rows.add(2, 0.5f),
        rows.end_row();  // another order, in which sums may round differently
    rows.end_row();
    const ShiftedRows found = find_alike(rows);
    EXPECT_EQ(found.first, (std::vector<Index>{2, 0, 7, 7, 7, 2, 0}));
    EXPECT_EQ(found.alike, (std::vector<Index>{0, 1, 0, 2, 3, 4, 1}));
    EXPECT_EQ(found.columns(), 10);
    EXPECT_EQ(find_alike({}).columns(), 0);
}

TEST(SparseRows, CornersOfASubdividedMeshAreAFewRows) {
    const SparseRows corners = refine_subdivision(build(grid(12, 12, 0.1f)).welded, 2).corner_from_parent;
    const ShiftedRows found = find_alike(corners);
    const SparseRows same = written_out(found);
    EXPECT_EQ(same.start, corners.start);
    EXPECT_EQ(same.index, corners.index);
    EXPECT_EQ(same.weight, corners.weight);
    EXPECT_LT(10 * found.different.rows(), found.rows());
}

}  // namespace
}  // namespace rumple::tests
