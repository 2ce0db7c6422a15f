// SPDX-License-Identifier: GPL-3.0-or-later
// Labels of triangles (Gillette 2015, section 4.1): stretches, costs and the cut.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "base/tolerances.h"
#include "surface/strain/labels.h"
#include "tests/meshes.h"

namespace rumple::tests {
namespace {

const FlatTriangle kRight{1.0f, 0.0f, 1.0f};

Stretch change(float compression, float stretch) {
    return {compression, stretch, {1.0f, 0.0f}, true};
}

// ---- stretch tensors

TEST(FlatTriangles, OfAShapeWithItselfIsOne) {
    for (const FlatTriangle& t : {kRight, FlatTriangle{0.03f, -0.01f, 0.002f}}) {
        const Stretch s = measure_stretch(t, t);
        EXPECT_NEAR(s.compression, 1.0f, 1e-6f);
        EXPECT_NEAR(s.stretch, 1.0f, 1e-6f);
        EXPECT_TRUE(s.defined);
    }
}

TEST(FlatTriangles, DoesNotSeeTurnsAndShifts) {
    const Vec3 a(1, 2, 3), b(1.5f, 2, 3), c(1, 2.25f, 3.5f), n = glm::normalize(Vec3(1, -2, 0.5f));
    const auto turned = [&](const Vec3& p) {
        return 0.5f * p + 0.5f * glm::dot(n, p) * n + 0.8660254f * glm::cross(n, p) +
               Vec3(0, 5, 0);  // Rodrigues, 60 degrees
    };
    const Stretch s = measure_stretch(flatten(a, b, c), flatten(turned(a), turned(b), turned(c)));
    EXPECT_NEAR(s.compression, 1.0f, 1e-5f);
    EXPECT_NEAR(s.stretch, 1.0f, 1e-5f);
}

// u1 = (1, 0) stays, u2 = (0, 1) is halved: compressed to half along y.
TEST(FlatTriangles, OfAHalvedHeightIsTwoAcross) {
    const Stretch s = measure_stretch(kRight, {1.0f, 0.0f, 0.5f});
    EXPECT_NEAR(s.compression, 2.0f, 1e-6f);
    EXPECT_NEAR(s.stretch, 1.0f, 1e-6f);
    EXPECT_NEAR(std::abs(s.direction.y), 1.0f, 1e-6f);
}

// F = [[1, 1], [0, 1]] shears: F^T F = [[1, 1], [1, 2]] has eigenvalues (3 +- sqrt 5) / 2, so U has the
// golden ratio and its inverse; the compressed direction in the current triangle is that of F F^T = [[2, 1],
// [1, 1]] for the smaller one, (1, -phi).
TEST(FlatTriangles, OfAShearIsTheGoldenRatio) {
    const float phi = 0.5f * (1.0f + std::sqrt(5.0f));
    const Stretch s = measure_stretch(kRight, {1.0f, 1.0f, 1.0f});
    EXPECT_NEAR(s.compression, phi, 1e-6f);
    EXPECT_NEAR(s.stretch, phi, 1e-6f);
    EXPECT_NEAR(s.direction.y / s.direction.x, -phi, 1e-5f);
}

TEST(FlatTriangles, OfATriangleWithoutAreaIsNotDefined) {
    const FlatTriangle none = flatten({0, 0, 0}, {1, 0, 0}, {2, 0, 0});
    EXPECT_FALSE(none.has_area());
    EXPECT_FALSE(measure_stretch(none, kRight).defined);
    EXPECT_FALSE(measure_stretch(kRight, none).defined);
    EXPECT_EQ(measure_stretch(kRight, none).compression, 1.0f);
    EXPECT_FALSE(flatten({1, 1, 1}, {1, 1, 1}, {1, 1, 1}).has_area());
}

TEST(FlatTriangles, HasNoEndWhereATriangleFoldsUp) {
    EXPECT_EQ(measure_stretch(kRight, {1.0f, 0.0f, 1e-5f}).compression, kMostCompression);
}

TEST(FlatTriangles, BetweenTwoShapesTurningDoesNotShrink) {
    // Lengths 1 and 3 mix to sqrt(5) half way: squares are mixed.
    const FlatTriangle half = between({1.0f, 0.0f, 1.0f}, {3.0f, 0.0f, 3.0f}, 0.5f);
    EXPECT_NEAR(half.x1, std::sqrt(5.0f), 1e-6f);
    EXPECT_NEAR(half.y2, std::sqrt(5.0f), 1e-6f);
    const FlatTriangle same = between(kRight, kRight, 0.3f);
    EXPECT_NEAR(same.x1, 1.0f, 1e-6f);
    EXPECT_NEAR(same.y2, 1.0f, 1e-6f);
    EXPECT_EQ(between({}, kRight, 0.3f).y2, 1.0f);
}

// ---- costs

TEST(LabelCosts, OfNoChangeAreZeroAtRestAndOneElsewhere) {
    const LabelCosts cost = label_costs(change(1.0f, 1.0f));
    EXPECT_NEAR(cost[kCompress], 1.0, 1e-9);
    EXPECT_NEAR(cost[kRest], 0.0, 1e-9);
    EXPECT_NEAR(cost[kStretch], 1.0, 1e-9);
}

// By hand: 1 - exp(-0.05^2 / (2 0.05^2)) = 1 - exp(-1/2) = 0.3935; (4.5): H = exp(-0.45) = 0.6376,
// h = exp(-4.5) = 0.0111, (H - h) exp(-0.0025 / 0.01) + h = 0.4990.
TEST(LabelCosts, OfFivePerCentOneWayAreTheThesis) {
    const LabelCosts cost = label_costs(change(1.05f, 1.0f));
    EXPECT_NEAR(cost[kRest], 0.39347, 1e-4);
    EXPECT_NEAR(cost[kCompress], 0.49903, 1e-4);
    EXPECT_LT(cost[kRest] + cost[kCompress], cost[kStretch]);
    const LabelCosts mirrored = label_costs(change(1.0f, 1.05f));
    EXPECT_NEAR(mirrored[kStretch], cost[kCompress], 1e-6);
}

// The printed equation 4.5 does not: for a = 1.2, b = 3 it is (3 / 1.2) (exp(-1.8) - 1) + 1 = -1.087.
TEST(LabelCosts, StayBetweenZeroAndOne) {
    for (float a = 1.0f; a < 4.0f; a += 0.07f) {
        for (float b = 1.0f; b < 4.0f; b += 0.07f) {
            for (const double cost : label_costs(change(a, b))) {
                EXPECT_GE(cost, 0.0) << a << ' ' << b;
                EXPECT_LE(cost, 1.0) << a << ' ' << b;
            }
        }
    }
}

TEST(LabelCosts, HaveNoStepWhereCompressionAndStretchAreEqual) {
    for (const float a : {1.0f, 1.05f, 1.5f, 3.0f}) {
        const double below = label_costs(change(a, a - 1e-5f))[kCompress];
        const double above = label_costs(change(a, a + 1e-5f))[kCompress];
        EXPECT_NEAR(below, above, 1e-3) << a;
    }
}

TEST(LabelCosts, OfCompressionFallAsItGrowsAndAsItDominates) {
    double last = 2.0;
    for (float a = 1.0f; a < 2.0f; a += 0.05f) {
        const double cost = label_costs(change(a, 1.0f))[kCompress];
        EXPECT_LT(cost, last);
        last = cost;
    }
    last = 0.0;
    for (float b = 1.0f; b < 3.0f; b += 0.05f) {
        const double cost = label_costs(change(1.2f, b))[kCompress];
        EXPECT_GE(cost, last) << b;
        last = cost;
    }
}

// ---- the cut

std::vector<LabelCosts> random_costs(size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<LabelCosts> costs(count);
    for (LabelCosts& cost : costs) {
        // Multiples of 2^-10: no capacity is rounded, so equal energies are equal.
        for (double& c : cost) c = double(random() % 1024) / 1024.0;
    }
    return costs;
}

Labels best_by_trying_all(const TriangleNet& net, const std::vector<LabelCosts>& costs, const Labels& before,
                          double& least) {
    Labels labels(costs.size(), 0), best;
    least = 1e30;
    size_t tries = 1;
    for (size_t i = 0; i < costs.size(); ++i) tries *= 3;
    for (size_t n = 0; n < tries; ++n) {
        size_t digits = n;
        for (std::uint8_t& l : labels) {
            l = std::uint8_t(digits % 3);
            digits /= 3;
        }
        const double energy = label_energy(net, costs, before, labels);
        if (energy < least) {
            least = energy;
            best = labels;
        }
    }
    return best;
}

TEST(LabelCut, IsTheBestOfAllLabelingsOfSmallGraphs) {
    struct Case {
        MeshData mesh;
        size_t frames;
    };
    const Case cases[] = {{grid(1, 1, 1.0f), 1},
                          {grid(2, 2, 1.0f), 1},
                          {grid(2, 1, 1.0f), 2},
                          {grid(1, 1, 1.0f), 4},
                          {tube(3, 1, 1.0f, 1.0f), 1}};
    for (const Case& c : cases) {
        const Surface surface = build(c.mesh);
        const TriangleNet net = build_net(surface);
        const size_t count = c.frames * size_t(net.triangles());
        ASSERT_LE(count, 8u);
        for (unsigned seed = 0; seed < 60; ++seed) {
            const std::vector<LabelCosts> costs = random_costs(count, seed);
            Labels before;
            if (seed % 2) {
                for (Index t = 0; t < net.triangles(); ++t)
                    before.push_back(std::uint8_t((seed / 2 + t) % 3));
            }
            double least = 0.0;
            best_by_trying_all(net, costs, before, least);
            const Labels labels = cut_labels(net, costs, before);
            EXPECT_NEAR(label_energy(net, costs, before, labels), least, 1e-4) << seed;
        }
    }
}

TEST(LabelCut, OverrulesOneTriangleAgainstItsNeighbours) {
    // A right triangle alone in rest, with two neighbours that are sure to be compressed: 0.4 against 0.3.
    const Surface surface = build(grid(2, 1, 1.0f));
    const TriangleNet net = build_net(surface);
    std::vector<LabelCosts> costs(4, LabelCosts{0.0, 1.0, 1.0});
    Index middle = kNone;  // a triangle with two neighbours
    for (Index t = 0; t < 4; ++t) {
        int neighbours = 0;
        for (Index k = 0; k < 3; ++k) neighbours += net.twin[3 * t + k] != kNone;
        if (neighbours == 2) middle = t;
    }
    ASSERT_NE(middle, kNone);
    costs[middle] = {0.3, 0.0, 1.0};
    EXPECT_EQ(cut_labels(net, costs, {}), Labels(4, kCompress));
    costs[middle] = {0.5, 0.0, 1.0};
    EXPECT_EQ(cut_labels(net, costs, {})[middle], kRest);
}

TEST(LabelCut, KeepsTheFormerLabelWhereTheCostsAreNearlyEven) {
    const Surface surface = build(grid(1, 1, 1.0f));
    const TriangleNet net = build_net(surface);
    const std::vector<LabelCosts> costs(2, LabelCosts{0.1, 0.0, 1.0});
    EXPECT_EQ(cut_labels(net, costs, {}), Labels(2, kRest));
    EXPECT_EQ(cut_labels(net, costs, Labels(2, kCompress)), Labels(2, kCompress));
}

TEST(LabelCut, DoesNotDependOnTheOrderOfTriangles) {
    // Even costs: every labeling without a step is optimal, so an order would show.
    const MeshData mesh = grid(4, 4, 1.0f);
    const Surface surface = build(mesh);
    const TriangleNet net = build_net(surface);
    std::vector<LabelCosts> costs = random_costs(size_t(net.triangles()), 5);
    for (size_t i = 0; i < costs.size(); i += 2) costs[i] = {0.25, 0.25, 0.25};
    const Labels labels = cut_labels(net, costs, {});

    MeshData turned = mesh;  // the same faces, the last one first
    turned.corner_vertex.clear();
    turned.polygon_start = {0};
    turned.triangle_corner.clear();
    for (Index p = Index(mesh.polygon_start.size()) - 2; p >= 0; --p) {
        const Index* v = &mesh.corner_vertex[mesh.polygon_start[p]];
        turned.add_polygon({v[0], v[1], v[2], v[3]});
    }
    const auto counterpart = [&](size_t i) { return 2 * (costs.size() / 2 - 1 - i / 2) + i % 2; };
    std::vector<LabelCosts> turned_costs(costs.size());
    for (size_t i = 0; i < costs.size(); ++i) turned_costs[counterpart(i)] = costs[i];
    const Labels turned_labels = cut_labels(build_net(build(turned)), turned_costs, {});
    for (size_t i = 0; i < labels.size(); ++i) EXPECT_EQ(turned_labels[counterpart(i)], labels[i]) << i;
}

// Costs that change slowly, as those of a clip do. Pieces see far enough ahead to give the labels of one cut.
TEST(LabelCut, OfALongClipInPiecesIsThatOfOneCut) {
    const Surface surface = build(grid(2, 2, 1.0f));
    const TriangleNet net = build_net(surface);
    const size_t triangles = size_t(net.triangles()), frames = 400;
    std::vector<LabelCosts> costs;
    for (size_t f = 0; f < frames; ++f) {
        for (size_t t = 0; t < triangles; ++t) {
            const double x = 0.5 + 0.5 * std::sin(0.11 * double(f) + 0.7 * double(t));
            costs.push_back({x, 0.3 + 0.2 * std::cos(0.05 * double(f)), 1.0 - x});
        }
    }
    const Labels whole = cut_labels(net, costs, {});
    for (const std::uint8_t label : {kCompress, kRest, kStretch})
        EXPECT_GT(std::count(whole.begin(), whole.end(), label), 100);
    for (const size_t most : {0, 70, 170})  // frames; never less than twice the look ahead
        EXPECT_EQ(cut_clip(net, costs, most * triangles), whole) << most;
}

// ---- the net

TEST(TriangleNet, TwinsRunBackAndBordersHaveNone) {
    for (const MeshData& mesh : {grid(3, 2, 1.0f), tube(5, 3, 1.0f, 1.0f), cube(), seam_split_cube()}) {
        const Surface surface = build(mesh);
        const TriangleNet net = build_net(surface);
        size_t borders = 0;
        for (Index h = 0; h < Index(net.twin.size()); ++h) {
            const Index twin = net.twin[h];
            if (twin == kNone) {
                ++borders;
                continue;
            }
            EXPECT_EQ(net.twin[twin], h);
            EXPECT_NE(triangle_of(twin), triangle_of(h));
            EXPECT_EQ(net.vertex[twin], net.vertex[next_in_triangle(h)]);
            EXPECT_EQ(net.vertex[h], net.vertex[next_in_triangle(twin)]);
        }
        size_t expected = 0;
        for (const Edge& e : surface.edges) expected += e.right == kNone;
        EXPECT_EQ(borders, expected);
    }
}

}  // namespace
}  // namespace rumple::tests
