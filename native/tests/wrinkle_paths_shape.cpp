// SPDX-License-Identifier: GPL-3.0-or-later
// The shape of the folds of the Wrinkle Paths: cross-sections, heights on the shown mesh.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "systems/wrinkle_paths/walk.h"
#include "tests/wrinkle_paths_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_paths;

float profile(Profile kind, float x) {
    return formulas::fold_profile(int(kind), std::abs(x)).height;
}

// ---- section 6.1

TEST(PathProfile, IsOneAtTheCrestFlatThereAndAtTheFoot) {
    for (const Profile kind : {Profile::kSpline, Profile::kQuartic, Profile::kCircularArcs, Profile::kSine}) {
        EXPECT_FLOAT_EQ(profile(kind, 0.0f), 1.0f);
        EXPECT_NEAR(profile(kind, 1.0f), 0.0f, 1e-6f);
        EXPECT_EQ(profile(kind, 1.5f), 0.0f);
        EXPECT_NEAR(profile(kind, 1e-3f), 1.0f, 1e-5f);
        EXPECT_NEAR(profile(kind, 1.0f - 1e-3f), 0.0f, 1e-5f);
        EXPECT_EQ(profile(kind, -0.4f), profile(kind, 0.4f));
    }
    EXPECT_NEAR(profile(Profile::kSpline, 1.0f / 3.0f), 2.0f / 3.0f, 1e-6f);  // the knot of figure 6.3
}

TEST(PathProfile, KeepsTheArcLength) {
    for (const Profile kind : {Profile::kSpline, Profile::kQuartic, Profile::kCircularArcs, Profile::kSine}) {
        for (const float ratio : {1.01f, 1.1f, 1.2f, 1.35f, 1.5f, kMostRatio}) {
            const float height = height_table(kind).height_over_width(ratio);
            double length = 0.0;
            const int steps = 4000;
            for (int i = 0; i < steps; ++i) {
                const double rise = profile(kind, 2.0f * float(i + 1) / steps - 1.0f) -
                                    profile(kind, 2.0f * float(i) / steps - 1.0f);
                length += std::hypot(1.0 / steps, height * rise);
            }
            EXPECT_NEAR(length, ratio, 2e-3) << int(kind) << ' ' << ratio;
        }
        EXPECT_EQ(height_table(kind).height_over_width(1.0f), 0.0f);
        EXPECT_EQ(height_table(kind).height_over_width(5.0f),
                  height_table(kind).height_over_width(kMostRatio));
    }
}

TEST(PathProfile, OfTheSplineHasTheHeightsFoundBefore) {
    EXPECT_NEAR(height_table(Profile::kSpline).height_over_width(1.2f), 0.296f, 1e-3f);
    EXPECT_NEAR(height_table(Profile::kSpline).height_over_width(1.3f), 0.375f, 1e-3f);
    EXPECT_NEAR(height_table(Profile::kSpline).height_over_width(1.4f), 0.447f, 1e-3f);
}

// ---- chapters 6 to 8

// A sheet squeezed to 1 / 1.4 along x, with one fold that runs straight up along y from 0.02 to 0.38.
struct StraightFold : PathCloth {
    Pose3 pose;
    State state;
    float x = 0.2f / 1.4f + 0.01f;

    StraightFold() : PathCloth(grid(4, 4, 0.1f), 6) {
        settings.width = 0.05f;
        pose = squeezed(1.0f / 1.4f);
        state = solve(pose);
        const Pose flat = make_pose(*model, pose);
        const PathContext context = make_context(*model, settings, {}, flat, flat.base.shapes,
                                                 model->triangles.rest, std::vector<Stretch>(32));
        for (Index t = 0; t < 32; ++t) {
            const glm::dvec2 at = context.to_flat(t, {x, 0.02f, 0}), u1 = context.corner(t, 1),
                             u2 = context.corner(t, 2);
            const double b = at.y / u2.y, a = (at.x - b * u2.x) / u1.x;
            if (a < 0 || b < 0 || a + b > 1) continue;
            WalkLimits limits;
            limits.length = 0.36f;
            std::vector<Index> visited{t};
            Path path;
            path.points =
                walk(context, t, at, context.to_flat(t, {x, 1.02f, 0}) - at, limits, visited).points;
            path.points.insert(path.points.begin(), inside(context, t, at));
            state.paths = {path};
            break;
        }
        EXPECT_EQ(validate(state), "");
    }
    // The height of the crest nearest to y, with the compression given to the lower and the upper half.
    float crest(float y, float lower, float upper) {
        state.compression.assign(16, lower);
        state.compression.resize(32, upper);
        const Curves line = curves(pose, state);
        size_t nearest = 0;
        for (size_t i = 0; i < line.positions.size(); ++i) {
            if (std::abs(line.positions[i].y - y) < std::abs(line.positions[nearest].y - y)) nearest = i;
        }
        return line.height[nearest];
    }
};

