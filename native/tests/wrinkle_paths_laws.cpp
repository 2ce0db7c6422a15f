// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of the Wrinkle Paths: what holds for every cloth and every motion.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "tests/wrinkle_paths_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_paths;

// Squeezed to 1 / 1.5 along x within `seconds`, then held.
auto squeeze(const PathCloth& cloth, double seconds = 0.5, float to = 1.0f / 1.5f) {
    return [&cloth, seconds, to](double t) {
        return cloth.squeezed(1.0f + (to - 1.0f) * float(std::min(t / seconds, 1.0)));
    };
}

auto bend(const PathCloth& cloth, float length, double seconds = 0.5, float angle = 2.0f) {
    return [&cloth, length, seconds, angle](double t) {
        return cloth.bent(angle * float(std::min(t / seconds, 1.0)), length);
    };
}

PathCloth sleeve() {
    PathCloth cloth(shaken(triangulated(tube(16, 14, 0.06f, 0.5f)), 0.004f, 3));
    return cloth;
}

TEST(WrinklePaths, AtRestThereAreNone) {
    for (const Reference reference : {Reference::kRestPose, Reference::kFirstFrame, Reference::kStaticRest}) {
        PathCloth cloth = sleeve();
        cloth.settings.rest.reference = reference;
        const State state = cloth.play(0.3, [&](double) { return cloth.mesh.positions; });
        EXPECT_TRUE(state.paths.empty());
        for (const std::uint8_t label : state.reference.labels) EXPECT_EQ(label, kRest);
    }
}

TEST(WrinklePaths, LieOnTheSurfaceInEveryFrameOfAWildMotion) {
    PathCloth cloth = sleeve();
    std::mt19937 random(7);
    size_t most = 0;
    State state = cloth.solve(cloth.mesh.positions);
    for (int f = 0; f < 90; ++f) {
        Pose3 pose = cloth.bent(1.4f + std::sin(0.21f * float(f)) * 1.2f, 0.5f);
        for (Vec3& p : pose) {
            p.x *= 0.9f + 0.1f * std::cos(0.5f * float(f));
            for (int c = 0; c < 3; ++c) p[c] += 0.004f * (float(random() % 2001) / 1000.0f - 1.0f);
        }
        state = cloth.solve(pose, &state);
        ASSERT_EQ(cloth.validate(state), "") << "frame " << f;
        most = std::max(most, state.paths.size());
        for (const float width : cloth.curves(pose, state).width) ASSERT_TRUE(std::isfinite(width));
        for (const Vec3& p : cloth.curves(pose, state).positions) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
    }
    EXPECT_GT(most, 5u) << "the motion was not wild enough to test anything";
}

TEST(WrinklePaths, OfASqueezedSheetRunAcrossTheCompression) {
    PathCloth cloth(shaken(triangulated(grid(12, 12, 0.03f)), 0.004f, 1));
    for (Vec3& p : cloth.mesh.positions) p.z = 0.0f;  // flat, but no two triangles alike
    cloth = PathCloth(cloth.mesh);
    const State state = cloth.play(0.5, squeeze(cloth));
    ASSERT_FALSE(state.paths.empty());
    const Curves curves = cloth.curves(cloth.squeezed(1.0f / 1.5f), state);
    for (size_t c = 0; c < curves.id.size(); ++c) {
        for (Index i = curves.start[c]; i + 1 < curves.start[c + 1]; ++i) {
            const Vec3 way = curves.positions[i + 1] - curves.positions[i];
            EXPECT_LT(std::abs(way.x),
                      0.02f * std::abs(way.y) + 2e-4f);  // paths keep 30 micrometres from vertices
        }
    }
}

TEST(WrinklePaths, NeedTheThreshold) {
    PathCloth cloth(grid(10, 10, 0.03f));
    cloth.settings.rest.reference = Reference::kStaticRest;
    EXPECT_TRUE(cloth.solve(cloth.squeezed(1.0f / 1.24f)).paths.empty());
    EXPECT_FALSE(cloth.solve(cloth.squeezed(1.0f / 1.26f)).paths.empty());
}

// Squeezed the same in both directions there is no direction to run in: the thesis would not seed, nor do we.
TEST(WrinklePaths, OfAnEvenlyShrunkenSheetAreNone) {
    PathCloth cloth(grid(10, 10, 0.03f));
    cloth.settings.rest.reference = Reference::kStaticRest;
    EXPECT_TRUE(cloth.solve(cloth.squeezed(0.6f, 0.6f)).paths.empty());
    EXPECT_FALSE(cloth.solve(cloth.squeezed(0.6f, 0.7f)).paths.empty());
}

