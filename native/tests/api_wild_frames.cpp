// SPDX-License-Identifier: GPL-3.0-or-later
// One frame in which a simulation explodes must not be the end: it is refused with words, and the frames
// after it are what they would have been without it. Before, a vertex at 1e20 left a state that was not
// finite and never became so again (Wrinkle Mesh), and one at 1e14 ended the process (Wrinkle Field: a phase
// that is no number was a place in a table).
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "base/formulas.h"
#include "tests/api_player.h"

namespace rumple::api {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN(),
                kEndless = std::numeric_limits<float>::infinity();

// Of a sheet of 1 x 1: beyond a million times its size.
constexpr float kWild[] = {kNone, kEndless, -kEndless, 1.1e6f, -1.1e6f, 1e9f, 1e14f, 1e20f, 3e38f};

std::vector<float> squeezed(float by) {
    return {0, 0, 0, by, 0, 0, by, 1, 0, 0, 1, 0};
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

TEST(ApiWildFrames, AreRefusedAndLeaveNoTrace) {
    const Sheet sheet;
    for (const float wild : kWild) {
        std::vector<System> one = systems(sheet), other = systems(sheet);
        for (size_t i = 0; i < one.size(); ++i) {
            SCOPED_TRACE(one[i].name + " with a vertex at " + std::to_string(wild));
            std::vector<float> astray = squeezed(0.7f);
            astray[7] = wild;  // y of vertex 2
            ASSERT_FALSE(one[i].play(squeezed(0.8f)).empty()) << rumple_error();
            ASSERT_FALSE(other[i].play(squeezed(0.8f)).empty()) << rumple_error();
            EXPECT_TRUE(one[i].play(astray).empty());
            EXPECT_NE(std::string(rumple_error()).find("positions: vertex 2 is "), std::string::npos)
                << rumple_error();
            const std::vector<float> after = one[i].play(squeezed(0.6f));
            ASSERT_FALSE(after.empty()) << rumple_error();
            EXPECT_TRUE(same_bits(after, other[i].play(squeezed(0.6f))));
        }
    }
}

// Within the bounds a frame may be as wild as it likes: what comes of it is finite, or it is refused; and the
// cloth is back soon.
TEST(ApiWildFrames, WithinTheBoundsAnswersAreFinite) {
    const Sheet sheet;
    for (const float far : {1e2f, 1e4f, 9e5f, -9e5f}) {
        for (System& system : systems(sheet)) {
            SCOPED_TRACE(system.name + " with a vertex at " + std::to_string(far));
            std::vector<float> astray = squeezed(0.7f);
            astray[6] = far;
            for (const auto& frame : {squeezed(0.8f), astray, squeezed(0.7f), squeezed(0.6f)}) {
                for (const float value : system.play(frame)) ASSERT_TRUE(std::isfinite(value));
            }
            EXPECT_FALSE(system.play(squeezed(0.6f)).empty()) << rumple_error();
        }
    }
}

// The bound is of the mesh, not of the unit: what is tiny, and what is large, moves as far.
TEST(ApiWildFrames, TheBoundFollowsTheSizeOfTheMesh) {
    for (const float size : {1e-3f, 50.0f}) {
        const Sheet sheet(size);
        for (System& system : systems(sheet)) {
            SCOPED_TRACE(system.name);
            std::vector<float> away = squeezed(0.9f);
            for (float& x : away) x = size * (x + 1e4f);  // far, but whole
            EXPECT_FALSE(system.play(away).empty()) << rumple_error();
            for (float& x : away) x = 2e6f * size;
            EXPECT_TRUE(system.play(away).empty());
        }
    }
}

TEST(ApiWildFrames, ARestShapeOrABodyThatFloatsCannotHoldIsRefused) {
    const float far[] = {0, 0, 0, 1, 0, 0, 1, 2e8f, 0, 0, 1, 0};
    const int32_t start[] = {0, 4}, corner[] = {0, 1, 2, 3}, triangle[] = {0, 1, 2, 0, 2, 3};
    rumple_surface_plan plan = rumple_surface_plan_default();
    plan.positions_rest = far;
    plan.positions_rest_count = 4;
    plan.polygon_start = start;
    plan.polygon_start_count = 2;
    plan.corner_vertex = corner;
    plan.corner_vertex_count = 4;
    plan.triangle_corner = triangle;
    plan.triangle_corner_count = 2;
    rumple_surface* surface = nullptr;
    EXPECT_EQ(rumple_surface_build(&plan, &surface), RUMPLE_INVALID);
    EXPECT_STREQ(
        rumple_error(),
        "positions_rest: vertex 2 is 2e+08 away from the origin, more than 1e+08: move the mesh to the "
        "origin, or scale it down");
    rumple_collider* collider = nullptr;
    EXPECT_EQ(rumple_collider_build(far, 4, triangle, 2, nullptr, 0, 0.0f, &collider), RUMPLE_INVALID);
    EXPECT_NE(std::string(rumple_error()).find("body positions: vertex 2"), std::string::npos);
}

// int(x) of what is no number is any number: it was a place in the table of the profile.
TEST(ApiWildFrames, APhaseThatIsNoNumberHasAPlaceInTheTable) {
    for (const float phase : {kNone, kEndless, -kEndless, 3e38f, -1e20f, 3.14159274f}) {
        const formulas::ProfilePlace place = formulas::profile_place(phase);
        EXPECT_GE(place.index, 0);
        EXPECT_LT(place.index, formulas::kProfileIntervals);
        EXPECT_TRUE(place.fraction >= 0.0f && place.fraction <= 1.0f) << place.fraction;
    }
}

}  // namespace
}  // namespace rumple::api