float full_height(const Settings& settings, float compression) {
    const float width = kMostRatio * settings.width / compression;
    return width * height_table(Profile::kSpline).height_over_width(compression);
}

// The crest is h high, the cloth beyond L / 2 lies flat, and a line across the fold has the arc length s
// where it had L.
TEST(PathShow, AFoldKeepsTheLengthOfTheClothAcrossIt) {
    StraightFold cloth;
    const float x = cloth.x;
    const Pose3& pose = cloth.pose;
    State& state = cloth.state;
    ASSERT_GT(state.paths[0].points.size(), 3u);
    state.compression.assign(32, 1.4f);
    const Picture picture = cloth.show(pose, state);
    const float s = kMostRatio * cloth.settings.width, width = s / 1.4f;
    const float high = full_height(cloth.settings, 1.4f);
    std::vector<std::pair<float, float>> section;  // x, height along the line y = 0.2
    for (size_t v = 0; v < picture.positions.size(); ++v) {
        const Vec3& p = picture.positions[v];
        if (std::abs(p.y - 0.2f) < 1e-6f) section.emplace_back(p.x, p.z);
        if (std::abs(p.x - x) > 0.5f * s + 1e-5f) {
            EXPECT_EQ(p.z, 0.0f);
        }
        EXPECT_NEAR(picture.height[v], p.z, 1e-7f);
    }
    std::sort(section.begin(), section.end());
    float length = 0.0f, top = 0.0f;
    for (size_t i = 0; i + 1 < section.size(); ++i) {
        top = std::max(top, section[i].second);
        length +=
            std::hypot(section[i + 1].first - section[i].first, section[i + 1].second - section[i].second);
    }
    EXPECT_NEAR(top, high, 0.02f * high);
    EXPECT_NEAR(length - (section.back().first - section.front().first), s - width, 0.03f * s);
}

// At what paths reach to a fold is flat, from tau on it takes up all compression, and between it rises.
TEST(PathShow, AFoldSinksBelowTau) {
    StraightFold cloth;
    cloth.settings.threshold = 1.3f;
    cloth.settings.reach = 0.5f;
    EXPECT_EQ(cloth.crest(0.2f, 1.15f, 1.15f), 0.0f);
    EXPECT_NEAR(cloth.crest(0.2f, 1.3f, 1.3f), full_height(cloth.settings, 1.3f), 1e-6f);
    EXPECT_NEAR(cloth.crest(0.2f, 1.5f, 1.5f), full_height(cloth.settings, 1.5f), 1e-6f);
    // Half way: ease(1/2) = 1/2 of the height.
    EXPECT_NEAR(cloth.crest(0.2f, 1.225f, 1.225f), 0.5f * full_height(cloth.settings, 1.225f), 1e-6f);
}

// One collapsed triangle must not raise a fold along its whole length: it is as high as its surroundings ask
// for, without a step where they change.
TEST(PathShow, AFoldFollowsTheCompressionAlongIt) {
    StraightFold cloth;
    EXPECT_EQ(cloth.crest(0.1f, 1.0f, 1.4f), 0.0f);
    EXPECT_NEAR(cloth.crest(0.3f, 1.4f, 1.4f), cloth.crest(0.3f, 1.0f, 1.4f), 1e-6f);
    EXPECT_GT(cloth.crest(0.3f, 1.0f, 1.4f), 0.1f * cloth.settings.width);
    cloth.crest(0.0f, 1.0f, 1.4f);
    const Curves line = cloth.curves(cloth.pose, cloth.state);
    for (size_t i = 0; i + 1 < line.height.size(); ++i)
        EXPECT_LT(std::abs(line.height[i + 1] - line.height[i]), 0.5f * full_height(cloth.settings, 1.4f));
}

