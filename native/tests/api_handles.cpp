// SPDX-License-Identifier: GPL-3.0-or-later
// Who keeps what: handles of the C library know their model, and hold it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "api/sizes.h"
#include "surface/cloth/swing.h"
#include "systems/wrinkle_field/wrinkle_field.h"
#include "systems/wrinkle_mesh/wrinkle_mesh.h"
#include "systems/wrinkle_paths/wrinkle_paths.h"
#include "tests/api_player.h"

namespace rumple::api {
namespace {

TEST(ApiHandles, AStateOfAnotherModelIsRefusedThoughItsMeshIsTheSame) {
    const Sheet one, other;
    rumple_wrinkle_mesh_state* state = one.solve();
    rumple_wrinkle_mesh_state_free(one.solve(state));  // its own goes on

    const rumple_wrinkle_mesh_settings settings = rumple_wrinkle_mesh_settings_default();
    rumple_wrinkle_mesh_state* next = nullptr;
    EXPECT_EQ(
        rumple_wrinkle_mesh_solve(other.model(), &settings, nullptr, other.pose(), state, nullptr, &next),
        RUMPLE_INVALID);
    EXPECT_STREQ(rumple_error(), "state: it was made for another model");
    rumple_frame* frame = nullptr;
    EXPECT_EQ(rumple_wrinkle_mesh_show(other.model(), &settings, other.pose(), state, false, &frame),
              RUMPLE_INVALID);
    EXPECT_EQ(frame, nullptr);
    rumple_wrinkle_mesh_state_free(state);
}

TEST(ApiHandles, APoseOfAnotherModelIsRefusedThoughItsMeshIsTheSame) {
    const Sheet one, other;
    const rumple_wrinkle_mesh_settings settings = rumple_wrinkle_mesh_settings_default();
    rumple_wrinkle_mesh_state* state = nullptr;
    EXPECT_EQ(
        rumple_wrinkle_mesh_solve(one.model(), &settings, nullptr, other.pose(), nullptr, nullptr, &state),
        RUMPLE_INVALID);
    EXPECT_STREQ(rumple_error(), "pose: it was made for another model");
}

// What a drawing of the Wrinkle Paths reads of a frame are its positions, long after the pose was made.
TEST(ApiHandles, APoseKeepsItsModelAndWhatItWasMadeOf) {
    Sheet sheet;
    rumple_fine_plan plan = rumple_wrinkle_paths_plan_default();
    rumple_wrinkle_paths* model = nullptr;
    ASSERT_EQ(rumple_wrinkle_paths_build(sheet.surface(), &plan, &model), RUMPLE_OK);
    const rumple_wrinkle_paths_settings settings = rumple_wrinkle_paths_settings_default();
    const rumple_pose frame = sheet.frame();
    rumple_wrinkle_paths_pose* pose = nullptr;
    rumple_wrinkle_paths_state* state = nullptr;
    ASSERT_EQ(rumple_wrinkle_paths_pose_build(model, &frame, &pose), RUMPLE_OK);
    ASSERT_EQ(rumple_wrinkle_paths_solve(model, &settings, nullptr, pose, nullptr, nullptr, &state),
              RUMPLE_OK);
    const auto offsets = [&] {
        rumple_drawing* drawing = nullptr;
        EXPECT_EQ(rumple_wrinkle_paths_draw(model, &settings, pose, state, &drawing), RUMPLE_OK);
        rumple_drawing_view view{};
        EXPECT_EQ(rumple_drawing_get_view(drawing, &view), RUMPLE_OK);
        std::vector<float> out(view.proxy_offset, view.proxy_offset + 12);
        rumple_drawing_free(drawing);
        return out;
    };
    const std::vector<float> before = offsets();
    sheet.positions.assign(sheet.positions.size(), 7.0f);
    EXPECT_EQ(offsets(), before);
    rumple_wrinkle_paths_free(model);
    rumple_wrinkle_paths_state_free(state);
    rumple_wrinkle_paths_pose_free(pose);
}

TEST(ApiHandles, PaintOfAnotherModelIsRefused) {
    const Sheet one, other;
    const float half[4] = {0.5f, 0.5f, 0.5f, 0.5f};
    rumple_wrinkle_mesh_painted painted{};
    painted.radius = half;
    painted.radius_count = 4;
    rumple_wrinkle_mesh_paint* paint = nullptr;
    ASSERT_EQ(rumple_wrinkle_mesh_paint_build(one.model(), &painted, &paint), RUMPLE_OK);
    const rumple_wrinkle_mesh_settings settings = rumple_wrinkle_mesh_settings_default();
    rumple_wrinkle_mesh_state* state = nullptr;
    EXPECT_EQ(
        rumple_wrinkle_mesh_solve(other.model(), &settings, paint, other.pose(), nullptr, nullptr, &state),
        RUMPLE_INVALID);
    EXPECT_STREQ(rumple_error(), "paint: it was made for another model");
    rumple_wrinkle_mesh_paint_free(paint);
    painted.radius_count = 3;
    EXPECT_EQ(rumple_wrinkle_mesh_paint_build(one.model(), &painted, &paint), RUMPLE_INVALID);
    EXPECT_STREQ(rumple_error(), "radius: expected 4 values, got 3");
}

TEST(ApiHandles, AFrameAndAStateOutliveTheirModel) {
    rumple_frame* frame = nullptr;
    rumple_wrinkle_mesh_state* state = nullptr;
    {
        const Sheet sheet;
        state = sheet.solve();
        const rumple_wrinkle_mesh_settings settings = rumple_wrinkle_mesh_settings_default();
        ASSERT_EQ(rumple_wrinkle_mesh_show(sheet.model(), &settings, sheet.pose(), state, false, &frame),
                  RUMPLE_OK);
    }
    const std::vector<float> moved{0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
    rumple_frame_view before{}, after{};
    ASSERT_EQ(rumple_frame_get_view(frame, &before), RUMPLE_OK);
    const std::vector<float> offsets(before.local_offset, before.local_offset + 3 * before.vertex_count);
    ASSERT_EQ(rumple_frame_embed(frame, moved.data(), 4), RUMPLE_OK) << rumple_error();
    ASSERT_EQ(rumple_frame_get_view(frame, &after), RUMPLE_OK);
    EXPECT_EQ(after.local_offset, before.local_offset);  // where it lay already
    EXPECT_NE(std::memcmp(after.local_offset, offsets.data(), offsets.size() * sizeof(float)), 0);
    EXPECT_EQ(rumple_frame_embed(frame, moved.data(), 3), RUMPLE_INVALID);
    rumple_wrinkle_mesh_state_view view{};
    EXPECT_EQ(rumple_wrinkle_mesh_state_get_view(state, &view), RUMPLE_OK);
    EXPECT_GT(view.offset_count, 4u);
    rumple_wrinkle_mesh_state_free(state);
    rumple_frame_free(frame);
}

TEST(ApiHandles, AStateOfPlainArraysGoesOnAsTheOneThatTheyAreOf) {
    const Sheet sheet;
    rumple_wrinkle_mesh_state *state = sheet.solve(), *again = nullptr;
    rumple_wrinkle_mesh_state_view view{}, one{}, two{};
    ASSERT_EQ(rumple_wrinkle_mesh_state_get_view(state, &view), RUMPLE_OK);
    ASSERT_EQ(rumple_wrinkle_mesh_state_build(sheet.model(), &view, &again), RUMPLE_OK) << rumple_error();
    rumple_wrinkle_mesh_state *next = sheet.solve(state), *next_again = sheet.solve(again);
    ASSERT_EQ(rumple_wrinkle_mesh_state_get_view(next, &one), RUMPLE_OK);
    ASSERT_EQ(rumple_wrinkle_mesh_state_get_view(next_again, &two), RUMPLE_OK);
    ASSERT_EQ(one.offset_count, two.offset_count);
    EXPECT_EQ(std::memcmp(one.offset, two.offset, one.offset_count * 3 * sizeof(float)), 0);
    for (rumple_wrinkle_mesh_state* each : {state, again, next, next_again})
        rumple_wrinkle_mesh_state_free(each);
}

// Cloth at rest and cloth that swings, two frames, and a third from what was kept of the second.
TEST(ApiHandles, KeptClothGoesOnAsTheOneThatItIsOf) {
    const Sheet sheet;
    rumple_base_cloth* model = nullptr;
    ASSERT_EQ(rumple_base_cloth_build(sheet.surface(), &model), RUMPLE_OK);
    const auto cloth = owned(model, rumple_base_cloth_free);
    const rumple_base_cloth_settings settings = rumple_base_cloth_settings_default();
    rumple_base_cloth_swing swing = rumple_base_cloth_swing_default();
    swing.seconds = 0.04f;
    for (const bool swings : {false, true}) {
        float squeeze = 1.0f;
        const auto solve = [&](const rumple_base_cloth_state* before) {
            std::vector<float> at = sheet.positions;
            for (size_t v = 0; v < 4; ++v) at[3 * v] *= squeeze;
            rumple_base_cloth_state* state = nullptr;
            EXPECT_EQ(swings ? rumple_base_cloth_swing_solve(model, &settings, &swing, nullptr, at.data(), 4,
                                                             nullptr, before, nullptr, &state)
                             : rumple_base_cloth_solve(model, &settings, nullptr, at.data(), 4, nullptr,
                                                       before, nullptr, &state),
                      RUMPLE_OK)
                << rumple_error();
            return owned(state, rumple_base_cloth_state_free);
        };
        const auto first = solve(nullptr);
        squeeze = 0.9f;
        const auto second = solve(first.get());
        rumple_base_cloth_kept kept;
        ASSERT_EQ(rumple_base_cloth_state_get_kept(second.get(), &kept), RUMPLE_OK);
        EXPECT_EQ(kept.position_count, swings ? 4u : 0u);
        rumple_base_cloth_state* built = nullptr;
        ASSERT_EQ(rumple_base_cloth_state_build(model, &kept, &built), RUMPLE_OK) << rumple_error();
        const auto again = owned(built, rumple_base_cloth_state_free);
        squeeze = 0.8f;
        rumple_base_cloth_state_view one, two, jumped;
        ASSERT_EQ(rumple_base_cloth_state_get_view(again.get(), &one), RUMPLE_OK);
        EXPECT_EQ(one.vertex_count, 0);
        const auto next = solve(second.get()), next_again = solve(again.get()), alone = solve(nullptr);
        ASSERT_EQ(rumple_base_cloth_state_get_view(next.get(), &one), RUMPLE_OK);
        ASSERT_EQ(rumple_base_cloth_state_get_view(next_again.get(), &two), RUMPLE_OK);
        ASSERT_EQ(rumple_base_cloth_state_get_view(alone.get(), &jumped), RUMPLE_OK);
        EXPECT_EQ(std::memcmp(one.positions, two.positions, 12 * sizeof(float)), 0);
        EXPECT_NE(std::memcmp(one.positions, jumped.positions, 12 * sizeof(float)), 0);  // it counts
    }
}

TEST(ApiHandles, AFrameOfAnotherSystemHasNoWavesAndNoFolds) {
    const Sheet sheet;
    rumple_wrinkle_mesh_state* state = sheet.solve();
    const rumple_wrinkle_mesh_settings settings = rumple_wrinkle_mesh_settings_default();
    rumple_frame* frame = nullptr;
    ASSERT_EQ(rumple_wrinkle_mesh_show(sheet.model(), &settings, sheet.pose(), state, false, &frame),
              RUMPLE_OK);
    rumple_frame_waves_view waves{};
    rumple_frame_folds_view folds{};
    EXPECT_EQ(rumple_frame_get_waves(frame, &waves), RUMPLE_INVALID);
    EXPECT_EQ(rumple_frame_get_folds(frame, &folds), RUMPLE_INVALID);
    rumple_frame_free(frame);
    rumple_wrinkle_mesh_state_free(state);
}

TEST(ApiHandles, EveryStructIsKnownByNameAndSize) {
    EXPECT_STREQ(rumple_version(), RUMPLE_VERSION);
    EXPECT_EQ(rumple_struct_size("rumple_pose"), sizeof(rumple_pose));
    EXPECT_EQ(rumple_struct_size("rumple_wrinkle_paths_settings"), sizeof(rumple_wrinkle_paths_settings));
    EXPECT_EQ(rumple_struct_size("rumple_nothing"), 0u);
    for (const StructSize& known : kStructSizes) EXPECT_EQ(rumple_struct_size(known.name), known.size);
}

// Defaults stand in C++, once; a field that pair_fields() forgets would be 0 in C.
TEST(ApiHandles, DefaultsAreThoseOfTheSystems) {
    const wrinkle_mesh::Settings mesh;
    const rumple_wrinkle_mesh_settings c_mesh = rumple_wrinkle_mesh_settings_default();
    EXPECT_EQ(c_mesh.radius, mesh.radius);
    EXPECT_EQ(c_mesh.collision, RUMPLE_COLLISION_PLANE);
    EXPECT_EQ(c_mesh.compression_limit, mesh.compression_limit);
    EXPECT_EQ(c_mesh.start_iterations, mesh.start_iterations);
    EXPECT_EQ(c_mesh.nudge, mesh.nudge);
    EXPECT_EQ(c_mesh.rest.reference, RUMPLE_REFERENCE_STATIC_REST);
    EXPECT_EQ(c_mesh.rest.growth, mesh.rest.growth);
    const base_cloth::Settings cloth;
    const rumple_base_cloth_settings c_cloth = rumple_base_cloth_settings_default();
    EXPECT_EQ(c_cloth.gravity[2], cloth.gravity.z);
    EXPECT_EQ(c_cloth.spread, cloth.clearance.spread);
    EXPECT_EQ(c_cloth.most_cg_iterations, cloth.most_cg_iterations);
    const rumple_base_cloth_swing swing = rumple_base_cloth_swing_default();
    EXPECT_EQ(swing.longest_step, base_cloth::Swing{}.longest_step);
    for (int k = 0; k < 9; ++k) EXPECT_EQ(swing.matrix[k], k % 4 ? 0.0f : 1.0f);
    const wrinkle_field::Settings field;
    const rumple_wrinkle_field_settings c_field = rumple_wrinkle_field_settings_default();
    EXPECT_EQ(c_field.rate, field.rate);
    EXPECT_EQ(c_field.start_rounds, field.start_rounds);
    EXPECT_EQ(c_field.dissolve, field.dissolve);
    const wrinkle_paths::Settings paths;
    const rumple_wrinkle_paths_settings c_paths = rumple_wrinkle_paths_settings_default();
    EXPECT_EQ(c_paths.threshold, paths.threshold);
    EXPECT_EQ(c_paths.rest.reference, RUMPLE_REFERENCE_REST);
    EXPECT_EQ(c_paths.height, paths.height);
}

}  // namespace
}  // namespace rumple::api
