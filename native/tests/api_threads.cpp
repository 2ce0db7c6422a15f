// SPDX-License-Identifier: GPL-3.0-or-later
// What rumple.h promises of threads: any number of them may use a model and a state at the same time. The
// bits are compared here; that nobody writes what another reads is seen by ThreadSanitizer (the preset tsan).
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace rumple::api