TEST(PathShow, TurnsFoldsToTheSideAskedFor) {
    PathCloth cloth(grid(8, 8, 0.03f), 3);
    cloth.settings.rest.reference = Reference::kStaticRest;
    const Pose3 pose = cloth.squeezed(0.7f);
    const State state = cloth.solve(pose);
    const auto range = [&](Direction direction, float height) {
        cloth.settings.direction = direction;
        cloth.settings.height = height;
        const std::vector<float> h = cloth.show(pose, state).height;
        return std::pair(*std::min_element(h.begin(), h.end()), *std::max_element(h.begin(), h.end()));
    };
    const auto out = range(Direction::kOutward, 1.0f), in = range(Direction::kInward, 1.0f),
               both = range(Direction::kBoth, 1.0f), half = range(Direction::kOutward, 0.5f);
    EXPECT_EQ(out.first, 0.0f);
    EXPECT_GT(out.second, 0.2f * cloth.settings.width);
    EXPECT_EQ(in.first, -out.second);
    EXPECT_EQ(in.second, 0.0f);
    EXPECT_LT(both.first, -0.2f * cloth.settings.width);
    EXPECT_GT(both.second, 0.2f * cloth.settings.width);
    EXPECT_FLOAT_EQ(half.second, 0.5f * out.second);
}

TEST(PathShow, WithoutPathsIsTheUnwrinkledSurface) {
    PathCloth cloth(tube(12, 6, 0.1f, 0.4f), 2);
    const State state = cloth.solve(cloth.mesh.positions);
    const Picture picture = cloth.show(cloth.mesh.positions, state);
    ASSERT_EQ(picture.positions.size(), cloth.model->shown.positions_rest.size());
    for (size_t v = 0; v < picture.positions.size(); ++v) {
        EXPECT_LT(glm::distance(picture.positions[v], cloth.model->shown.positions_rest[v]), 1e-6f);
        EXPECT_EQ(picture.height[v], 0.0f);
        EXPECT_LT(glm::length(picture.local_offset[v]), 1e-6f);  // linear attachment: the embedding itself
    }
}

// On a flat sheet the distance through space is the one on the cloth: leaving out no piece at all must give
// the same.
TEST(PathShow, ListsMissNoPieceThatReachesATriangle) {
    PathCloth cloth(shaken(triangulated(grid(10, 10, 0.03f)), 0.004f, 2), 2);
    for (Vec3& p : cloth.mesh.positions) p.z = 0.0f;
    cloth = PathCloth(cloth.mesh, 2);
    cloth.settings.rest.reference = Reference::kStaticRest;
    const Pose3 pose = cloth.squeezed(0.7f);
    const State state = cloth.solve(pose);
    ASSERT_GT(state.paths.size(), 3u);
    const TriangleLists lists =
        build_triangle_lists(*cloth.model, cloth.settings, make_pose(*cloth.model, pose), state);
    const Curves lines = cloth.curves(pose, state);
    const Picture picture = cloth.show(pose, state);
    size_t lifted = 0;
    for (size_t v = 0; v < picture.positions.size(); ++v) {
        const Vec3 p(picture.positions[v].x, picture.positions[v].y, 0.0f);
        float best = 0.0f;
        for (size_t c = 0; c < lines.id.size(); ++c) {
            for (Index i = lines.start[c]; i + 1 < lines.start[c + 1]; ++i)
                best = std::max(best, formulas::fold_height(int(cloth.settings.profile), lists.ends[i],
                                                            lists.ends[i + 1], p)
                                          .height);
        }
        EXPECT_NEAR(picture.height[v], best, 1e-6f);
        lifted += best > 1e-4f;
    }
    EXPECT_GT(lifted, 100u);
}

TEST(PathShow, ListsAreSortedAndWhole) {
    PathCloth cloth(tube(16, 14, 0.06f, 0.5f));
    cloth.settings.rest.reference = Reference::kStaticRest;
    const Pose3 pose = cloth.bent(2.0f, 0.5f);
    const State state = cloth.solve(pose);
    const TriangleLists lists =
        build_triangle_lists(*cloth.model, cloth.settings, make_pose(*cloth.model, pose), state);
    ASSERT_EQ(lists.triangle_start.size(), size_t(cloth.model->triangles.net.triangles()) + 1);
    EXPECT_EQ(size_t(lists.triangle_start.back()), lists.ranges.size());
    const Curves lines = cloth.curves(pose, state);
    ASSERT_EQ(lists.ends.size(), lines.positions.size());
    for (const auto& [first, end] : lists.ranges) {
        ASSERT_LT(first, end);
        // Within one fold: no range runs over from one path to the next.
        const auto fold = std::upper_bound(lines.start.begin(), lines.start.end(), first);
        EXPECT_LT(end, *fold);
    }
    for (const Path& path : state.paths) {  // a triangle that a path crosses is on its list
        for (size_t i = 0; i + 1 < path.points.size(); ++i) {
            const Index t = segment_triangle(*cloth.model, path.points, i);
            EXPECT_LT(lists.triangle_start[t], lists.triangle_start[t + 1]);
        }
    }
}

