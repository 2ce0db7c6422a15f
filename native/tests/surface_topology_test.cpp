// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <limits>

#include "base/errors.h"
#include "surface/mesh/checks.h"
#include "tests/surface_laws.h"

namespace rumple::tests {
namespace {

template <typename Error>
std::string message_of(const MeshData& mesh) {
    try {
        build(mesh);
    } catch (const Error& error) {
        return error.what();
    }
    return "nothing was thrown";
}

bool says(const std::string& message, const std::string& words) {
    return message.find(words) != std::string::npos;
}
#define EXPECT_SAYS(message, words) EXPECT_TRUE(says(message, words)) << "it says: " << message

// --- Laws ---

TEST(Topology, EulerNumberTellsTheGenusAndTheHoles) {
    EXPECT_EQ(euler(build(cube()).welded), 2);
    EXPECT_EQ(euler(build(tube(7, 4, 0.1f, 1.0f)).welded), 0);
    EXPECT_EQ(euler(build(grid(5, 3, 0.1f)).welded), 1);
}

TEST(Topology, EdgesDoNotDependOnTheOrderOfPolygons) {
    const MeshData forward = tube(5, 3, 0.1f, 1.0f);
    MeshData backward;
    backward.positions = forward.positions;
    for (std::size_t p = forward.polygon_start.size() - 1; p-- > 0;) {
        const Index* v = &forward.corner_vertex[forward.polygon_start[p]];
        backward.add_polygon({v[0], v[1], v[2], v[3]});
    }
    const auto x = build(forward).edges, y = build(backward).edges;
    ASSERT_EQ(x.size(), y.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
        EXPECT_EQ(x[i].a, y[i].a);
        EXPECT_EQ(x[i].b, y[i].b);
        EXPECT_LT(x[i].a, x[i].b);
        if (i == 0) continue;
        EXPECT_LT(std::make_pair(x[i - 1].a, x[i - 1].b), std::make_pair(x[i].a, x[i].b));
    }
}

TEST(Topology, EdgesStandBetweenTheirPolygons) {
    for (const MeshData& mesh : {cube(), mixed(), tube(5, 3, 0.1f, 1.0f)}) {
        const Surface surface = build(mesh);
        const auto has = [&](Index p, Index v) {
            const auto begin = surface.welded.corner_vertex.begin();
            const auto end = begin + surface.welded.polygon_start[p + 1];
            return std::find(begin + surface.welded.polygon_start[p], end, v) != end;
        };
        Index sides = 0;
        for (const Edge& e : surface.edges) {
            EXPECT_TRUE(has(e.left, e.a) && has(e.left, e.b));
            ++sides;
            if (e.right == kNone) continue;
            EXPECT_LT(e.left, e.right);
            EXPECT_TRUE(has(e.right, e.a) && has(e.right, e.b));
            ++sides;
        }
        EXPECT_EQ(sides, surface.welded.corners());
    }
}

TEST(Topology, BoundaryIsTheRimAndNothingElse) {
    const Surface surface = build(grid(4, 3, 0.1f));
    for (Index j = 0; j <= 3; ++j) {
        for (Index i = 0; i <= 4; ++i) {
            const bool rim = i == 0 || i == 4 || j == 0 || j == 3;
            EXPECT_EQ(surface.boundary_vertex[i + 5 * j], rim) << i << " " << j;
        }
    }
    for (bool rim : build(cube()).boundary_vertex) EXPECT_FALSE(rim);
}

TEST(Weld, ASplitMeshBecomesTheMeshItWasSplitFrom) {
    for (const MeshData& whole : {cube(), tube(6, 4, 0.1f, 1.0f), grid(3, 3, 0.1f)}) {
        const Surface joined = build(split_at_seams(whole)), was = build(whole);
        ASSERT_EQ(joined.welded.vertex_count, was.welded.vertex_count);
        ASSERT_EQ(joined.edges.size(), was.edges.size());
        for (std::size_t c = 0; c < whole.corner_vertex.size(); ++c) {
            EXPECT_EQ(joined.positions_rest[joined.welded.corner_vertex[c]],
                      was.positions_rest[was.welded.corner_vertex[c]]);
        }
        EXPECT_TRUE(joined.warnings.empty());
    }
    EXPECT_EQ(build(seam_split_cube()).welded.vertex_count, 8);
}

TEST(Weld, RepresentativesAreTheFirstOfTheirClassInOrder) {
    const Surface surface = build(seam_split_cube());
    for (Index w = 0; w < surface.welded.vertex_count; ++w) {
        EXPECT_EQ(surface.welded_of[surface.representative[w]], w);
    }
    EXPECT_TRUE(std::is_sorted(surface.representative.begin(), surface.representative.end()));
    for (std::size_t v = 0; v < surface.welded_of.size(); ++v) {
        EXPECT_LE(surface.representative[surface.welded_of[v]], static_cast<Index>(v));
    }
}

TEST(Weld, IsLeftOutWhenNotAskedFor) {
    const Surface surface = build(seam_split_cube(), false);
    EXPECT_EQ(surface.welded.vertex_count, 24);
    for (const Edge& edge : surface.edges) EXPECT_EQ(edge.right, kNone);
}

TEST(Weld, JoinsWithinTheToleranceAndNotBeyond) {
    for (const auto& [gap, vertices] : {std::pair{1e-7f, 6}, {1e-3f, 8}}) {
        MeshData two = split_at_seams(grid(2, 1, 1.0f));
        for (Index c = 4; c < 8; ++c) two.positions[c].x += gap;
        EXPECT_EQ(build(two).welded.vertex_count, vertices) << gap;
    }
}

TEST(Weld, PositionsOfJoinedVerticesAreTheirMean) {
    const Surface surface = build(seam_split_cube());
    std::vector<Vec3> display(24, Vec3(0.1f, 0.7f, -0.3f)), welded(8);
    weld_positions(surface, display, welded);
    for (const Vec3& p : welded) EXPECT_EQ(p, display[0]);  // to the bit
    // Vertex 0 of the cube belongs to three faces: move one of its three copies.
    display[0].x += 3.0f;
    weld_positions(surface, display, welded);
    EXPECT_NEAR(welded[surface.welded_of[0]].x, 1.1f, 1e-6f);
}

TEST(Weld, LeavesLayersOfOneFacingApart) {
    MeshData layers = grid(2, 2, 0.1f);
    const MeshData copy = layers;
    for (const Vec3& p : copy.positions) layers.positions.push_back(p);
    for (std::size_t p = 0; p + 1 < copy.polygon_start.size(); ++p) {
        const Index* v = &copy.corner_vertex[copy.polygon_start[p]];
        layers.add_polygon({v[0] + 9, v[1] + 9, v[2] + 9, v[3] + 9});
    }
    const Surface surface = build(layers);
    EXPECT_EQ(surface.welded.vertex_count, 18);
    ASSERT_EQ(surface.warnings.size(), 1u);
    EXPECT_SAYS(surface.warnings[0], "vertex 0");
}

TEST(Weld, LeavesADoubleSidedCardApart) {
    MeshData card = grid(1, 1, 0.1f);
    for (int v = 0; v < 4; ++v) card.positions.push_back(card.positions[v]);
    card.add_polygon({4, 6, 7, 5});  // the same square from below
    const Surface surface = build(card);
    EXPECT_EQ(surface.welded.vertex_count, 8);  // joined, both faces would use the same vertices
    EXPECT_EQ(surface.warnings.size(), 1u);
}

TEST(Weld, LeavesWhatTouchesInAPointApart) {
    MeshData corners = grid(1, 1, 1.0f);
    for (const Vec3& p : grid(1, 1, 1.0f).positions) corners.positions.push_back(p + Vec3(1, 1, 0));
    corners.add_polygon({4, 5, 7, 6});
    EXPECT_EQ(build(corners).welded.vertex_count, 8);
}

// An upright square with vertices of its own, over the ground line from-to.
void add_square(MeshData& mesh, Vec3 from, Vec3 to) {
    const Index v = static_cast<Index>(mesh.positions.size());
    for (const Vec3& p : {from, to, to + Vec3(0, 0, 1), from + Vec3(0, 0, 1)}) mesh.positions.push_back(p);
    mesh.add_polygon({v, v + 1, v + 2, v + 3});
}

TEST(Weld, ThreeSheetsAtOneSeamStayApartAndTheRestIsJoined) {
    MeshData fin;  // three squares at x = y = 0 and a fourth that continues the first on its other side
    add_square(fin, {0, 0, 0}, {1, 0, 0});
    add_square(fin, {-1, 0, 0}, {0, 0, 0});
    add_square(fin, {0, 0, 0}, {0, 1, 0});
    add_square(fin, {1, 0, 0}, {2, 0, 0});
    const Surface surface = build(fin);
    EXPECT_EQ(surface.welded.vertex_count, 14);
    EXPECT_EQ(surface.warnings.size(), 1u);
}

TEST(Weld, ASeamEndsWhereTheNextOneCannotBeJoined) {
    MeshData sheets;  // the first two face opposite ways at x = y = 0; the third stands on the first
    add_square(sheets, {0, 0, 0}, {1, 0, 0});
    add_square(sheets, {0, 0, 0}, {0, 1, 0});
    add_square(sheets, {0, 0, 1}, {1, 0, 1});
    const Surface surface = build(sheets);
    EXPECT_EQ(surface.welded.vertex_count, 10);
    EXPECT_EQ(surface.warnings.size(), 1u);
}

TEST(Weld, TakesBackWhatWouldPutAThirdFaceOnAnEdge) {
    // Faces 0 and 1 share the edge 2-3 (from the origin to x = 1). A fin stands on
    // that edge, and two caps have good seams with the fin and with face 1: joining
    // them all would join the fin's foot to the edge, too.
    MeshData mesh;
    mesh.positions = {{0, -1, 0}, {1, -1, 0}, {1, 0, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0},  // faces 0, 1
                      {1, 0, 0},  {0, 0, 0},  {0, 0, 1}, {1, 0, 1},                        // fin
                      {0, 0, 0},  {0, 1, 0},  {0, 0, 1},                                   // cap at x = 0
                      {1, 1, 0},  {1, 0, 0},  {1, 0, 1}};                                  // cap at x = 1
    mesh.add_polygon({0, 1, 2, 3});
    mesh.add_polygon({3, 2, 4, 5});
    mesh.add_polygon({6, 7, 8, 9});
    mesh.add_polygon({10, 11, 12});
    mesh.add_polygon({13, 14, 15});
    const Surface surface = build(mesh);
    // All four seams end at the foot, so none is joined.
    EXPECT_EQ(surface.welded.vertex_count, 16);
    ASSERT_EQ(surface.warnings.size(), 1u);
    EXPECT_SAYS(surface.warnings[0], "vertex 2");
}

TEST(Weld, DoesNotPinchAFaceWithAZeroLengthEdge) {
    // Face 0 touches face 1 along four edges at x = 1; in their middle it has an edge
    // of length zero (3-4), where face 1 has one vertex (13).
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 2, 0}, {1, 2, 0}, {1, 3, 0}, {1, 4, 0}, {0, 4, 0},
                      {1, 0, 0}, {2, 0, 0}, {2, 4, 0}, {1, 4, 0}, {1, 3, 0}, {1, 2, 0}, {1, 1, 0}};
    mesh.add_polygon({0, 1, 2, 3, 4, 5, 6, 7});
    mesh.add_polygon({8, 9, 10, 11, 12, 13, 14});
    const Surface surface = build(mesh);
    EXPECT_NE(surface.welded_of[3], surface.welded_of[4]);
    EXPECT_EQ(surface.welded_of[1], surface.welded_of[8]);  // the seam goes on beyond the edges beside it
    EXPECT_EQ(surface.welded_of[2], surface.welded_of[14]);
    EXPECT_EQ(surface.welded_of[5], surface.welded_of[12]);
    EXPECT_EQ(surface.welded_of[6], surface.welded_of[11]);
}

