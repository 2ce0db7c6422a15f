// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "base/errors.h"
#include "surface/strain/guided_strain.h"
#include "tests/meshes.h"

namespace rumple::tests {
namespace {

constexpr float kPi = 3.14159265f;

Vec2 at(float angle) {
    return {std::cos(angle), std::sin(angle)};
}

// F F^T with these stretches, the small one in a direction.
Tensor2 stretched(float small, float large, float angle) {
    const Vec2 e = at(angle);
    const float s = small * small, l = large * large;
    return {s * e.x * e.x + l * e.y * e.y, (s - l) * e.x * e.y, s * e.y * e.y + l * e.x * e.x};
}

TEST(GuidedStrain, NothingIsAskedNothingChangesToTheBit) {
    const Tensor2 left = stretched(0.83f, 1.07f, 0.4f), same = turned(left, Vec2(0.0f));
    EXPECT_EQ(left.xx, same.xx);
    EXPECT_EQ(left.xy, same.xy);
    EXPECT_EQ(left.yy, same.yy);
}

TEST(GuidedStrain, TurnsTheCompressionAcrossTheLineAndKeepsItsAmount) {
    for (int k = 0; k < 12; ++k) {
        const float angle = kPi * float(k) / 12.0f;
        const Principal p = principal(turned(stretched(0.8f, 1.1f, 0.3f), at(angle)));
        EXPECT_NEAR(std::sqrt(p.small), 0.8f, 1e-5f);
        EXPECT_NEAR(std::sqrt(p.large), 1.1f, 1e-5f);
        EXPECT_NEAR(glm::dot(p.small_direction, at(angle)), 0.0f, 1e-4f);
    }
}

TEST(GuidedStrain, EitherWayAlongTheLineIsTheSame) {
    const Tensor2 left = stretched(0.8f, 1.1f, 0.3f), one = turned(left, 0.6f * at(1.0f)),
                  other = turned(left, -0.6f * at(1.0f));
    EXPECT_FLOAT_EQ(one.xx, other.xx);
    EXPECT_FLOAT_EQ(one.xy, other.xy);
    EXPECT_FLOAT_EQ(one.yy, other.yy);
}

// By hand: at right angles to what is compressed, a half of it each way is the mean of the squares.
TEST(GuidedStrain, HalfOfItIsTheMean) {
    const Tensor2 half = turned({0.64f, 0.0f, 1.0f}, 0.5f * Vec2(1.0f, 0.0f));
    EXPECT_NEAR(half.xx, 0.82f, 1e-6f);
    EXPECT_NEAR(half.xy, 0.0f, 1e-6f);
    EXPECT_NEAR(half.yy, 0.82f, 1e-6f);
}

// A grid of unit squares in the plane, x pressed to 0.8: pairs across a line along x keep their length as
// long as the pressed ones were, and those along it are asked for no more than they have.
TEST(GuidedStrain, ScalesRestLengthsByHand) {
    const Surface surface = build(grid(6, 6, 1.0f));
    std::vector<Vec3> asked(surface.welded_of.size(), Vec3(1.0f, 0.0f, 0.0f));
    std::vector<Vec3> posed(surface.positions_rest);
    for (Vec3& p : posed) p.x *= 0.8f;
    const auto guide = build_guide_lines(surface, asked);
    for (const GuidedStrain& strain : guided_strain(*guide, posed)) {
        EXPECT_NEAR(strain.rest_scale({1.0f, 0.0f, 0.0f}), 0.8f, 1e-4f);
        EXPECT_NEAR(strain.rest_scale({0.0f, 1.0f, 0.0f}), 1.25f, 1e-4f);
        EXPECT_NEAR(strain.weight, 1.0f, 1e-5f);
        SpareCloth spare;
        spare.all.add(1.0f, {1.0f, 0.0f, 0.0f});
        spare.all.add(1.0f, {0.0f, 1.0f, 0.0f});
        const SpareCloth left = spared_along(spare, strain);
        EXPECT_NEAR(left.share_without_place({1.0f, 0.0f, 0.0f}), 1.0f, 1e-4f);
        EXPECT_NEAR(left.share_without_place({0.0f, 1.0f, 0.0f}), 0.0f, 1e-4f);
    }
}

TEST(GuidedStrain, WhereNothingIsAskedRestLengthsAreTheSameToTheBit) {
    const Surface surface = build(grid(6, 6, 1.0f));
    std::vector<Vec3> posed(surface.positions_rest);
    for (Vec3& p : posed) p = Vec3(0.7f * p.x, p.y + 0.2f * p.x, 0.1f * p.x * p.y);
    const auto guide = build_guide_lines(surface, std::vector<Vec3>(surface.welded_of.size(), Vec3(0.0f)));
    for (const GuidedStrain& strain : guided_strain(*guide, posed))
        EXPECT_EQ(strain.rest_scale({0.3f, -0.4f, 0.1f}), 1.0f);
}

TEST(GuidedStrain, RefusesWhatIsNoDirection) {
    const Surface surface = build(grid(3, 3, 1.0f));
    std::vector<Vec3> asked(surface.welded_of.size(), Vec3(0.0f));
    asked[2] = Vec3(2.0f, 0.0f, 0.0f);
    EXPECT_THROW(build_guide_lines(surface, asked), InvalidInput);
    asked[2] = Vec3(std::nanf(""), 0.0f, 0.0f);
    EXPECT_THROW(build_guide_lines(surface, asked), InvalidInput);
    asked.pop_back();
    EXPECT_THROW(build_guide_lines(surface, asked), InvalidInput);
}

// A wild frame gives numbers: a collapsed one says nothing.
TEST(GuidedStrain, OfAWildFrameAreNumbers) {
    const Surface surface = build(grid(6, 6, 1.0f));
    const auto guide =
        build_guide_lines(surface, std::vector<Vec3>(surface.welded_of.size(), Vec3(0.6f, 0.8f, 0.0f)));
    std::vector<Vec3> posed(surface.positions_rest.size(), Vec3(0.0f));
    for (const float far : {0.0f, 1e-20f, 1e6f, 1e12f, 1e30f}) {
        for (size_t v = 0; v < posed.size(); v += 2) posed[v] = Vec3(far * float(v), -1e-9f, 3.0f);
        for (const GuidedStrain& strain : guided_strain(*guide, posed))
            EXPECT_TRUE(std::isfinite(strain.rest_scale({1.0f, 2.0f, -1.0f}))) << far;
    }
}

}  // namespace
}  // namespace rumple::tests
