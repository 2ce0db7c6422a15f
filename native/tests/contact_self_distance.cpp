// SPDX-License-Identifier: GPL-3.0-or-later
// The distance of a cloth to itself, and that no layer of folds passes through it.
#include <gtest/gtest.h>

#include <numbers>

#include "surface/contact/self_distance.h"
#include "systems/wrinkle_mesh/layers.h"
#include "systems/wrinkle_mesh/pose.h"
#include "tests/refusals.h"
#include "tests/wrinkle_mesh_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_mesh;

constexpr Index kSide = 6;
constexpr float kEdge = 0.02f;
constexpr float kGap = 0.004f, kInfinity = std::numeric_limits<float>::infinity();

// Two square sheets that are one mesh, one above the other. The lower one's normals point up, the upper one's
// down, if they face; else both up.
MeshData two_sheets(float gap, bool facing) {
    MeshData mesh = grid(kSide, kSide, kEdge);
    const MeshData lower = mesh;
    const Index count = static_cast<Index>(lower.positions.size());
    for (const Vec3& p : lower.positions) mesh.positions.push_back(p + Vec3(0.0f, 0.0f, gap));
    for (size_t p = 0; p + 1 < lower.polygon_start.size(); ++p) {
        const Index* c = &lower.corner_vertex[lower.polygon_start[p]];
        if (facing) {
            mesh.add_polygon({c[0] + count, c[3] + count, c[2] + count, c[1] + count});
        } else {
            mesh.add_polygon({c[0] + count, c[1] + count, c[2] + count, c[3] + count});
        }
    }
    return mesh;
}

std::vector<SelfContactSide> sides_of(const MeshData& mesh, float reach) {
    std::vector<std::array<Index, 3>> triangles;
    for (size_t k = 0; k < mesh.triangle_corner.size(); k += 3) {
        std::array<Index, 3> t;
        for (int i = 0; i < 3; ++i) t[i] = mesh.corner_vertex[mesh.triangle_corner[k + i]];
        triangles.push_back(t);
    }
    const SelfContactMesh cloth(mesh.positions, triangles);
    return PosedSelfContactMesh(cloth, mesh.positions)
        .facing(std::vector<float>(mesh.positions.size(), reach));
}

// Of two sheets each vertex knows of the other one, across the gap.
void expect_the_gap(const std::vector<SelfContactSide>& sides, bool opposed) {
    for (size_t v = 0; v < sides.size(); ++v) {
        EXPECT_NEAR(sides[v].distance, kGap, kRounding);
        const float up = v < sides.size() / 2 ? 1.0f : -1.0f;
        EXPECT_LT(glm::distance(sides[v].towards, Vec3(0.0f, 0.0f, up)), 1e-4f);
        EXPECT_EQ(sides[v].in_any_direction, opposed ? sides[v].distance : kInfinity);
    }
}

TEST(SelfDistance, OfTwoSheetsIsTheGapBetweenThem) {
    expect_the_gap(sides_of(two_sheets(kGap, true), 2.0f * kGap), true);
    // Where they have passed each other it is the depth, so what crosses stays as it is.
    for (const SelfContactSide& side : sides_of(two_sheets(-kGap, true), 2.0f * kGap))
        EXPECT_NEAR(side.in_any_direction, kGap, kRounding);
}

TEST(SelfDistance, WhatIsFarOrFacesTheSameWayOrLiesAroundIsNothing) {
    MeshData joined = two_sheets(kGap, false);
    const Index other = static_cast<Index>(joined.positions.size()) / 2;
    joined.add_polygon({0, other, other + 1, 1});
    for (const auto& sides : {sides_of(two_sheets(kGap, true), 0.9f * kGap), sides_of(joined, 2.0f * kGap),
                              sides_of(grid(5, 5, 1.0f), 4.0f), sides_of(two_sheets(kGap, true), 0.0f)}) {
        for (const SelfContactSide& side : sides) EXPECT_EQ(side.towards, Vec3(0.0f));
    }
}

// A hem of a blouse sank into the skirt under it: they face the same way.
TEST(SelfDistance, OfAnotherPartCountsWhatFacesTheSameWay) {
    expect_the_gap(sides_of(two_sheets(kGap, false), 2.0f * kGap), false);
    // Where they touch they were cut apart.
    for (const SelfContactSide& side : sides_of(two_sheets(0.0f, false), kGap))
        EXPECT_EQ(side.towards, Vec3(0.0f));
}