// --- What is tolerated ---

TEST(Topology, LooseVerticesKeepAPlaceAndAreSaid) {
    MeshData mesh = grid(1, 1, 1.0f);
    mesh.positions.push_back({5, 5, 5});
    const Surface surface = build(mesh);
    EXPECT_EQ(surface.welded.vertex_count, 5);
    EXPECT_EQ(surface.positions_rest[surface.welded_of[4]], Vec3(5, 5, 5));
    ASSERT_EQ(surface.warnings.size(), 1u);
    EXPECT_SAYS(surface.warnings[0], "vertex 4");
}

TEST(Topology, BowTieIsSaid) {
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
    mesh.add_polygon({0, 1, 2});
    mesh.add_polygon({0, 3, 4});
    const Surface surface = build(mesh);
    ASSERT_EQ(surface.warnings.size(), 1u);
    EXPECT_SAYS(surface.warnings[0], "vertex 0");
}

TEST(Topology, TwoClosedFansInOneVertexAreSaid) {
    // Two tetrahedra tip to tip: OpenMesh alone would refuse the second.
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 1}, {-1, 1, 1}, {-1, -1, 1}, {1, 0, -1}, {-1, 1, -1}, {-1, -1, -1}};
    for (Index k : {0, 3}) {
        mesh.add_polygon({0, k + 1, k + 2});
        mesh.add_polygon({0, k + 2, k + 3});
        mesh.add_polygon({0, k + 3, k + 1});
        mesh.add_polygon({k + 3, k + 2, k + 1});
    }
    const Surface surface = build(mesh);
    ASSERT_EQ(surface.warnings.size(), 1u);
    EXPECT_SAYS(surface.warnings[0], "vertex 0");
}

