// SPDX-License-Identifier: GPL-3.0-or-later
// Every system as a caller plays it, frame after frame: where a frame is refused, the state before it stays.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tests/api_sheet.h"

namespace rumple::api {

template <typename T>
std::shared_ptr<T> owned(T* handle, void (*free)(T*)) {
    return {handle, free};
}

// What a frame of a system was solved to, as numbers; empty where it was refused.
using Play = std::function<std::vector<float>(const std::vector<float>& positions)>;

struct System {
    std::string name;
    Play play;
};

inline rumple_pose pose_at(const std::vector<float>& positions) {
    rumple_pose pose = rumple_pose_default();
    pose.positions = positions.data();
    pose.positions_count = positions.size() / 3;
    return pose;
}

inline System play_mesh(const Sheet& sheet) {
    return {"Wrinkle Mesh",
            [&sheet, before = std::shared_ptr<rumple_wrinkle_mesh_state>()](
                const std::vector<float>& positions) mutable -> std::vector<float> {
                const rumple_pose in = pose_at(positions);
                rumple_wrinkle_mesh_pose* pose = nullptr;
                rumple_wrinkle_mesh_state* state = nullptr;
                const auto settings = rumple_wrinkle_mesh_settings_default();
                if (rumple_wrinkle_mesh_pose_build(sheet.model(), &in, &pose) != RUMPLE_OK) return {};
                const auto keep = owned(pose, rumple_wrinkle_mesh_pose_free);
                if (rumple_wrinkle_mesh_solve(sheet.model(), &settings, nullptr, pose, before.get(), nullptr,
                                              &state) != RUMPLE_OK)
                    return {};
                before = owned(state, rumple_wrinkle_mesh_state_free);
                rumple_wrinkle_mesh_state_view view;
                rumple_wrinkle_mesh_state_get_view(state, &view);
                return {view.offset, view.offset + 3 * view.offset_count};
            }};
}

inline System play_field(const Sheet& sheet) {
    rumple_wrinkle_field_plan plan = rumple_wrinkle_field_plan_default();
    plan.output = RUMPLE_FIELD_GEOMETRY;
    rumple_wrinkle_field* built = nullptr;
    EXPECT_EQ(rumple_wrinkle_field_build(sheet.surface(), &plan, &built), RUMPLE_OK) << rumple_error();
    return {"Wrinkle Field",
            [model = owned(built, rumple_wrinkle_field_free),
             before = std::shared_ptr<rumple_wrinkle_field_state>()](
                const std::vector<float>& positions) mutable -> std::vector<float> {
                const rumple_pose in = pose_at(positions);
                rumple_wrinkle_field_pose* pose = nullptr;
                rumple_wrinkle_field_state* state = nullptr;
                rumple_frame* frame = nullptr;
                const auto settings = rumple_wrinkle_field_settings_default();
                rumple_wrinkle_field_profile profile;
                rumple_wrinkle_field_profile_build(RUMPLE_PROFILE_SINE, nullptr, 0, &profile);
                if (rumple_wrinkle_field_pose_build(model.get(), &in, &pose) != RUMPLE_OK) return {};
                const auto keep = owned(pose, rumple_wrinkle_field_pose_free);
                if (rumple_wrinkle_field_solve(model.get(), &settings, nullptr, pose, before.get(), nullptr,
                                               nullptr, &state) != RUMPLE_OK)
                    return {};
                before = owned(state, rumple_wrinkle_field_state_free);
                if (rumple_wrinkle_field_show(model.get(), &settings, &profile, nullptr, pose, nullptr, 0,
                                              nullptr, state, &frame) != RUMPLE_OK)
                    return {};
                const auto keep_frame = owned(frame, rumple_frame_free);
                rumple_frame_view view;
                rumple_frame_get_view(frame, &view);
                return {view.positions, view.positions + 3 * view.vertex_count};
            }};
}

inline System play_paths(const Sheet& sheet) {
    const rumple_fine_plan plan = rumple_wrinkle_paths_plan_default();
    rumple_wrinkle_paths* built = nullptr;
    EXPECT_EQ(rumple_wrinkle_paths_build(sheet.surface(), &plan, &built), RUMPLE_OK) << rumple_error();
    return {"Wrinkle Paths",
            [model = owned(built, rumple_wrinkle_paths_free), time = 0.0,
             before = std::shared_ptr<rumple_wrinkle_paths_state>()](
                const std::vector<float>& positions) mutable -> std::vector<float> {
                rumple_pose in = pose_at(positions);
                in.time = time;
                rumple_wrinkle_paths_pose* pose = nullptr;
                rumple_wrinkle_paths_state* state = nullptr;
                const auto settings = rumple_wrinkle_paths_settings_default();
                if (rumple_wrinkle_paths_pose_build(model.get(), &in, &pose) != RUMPLE_OK) return {};
                const auto keep = owned(pose, rumple_wrinkle_paths_pose_free);
                if (rumple_wrinkle_paths_solve(model.get(), &settings, nullptr, pose, before.get(), nullptr,
                                               &state) != RUMPLE_OK)
                    return {};
                time += 0.04;
                before = owned(state, rumple_wrinkle_paths_state_free);
                rumple_wrinkle_paths_state_view view;
                rumple_wrinkle_paths_state_get_view(state, &view);
                return {view.compression, view.compression + view.compression_count};
            }};
}

inline System play_cloth(const Sheet& sheet, bool swings) {
    rumple_base_cloth* built = nullptr;
    EXPECT_EQ(rumple_base_cloth_build(sheet.surface(), &built), RUMPLE_OK) << rumple_error();
    return {swings ? "Base cloth that swings" : "Base cloth",
            [model = owned(built, rumple_base_cloth_free), swings,
             before = std::shared_ptr<rumple_base_cloth_state>()](
                const std::vector<float>& positions) mutable -> std::vector<float> {
                rumple_base_cloth_state* state = nullptr;
                auto settings = rumple_base_cloth_settings_default();
                settings.gravity[2] = -9.81f;
                auto swing = rumple_base_cloth_swing_default();
                swing.seconds = 0.04f;
                const rumple_status status =
                    swings ? rumple_base_cloth_swing_solve(model.get(), &settings, &swing, nullptr,
                                                           positions.data(), positions.size() / 3, nullptr,
                                                           before.get(), nullptr, &state)
                           : rumple_base_cloth_solve(model.get(), &settings, nullptr, positions.data(),
                                                     positions.size() / 3, nullptr, before.get(), nullptr,
                                                     &state);
                if (status != RUMPLE_OK) return {};
                before = owned(state, rumple_base_cloth_state_free);
                rumple_base_cloth_state_view view;
                rumple_base_cloth_state_get_view(state, &view);
                return {view.positions, view.positions + 3 * view.vertex_count};
            }};
}

inline System play_layers(const Sheet& sheet) {
    const rumple_wrinkle_layers_plan plan = rumple_wrinkle_layers_plan_default();
    rumple_wrinkle_layers* built = nullptr;
    EXPECT_EQ(rumple_wrinkle_layers_build(sheet.surface(), &plan, &built), RUMPLE_OK) << rumple_error();
    return {"Wrinkle Layers",
            [model = owned(built, rumple_wrinkle_layers_free),
             before = std::shared_ptr<rumple_wrinkle_layers_state>()](
                const std::vector<float>& positions) mutable -> std::vector<float> {
                const std::vector<rumple_wrinkle_mesh_settings> settings(
                    3, rumple_wrinkle_mesh_settings_default());
                rumple_wrinkle_layers_input input = rumple_wrinkle_layers_input_default();
                input.positions = positions.data();
                input.positions_count = positions.size() / 3;
                rumple_wrinkle_layers_state* state = nullptr;
                if (rumple_wrinkle_layers_solve(model.get(), settings.data(), settings.size(), nullptr,
                                                &input, before.get(), nullptr, 0, &state) != RUMPLE_OK)
                    return {};
                before = owned(state, rumple_wrinkle_layers_state_free);
                rumple_wrinkle_layers_state_view view;
                rumple_wrinkle_layers_state_get_view(state, &view);
                return {view.solved, view.solved + 3 * view.solved_count};
            }};
}

inline std::vector<System> systems(const Sheet& sheet) {
    return {play_mesh(sheet),         play_field(sheet),       play_paths(sheet),
            play_cloth(sheet, false), play_cloth(sheet, true), play_layers(sheet)};
}

}  // namespace rumple::api
