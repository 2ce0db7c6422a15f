// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "base/errors.h"
#include "surface/mesh/heal.h"
#include "tests/surface_laws.h"

namespace rumple::tests {
namespace {

using Pairs = std::vector<std::array<Index, 2>>;

HealedMesh heal(const MeshData& mesh, bool weld_seams = true) {
    return heal_mesh(mesh.input(weld_seams));
}

bool is_changed(const HealedMesh& healed) {
    return !(healed.turned.empty() && healed.cut.empty() && healed.doubled.empty() &&
             healed.repeated.empty());
}

// The healed mesh as a mesh of its own.
MeshData as_mesh(const MeshData& mesh, const HealedMesh& healed) {
    MeshData out;
    for (const Index v : healed.vertex_source) out.positions.push_back(mesh.positions[v]);
    out.polygon_start = healed.mesh.polygon_start;
    out.corner_vertex = healed.mesh.corner_vertex;
    out.triangle_corner = healed.triangle_corner;
    return out;
}

// Every polygon is there once or lies on one that is, with its own corners in their order or the reverse of
// it.
void expect_laws(const MeshData& mesh, const HealedMesh& healed) {
    EXPECT_NO_THROW(build(as_mesh(mesh, healed)));
    std::set<Index> there(healed.polygon_source.begin(), healed.polygon_source.end());
    EXPECT_EQ(there.size(), healed.polygon_source.size());
    for (const auto& [copy, original] : healed.doubled) {
        EXPECT_TRUE(there.count(original));
        EXPECT_TRUE(there.insert(copy).second);
    }
    EXPECT_EQ(there.size(), mesh.polygon_start.size() - 1);
    for (Index p = 0; p < healed.mesh.polygons(); ++p) {
        const Index source = healed.polygon_source[p];
        const bool turned = std::binary_search(healed.turned.begin(), healed.turned.end(), source);
        const Index size = healed.mesh.polygon_size(p);
        ASSERT_EQ(size, mesh.polygon_start[source + 1] - mesh.polygon_start[source]);
        for (Index k = 0; k < size; ++k) {
            const Index corner = healed.mesh.polygon_start[p] + k;
            EXPECT_EQ(healed.corner_source[corner],
                      mesh.polygon_start[source] + (turned ? (size - k) % size : k));
            EXPECT_EQ(healed.vertex_source[healed.mesh.corner_vertex[corner]],
                      mesh.corner_vertex[healed.corner_source[corner]]);
        }
    }
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) EXPECT_EQ(healed.vertex_source[v], Index(v));
}

// --- Laws ---

TEST(Healing, WhatIsAManifoldComesBackAsItIs) {
    for (const MeshData& mesh : {cube(), grid(5, 3, 0.1f), tube(7, 4, 0.1f, 1.0f)}) {
        const HealedMesh healed = heal(mesh);
        EXPECT_FALSE(is_changed(healed));
        EXPECT_EQ(healed.mesh.corner_vertex, mesh.corner_vertex);
        EXPECT_EQ(healed.triangle_corner, mesh.triangle_corner);
        EXPECT_EQ(healed.vertex_source.size(), mesh.positions.size());
    }
}

TEST(Healing, AnyPolygonsCanBeBuiltAndHealedIsHealed) {
    std::mt19937 random(7);
    for (int round = 0; round < 500; ++round) {
        MeshData mesh;
        for (int v = 0; v < 8; ++v)
            mesh.positions.push_back(Vec3(random() % 5, random() % 5, random() % 5) * 0.1f);
        mesh.positions.push_back({2, 2, 2});
        for (unsigned p = 0, count = 1 + random() % 20; p < count; ++p) {
            if (random() % 2) {
                mesh.add_polygon({Index(random() % 8), Index(random() % 8), Index(random() % 8)});
            } else {
                mesh.add_polygon(
                    {Index(random() % 8), Index(random() % 8), Index(random() % 8), Index(random() % 8)});
            }
        }
        const HealedMesh healed = heal(mesh, round % 2);
        expect_laws(mesh, healed);
        const HealedMesh again = heal(as_mesh(mesh, healed), round % 2);
        EXPECT_TRUE(again.cut.empty() && again.doubled.empty() && again.repeated.empty()) << round;
    }
}

TEST(Healing, TurningPolygonsOfAManifoldIsUndone) {
    std::mt19937 random(3);
    const MeshData right = tube(9, 6, 0.1f, 1.0f);
    for (int round = 0; round < 20; ++round) {
        MeshData mesh = right;
        std::vector<Index> turned;
        for (Index p = 0; p < 54; ++p) {
            if (random() % 4) continue;
            turned.push_back(p);
            std::reverse(mesh.corner_vertex.begin() + 4 * p + 1, mesh.corner_vertex.begin() + 4 * p + 4);
        }
        const HealedMesh healed = heal(mesh);
        EXPECT_EQ(healed.turned, turned);
        EXPECT_EQ(healed.mesh.corner_vertex, right.corner_vertex);
        expect_laws(mesh, healed);
    }
}

// --- Small exact cases ---

// Two squares side by side, and one that stands on the edge 1-2 between them.
MeshData standing_square() {
    MeshData mesh = grid(2, 1, 1.0f);
    mesh.positions.push_back({1, 0, 1});
    mesh.positions.push_back({1, 1, 1});
    mesh.add_polygon({1, 4, 7, 6});
    return mesh;
}

// A garment whose faces all look inwards is shown as any other, but what is worn under it would lie before
// them.
// Inside out, and wherever it stands.
void expect_turned_unless_a_sheet(const MeshData& right, const Vec3& place) {
    MeshData mesh = right;
    for (Vec3& p : mesh.positions) p += place;
    const Index polygons = static_cast<Index>(mesh.polygon_start.size()) - 1;
    for (Index p = 0; p < polygons; ++p)
        std::reverse(mesh.corner_vertex.begin() + mesh.polygon_start[p] + 1,
                     mesh.corner_vertex.begin() + mesh.polygon_start[p + 1]);
    const HealedMesh healed = heal(mesh);
    const bool is_sheet = polygons == 15;
    EXPECT_EQ(healed.turned.size(), is_sheet ? 0u : static_cast<std::size_t>(polygons));
    EXPECT_EQ(healed.mesh.corner_vertex, is_sheet ? mesh.corner_vertex : right.corner_vertex);
}

TEST(Healing, AGarmentThatIsInsideOutIsTurnedAndASheetIsNot) {
    for (const Vec3& place : {Vec3(0.0f), Vec3(3.0f, -7.0f, 5.0f), Vec3(-3.0f, 7.0f, -5.0f)})
        for (const MeshData& right : {cube(), tube(16, 8, 0.1f, 1.0f), grid(5, 3, 0.1f)})
            expect_turned_unless_a_sheet(right, place);
}

TEST(Healing, WhatStandsOnASheetIsCutOffAndTheSheetIsNot) {
    const MeshData mesh = standing_square();
    const HealedMesh healed = heal(mesh);
    EXPECT_EQ(healed.cut, (Pairs{{1, 4}}));
    EXPECT_TRUE(healed.turned.empty());
    EXPECT_EQ(healed.vertex_source, (std::vector<Index>{0, 1, 2, 3, 4, 5, 6, 7, 1, 4}));
    EXPECT_EQ(healed.mesh.corner_vertex, (std::vector<Index>{0, 1, 4, 3, 1, 2, 5, 4, 8, 9, 7, 6}));
}

TEST(Healing, OfFacesThatFitAlikeThoseThatFaceTheSameWayStayJoined) {
    MeshData mesh = standing_square();
    mesh.positions.push_back({1, 0, -1});
    mesh.positions.push_back({1, 1, -1});
    mesh.add_polygon({4, 1, 8, 9});  // goes on below: a cross of two sheets
    const HealedMesh healed = heal(mesh);
    EXPECT_EQ(healed.cut, (Pairs{{1, 4}}));
    EXPECT_TRUE(healed.turned.empty());
    EXPECT_EQ(build(as_mesh(mesh, healed)).welded.vertex_count, 12);
}

TEST(Healing, FacesOverTheSameVerticesAreLeftOutWhicheverWayTheyFace) {
    MeshData mesh = grid(2, 2, 1.0f);
    mesh.add_polygon({4, 3, 0, 1});  // the first, from its third corner
    mesh.add_polygon({1, 4, 5, 2});  // the second, turned
    const HealedMesh healed = heal(mesh);
    EXPECT_EQ(healed.doubled, (Pairs{{4, 0}, {5, 1}}));
    EXPECT_EQ(healed.mesh.polygons(), 4);
    EXPECT_FALSE(healed.cut.size() || healed.turned.size() || healed.repeated.size());
}

TEST(Healing, AFaceThatTakesTheVerticesInAnotherOrderHangsByItself) {
    MeshData mesh = grid(2, 2, 1.0f);
    mesh.add_polygon({0, 4, 1, 3});
    const HealedMesh healed = heal(mesh);
    EXPECT_EQ(healed.repeated, (std::vector<Index>{4}));
    EXPECT_EQ(healed.mesh.vertex_count, 13);
    expect_laws(mesh, healed);
}

TEST(Healing, TheSecondUseOfAVertexIsAVertexOfItsOwn) {
    MeshData mesh = grid(1, 1, 1.0f);
    mesh.add_polygon({1, 3, 1, 2});
    const HealedMesh healed = heal(mesh);
    EXPECT_EQ(healed.repeated, (std::vector<Index>{1}));
    EXPECT_EQ(healed.vertex_source, (std::vector<Index>{0, 1, 2, 3, 1}));
    expect_laws(mesh, healed);
}

// A strip of 8 quads, two side by side, whose ends meet after half a turn.
TEST(Healing, AStripWithOneSideIsCutAcross) {
    MeshData mesh;
    constexpr int kCount = 8;
    for (int k = 0; k < kCount; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / kCount;
        for (int j = -1; j <= 1; ++j) {
            const double radius = 3.0 + j * std::cos(angle / 2.0);
            mesh.positions.push_back(
                Vec3(radius * std::cos(angle), radius * std::sin(angle), j * std::sin(angle / 2.0)));
        }
    }
    for (Index k = 0; k < kCount; ++k) {
        for (Index j = 0; j < 2; ++j) {
            const Index v = 3 * k + j;
            if (k + 1 < kCount) {
                mesh.add_polygon({v, v + 3, v + 4, v + 1});
            } else {
                mesh.add_polygon({v, 2 - j, 1 - j, v + 1});
            }
        }
    }
    const HealedMesh healed = heal(mesh);
    expect_laws(mesh, healed);
    EXPECT_GE(healed.cut.size(), 2u);
    EXPECT_LE(healed.cut.size(), 4u);
    EXPECT_EQ(euler(build(as_mesh(mesh, healed), false).welded), 1);  // a disk
}

// Two halves that are joined by a seam only, one of them wound the other way.
TEST(Healing, WindingGoesAcrossSeamsThatAreWelded) {
    MeshData mesh = grid(3, 2, 1.0f);
    for (int v = 0; v < 12; ++v) mesh.positions.push_back(mesh.positions[v] + Vec3(3, 0, 0));
    for (Index j = 0; j < 2; ++j) {
        for (Index i = 0; i < 2; ++i) {  // narrower: the smaller one is turned
            const Index v = 12 + i + 4 * j;
            mesh.add_polygon({v, v + 4, v + 5, v + 1});
        }
    }
    EXPECT_EQ(heal(mesh).turned, (std::vector<Index>{6, 7, 8, 9}));
    EXPECT_TRUE(heal(mesh, false).turned.empty());
    EXPECT_EQ(build(as_mesh(mesh, heal(mesh))).welded.vertex_count, 12 + 12 - 3);
}

TEST(Healing, LayersThatLieOnOneAnotherAreLeftAlone) {
    MeshData mesh = grid(2, 2, 1.0f);
    const Index first = Index(mesh.positions.size());
    const auto corners = mesh.corner_vertex;
    for (Index v = 0; v < first; ++v) mesh.positions.push_back(mesh.positions[v]);
    for (std::size_t c = 0; c < corners.size(); c += 4)
        mesh.add_polygon(
            {first + corners[c], first + corners[c + 1], first + corners[c + 2], first + corners[c + 3]});
    EXPECT_FALSE(is_changed(heal(mesh)));
}

TEST(Healing, WhatIsNoMeshIsRefused) {
    MeshData mesh = grid(2, 2, 1.0f);
    mesh.positions[3].x = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW(heal(mesh), InvalidInput);
    MeshData none;
    EXPECT_THROW(heal(none), InvalidInput);
    // The difference of two starts may need more than 32 bits: a long has no more on Windows.
    MeshData wrapped = grid(2, 2, 1.0f);
    const Index corners = wrapped.polygon_start.back(), lowest = std::numeric_limits<Index>::min();
    wrapped.polygon_start = {0, 5, lowest, -5, corners};
    EXPECT_THROW(heal(wrapped), InvalidInput);
}

}  // namespace
}  // namespace rumple::tests