TEST(Topology, OpenMeshRefusesWhatWasNotSplitIntoFans) {
    // The same tips, as one vertex: split_fans() is what makes them acceptable.
    PolygonMesh mesh;
    mesh.vertex_count = 7;
    for (Index k : {0, 3}) {
        const Index a = k + 1, b = k + 2, c = k + 3;
        for (Index v : {0, a, b, 0, b, c, 0, c, a, c, b, a}) mesh.corner_vertex.push_back(v);
    }
    for (Index p = 1; p <= 8; ++p) mesh.polygon_start.push_back(3 * p);
    EXPECT_THROW(check_manifold(mesh), TopologyError);
    std::vector<Index> fans;
    const PolygonMesh split = split_fans(mesh, fans);
    EXPECT_NO_THROW(check_manifold(split));
    EXPECT_EQ(split.vertex_count, 8);
    EXPECT_EQ(fans, (std::vector<Index>{2, 1, 1, 1, 1, 1, 1}));
}

TEST(Topology, PolygonsMayComeInAnyOrder) {
    // OpenMesh joins polygon by polygon and passes through states that are not manifold.
    std::mt19937 random(9);
    for (const MeshData& mesh : {cube(), triangulated(tube(6, 5, 0.4f, 1.0f)), grid(6, 6, 0.1f)}) {
        const Index faces = static_cast<Index>(mesh.polygon_start.size()) - 1;
        std::vector<Index> order(faces);
        for (Index p = 0; p < faces; ++p) order[p] = p;
        for (int round = 0; round < 30; ++round) {
            for (Index p = faces - 1; p > 0; --p) std::swap(order[p], order[random() % (p + 1)]);
            MeshData shuffled;
            shuffled.positions = mesh.positions;
            for (Index p : order) {
                const Index* v = &mesh.corner_vertex[mesh.polygon_start[p]];
                if (mesh.polygon_start[p + 1] - mesh.polygon_start[p] == 4) {
                    shuffled.add_polygon({v[0], v[1], v[2], v[3]});
                } else {
                    shuffled.add_polygon({v[0], v[1], v[2]});
                }
            }
            EXPECT_NO_THROW(build(shuffled));
        }
    }
}