TEST(SelfDistance, HeightsAreThoseOfTheTriangles) {
    // A square of side 1, cut along a diagonal: two heights of 1 where the right angles are not, and of half
    // the diagonal where they are.
    const std::vector<Vec3> p = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {9, 9, 9}};
    const SelfContactMesh cloth(p, {{0, 1, 2}, {0, 2, 3}});
    const auto heights = PosedSelfContactMesh(cloth, p).heights();
    const float half = 0.5f * std::numbers::sqrt2_v<float>;
    const float expected[] = {1.0f, half, 1.0f, half};
    for (int v = 0; v < 4; ++v) EXPECT_NEAR(heights[v], expected[v], kRounding);
    EXPECT_TRUE(std::isinf(heights[4]));
}

// A strip bent to a U, its two sides kGap apart, whose cloth is a tenth too long: folds of more than the gap.
struct U {
    static constexpr Index kAlong = 20, kAcross = 6;
    MeshData mesh = grid(kAlong, kAcross, kEdge);
    std::shared_ptr<const Layers> layers = build_layers(tests::build(mesh), 2, 0, 1'000'000);
    Pose3 pose;

    U() {
        const float turn = kEdge * 4.0f;  // length of the round end
        const float middle = 0.5f * kEdge * kAlong, radius = turn / std::numbers::pi_v<float>;
        for (const Vec3& p : mesh.positions) {
            const float s = p.x - middle;
            const float angle = std::clamp(s / (0.5f * turn), -1.0f, 1.0f) * 0.5f * std::numbers::pi_v<float>;
            const float left = std::max(std::abs(s) - 0.5f * turn, 0.0f);
            // The sides come together behind the end.
            const float narrow = left > 0.0f ? 0.5f * kGap / radius : 1.0f;
            pose.push_back(
                {0.9f * (radius * std::cos(angle) - left), 0.9f * p.y, narrow * radius * std::sin(angle)});
        }
    }
    std::vector<Settings> settings(float apart) const {
        Settings one;
        one.prestretch = 1.1f;
        one.inside = 1.0f;
        one.hem_rings = 1;
        one.apart = one.slide = apart;
        return std::vector<Settings>(layers->layers.size(), one);
    }
    LayersState solve(float apart, std::vector<Report>& reports, int threads = 0) const {
        auto all = settings(apart);
        for (Settings& s : all) s.threads = threads;
        const std::vector<Paint> paint(all.size());
        LayersState state = wrinkle_mesh::solve(*layers, all, paint, {pose}, nullptr, reports);
        for (int frame = 0; frame < 4; ++frame) {
            state = activated(state);
            state = wrinkle_mesh::solve(*layers, all, paint, {pose}, &state, reports);
        }
        return state;
    }
    // Sides of triangles of the finest layer that pass through triangles they share no vertex with.
    size_t crossings(const LayersState& state) const {
        const auto& triangles = layers->layers.back()->triangles;
        const Pose3& p = state.solved;
        size_t count = 0;
        for (const auto& s : triangles) {
            for (int k = 0; k < 3; ++k) {
                const Index from = s[k], to = s[(k + 1) % 3];
                if (from > to) continue;  // the triangle beside it has it the other way round
                for (const auto& t : triangles) count += passes(p, from, to, t);
            }
        }
        return count;
    }
    static bool passes(const Pose3& p, Index from, Index to, const std::array<Index, 3>& t) {
        for (const Index v : t)
            if (v == from || v == to) return false;
        const Vec3 a = p[t[0]], b = p[t[1]], c = p[t[2]], u = p[from], w = p[to];
        const Vec3 low = glm::min(a, glm::min(b, c)), high = glm::max(a, glm::max(b, c));
        for (int k = 0; k < 3; ++k)
            if (std::max(u[k], w[k]) < low[k] || std::min(u[k], w[k]) > high[k]) return false;
        const Vec3 n = glm::cross(b - a, c - a);
        const float hu = glm::dot(n, u - a), hw = glm::dot(n, w - a);
        if (hu * hw >= 0.0f) return false;
        const Vec3 x = u + (w - u) * (hu / (hu - hw));
        return glm::dot(n, glm::cross(b - a, x - a)) > 0.0f && glm::dot(n, glm::cross(c - b, x - b)) > 0.0f &&
               glm::dot(n, glm::cross(a - c, x - c)) > 0.0f;
    }
};