// A fold along y whose points zigzag by a fifth of its width: a fold cannot bend within its width. Straight
// folds stay as they are, and so do ends.
TEST(PathShow, SmoothsWhatIsShorterThanTheWidth) {
    PathCloth cloth(grid(4, 24, 0.01f));  // squeezed to 7 mm by 10 mm, folds of 20 mm
    cloth.settings.rest.reference = Reference::kStaticRest;
    const Pose3 pose = cloth.squeezed(0.7f);
    State state = cloth.solve(pose);
    ASSERT_FALSE(state.paths.empty());
    const auto spread = [](const std::vector<Vec3>& line) {  // across, of the middle half
        float low = 1.0f, high = 0.0f;
        for (const Vec3& p : line) {
            if (std::abs(p.y - 0.12f) < 0.06f) low = std::min(low, p.x), high = std::max(high, p.x);
        }
        return high - low;
    };
    const auto shown = [&](const Path& path) {
        state.paths = {path};
        return cloth.curves(pose, state).positions;
    };
    const Path straight =
        *std::max_element(state.paths.begin(), state.paths.end(),
                          [](const Path& a, const Path& b) { return a.points.size() < b.points.size(); });
    ASSERT_GT(straight.points.size(), 20u);
    EXPECT_LT(spread(shown(straight)), 1e-6f);

    Path zigzag = straight;
    for (size_t i = 1; i + 1 < zigzag.points.size(); ++i) {
        float& fraction = zigzag.points[i].at.x;
        fraction = std::clamp(fraction + (i % 2 == 1 ? 0.3f : -0.3f), 0.01f, 0.99f);
    }
    const Pose flat = make_pose(*cloth.model, pose);
    const std::vector<Vec3> raw = positions(PathSurface{*cloth.model, flat}, zigzag.points);
    const std::vector<Vec3> line = shown(zigzag);
    ASSERT_GT(spread(raw), 0.1f * cloth.settings.width);
    EXPECT_LT(spread(line), 0.1f * spread(raw));
    EXPECT_EQ(line.front(), raw.front());
    EXPECT_EQ(line.back(), raw.back());
}

// A straight piece along y: height and slope depend on the distance only; the gradient is the slope of the
// height.
TEST(PathShow, TheGradientIsTheSlopeOfTheHeight) {
    const formulas::FoldEnd a{{0, 0, 0}, 0.03f, {0, 1, 0}, 0.01f}, b{{0, 1, 0}, 0.03f, {0, 1, 0}, 0.01f};
    for (const Profile kind : {Profile::kSpline, Profile::kQuartic, Profile::kCircularArcs, Profile::kSine}) {
        for (const float x : {-0.012f, -0.004f, 0.002f, 0.006f, 0.0074f, 0.011f}) {
            const auto at = [&](float dx) {
                return formulas::fold_height(int(kind), a, b, Vec3(x + dx, 0.4f, 0.0f));
            };
            EXPECT_NEAR(at(0.0f).height, 0.01f * profile(kind, x / 0.015f), 1e-7f);
            EXPECT_NEAR(at(0.0f).gradient.x, (at(1e-4f).height - at(-1e-4f).height) / 2e-4f, 5e-3f) << x;
            EXPECT_NEAR(at(0.0f).gradient.y, 0.0f, 1e-4f);
        }
    }
    EXPECT_EQ(formulas::fold_height(0, a, b, Vec3(0.001f, 1.2f, 0.0f)).height, 0.0f);  // beyond the end
}

// Two pieces at a right angle share the direction of their corner: a point on the bisector is projected to
// the corner by both (eq. 7.1), inside the bend as outside of it.
TEST(PathShow, PiecesAgreeWhereTheyMeet) {
    const Vec3 bisector = glm::normalize(Vec3(1, 1, 0));
    const formulas::FoldEnd a{{-1, 0, 0}, 2.0f, {1, 0, 0}, 1.0f}, corner{{0, 0, 0}, 2.0f, bisector, 1.0f},
        b{{0, 1, 0}, 2.0f, {0, 1, 0}, 1.0f};
    for (const float far : {-0.3f, -0.1f, 0.1f, 0.3f}) {
        const Vec3 p = far * Vec3(1, -1, 0);
        const float expected = profile(Profile::kSpline, std::abs(far) * std::sqrt(2.0f));
        EXPECT_NEAR(formulas::fold_height(0, a, corner, p).height, expected, 1e-5f) << far;
        EXPECT_NEAR(formulas::fold_height(0, corner, b, p).height, expected, 1e-5f) << far;
    }
}

}  // namespace
}  // namespace rumple::tests