TEST(Topology, ZeroLengthAndZeroAreaAreSaid) {
    MeshData mesh = grid(2, 1, 1.0f);
    mesh.positions[1] = mesh.positions[0];
    const Surface surface = build(mesh);
    ASSERT_EQ(surface.warnings.size(), 2u);
    EXPECT_SAYS(surface.warnings[0], "edge 0-1");
    EXPECT_SAYS(surface.warnings[1], "triangle 0 of face 0");
}

// --- Bad input: each error names the element ---

TEST(BadMesh, NotFinite) {
    MeshData mesh = grid(2, 2, 1.0f);
    mesh.positions[7].y = std::numeric_limits<float>::quiet_NaN();
    mesh.positions[8].x = std::numeric_limits<float>::infinity();
    EXPECT_SAYS(message_of<InvalidInput>(mesh), "vertex 7 is not finite");
}

TEST(BadMesh, Empty) {
    EXPECT_SAYS(message_of<InvalidInput>(MeshData{}), "no faces");
    MeshData point = grid(1, 1, 1.0f);
    for (Vec3& p : point.positions) p = Vec3(1, 2, 3);
    EXPECT_SAYS(message_of<InvalidInput>(point), "at one place");
}

TEST(BadMesh, CornerOutOfRange) {
    for (Index wrong : {-1, 9}) {
        MeshData mesh = grid(2, 2, 1.0f);
        mesh.corner_vertex[5] = wrong;
        EXPECT_SAYS(message_of<InvalidInput>(mesh), "corner 5 names vertex " + std::to_string(wrong));
    }
}

