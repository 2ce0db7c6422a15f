// SPDX-License-Identifier: GPL-3.0-or-later
// What the C library makes of exceptions and of pointers that are wrong.
#include <gtest/gtest.h>

#include <limits>
#include <new>
#include <stdexcept>

#include "api/call.h"
#include "tests/api_sheet.h"

namespace rumple::api {
namespace {

TEST(ApiErrors, NothingThatIsThrownGoesOnAndItsWordsAreKept) {
    EXPECT_EQ(guarded([] {}), RUMPLE_OK);
    EXPECT_EQ(guarded([] { throw InvalidInput("positions: too few"); }), RUMPLE_INVALID);
    EXPECT_STREQ(rumple_error(), "positions: too few");
    EXPECT_EQ(guarded([] { throw TopologyError("polygon 3"); }), RUMPLE_INVALID);
    EXPECT_STREQ(rumple_error(), "polygon 3");
    EXPECT_EQ(guarded([] { throw std::bad_alloc(); }), RUMPLE_NO_MEMORY);
    EXPECT_EQ(guarded([] { throw std::runtime_error("broken"); }), RUMPLE_INTERNAL);
    EXPECT_STREQ(rumple_error(), "broken");
    EXPECT_EQ(guarded([] { throw 7; }), RUMPLE_INTERNAL);
    EXPECT_EQ(guarded([] { throw InvalidInput(std::string(100000, 'x')); }), RUMPLE_INVALID);
    EXPECT_LT(std::string(rumple_error()).size(), 100000u);
}

TEST(ApiErrors, ATextIsOfTheThreadThatFailed) {
    EXPECT_EQ(guarded([] { throw InvalidInput("here"); }), RUMPLE_INVALID);
    std::thread([] {
        EXPECT_STREQ(rumple_error(), "");
        EXPECT_EQ(guarded([] { throw InvalidInput("there"); }), RUMPLE_INVALID);
    }).join();
    EXPECT_STREQ(rumple_error(), "here");
}

TEST(ApiErrors, CountsThatNoArrayHasAreRefusedUnread) {
    const float number = 0.0f;
    for (const size_t count : {size_t(1) << 31, std::numeric_limits<size_t>::max()}) {
        EXPECT_THROW(vectors(&number, count, "positions"), InvalidInput);
        rumple_collider* collider = nullptr;
        const int32_t corners[3] = {0, 1, 2};
        EXPECT_EQ(rumple_collider_build(&number, count, corners, 1, nullptr, 0, 0.0f, &collider),
                  RUMPLE_INVALID);
        EXPECT_NE(std::string(rumple_error()).find("positions: expected at most 2147483647"),
                  std::string::npos);
        EXPECT_EQ(collider, nullptr);
    }
    EXPECT_THROW(vectors(nullptr, 1, "positions"), InvalidInput);
    EXPECT_TRUE(vectors(nullptr, 0, "positions").empty());
}

TEST(ApiErrors, NullIsRefusedByNameAndFreedForNothing) {
    const Sheet sheet;
    rumple_wrinkle_mesh* model = nullptr;
    const rumple_wrinkle_mesh_plan plan = rumple_wrinkle_mesh_plan_default();
    EXPECT_EQ(rumple_wrinkle_mesh_build(nullptr, &plan, &model), RUMPLE_INVALID);
    EXPECT_STREQ(rumple_error(), "base: expected a pointer, got NULL");
    EXPECT_EQ(rumple_wrinkle_mesh_build(sheet.surface(), nullptr, &model), RUMPLE_INVALID);
    EXPECT_STREQ(rumple_error(), "plan: expected a pointer, got NULL");
    EXPECT_EQ(rumple_wrinkle_mesh_build(sheet.surface(), &plan, nullptr), RUMPLE_INVALID);
    EXPECT_STREQ(rumple_error(), "model: expected a pointer, got NULL");
    EXPECT_EQ(rumple_frame_get_view(nullptr, nullptr), RUMPLE_INVALID);
    EXPECT_EQ(rumple_wrinkle_mesh_shown(nullptr, false), nullptr);
    EXPECT_EQ(rumple_surface_warning(nullptr, 0), nullptr);
    EXPECT_EQ(rumple_surface_warning(sheet.surface(), -1), nullptr);
    EXPECT_EQ(rumple_struct_size(nullptr), 0u);
    rumple_surface_free(nullptr);
    rumple_wrinkle_mesh_free(nullptr);
    rumple_wrinkle_mesh_state_free(nullptr);
    rumple_frame_free(nullptr);
}

TEST(ApiErrors, AChoiceThatIsNoneIsRefused) {
    const Sheet sheet;
    rumple_wrinkle_mesh_settings settings = rumple_wrinkle_mesh_settings_default();
    rumple_wrinkle_mesh_state* state = nullptr;
    for (const int32_t wrong : {-1, 3, 99}) {
        settings.collision = wrong;
        EXPECT_EQ(rumple_wrinkle_mesh_solve(sheet.model(), &settings, nullptr, sheet.pose(), nullptr, nullptr,
                                            &state),
                  RUMPLE_INVALID);
        EXPECT_EQ(std::string(rumple_error()), "collision: expected 0 to 2, got " + std::to_string(wrong));
    }
    settings = rumple_wrinkle_mesh_settings_default();
    settings.radius = -1.0f;
    EXPECT_EQ(
        rumple_wrinkle_mesh_solve(sheet.model(), &settings, nullptr, sheet.pose(), nullptr, nullptr, &state),
        RUMPLE_INVALID);
    EXPECT_NE(std::string(rumple_error()).find("radius"), std::string::npos);
    EXPECT_EQ(state, nullptr);
}

TEST(ApiErrors, WhatIsNotFiniteIsNamed) {
    Sheet sheet;
    sheet.positions[7] = std::numeric_limits<float>::quiet_NaN();  // of vertex 2
    const rumple_pose frame = sheet.frame();
    rumple_wrinkle_mesh_pose* pose = nullptr;
    EXPECT_EQ(rumple_wrinkle_mesh_pose_build(sheet.model(), &frame, &pose), RUMPLE_INVALID);
    EXPECT_EQ(pose, nullptr);
    EXPECT_NE(std::string(rumple_error()).find("positions: vertex 2 is not finite"), std::string::npos)
        << rumple_error();
}

TEST(ApiErrors, AnOutputOfAnotherLengthIsRefusedAndLeftAsItWas) {
    const Sheet sheet;
    const float up[3] = {0.0f, 0.0f, 1.0f};
    float follow[5] = {7.0f, 7.0f, 7.0f, 7.0f, 7.0f};
    for (const size_t wrong : {size_t(0), size_t(3), size_t(5)}) {
        EXPECT_EQ(rumple_surface_suggest_follow(sheet.surface(), up, follow, wrong), RUMPLE_INVALID);
        EXPECT_EQ(std::string(rumple_error()), "follow: expected 4 rows, got " + std::to_string(wrong));
    }
    for (const float value : follow) EXPECT_EQ(value, 7.0f);
}

}  // namespace
}  // namespace rumple::api