TEST(WrinklePaths, StandStillToTheBitWhenThePoseIsHeld) {
    PathCloth cloth = sleeve();
    const auto pose = bend(cloth, 0.5f);
    State state = cloth.play(2.5, pose);  // bent within half a second; growth and fading take some more
    ASSERT_FALSE(state.paths.empty());
    for (int f = 0; f < 60; ++f) {
        Report report;
        const State next = cloth.solve(pose(9.0), &state, &report);
        ASSERT_TRUE(same_bits(next.paths, state.paths)) << f;
        ASSERT_EQ(report.born + report.died, 0);
        EXPECT_EQ(report.moved_most, 0.0f);
        state = next;
    }
}

// The fuzzer's: ways over the smallest width were infinite.
TEST(WrinklePaths, SayHowFarTheyMovedInFiniteNumbersWhateverTheWidth) {
    PathCloth cloth = sleeve();
    const auto pose = bend(cloth, 0.5f);
    const State state = cloth.play(0.5, pose);
    ASSERT_FALSE(state.paths.empty());
    cloth.settings.width = std::numeric_limits<float>::denorm_min();
    Report report;
    cloth.solve(pose(0.3), &state, &report);
    EXPECT_GT(report.moved_mean, 0.0f);
    EXPECT_TRUE(std::isfinite(report.moved_mean) && std::isfinite(report.moved_most));
}

// The fuzzer's, too: after 1e38 seconds the squares were nothing but the pull across the compression.
TEST(WrinklePaths, StayFiniteWhateverTimeHasPassed) {
    PathCloth cloth = sleeve();
    const auto pose = bend(cloth, 0.5f);
    const State state = cloth.play(0.5, pose);
    ASSERT_FALSE(state.paths.empty());
    for (const double rate : {1e-3, 1e-9, 3e-39}) {
        cloth.frame_rate = rate;
        Report report;
        const State next = cloth.solve(pose(0.3), &state, &report);
        EXPECT_TRUE(std::isfinite(report.moved_mean) && std::isfinite(report.moved_most)) << rate;
        for (const Path& path : next.paths)
            for (const PathPoint& point : path.points)
                EXPECT_TRUE(std::isfinite(point.at.x) && std::isfinite(point.at.y)) << rate;
    }
}

TEST(WrinklePaths, RideOnARigidMotion) {
    PathCloth cloth = sleeve();
    const auto pose = bend(cloth, 0.5f);
    State state = cloth.play(2.5, pose);
    const std::vector<Path> before = state.paths;
    ASSERT_FALSE(before.empty());
    for (int f = 1; f <= 60; ++f) {
        Pose3 turned = pose(9.0);
        const float a = 0.15f * float(f);
        for (Vec3& p : turned)
            p = Vec3(p.x * std::cos(a) - p.y * std::sin(a) + 0.05f * float(f),
                     p.x * std::sin(a) + p.y * std::cos(a), p.z);
        Report report;
        state = cloth.solve(turned, &state, &report);
        ASSERT_EQ(report.born + report.died, 0) << f;
    }
    // The same triangles, edges and places on them, but for roundings.
    ASSERT_EQ(state.paths.size(), before.size());
    for (size_t i = 0; i < before.size(); ++i) {
        ASSERT_EQ(state.paths[i].points.size(), before[i].points.size());
        for (size_t k = 0; k < before[i].points.size(); ++k) {
            EXPECT_EQ(state.paths[i].points[k].triangle, before[i].points[k].triangle);
            EXPECT_LT(glm::distance(state.paths[i].points[k].at, before[i].points[k].at), 2e-3f);
        }
    }
}

TEST(WrinklePaths, TheSameInputGivesTheSameBits) {
    const PathCloth cloth = sleeve();
    const State a = cloth.play(1.0, bend(cloth, 0.5f)), b = cloth.play(1.0, bend(cloth, 0.5f));
    ASSERT_FALSE(a.paths.empty());
    EXPECT_TRUE(same_bits(a, b));
}

TEST(WrinklePaths, AnyNumberOfThreadsShowsTheSameBits) {
    PathCloth cloth(shaken(triangulated(tube(16, 14, 0.06f, 0.5f)), 0.004f, 3), 2);
    const Pose3 pose = bend(cloth, 0.5f)(9.0);
    const State state = cloth.play(1.0, bend(cloth, 0.5f));
    cloth.settings.threads = 1;
    const Picture alone = cloth.show(pose, state);
    EXPECT_GT(*std::max_element(alone.height.begin(), alone.height.end()), 0.2f * cloth.settings.width);
    for (const int threads : {2, 3, 8}) {
        cloth.settings.threads = threads;
        const Picture many = cloth.show(pose, state);
        EXPECT_EQ(many.height, alone.height) << threads;
        EXPECT_EQ(many.positions, alone.positions) << threads;
    }
}