TEST(SelfDistance, TheSidesOfAUDoNotPassEachOther) {
    const U u;
    std::vector<Report> reports;
    EXPECT_GT(u.crossings(u.solve(0.0f, reports)), 100u);  // without the bound they do
    for (const Report& report : reports) EXPECT_EQ(report.kept_apart, 0);
    EXPECT_EQ(u.crossings(u.solve(0.45f, reports)), 0u);
    for (const Report& report : reports) EXPECT_GT(report.kept_apart, 0);
}

// In any direction, as in the paper.
TEST(SelfDistance, AVertexMovesAtMostByAShareOfTheGap) {
    const U u;
    constexpr float kShare = 0.3f;
    const auto settings = u.settings(kShare);
    const Model& drape = *u.layers->layers[0];
    const std::vector<Paint> paint(settings.size());
    std::vector<Report> reports;
    const LayersState state = wrinkle_mesh::solve(*u.layers, settings, paint, {u.pose}, nullptr, reports);
    const LayersState free =
        wrinkle_mesh::solve(*u.layers, u.settings(0.0f), paint, {u.pose}, nullptr, reports);
    const auto farthest = [&](const LayersState& solved) {
        const Input input{u.pose};
        const wrinkle_mesh::Pose pose = wrinkle_mesh::make_pose(drape, input);
        const wrinkle_mesh::OffsetFrames frames(drape, settings[0], input, pose);
        const std::vector<Vec3> positions =
            wrinkle_mesh::solved_positions(pose, frames.in_object(solved.layers[0]));
        float most = 0.0f;
        for (size_t v = 0; v < u.pose.size(); ++v) {
            const float s = u.mesh.positions[v].x - 0.5f * kEdge * U::kAlong;
            if (std::abs(s) < 4.0f * kEdge) continue;  // straight above one another
            most = std::max(most, glm::distance(positions[v], u.pose[v]));
        }
        return most;
    };
    EXPECT_LE(farthest(state), kShare * kGap + kRounding);
    EXPECT_GT(farthest(state), 0.99f * kShare * kGap);
    EXPECT_GT(farthest(free), kGap);
}

// Bounds that were projected one after the other, each breaking the one before, pushed held vertices a little
// in every frame: a held pose took more than half a second to rest.
TEST(SelfDistance, AHeldPoseRestsAtOnceThoughItsBoundsAreNew) {
    const U u;
    std::vector<Report> reports;
    const LayersState free = u.solve(0.0f, reports);
    const auto settings = u.settings(0.3f);
    const std::vector<Paint> paint(settings.size());
    // Held, but for the bounds that it was not solved with: each layer is pushed once, coarse first.
    LayersState state = free;
    for (size_t layer = 0; layer <= settings.size(); ++layer)
        state = wrinkle_mesh::solve(*u.layers, settings, paint, {u.pose}, &state, reports);
    EXPECT_FALSE(same_bits(free.layers[0].offset, state.layers[0].offset));
    const LayersState next = wrinkle_mesh::solve(*u.layers, settings, paint, {u.pose}, &state, reports);
    EXPECT_TRUE(same_bits(state.layers[0].offset, next.layers[0].offset));
}

TEST(SelfDistance, ThreadsAndRepetitionChangeNoBit) {
    const U u;
    std::vector<Report> reports;
    const LayersState one = u.solve(0.45f, reports, 1);
    for (const int threads : {1, 2, 3, 5}) {
        const LayersState other = u.solve(0.45f, reports, threads);
        EXPECT_TRUE(same_bits(one.solved, other.solved)) << threads;
    }
}

TEST(SelfDistance, SharesOutOfRangeAreNamed) {
    Settings settings;
    settings.apart = 0.6f;
    EXPECT_NE(refusal([&] { check(settings); }).find("apart"), std::string::npos);
    settings.apart = 0.0f;
    settings.slide = -0.1f;
    EXPECT_NE(refusal([&] { check(settings); }).find("slide"), std::string::npos);
}

}  // namespace
}  // namespace rumple::tests
