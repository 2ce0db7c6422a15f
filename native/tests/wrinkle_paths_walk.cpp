// SPDX-License-Identifier: GPL-3.0-or-later
// Walks of the Wrinkle Paths over triangles (Gillette 2015, section 5.1), worked by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/tolerances.h"
#include "tests/wrinkle_paths_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_paths;

TEST(PathWalk, RunsStraightToTheHem) {
    const Squeezed sheet;
    WalkLimits limits;
    limits.compression = 1.5f;
    limits.length = 100.0f;
    // Up at x = 0.8 of edges 0.5 wide: by hand it crosses diagonals and rungs at y = 1.6, 2, 2.6, 3, 3.6 and
    // ends at 4.
    const std::vector<Vec3> points = sheet.walk_from({0.8f, 1.2f, 0.0f}, {0, 1, 0}, limits);
    const float heights[] = {1.6f, 2.0f, 2.6f, 3.0f, 3.6f, 4.0f};
    ASSERT_EQ(points.size(), 6u);
    for (size_t i = 0; i < points.size(); ++i)
        EXPECT_LT(glm::distance(points[i], Vec3(0.8f, heights[i], 0.0f)), 1e-5f) << i;
}

TEST(PathWalk, EndsWithinATriangleWhenItsLengthIsUsedUp) {
    const Squeezed sheet;
    WalkLimits limits;
    limits.compression = 1.5f;
    limits.length = 1.0f;
    const std::vector<Vec3> points = sheet.walk_from({0.8f, 1.2f, 0.0f}, {0, 1, 0}, limits);
    ASSERT_EQ(points.size(), 3u);
    EXPECT_LT(glm::distance(points.back(), Vec3(0.8f, 2.2f, 0.0f)), 1e-5f);
}

TEST(PathWalk, EndsAtTheEdgeOfLessCompression) {
    Squeezed sheet;
    for (Index t = 16; t < 32; ++t) sheet.context.compression[t] = 1.0f;  // the upper two rows
    WalkLimits limits;
    limits.compression = 1.5f;
    limits.length = 100.0f;
    const std::vector<Vec3> points = sheet.walk_from({0.8f, 1.2f, 0.0f}, {0, 1, 0}, limits);
    ASSERT_EQ(points.size(), 2u);
    EXPECT_LT(glm::distance(points.back(), Vec3(0.8f, 2.0f, 0.0f)), 1e-5f);
}

TEST(PathWalk, EndsWhereItMeetsAnother) {
    const Squeezed sheet;
    const Index t =
        sheet.triangle_at({0.95f, 2.1f, 0.0f});  // crossed from (0.5, 2) .. at y = 2.06 above x = 0.8
    ASSERT_NE(t, kNone);
    SegmentMap map(sheet.context);
    map.add({inside(sheet.context, t, sheet.context.to_flat(t, {0.6f, 2.06f, 0.0f})),
             inside(sheet.context, t, sheet.context.to_flat(t, {0.95f, 2.06f, 0.0f}))});
    WalkLimits limits;
    limits.compression = 1.5f;
    limits.length = 100.0f;
    limits.others = &map;
    const std::vector<Vec3> points = sheet.walk_from({0.8f, 1.2f, 0.0f}, {0, 1, 0}, limits);
    EXPECT_LT(glm::distance(points.back(), Vec3(0.8f, 2.06f, 0.0f)), 1e-5f);
}

TEST(PathWalk, TurnsWithTheCompressionOverAFoldedEdge) {
    // The same sheet folded up by 90 degrees at y = 2: the fold goes on up the wall.
    PathCloth cloth(grid(4, 4, 1.0f));
    Pose3 folded = cloth.squeezed(0.5f);
    for (Vec3& p : folded) {
        if (p.y > 2.0f) p = Vec3(p.x, 2.0f, p.y - 2.0f);
    }
    const Pose pose = make_pose(*cloth.model, folded);
    const PathContext context = make_context(*cloth.model, cloth.settings, {}, pose, pose.base.shapes,
                                             cloth.model->triangles.rest, std::vector<Stretch>(32));
    WalkLimits limits;
    limits.compression = 1.5f;
    limits.length = 100.0f;
    const Index t = 18;  // the lower right triangle of face (1, 2), whose corner 0 is (0.5, 2)
    ASSERT_LT(glm::distance(context.vertex(3 * t), Vec3(0.5f, 2.0f, 0.0f)), 1e-6f);
    std::vector<Index> visited{t};
    const glm::dvec2 at = context.to_flat(t, {0.8f, 2.0f, 0.1f}), up = context.to_flat(t, {0.8f, 2.0f, 1.1f});
    const auto ends = positions(context, walk(context, t, at, up - at, limits, visited).points);
    EXPECT_LT(glm::distance(ends.back(), Vec3(0.8f, 2.0f, 2.0f)), 1e-5f);
    visited = {t};
    const auto down = positions(context, walk(context, t, at, at - up, limits, visited).points);
    EXPECT_LT(glm::distance(down.back(), Vec3(0.8f, 0.0f, 0.0f)), 1e-5f);
}