TEST(WrinklePaths, TheNumberingOfVerticesDoesNotMatter) {
    const PathCloth cloth = sleeve();
    std::vector<Index> renamed(cloth.mesh.positions.size());
    std::iota(renamed.begin(), renamed.end(), 0);
    std::mt19937 random(11);
    for (size_t i = renamed.size(); i-- > 1;) std::swap(renamed[i], renamed[random() % (i + 1)]);
    MeshData mesh = cloth.mesh;
    for (size_t v = 0; v < renamed.size(); ++v) mesh.positions[renamed[v]] = cloth.mesh.positions[v];
    for (Index& v : mesh.corner_vertex) v = renamed[v];
    const PathCloth other(mesh);
    const State a = cloth.play(1.0, bend(cloth, 0.5f)), b = other.play(1.0, bend(other, 0.5f));
    ASSERT_FALSE(a.paths.empty());
    EXPECT_TRUE(same_bits(a.paths, b.paths));
    EXPECT_EQ(a.reference.labels, b.reference.labels);
}

TEST(WrinklePaths, ComeBackToNothingWhenTheClothIsStretchedOut) {
    PathCloth cloth = sleeve();
    const State state = cloth.play(3.0, [&](double t) {
        return cloth.bent(2.0f * float(std::clamp(t < 1.0 ? 2.0 * t : 3.0 - 2.0 * t, 0.0, 1.0)), 0.5f);
    });
    EXPECT_TRUE(state.paths.empty());
}

TEST(WrinklePaths, OfAGlitchOfOneFrameAreGoneAfterASecond) {
    for (const bool printed : {false, true}) {
        PathCloth cloth = sleeve();
        if (printed) cloth.settings.smoothing = cloth.settings.rest.growth_time = 0.0f;
        size_t most = 0;
        const auto pose = [&](double t) {
            return std::abs(t - 0.5) < 0.01 ? cloth.squeezed(0.5f) : cloth.mesh.positions;
        };
        const State state = cloth.play(
            1.5, pose, [&](const State& s, const Report&) { most = std::max(most, s.paths.size()); });
        // The smoothing keeps such folds from being born at all.
        EXPECT_EQ(most > 0, printed);
        EXPECT_TRUE(state.paths.empty());
        for (size_t t = 0; t < state.reference.reference.size(); ++t) {
            const Stretch left =
                measure_stretch(cloth.model->triangles.rest[t], state.reference.reference[t]);
            EXPECT_LT(left.compression, 1.06f);
            EXPECT_LT(left.stretch, 1.06f);
        }
    }
}

// Why a glitch leaves nothing in cloth that is compressed anyway: below tau only folds that have risen live
// on.
TEST(WrinklePaths, LiveOnBelowTauOnceTheyHaveRisen) {
    PathCloth cloth(grid(10, 10, 0.03f));
    cloth.settings.rest.reference = Reference::kStaticRest;
    cloth.settings.smoothing = 0.0f;
    cloth.settings.fade = 0.15f;
    for (const auto& [seconds, stay] : {std::pair(0.1, false), std::pair(0.2, true)}) {
        const auto pose = [&, until = seconds](double t) {
            return cloth.squeezed(t == 0.0 ? 1.0f : t < until + 0.01 ? 1.0f / 1.3f : 1.0f / 1.15f);
        };
        size_t most = 0;
        const State state = cloth.play(
            1.0, pose, [&](const State& s, const Report&) { most = std::max(most, s.paths.size()); });
        EXPECT_GT(most, 3u);
        EXPECT_EQ(!state.paths.empty(), stay) << seconds;
    }
}

// A new fold starts flat and an old one ends flat: no point of the shown mesh jumps.
TEST(WrinklePaths, RiseAndSinkWithoutAJump) {
    PathCloth cloth(shaken(triangulated(tube(16, 14, 0.06f, 0.5f)), 0.004f, 3), 2);
    std::vector<float> before;
    float highest = 0.0f;
    const auto pose = [&](double t) {
        return cloth.bent(2.0f * float(std::clamp(t < 1.0 ? 2.0 * t : 3.0 - 2.0 * t, 0.0, 1.0)), 0.5f);
    };
    cloth.play(1.8, pose, [&](const State& state, const Report& report) {
        const std::vector<float> height = cloth.show(pose(state.reference.time), state).height;
        double jump = 0.0;
        for (size_t v = 0; v < before.size(); ++v) {
            highest = std::max(highest, height[v]);
            jump += std::abs(height[v] - before[v]) / double(before.size());
        }
        EXPECT_LT(jump, 0.06 * cloth.settings.width) << state.reference.time << " born " << report.born;
        before = height;
    });
    EXPECT_GT(highest, 0.2f * cloth.settings.width);
}