TEST(BadMesh, FaceWithTwoCorners) {
    MeshData mesh = grid(2, 2, 1.0f);
    mesh.polygon_start[2] = 6;
    EXPECT_SAYS(message_of<InvalidInput>(mesh), "face 1 has 2 corners");
    mesh.polygon_start.back() = 15;
    mesh.polygon_start[2] = 8;
    EXPECT_SAYS(message_of<InvalidInput>(mesh), "ends at 15");
}

TEST(BadMesh, TrianglesThatAreNotOfTheirFace) {
    MeshData mesh = grid(2, 2, 1.0f);
    mesh.triangle_corner[8] = 3;
    EXPECT_SAYS(message_of<InvalidInput>(mesh), "triangle 2 takes its corners from more than one face");
    mesh = grid(2, 2, 1.0f);
    mesh.triangle_corner[8] = mesh.triangle_corner[7];
    EXPECT_SAYS(message_of<InvalidInput>(mesh), "triangle 2 uses one corner twice");
    mesh = grid(2, 2, 1.0f);
    mesh.triangle_corner[4] = 99;
    EXPECT_SAYS(message_of<InvalidInput>(mesh), "triangle 1 names corner 99");
    mesh = grid(2, 2, 1.0f);
    mesh.triangle_corner.resize(mesh.triangle_corner.size() - 3);
    EXPECT_SAYS(message_of<InvalidInput>(mesh), "face 3 has 1 triangles, expected 2");
}

TEST(BadMesh, EdgeWithThreeFaces) {
    MeshData mesh = grid(2, 1, 1.0f);
    mesh.positions.push_back({1, 0, 1});
    mesh.positions.push_back({1, 1, 1});
    mesh.add_polygon({1, 4, 7, 6});
    EXPECT_SAYS(message_of<TopologyError>(mesh), "edge 1-4 is used by 3 faces");
}

TEST(BadMesh, NeighboursOfOppositeWinding) {
    MeshData mesh;
    mesh.positions = grid(2, 1, 1.0f).positions;
    mesh.add_polygon({0, 1, 4, 3});
    mesh.add_polygon({1, 4, 5, 2});
    const std::string message = message_of<TopologyError>(mesh);
    EXPECT_SAYS(message, "edge 1-4");
    EXPECT_SAYS(message, "faces 0 and 1");
}

TEST(BadMesh, FacesOverTheSameVertices) {
    MeshData mesh = grid(2, 1, 1.0f);
    mesh.add_polygon({5, 4, 1, 2});
    EXPECT_SAYS(message_of<TopologyError>(mesh), "faces 1 and 2 use the same vertices");
}

TEST(BadMesh, VertexTwiceInAFace) {
    MeshData mesh = grid(2, 1, 1.0f);
    mesh.corner_vertex[6] = 1;
    EXPECT_SAYS(message_of<TopologyError>(mesh), "face 1 uses vertex 1 twice");
}

}  // namespace
}  // namespace rumple::tests