TEST(PathWalk, ReversedTwiceIsTheSamePath) {
    const Squeezed sheet;
    const State state = sheet.solve(sheet.squeezed(0.5f));
    ASSERT_FALSE(state.paths.empty());
    const std::vector<PathPoint> back = reversed(*sheet.model, state.paths[0].points);
    EXPECT_EQ(validate(*sheet.model, {{0, 1.0f, back}}), "");
    std::vector<Vec3> there = positions(sheet.context, state.paths[0].points),
                      again = positions(sheet.context, back);
    std::reverse(again.begin(), again.end());
    for (size_t i = 0; i < there.size(); ++i) EXPECT_LT(glm::distance(there[i], again[i]), 1e-6f);
}

// Compression that points to one place in the middle: at right angles to it a path would run round in a ring.
TEST(PathWalk, EndsWhenItHasTurnedTooFar) {
    PathCloth cloth(shaken(triangulated(grid(20, 20, 0.03f)), 0.003f, 4));
    for (Vec3& p : cloth.mesh.positions) p.z = 0.0f;
    cloth = PathCloth(cloth.mesh);
    const Vec3 middle(0.3f, 0.3f, 0.0f);
    const Pose pose = make_pose(*cloth.model, cloth.mesh.positions);
    PathContext context{{{*cloth.model, pose}, std::vector<float>(800, 2.0f)}};
    for (Index t = 0; t < 800; ++t) {
        const Vec3 centre =
            (context.vertex(3 * t) + context.vertex(3 * t + 1) + context.vertex(3 * t + 2)) / 3.0f;
        const Vec3 towards = pose.frames[t].to_local(glm::normalize(middle - centre));
        context.stretch.push_back({2.0f, 1.0f, Vec2(towards), true});
    }
    WalkLimits limits;
    limits.compression = 1.5f;
    limits.length = 10.0f;
    const Index t = 20 * 2 * 10 + 26;  // right of the middle
    std::vector<Index> visited{t};
    const Vec3 start = (context.vertex(3 * t) + context.vertex(3 * t + 1) + context.vertex(3 * t + 2)) / 3.0f;
    const glm::dvec2 at = context.to_flat(t, start), up = context.to_flat(t, start + Vec3(0, 1, 0));
    const Walk found = walk(context, t, at, up - at, limits, visited);
    EXPECT_NEAR(std::abs(found.turned), kMostTurn, 0.5);
    std::vector<PathPoint> points = found.points;
    points.insert(points.begin(), inside(context, t, at));
    EXPECT_EQ(validate(*cloth.model, {{0, 1.0f, points}}), "");
    EXPECT_LT(std::abs(turning(context, points)), kMostTurn + 0.3);
    EXPECT_GT(std::abs(turning(context, points)), kMostTurn - 0.6);
    // The other way round it turns to the other side by as much.
    EXPECT_NEAR(turning(context, reversed(*cloth.model, points)), -turning(context, points), 1e-4);
}

TEST(PathFault, NamesWhatIsWrong) {
    const Squeezed sheet;
    const State state = sheet.solve(sheet.squeezed(0.5f));
    ASSERT_GT(state.paths[0].points.size(), 3u);
    const auto says = [&](auto&& spoil) {
        std::vector<Path> paths = state.paths;
        spoil(paths[0].points);
        return validate(*sheet.model, paths);
    };
    EXPECT_EQ(says([](auto&) {}), "");
    EXPECT_NE(says([](auto& p) { p[1].at.x = 1.5f; }).find("point 1: beyond its edge"), std::string::npos);
    EXPECT_NE(says([](auto& p) { p[1].at.y = std::nanf(""); }).find("point 1: not finite"),
              std::string::npos);
    EXPECT_NE(says([](auto& p) { p[0].at = {0.7f, 0.7f}; }).find("point 0: outside"), std::string::npos);
    EXPECT_NE(says([](auto& p) { p[1].triangle = 99; }).find("in no triangle"), std::string::npos);
    EXPECT_NE(says([](auto& p) { p.erase(p.begin() + 1); }).find("another triangle"), std::string::npos);
    EXPECT_NE(says([](auto& p) { p.resize(1); }).find("alone"), std::string::npos);
    EXPECT_NE(says([](auto& p) { p[2].edge = kNone; }).find("point 2: not on an edge"), std::string::npos);
}

}  // namespace
}  // namespace rumple::tests