TEST(WrinklePaths, GrowAndShrinkNoFasterThanTheLimit) {
    PathCloth cloth(grid(16, 16, 0.03f));
    cloth.settings.rest.reference = Reference::kStaticRest;
    // A squeezed band that widens along y: folds along y grow with it.
    const auto pose = [&](double t) {
        return cloth.moved([=](const Vec3& p) {
            const float inside = std::abs(p.y - 0.24f) < 0.05f + 0.4f * float(t) ? 1.0f / 1.5f : 1.0f;
            return Vec3((p.x - 0.24f) * inside, p.y, 0.0f);
        });
    };
    std::vector<std::pair<Index, float>> before;
    bool grew = false;
    cloth.play(0.5, pose, [&](const State& state, const Report&) {
        const Pose stands = make_pose(*cloth.model, pose(state.reference.time));
        const PathSurface surface{*cloth.model, stands};
        std::vector<std::pair<Index, float>> now;
        for (const Path& path : state.paths) {
            const float length = wrinkle_paths::length(surface, path.points);
            now.emplace_back(path.id, length);
            for (const auto& [id, old] : before) {
                if (id != path.id) continue;
                // A row of the sheet is squeezed within a frame: that alone bends folds that end in it.
                EXPECT_LT(length,
                          1.15f * std::max(old, 2.0f * cloth.settings.width) + 0.4f * cloth.settings.width);
                grew = grew || length > 1.05f * old;
            }
        }
        before = now;
    });
    EXPECT_TRUE(grew);
}

TEST(WrinklePaths, TheSeedDecidesWhere) {
    PathCloth cloth(grid(10, 10, 0.03f));
    cloth.settings.rest.reference = Reference::kStaticRest;
    const State a = cloth.solve(cloth.squeezed(0.7f));
    cloth.settings.seed = 1;
    EXPECT_FALSE(same_bits(a.paths, cloth.solve(cloth.squeezed(0.7f)).paths));
}

TEST(WrinklePaths, KeepAwayFromWhatIsMaskedAndFromHems) {
    PathCloth cloth(grid(12, 12, 0.03f));
    cloth.settings.rest.reference = Reference::kStaticRest;
    Paint paint;
    for (const Vec3& p : cloth.mesh.positions) paint.mask.push_back(p.x < 0.18f ? 0.0f : 1.0f);
    const Pose3 pose = cloth.squeezed(0.7f);
    Input input;
    input.positions = pose;
    Report report;
    const State masked =
        solve(*cloth.model, cloth.settings, paint, input, make_pose(*cloth.model, pose), nullptr, report);
    ASSERT_FALSE(masked.paths.empty());
    for (const Vec3& p : cloth.curves(pose, masked).positions) EXPECT_GT(p.x, 0.7f * 0.15f);
    cloth.settings.hem_rings = 3;
    const Curves inner = cloth.curves(pose, cloth.solve(pose));
    ASSERT_GT(inner.id.size(), 0u);
    for (size_t i = 0; i < inner.positions.size(); ++i) {
        if (inner.height[i] < 0.05f * cloth.settings.width) continue;  // paths go on where folds are flat
        EXPECT_GT(inner.positions[i].y, 0.02f);
        EXPECT_LT(inner.positions[i].y, 0.34f);
    }
}

// The same motion at 24 to 120 frames a second: as much fold at the same time.
TEST(WrinklePaths, DependLittleOnTheFrameRate) {
    PathCloth cloth = sleeve();
    const auto pose = bend(cloth, 0.5f);
    std::vector<float> lengths;
    for (const double rate : {24.0, 30.0, 60.0, 120.0}) {
        cloth.frame_rate = rate;
        lengths.push_back(total_length(cloth.curves(pose(9.0), cloth.play(1.5, pose))));
    }
    ASSERT_GT(lengths[0], 0.1f);
    for (const float length : lengths) EXPECT_NEAR(length / lengths[1], 1.0f, 0.25f);
}

TEST(WrinklePaths, HoldAPoseThatJitters) {
    PathCloth cloth = sleeve();
    const auto pose = bend(cloth, 0.5f);
    State state = cloth.play(1.0, pose);
    const float before = total_length(cloth.curves(pose(9.0), state));
    std::mt19937 random(5);
    for (int f = 0; f < 90; ++f) {
        Pose3 jittered = pose(9.0);
        for (Vec3& p : jittered) {
            for (int c = 0; c < 3; ++c) p[c] += 0.001f * (float(random() % 2001) / 1000.0f - 1.0f);
        }
        state = cloth.solve(jittered, &state);
        ASSERT_EQ(cloth.validate(state), "");
    }
    const float after = total_length(cloth.curves(pose(9.0), state));
    EXPECT_GT(after, 0.7f * before);
    EXPECT_LT(after, 1.4f * before);
}

}  // namespace
}  // namespace rumple::tests
