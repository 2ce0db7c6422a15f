// SPDX-License-Identifier: GPL-3.0-or-later
// The base cloth in cases that are worked out by hand: figures 6 and 7 of Mueller and Chentanez 2010, a strip
// that hangs, a sheet that floats.
#include <gtest/gtest.h>

#include "tests/base_cloth_rig.h"

namespace rumple::tests {
namespace {

using namespace base_cloth;

Settings nothing_but_springs() {
    Settings settings;
    settings.gravity = Vec3(0.0f);
    settings.smoothing = 0.0f;
    settings.shear = 0.0f;
    settings.room = 10.0f;  // the pull back does not grow
    settings.start_steps = 60;
    settings.most_cg_iterations = 200;
    return settings;
}

// ---------------------------------------------------------------- figure 6
// One equilateral triangle of side L, animated to the size f L. By symmetry it comes to rest as an
// equilateral triangle of side l. Its area A is on its three sides, 2 A / 3 on each: the weight of a side is
// w = 2 A / (3 L^2). A corner has an area of A / 3 and is (f L - l) / sqrt 3 from its animated place. Two
// sides pull it inwards, each by w T(l) cos 30:  sqrt 3 w T(l) = A / 3 F (f L - l) / sqrt 3, or  T(l) = F L^2
// / 6 (f L - l).
constexpr float kSide = 0.2f;

MeshData triangle_of_side(float side) {
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {side, 0, 0}, {0.5f * side, side * std::sqrt(0.75f), 0}};
    mesh.add_polygon({0, 1, 2});
    return mesh;
}

float side_at_rest(const Settings& settings, float factor) {
    const Garment garment(triangle_of_side(kSide));
    const Result result = garment.solve(settings, garment.moved([&](const Vec3& p) { return factor * p; }));
    const float a = glm::distance(result.positions[0], result.positions[1]);
    EXPECT_NEAR(glm::distance(result.positions[1], result.positions[2]), a, 1e-5f);
    EXPECT_NEAR(glm::distance(result.positions[2], result.positions[0]), a, 1e-5f);
    EXPECT_NEAR(result.positions[2].z, 0.0f, 1e-6f);
    return a;
}

// Where lines cross: T(l) = offset + slope (l - from) against the pull q (f L - l).
double balance(double offset, double slope, double from, double q, double animated) {
    return (q * animated + slope * from - offset) / (q + slope);
}

Settings two_stiffnesses() {
    Settings settings = nothing_but_springs();
    settings.stretch = 5.0f;
    settings.strain_limit = 10.0f;
    settings.compression = 0.5f;
    settings.compression_limit = 0.8f;
    settings.folded = 8.0f;
    settings.follow = 300.0f;
    return settings;
}

TEST(BaseClothExact, ALongerSideIsPulledByTheStretch) {
    const Settings s = two_stiffnesses();
    const double q = s.follow * kSide * kSide / 6.0;
    for (const float factor : {1.02f, 1.2f, 1.5f}) {
        const double l = balance(0.0, s.stretch, kSide, q, factor * kSide);
        ASSERT_GT(l, kSide);
        EXPECT_NEAR(side_at_rest(s, factor), l, 2e-5) << factor;
    }
}

TEST(BaseClothExact, BeyondTheStrainLimitItIsTenTimesAsStiff) {
    Settings s = two_stiffnesses();
    s.strain_limit = 0.1f;
    const double q = s.follow * kSide * kSide / 6.0;
    const double l = balance(s.stretch * 0.1 * kSide, 10.0 * s.stretch, 1.1 * kSide, q, 2.0 * kSide);
    ASSERT_GT(l, 1.1 * kSide);
    EXPECT_NEAR(side_at_rest(s, 2.0f), l, 2e-5);
}

TEST(BaseClothExact, AShorterSideIsPushedByK1) {
    const Settings s = two_stiffnesses();
    const double q = s.follow * kSide * kSide / 6.0;
    for (const float factor : {0.98f, 0.9f, 0.8f}) {
        const double l = balance(0.0, s.compression, kSide, q, factor * kSide);
        ASSERT_LT(l, kSide);
        ASSERT_GT(l, s.compression_limit * kSide);
        EXPECT_NEAR(side_at_rest(s, factor), l, 2e-5) << factor;
    }
}

TEST(BaseClothExact, BelowTheCompressionLimitItIsPushedByK2) {
    const Settings s = two_stiffnesses();
    const double q = s.follow * kSide * kSide / 6.0, limit = s.compression_limit * kSide;
    for (const float factor : {0.7f, 0.5f, 0.3f}) {
        const double l = balance(s.compression * (limit - kSide), s.folded, limit, q, factor * kSide);
        ASSERT_LT(l, limit);
        EXPECT_NEAR(side_at_rest(s, factor), l, 2e-5) << factor;
    }
}

// A triangle has no curvature.
TEST(BaseClothExact, FlatClothIsPushedByItsShare) {
    Settings s = two_stiffnesses();
    s.flat_share = 0.25f;
    const double q = s.follow * kSide * kSide / 6.0, limit = s.compression_limit * kSide;
    EXPECT_NEAR(side_at_rest(s, 0.9f), balance(0.0, 0.25 * s.compression, kSide, q, 0.9 * kSide), 2e-5);
    const double k1 = 0.25 * s.compression, k2 = 0.25 * s.folded;
    EXPECT_NEAR(side_at_rest(s, 0.5f), balance(k1 * (limit - kSide), k2, limit, q, 0.5 * kSide), 2e-5);
    EXPECT_NEAR(side_at_rest(s, 1.2f), balance(0.0, s.stretch, kSide, q, 1.2 * kSide), 2e-5);
}

// A garment is cut wider around the body, not longer on it: sides at 0 and 60 degrees to the hang.
TEST(BaseClothExact, AlongTheHangThereIsNoSlack) {
    Settings s = two_stiffnesses();
    s.follow = 1e-3f;
    s.slack = 1.1f;
    const Garment garment(triangle_of_side(kSide));
    for (const float much : {0.0f, 0.5f, 1.0f}) {
        s.hang = {much, 0.0f, 0.0f};
        const Points x = garment.solve(s, garment.mesh.positions).positions;
        EXPECT_NEAR(glm::distance(x[0], x[1]), (1.0f + 0.1f * (1.0f - much * much)) * kSide, 2e-5f);
        EXPECT_NEAR(glm::distance(x[1], x[2]), (1.0f + 0.1f * (1.0f - 0.25f * much * much)) * kSide, 2e-5f);
    }
}

TEST(BaseClothExact, SlackShiftsTheRestLength) {
    Settings s = two_stiffnesses();
    const double q = s.follow * kSide * kSide / 6.0;
    for (const float slack : {0.9f, 1.0f, 1.15f}) {
        s.slack = slack;
        EXPECT_NEAR(side_at_rest(s, slack), slack * kSide, 1e-5) << slack;
        const double rest = double(slack) * kSide, limit = s.compression_limit * rest;
        EXPECT_NEAR(side_at_rest(s, 1.4f), balance(0.0, s.stretch, rest, q, 1.4f * kSide), 2e-5);
        const float shorter = 0.9f * slack;
        EXPECT_NEAR(side_at_rest(s, shorter), balance(0.0, s.compression, rest, q, shorter * kSide), 2e-5);
        EXPECT_NEAR(side_at_rest(s, 0.4f),
                    balance(s.compression * (limit - rest), s.folded, limit, q, 0.4f * kSide), 2e-5);
    }
}

// Smoothing is against turning: sides that keep their direction become as long as without it.
TEST(BaseClothExact, SmoothingKeepsNoLength) {
    Settings s = two_stiffnesses();
    s.smoothing = 30.0f;
    const double q = s.follow * kSide * kSide / 6.0;
    EXPECT_NEAR(side_at_rest(s, 1.3f), balance(0.0, s.stretch, kSide, q, 1.3f * kSide), 2e-5);
    EXPECT_NEAR(side_at_rest(s, 0.9f), balance(0.0, s.compression, kSide, q, 0.9f * kSide), 2e-5);
}

// ---------------------------------------------------------------- hanging
// A strip one square wide. Every square of the area A = L^2 has A / 2 on each of its sides along the strip: w
// = 1/2. Its diagonal gives two triangles' thirds to the corners that it joins, and one to each of the
// others.
TEST(BaseClothExact, AHangingStripStretchesByTheWeightBelow) {
    constexpr Index kSquares = 8;
    constexpr float kLength = 0.05f;
    const MeshData mesh = grid(1, kSquares, kLength);
    const Garment garment(mesh);
    Points hanging = mesh.positions;
    for (Vec3& p : hanging) p = {p.x, 0.0f, -p.y};
    Settings s = nothing_but_springs();
    s.gravity = {0.0f, 0.0f, -9.81f};
    s.follow = 1.0f;
    s.stretch = 30.0f;
    s.strain_limit = 10.0f;
    Paint paint;
    for (Index v = 0; v < 2 * (kSquares + 1); ++v) paint.follow.push_back(v < 2 ? 1.0f : 0.0f);
    const Result result = garment.solve(s, hanging, nullptr, paint);
    const double area = double(kLength) * kLength;
    for (Index side = 0; side < 2; ++side) {
        // From below: the last corner has a third of a triangle or of two, every other one half a square.
        double below = side == 0 ? area / 6.0 : area / 3.0;
        for (Index j = kSquares; j > 0; --j, below += area / 2.0) {
            const Index lower = 2 * j + side, upper = lower - 2;
            const double longer =
                glm::distance(result.positions[lower], result.positions[upper]) - double(kLength);
            const double expected = 9.81 * below / (0.5 * s.stretch);
            EXPECT_NEAR(longer, expected, 0.005 * expected + 1e-6) << "side " << side << ", square " << j;
        }
    }
    // The pins hold it all: by 160 millions / s^2, on the area of the two corners.
    const double sunk[2] = {hanging[0].z - result.positions[0].z, hanging[1].z - result.positions[1].z};
    const double expected = 9.81 * area * kSquares / 1.6e8;
    EXPECT_NEAR(area / 3.0 * sunk[0] + area / 6.0 * sunk[1], expected, 0.01 * expected);
}

// d (1 + 15 (d / R)^4) = g / F.
double sunk(double gravity_over_follow, double room) {
    double d = 0.0;
    for (int i = 0; i < 400; ++i)
        d += 0.1 * (gravity_over_follow - d * (1.0 + 15.0 * std::pow(d / room, 4.0)));
    return d;
}

// Every vertex alike: gravity against the pull back, that grows towards the edge of the room.
TEST(BaseClothExact, AFloatingSheetSinksByGravityOverFollow) {
    const MeshData mesh = grid(5, 4, 0.05f);
    const Garment garment(mesh);
    Settings s;
    s.clearance.unknown = 1.0f;
    s.start_steps = 60;
    s.room = 0.1f;
    s.follow = 120.0f;
    const Result result = garment.solve(s, mesh.positions);
    const double d = sunk(9.81 / s.follow, s.room);
    for (size_t v = 0; v < mesh.positions.size(); ++v)
        EXPECT_LT(glm::distance(result.positions[v], mesh.positions[v] - Vec3(0, 0, d)), 2e-5f);
}

// With four times the room: the pull back is a fourth, and nothing stands below it.
TEST(BaseClothExact, WhatHangsFreeSinksFarther) {
    const MeshData mesh = grid(5, 4, 0.05f);
    const Garment garment(mesh);
    Settings s;
    s.start_steps = 60;
    s.room = 0.1f;
    s.follow = 120.0f;
    Paint paint;
    paint.room.assign(mesh.positions.size(), 4.0f);
    const Result result = garment.solve(s, mesh.positions, nullptr, paint);
    const double d = sunk(4.0 * 9.81 / s.follow, 4.0 * s.room);
    EXPECT_GT(d, 0.15);
    for (size_t v = 0; v < mesh.positions.size(); ++v)
        EXPECT_LT(glm::distance(result.positions[v], mesh.positions[v] - Vec3(0, 0, d)), 5e-5f);
}

// Along the surface, where a way counts by the share s = room over slide: d (1 + 15 s^2 (s d / R)^4) = g / F.
TEST(BaseClothExact, ASheetSlidesFartherThanItsRoom) {
    const MeshData mesh = grid(5, 4, 0.05f);
    const Garment garment(mesh);
    Settings s;
    s.start_steps = 60;
    s.room = 0.02f;
    s.slide_room = 0.08f;
    s.follow = 150.0f;
    s.gravity = Vec3(9.81f, 0.0f, 0.0f);
    const Result result = garment.solve(s, mesh.positions);
    double d = 0.0;
    const double share = 0.25, pull = 9.81 / 150.0;
    for (int i = 0; i < 500; ++i)
        d += 0.1 * (pull - d * (1.0 + 15.0 * share * share * std::pow(share * d / 0.02, 4.0)));
    EXPECT_GT(d, 0.04);
    for (size_t v = 0; v < mesh.positions.size(); ++v)
        EXPECT_LT(glm::distance(result.positions[v], mesh.positions[v] + Vec3(d, 0, 0)), 2e-5f);
    s.slide_room = 0.08f;  // counts for nothing where there is no room at all
    s.room = 0.0f;
    EXPECT_EQ(farthest(garment.solve(s, mesh.positions).positions, mesh.positions), 0.0f);
}

// Vertices without room were free while the others were solved, and put back at the end.
TEST(BaseClothExact, WhatHasNoRoomHoldsLikeAPin) {
    const MeshData mesh = grid(6, 5, 0.05f);
    const Garment garment(mesh);
    Settings s;
    s.gravity = Vec3(0.0f, 0.0f, -9.81f);
    Paint no_room, pinned;
    for (const Vec3& p : mesh.positions) {
        no_room.room.push_back(p.x < 0.12f ? 0.0f : 1.0f);
        pinned.follow.push_back(p.x < 0.12f ? 1.0f : 0.0f);
    }
    Result held, as_pinned;
    garment.settle(s, mesh.positions, held, no_room);
    garment.settle(s, mesh.positions, as_pinned, pinned);
    EXPECT_LT(farthest(held.positions, as_pinned.positions), 1e-5f);
    EXPECT_GT(farthest(held.positions, mesh.positions), 0.002f);
}

// A sheet on a slope of the angle a, every vertex alike. It is pressed on by N = g cos a, less what the pull
// back carries, and slides by d: F d (1 + 15 (d / R)^4) + mu N f(d) = g sin a, f(d) = (2 - d / e) d / e up to
// e, a sixth of the room R, and 1 beyond.
TEST(BaseClothExact, FrictionHoldsASheetOnASlope) {
    const MeshData mesh = grid(5, 4, 0.05f);
    const Garment garment(mesh);
    Settings s;
    s.start_steps = 60;
    s.room = 0.12f;
    s.follow = 100.0f;
    s.clearance.unknown = 0.0f;  // it lies on what is worn under it
    const auto slid = [&](double angle, double coefficient) {
        s.friction = float(coefficient);
        s.gravity = Vec3(9.81 * std::sin(angle), 0.0, -9.81 * std::cos(angle));
        Result result;
        EXPECT_GT(garment.settle(s, mesh.positions, result), 0);
        for (size_t v = 0; v < mesh.positions.size(); ++v)
            EXPECT_NEAR(result.positions[v].x - mesh.positions[v].x, result.positions[0].x, 1e-5f);
        return double(result.positions[0].x - mesh.positions[0].x);
    };
    const auto expected = [&](double angle, double coefficient) {
        const double edge = 0.02;
        double d = 0.0;
        for (int i = 0; i < 4000; ++i) {
            const double wall = 1.0 + 15.0 * std::pow(d / 0.12, 4.0),
                         f = d < edge ? (2.0 - d / edge) * d / edge : 1.0;
            const double pressed = 9.81 * std::cos(angle) * 2e4 / (2e4 + 100.0 * wall);
            d += 5e-4 * (9.81 * std::sin(angle) - 100.0 * d * wall - coefficient * pressed * f);
        }
        return d;
    };
    for (const double coefficient : {0.0, 0.3, 0.8}) {
        for (const double angle : {0.2, 0.6, 1.2})
            EXPECT_NEAR(slid(angle, coefficient), expected(angle, coefficient), 2e-4) << angle << coefficient;
    }
    EXPECT_LT(expected(0.6, 0.8), 0.4 * expected(0.6, 0.0));  // else friction would hold nothing
}

// ---------------------------------------------------------------- figure 7
// A strip that its two ends squeeze, a little bent so that it may buckle.
TEST(BaseClothExact, WeakCompressionIsCompressedWhereStiffBuckles) {
    const MeshData mesh = grid(20, 4, 0.02f);
    const Garment garment(mesh);
    Points squeezed = mesh.positions;
    Paint paint;
    for (Vec3& p : squeezed) {
        paint.follow.push_back(p.x < 0.03f || p.x > 0.37f ? 1.0f : 0.0f);
        p.z = 0.001f * std::sin(std::numbers::pi_v<float> * p.x / 0.4f);
        p.x *= 0.9f;
    }
    Settings s;
    s.gravity = Vec3(0.0f);
    s.smoothing = 1.0f;  // 30 holds against buckling, too
    s.room = 0.2f;
    s.clearance.unknown = 1.0f;
    struct Look {
        float shortening, height;
    };
    const auto look = [&](float compression) {
        s.compression = compression;
        Result result;
        garment.settle(s, squeezed, result, paint, nullptr, 100);
        Look out{0.0f, 0.0f};
        for (Index i = 0; i < 20; ++i)
            out.shortening +=
                1.0f - glm::distance(result.positions[42 + i], result.positions[43 + i]) / 0.02f;
        out.shortening /= 20.0f;
        for (const Vec3& p : result.positions) out.height = std::max(out.height, std::abs(p.z));
        return out;
    };
    const Look weak = look(1.0f), stiff = look(200.0f);
    EXPECT_NEAR(weak.shortening, 0.1f, 0.005f);
    EXPECT_LT(weak.height, 0.0015f);
    EXPECT_LT(stiff.shortening, 0.02f);
    EXPECT_GT(stiff.height,
              0.004f);  // nothing resists bending: a zigzag of squares of 2 cm, half of 2 cm sin 26
}

}  // namespace
}  // namespace rumple::tests
