// SPDX-License-Identifier: GPL-3.0-or-later
// What rumple.h promises of threads: any number of them may use a model and a state at the same time. The
// bits are compared here; that nobody writes what another reads is seen by ThreadSanitizer (the preset tsan).
#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <thread>
#include <vector>

#include "tests/api_sheet.h"

namespace rumple::api {
namespace {

constexpr int kThreads = 4;

// Runs work(number) on all threads at once.
template <typename Work>
void together(const Work& work) {
    std::vector<std::thread> threads;
    for (int number = 0; number < kThreads; ++number) threads.emplace_back([&work, number] { work(number); });
    for (std::thread& thread : threads) thread.join();
}

// The offsets of the frame after `before`, solved and shown.
std::vector<float> frame_after(const Sheet& sheet, const rumple_wrinkle_mesh_state* before) {
    rumple_wrinkle_mesh_state* state = sheet.solve(before);
    const rumple_wrinkle_mesh_settings settings = rumple_wrinkle_mesh_settings_default();
    rumple_frame* frame = nullptr;
    EXPECT_EQ(rumple_wrinkle_mesh_show(sheet.model(), &settings, sheet.pose(), state, false, &frame),
              RUMPLE_OK);
    rumple_frame_view view{};
    EXPECT_EQ(rumple_frame_get_view(frame, &view), RUMPLE_OK);
    std::vector<float> offsets(view.offset, view.offset + 3 * view.vertex_count);
    rumple_frame_free(frame);
    rumple_wrinkle_mesh_state_free(state);
    return offsets;
}

TEST(ApiThreads, ShareAModelAndAState) {
    const Sheet sheet;
    rumple_wrinkle_mesh_state* before = sheet.solve();
    const std::vector<float> alone = frame_after(sheet, before);
    ASSERT_FALSE(alone.empty());
    std::vector<std::vector<float>> found(kThreads);
    together([&](int number) { found[number] = frame_after(sheet, before); });
    for (const std::vector<float>& offsets : found) {
        ASSERT_EQ(offsets.size(), alone.size());
        EXPECT_EQ(std::memcmp(offsets.data(), alone.data(), alone.size() * sizeof(float)), 0);
    }
    rumple_wrinkle_mesh_state_free(before);
}

// A state of the Wrinkle Paths makes its arrays when somebody asks for them first.
TEST(ApiThreads, AskTogetherForArraysThatNobodyHasAskedFor) {
    const Sheet sheet;
    const rumple_fine_plan plan = rumple_wrinkle_paths_plan_default();
    rumple_wrinkle_paths* model = nullptr;
    ASSERT_EQ(rumple_wrinkle_paths_build(sheet.surface(), &plan, &model), RUMPLE_OK) << rumple_error();
    const rumple_wrinkle_paths_settings settings = rumple_wrinkle_paths_settings_default();
    rumple_wrinkle_paths_state* state = nullptr;
    const rumple_pose frame = sheet.frame();
    rumple_wrinkle_paths_pose* pose = nullptr;
    ASSERT_EQ(rumple_wrinkle_paths_pose_build(model, &frame, &pose), RUMPLE_OK) << rumple_error();
    ASSERT_EQ(rumple_wrinkle_paths_solve(model, &settings, nullptr, pose, nullptr, nullptr, &state),
              RUMPLE_OK)
        << rumple_error();
    std::vector<rumple_wrinkle_paths_state_view> views(kThreads);
    together([&](int number) {
        EXPECT_EQ(rumple_wrinkle_paths_state_get_view(state, &views[number]), RUMPLE_OK);
    });
    ASSERT_NE(views[0].path_start, nullptr);
    for (const rumple_wrinkle_paths_state_view& view : views) {
        EXPECT_EQ(view.path_start, views[0].path_start);
        EXPECT_EQ(view.path_start_count, views[0].path_start_count);
    }
    rumple_wrinkle_paths_state_free(state);
    rumple_wrinkle_paths_pose_free(pose);
    rumple_wrinkle_paths_free(model);
}

// A collider keeps the pose that it was asked for last.
TEST(ApiThreads, ShareAColliderThatIsPosedInTurns) {
    const Sheet sheet;
    rumple_base_cloth* model = nullptr;
    ASSERT_EQ(rumple_base_cloth_build(sheet.surface(), &model), RUMPLE_OK) << rumple_error();
    const std::vector<std::vector<float>> poses{{-1, -1, -0.005f, 3, -1, -0.005f, -1, 3, -0.005f},
                                                {-1, -1, -0.001f, 3, -1, -0.001f, -1, 3, -0.001f}};
    const int32_t triangle[] = {0, 1, 2};
    rumple_collider* collider = nullptr;
    ASSERT_EQ(rumple_collider_build(poses[0].data(), 3, triangle, 1, nullptr, 0, 0.0f, &collider), RUMPLE_OK)
        << rumple_error();
    const auto cloth_over = [&](const std::vector<float>& body) {
        const rumple_base_cloth_settings settings = rumple_base_cloth_settings_default();
        const rumple_bodies bodies{collider, body.data(), 3};
        rumple_base_cloth_state* state = nullptr;
        EXPECT_EQ(rumple_base_cloth_solve(model, &settings, nullptr, sheet.positions.data(), 4, &bodies,
                                          nullptr, nullptr, &state),
                  RUMPLE_OK)
            << rumple_error();
        rumple_base_cloth_state_view view{};
        EXPECT_EQ(rumple_base_cloth_state_get_view(state, &view), RUMPLE_OK);
        const std::vector<float> positions(view.positions, view.positions + 12);
        rumple_base_cloth_state_free(state);
        return positions;
    };
    const std::vector<float> alone[] = {cloth_over(poses[0]), cloth_over(poses[1])};
    EXPECT_NE(alone[0], alone[1]);
    together([&](int number) {
        for (int turn = 0; turn < 8; ++turn)
            EXPECT_EQ(cloth_over(poses[(number + turn / 2) % 2]), alone[(number + turn / 2) % 2]);
    });
    rumple_collider_free(collider);
    rumple_base_cloth_free(model);
}

// A model of `levels` layers over the sheet; null where it was stopped.
rumple_wrinkle_layers* layers_over(const Sheet& sheet, int32_t levels, rumple_status& status) {
    rumple_wrinkle_layers_plan plan = rumple_wrinkle_layers_plan_default();
    plan.levels = levels;
    rumple_wrinkle_layers* model = nullptr;
    status = rumple_wrinkle_layers_build(sheet.surface(), &plan, &model);
    return model;
}

TEST(ApiThreads, WhatIsAskedToStopMakesNothing) {
    const Sheet sheet;
    rumple_stop* stop = nullptr;
    ASSERT_EQ(rumple_stop_build(&stop), RUMPLE_OK);
    rumple_status status = RUMPLE_OK;
    rumple_stop_watch(stop);
    rumple_wrinkle_layers_free(layers_over(sheet, 2, status));
    EXPECT_EQ(status, RUMPLE_OK);  // nobody has asked
    rumple_stop_ask(stop);
    EXPECT_EQ(layers_over(sheet, 2, status), nullptr);
    EXPECT_EQ(status, RUMPLE_STOPPED);
    EXPECT_STREQ(rumple_error(), "it was stopped");
    rumple_stop_watch(nullptr);
    rumple_wrinkle_layers_free(layers_over(sheet, 2, status));
    EXPECT_EQ(status, RUMPLE_OK);
    rumple_stop_free(stop);
}

TEST(ApiThreads, AThreadIsStoppedByAnotherAndNobodyElseIs) {
    const Sheet sheet;
    rumple_stop* stop = nullptr;
    ASSERT_EQ(rumple_stop_build(&stop), RUMPLE_OK);
    std::atomic<int> made = 0;
    std::thread maker([&] {
        rumple_stop_watch(stop);
        rumple_status status = RUMPLE_OK;
        while (status == RUMPLE_OK) {
            rumple_wrinkle_layers_free(layers_over(sheet, 2, status));
            if (status == RUMPLE_OK) ++made;
        }
        EXPECT_EQ(status, RUMPLE_STOPPED);
    });
    while (made == 0) std::this_thread::yield();
    rumple_stop_ask(stop);
    maker.join();
    rumple_status status = RUMPLE_OK;
    rumple_wrinkle_layers_free(layers_over(sheet, 2, status));
    EXPECT_EQ(status, RUMPLE_OK);
    rumple_stop_free(stop);
}

}  // namespace
}  // namespace rumple::api
