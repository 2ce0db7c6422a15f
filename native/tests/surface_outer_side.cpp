// SPDX-License-Identifier: GPL-3.0-or-later
// Which side of a garment with a modelled thickness is the outer one.
#include <gtest/gtest.h>

#include <algorithm>

#include "surface/cloth/outer_side.h"
#include "tests/meshes.h"

namespace rumple::tests {
namespace {

constexpr float kThickness = 0.004f;
constexpr Index kAround = 24, kAlong = 16;
constexpr Index kSide = kAround * kAlong;  // polygons of one side

// A second side inside of a tube around the x axis, turned, the thickness below it, with rims or without.
MeshData thick_sleeve(float radius, bool rims, float thickness = kThickness) {
    MeshData mesh = tube(kAround, kAlong, radius, 0.5f);
    const Index count = Index(mesh.positions.size());
    for (Index v = 0; v < count; ++v) {
        const Vec3 p = mesh.positions[v];
        mesh.positions.push_back({p.x, (radius - thickness) / radius * Vec2(p.y, p.z)});
    }
    const auto corners = mesh.corner_vertex;
    for (size_t c = 0; c < corners.size(); c += 4) {
        mesh.add_polygon(
            {corners[c + 3] + count, corners[c + 2] + count, corners[c + 1] + count, corners[c] + count});
    }
    for (Index i = 0; rims && i < kAround; ++i) {
        const Index next = (i + 1) % kAround, last = kAlong * kAround;
        mesh.add_polygon({next, i, i + count, next + count});
        mesh.add_polygon({last + i, last + next, last + next + count, last + i + count});
    }
    return mesh;
}

TEST(OuterSide, OfASleeveItIsTheOneThatGoesRound) {
    for (const bool rims : {true, false}) {
        const OuterSide found = outer_side(build(thick_sleeve(0.08f, rims)));
        EXPECT_NEAR(found.thickness, kThickness, 0.1f * kThickness) << rims;
        for (Index p = 0; p < Index(found.polygons.size()); ++p)
            EXPECT_EQ(found.polygons[p], p < kSide) << p << ' ' << rims;
    }
}

TEST(OuterSide, TheOrderOfTheSidesDoesNotMatter) {
    MeshData mesh = thick_sleeve(0.08f, true);
    MeshData other;
    other.positions = mesh.positions;
    for (Index p = Index(mesh.polygon_start.size()) - 2; p >= 0; --p) {
        const Index* c = &mesh.corner_vertex[mesh.polygon_start[p]];
        other.add_polygon({c[0], c[1], c[2], c[3]});
    }
    const OuterSide found = outer_side(build(other));
    const Index count = Index(found.polygons.size());
    for (Index p = 0; p < count; ++p) EXPECT_EQ(found.polygons[p], p >= count - kSide) << p;
}

// A sheet in the plane z = 0 with a second side below it that is so much wider all round, joined by rims.
MeshData slab(Index nx, Index ny, float size, float wider) {
    MeshData mesh = grid(nx, ny, size);
    const Index count = Index(mesh.positions.size());
    const Vec3 far = mesh.positions.back(), grown = 1.0f + 2.0f * wider / glm::max(far, Vec3(size));
    for (Index v = 0; v < count; ++v) {
        const Vec3 p = far / 2.0f + grown * (mesh.positions[v] - far / 2.0f);
        mesh.positions.push_back({p.x, p.y, -kThickness});
    }
    const auto corners = mesh.corner_vertex;
    std::vector<Index> outline;  // counter-clockwise
    for (Index i = 0; i < nx; ++i) outline.push_back(i);
    for (Index j = 0; j < ny; ++j) outline.push_back(nx + j * (nx + 1));
    for (Index i = nx; i > 0; --i) outline.push_back(i + ny * (nx + 1));
    for (Index j = ny; j > 0; --j) outline.push_back(j * (nx + 1));
    for (size_t c = 0; c < corners.size(); c += 4) {
        mesh.add_polygon(
            {corners[c + 3] + count, corners[c + 2] + count, corners[c + 1] + count, corners[c] + count});
    }
    for (size_t k = 0; k < outline.size(); ++k) {
        const Index a = outline[k], b = outline[(k + 1) % outline.size()];
        mesh.add_polygon({b, a, a + count, b + count});
    }
    return mesh;
}

// A flat sheet has no larger side: the one that was modelled first counts.
TEST(OuterSide, OfASlabItIsOneOfBoth) {
    const OuterSide found = outer_side(build(slab(8, 8, 0.05f, 0.0f)));
    EXPECT_NEAR(found.thickness, kThickness, 1e-6f);
    for (Index p = 0; p < Index(found.polygons.size()); ++p) EXPECT_EQ(found.polygons[p], p < 64) << p;
}

// The rims of a strap lie on one another, and go on from its sides at less than a right angle.
TEST(OuterSide, RimsThatLeanDoNotJoinTheSides) {
    const OuterSide found = outer_side(build(slab(60, 1, 0.01f, 0.001f)));
    EXPECT_NEAR(found.thickness, kThickness, 1e-5f);
    const auto outer = [&](int first, int last) {
        return std::count(found.polygons.begin() + first, found.polygons.begin() + last, true);
    };
    EXPECT_EQ(std::max(outer(0, 60), outer(60, 120)), 60);
    EXPECT_EQ(std::min(outer(0, 60), outer(60, 120)), 0);
}

TEST(OuterSide, WhatIsNoThicknessHasOneSide) {
    const MeshData sleeve = tube(kAround, kAlong, 0.08f, 0.5f);
    const MeshData ring = thick_sleeve(0.08f, true, 0.03f);       // too thick for cloth
    const MeshData narrow = tube(kAround, kAlong, 0.004f, 0.5f);  // lies on its own other side
    const MeshData lined =
        with_part(tube(kAround, 3 * kAlong, 0.2f, 2.0f), thick_sleeve(0.08f, true), {0, 0, 1});
    for (const MeshData& mesh : {sleeve, ring, narrow, lined}) {
        const OuterSide found = outer_side(build(mesh));
        EXPECT_EQ(found.thickness, 0.0f);
        EXPECT_EQ(std::ranges::count(found.polygons, true), std::ptrdiff_t(found.polygons.size()));
    }
}

// A scarf over a thick coat is cloth as well.
TEST(OuterSide, PartsWithoutAnInnerSideCount) {
    const MeshData both = with_part(thick_sleeve(0.08f, true), grid(4, 4, 0.02f), {0.0f, 0.0f, 0.3f});
    const OuterSide found = outer_side(build(both));
    const Index count = Index(found.polygons.size());
    EXPECT_GT(found.thickness, 0.0f);
    for (Index p = count - 16; p < count; ++p) EXPECT_TRUE(found.polygons[p]);
    EXPECT_EQ(std::ranges::count(found.polygons, true), kSide + 16);
}

}  // namespace
}  // namespace rumple::tests
