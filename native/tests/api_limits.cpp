// SPDX-License-Identifier: GPL-3.0-or-later
// Counts, states that were stored, budgets: what a caller can get wrong is refused in words before it is
// used.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/api_player.h"

namespace rumple::api {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr int32_t kLeast = std::numeric_limits<int32_t>::min(), kMost = std::numeric_limits<int32_t>::max();

void expect_refused(rumple_status status, const std::string& begins) {
    EXPECT_EQ(status, RUMPLE_INVALID) << begins;
    EXPECT_EQ(std::string(rumple_error()).substr(0, begins.size()), begins);
}

// A state that a file holds: one value of it is not finite, or far too large. It was taken, and every frame
// after it was not finite.
TEST(ApiLimits, AStateIsReadAsAWhole) {
    const Sheet sheet;
    const auto state = owned(sheet.solve(), rumple_wrinkle_mesh_state_free);
    rumple_wrinkle_mesh_state_view view;
    ASSERT_EQ(rumple_wrinkle_mesh_state_get_view(state.get(), &view), RUMPLE_OK);
    std::vector<float> offset(view.offset, view.offset + 3 * view.offset_count),
        length(view.solved_length, view.solved_length + view.solved_length_count);
    view.offset = offset.data();
    view.solved_length = length.data();
    rumple_wrinkle_mesh_state* read = nullptr;
    for (const float bad : {kNone, std::numeric_limits<float>::infinity(), 1e30f}) {
        offset[5] = bad;
        expect_refused(rumple_wrinkle_mesh_state_build(sheet.model(), &view, &read),
                       std::isfinite(bad) ? "offset: number 5: expected -1e+08 to 1e+08, got 1e+30"
                                          : "offset: vertex 1 is not finite");
    }
    offset[5] = 0.0f;
    length[3] = kNone;
    expect_refused(rumple_wrinkle_mesh_state_build(sheet.model(), &view, &read), "solved_length: number 3");
    EXPECT_EQ(read, nullptr);
}

// Cloth on a sheet, what is kept of a solved frame of it, and what harm to that is answered.
struct KeptCloth {
    Sheet sheet;
    std::shared_ptr<rumple_base_cloth> model;
    std::shared_ptr<rumple_base_cloth_state> state;
    rumple_base_cloth_kept good{};

    explicit KeptCloth(bool swings) {
        rumple_base_cloth* built = nullptr;
        EXPECT_EQ(rumple_base_cloth_build(sheet.surface(), &built), RUMPLE_OK);
        model = owned(built, rumple_base_cloth_free);
        const rumple_base_cloth_settings settings = rumple_base_cloth_settings_default();
        const rumple_base_cloth_swing swing = rumple_base_cloth_swing_default();
        const float* at = sheet.positions.data();
        rumple_base_cloth_state* solved = nullptr;
        EXPECT_EQ(swings ? rumple_base_cloth_swing_solve(built, &settings, &swing, nullptr, at, 4, nullptr,
                                                         nullptr, nullptr, &solved)
                         : rumple_base_cloth_solve(built, &settings, nullptr, at, 4, nullptr, nullptr,
                                                   nullptr, &solved),
                  RUMPLE_OK);
        state = owned(solved, rumple_base_cloth_state_free);
        EXPECT_EQ(rumple_base_cloth_state_get_kept(solved, &good), RUMPLE_OK);
    }
    template <typename Harm>
    void refuses(const std::string& begins, const Harm& harm) const {
        rumple_base_cloth_kept kept = good;
        harm(kept);
        rumple_base_cloth_state* read = nullptr;
        expect_refused(rumple_base_cloth_state_build(model.get(), &kept, &read), begins);
        EXPECT_EQ(read, nullptr);
    }
    void takes_the_good() const {
        rumple_base_cloth_state* read = nullptr;
        ASSERT_EQ(rumple_base_cloth_state_build(model.get(), &good, &read), RUMPLE_OK) << rumple_error();
        rumple_base_cloth_state_free(read);
    }
};

// A hint of the cloth's own triangles is looked up as it is.
TEST(ApiLimits, KeptClothIsReadAsAWhole) {
    const KeptCloth cloth(false);
    std::vector<int32_t> hints(cloth.good.contact_hint, cloth.good.contact_hint + 4);
    for (const int32_t bad : {kLeast, -2, 2, kMost}) {
        hints[3] = bad;
        cloth.refuses("contact_hint: expected -1 to 1, got",
                      [&](auto& kept) { kept.contact_hint = hints.data(); });
    }
    std::vector<float> offset(cloth.good.offset, cloth.good.offset + 12);
    offset[5] = kNone;
    cloth.refuses("offset: vertex 1 is not finite", [&](auto& kept) { kept.offset = offset.data(); });
    std::vector<float> clearance(4, std::numeric_limits<float>::infinity());  // found by the fuzzer
    cloth.refuses("clearance: number 0 is not finite",
                  [&](auto& kept) { kept.clearance = clearance.data(); });
    cloth.refuses("moved: expected 0 to", [](auto& kept) { kept.moved = kNone; });
    cloth.refuses("fastest: expected 0 to", [](auto& kept) { kept.fastest = -1.0f; });
    cloth.refuses("wind: expected", [](auto& kept) { kept.wind[1] = 1e30f; });
    cloth.refuses("offset", [](auto& kept) { kept.offset_count = 0; });
    cloth.refuses("contact_hint", [](auto& kept) { kept.contact_hint_count = 0; });
    cloth.refuses("length", [](auto& kept) { kept.length_count -= 1; });
    cloth.refuses("body_hint",
                  [](auto& kept) { kept.body_hint = kept.contact_hint, kept.body_hint_count = 3; });
    cloth.takes_the_good();
}

// Found by the fuzzer: positions of cloth that swings were taken without its velocities, and the next frame
// read beyond the end of those.
TEST(ApiLimits, KeptClothThatSwingsHasAllOfItsMotion) {
    const KeptCloth cloth(true);
    cloth.refuses("velocity: expected 4 rows, got 0", [](auto& kept) { kept.velocity_count = 0; });
    cloth.refuses("animated: expected 4 rows, got 0", [](auto& kept) { kept.animated_count = 0; });
    cloth.refuses("animated_before: expected 4 rows, got 0",
                  [](auto& kept) { kept.animated_before_count = 0; });
    cloth.refuses("velocity: expected 0 rows, got 4", [](auto& kept) { kept.position_count = 0; });
    cloth.refuses("offset: expected 0 rows, got 4", [](auto& kept) {
        kept.offset = kept.position;
        kept.offset_count = kept.position_count;
    });
    cloth.takes_the_good();
}

struct Field {
    Sheet sheet;
    std::shared_ptr<rumple_wrinkle_field> model;
    std::shared_ptr<rumple_waves> waves;
    rumple_wrinkle_field_settings settings = rumple_wrinkle_field_settings_default();
    std::vector<float> phase = std::vector<float>(4, 0.5f);

    Field() {
        const rumple_wrinkle_field_plan plan = rumple_wrinkle_field_plan_default();
        rumple_wrinkle_field* built = nullptr;
        EXPECT_EQ(rumple_wrinkle_field_build(sheet.surface(), &plan, &built), RUMPLE_OK) << rumple_error();
        model = owned(built, rumple_wrinkle_field_free);
        rumple_waves* estimated = nullptr;
        EXPECT_EQ(rumple_wrinkle_field_estimate_waves(built, &settings, nullptr, sheet.positions.data(), 4,
                                                      nullptr, &estimated),
                  RUMPLE_OK);
        waves = owned(estimated, rumple_waves_free);
    }
    rumple_status relax(int32_t rounds) {
        return rumple_wrinkle_field_relax(model.get(), &settings, waves.get(), rounds, false, phase.data(),
                                          4);
    }
};

// -1 rounds took the last buffer of two from before the first one.
TEST(ApiLimits, RoundsAndThreadsOfTheStepsAreChecked) {
    Field field;
    EXPECT_EQ(field.relax(2), RUMPLE_OK) << rumple_error();
    for (const int32_t rounds : {-1, kLeast, kMost}) expect_refused(field.relax(rounds), "rounds: ");
    for (const int32_t threads : {-1, 100'000, kMost}) {
        field.settings.threads = threads;
        expect_refused(field.relax(2), "threads: ");
    }
    field.settings.threads = 1;
    field.phase[2] = kNone;
    expect_refused(field.relax(2), "phase: vertex 2 is not finite");
    Field other;
    expect_refused(rumple_wrinkle_field_relax(field.model.get(), &other.settings, other.waves.get(), 1, false,
                                              other.phase.data(), 4),
                   "waves: it was made for another model");
}

// Found by the fuzzer: what a frame is shown over was read without a look at how much of it there is.
TEST(ApiLimits, LayersAreShownOverAsManyPositionsAsTheBaseHas) {
    const Sheet sheet;
    const rumple_wrinkle_layers_plan plan = rumple_wrinkle_layers_plan_default();
    rumple_wrinkle_layers* built = nullptr;
    ASSERT_EQ(rumple_wrinkle_layers_build(sheet.surface(), &plan, &built), RUMPLE_OK) << rumple_error();
    const auto model = owned(built, rumple_wrinkle_layers_free);
    const std::vector<rumple_wrinkle_mesh_settings> settings(3, rumple_wrinkle_mesh_settings_default());
    rumple_wrinkle_layers_input input = rumple_wrinkle_layers_input_default();
    input.positions = sheet.positions.data();
    input.positions_count = 4;
    rumple_wrinkle_layers_state* solved = nullptr;
    ASSERT_EQ(
        rumple_wrinkle_layers_solve(built, settings.data(), 3, nullptr, &input, nullptr, nullptr, 0, &solved),
        RUMPLE_OK);
    const auto state = owned(solved, rumple_wrinkle_layers_state_free);
    const float* at = sheet.positions.data();
    rumple_frame* frame = nullptr;
    expect_refused(rumple_wrinkle_layers_show(built, at, 3, at, 4, solved, false, &frame),
                   "animated: expected 4 vertices");
    expect_refused(rumple_wrinkle_layers_show(built, at, 4, at, 3, solved, false, &frame),
                   "positions: expected 4 vertices");
    ASSERT_EQ(rumple_wrinkle_layers_show(built, at, 4, at, 4, solved, false, &frame), RUMPLE_OK)
        << rumple_error();
    rumple_frame_free(frame);
}

// Nothing is written where one of many places is wrong.
TEST(ApiLimits, NothingIsWrittenByACallThatIsRefused) {
    const Field field;
    rumple_wrinkle_field_profile profile;
    ASSERT_EQ(rumple_wrinkle_field_profile_build(RUMPLE_PROFILE_SINE, nullptr, 0, &profile), RUMPLE_OK);
    const int32_t triangles[] = {0, 2};
    const float places[] = {0.2f, 0.2f, 0.2f, 0.2f};
    float heights[] = {7.0f, 7.0f}, gradients[6] = {};
    expect_refused(
        rumple_wrinkle_field_evaluate(field.model.get(), field.waves.get(), &profile, field.phase.data(), 4,
                                      triangles, places, 2, heights, gradients),
        "triangle 1: expected 0 to 1, got 2");
    EXPECT_EQ(heights[0], 7.0f);
}

// A place beyond all triangles was taken, and its gradient was not finite.
TEST(ApiLimits, APlaceIsOnItsTriangle) {
    const Field field;
    rumple_wrinkle_field_profile profile;
    ASSERT_EQ(rumple_wrinkle_field_profile_build(RUMPLE_PROFILE_SINE, nullptr, 0, &profile), RUMPLE_OK);
    const int32_t triangles[] = {0, 1};
    const float places[] = {0.2f, 0.2f, std::numeric_limits<float>::max(), 0.2f};
    float heights[2] = {}, gradients[6] = {};
    expect_refused(
        rumple_wrinkle_field_evaluate(field.model.get(), field.waves.get(), &profile, field.phase.data(), 4,
                                      triangles, places, 2, heights, gradients),
        "barycentric: place 1: expected -1 to 2, got 3.40282e+38");
}

// A negative number of display steps made the estimate small, and the memory large.
TEST(ApiLimits, NoPlanGoesRoundTheBudget) {
    const Sheet sheet;
    const auto build = [&](auto&& change) {
        rumple_wrinkle_mesh_plan plan = rumple_wrinkle_mesh_plan_default();
        change(plan);
        rumple_wrinkle_mesh* model = nullptr;
        const rumple_status status = rumple_wrinkle_mesh_build(sheet.surface(), &plan, &model);
        rumple_wrinkle_mesh_free(model);
        return status;
    };
    for (const int32_t steps : {-1, -7, 9, kLeast, kMost}) {
        expect_refused(build([&](auto& plan) {
                           plan.fine.level = 7;
                           plan.display_steps = steps;
                       }),
                       "display_steps: expected 0 to 8, got ");
    }
    for (const int32_t segments : {0, -1, 1025, kMost}) {
        expect_refused(build([&](auto& plan) {
                           plan.fine.source = RUMPLE_FINE_REGULAR;
                           plan.fine.segments = segments;
                       }),
                       "segments: expected 1 to 1024, got ");
    }
    expect_refused(build([&](auto& plan) {
                       plan.fine.level = 8;
                       plan.display_steps = 8;
                   }),
                   "the fine mesh would have about 4294967296 vertices, more than ");
    for (const float length : {1e-30f, 1e-3f}) {
        expect_refused(build([&](auto& plan) {
                           plan.fine.source = RUMPLE_FINE_EDGE_LENGTH;
                           plan.fine.longest_edge = length;
                           plan.fine.most_vertices = 1000;
                       }),
                       "longest: edges of at most ");
    }
    // 40 vertices fit, but not sixteen times as many.
    const auto fine = [](int32_t steps) {
        return [steps](auto& plan) {
            plan.fine.source = RUMPLE_FINE_EDGE_LENGTH;
            plan.fine.longest_edge = 0.25f;
            plan.fine.most_vertices = 200;
            plan.display_steps = steps;
        };
    };
    EXPECT_EQ(build(fine(0)), RUMPLE_OK) << rumple_error();
    expect_refused(build(fine(2)), "longest: edges of at most 0.25 need more than ");
}

TEST(ApiLimits, PaintAndGapsAreNumbersInTheirRange) {
    const Sheet sheet;
    rumple_wrinkle_mesh_paint* paint = nullptr;
    for (const float bad : {kNone, -0.1f, 1.5f}) {
        const float radius[] = {1.0f, 1.0f, 1.0f, bad};
        rumple_wrinkle_mesh_painted painted{};
        painted.radius = radius;
        painted.radius_count = 4;
        expect_refused(rumple_wrinkle_mesh_paint_build(sheet.model(), &painted, &paint),
                       "radius: number 3: ");
    }
}

// What is painted for one layer was taken as it came: with what is no number a vertex had no radius that
// bounds it.
TEST(ApiLimits, PaintOfOneLayerIsInItsRange) {
    const Sheet sheet;
    const rumple_wrinkle_layers_plan plan = rumple_wrinkle_layers_plan_default();
    rumple_wrinkle_layers* built = nullptr;
    ASSERT_EQ(rumple_wrinkle_layers_build(sheet.surface(), &plan, &built), RUMPLE_OK) << rumple_error();
    const auto model = owned(built, rumple_wrinkle_layers_free);
    for (const float bad : {kNone, -0.1f, 1.5f}) {
        const float values[] = {1.0f, 1.0f, 1.0f, bad};
        const float* const strength[] = {nullptr, values, nullptr};
        rumple_wrinkle_layers_painted painted{};
        painted.strength = strength;
        painted.strength_count = 3;
        rumple_wrinkle_layers_paint* paint = nullptr;
        expect_refused(rumple_wrinkle_layers_paint_build(built, &painted, &paint), "strength: number 3: ");
    }
}

TEST(ApiLimits, AMatrixWithoutAnInverseIsRefused) {
    const Sheet sheet;
    rumple_wrinkle_mesh_settings settings = rumple_wrinkle_mesh_settings_default();
    settings.offset_space = RUMPLE_OFFSETS_WORLD;
    for (const float scale : {0.0f, kNone}) {
        rumple_pose frame = sheet.frame();
        frame.world_from_object[4] = scale;
        rumple_wrinkle_mesh_pose* built = nullptr;
        ASSERT_EQ(rumple_wrinkle_mesh_pose_build(sheet.model(), &frame, &built), RUMPLE_OK) << rumple_error();
        const auto pose = owned(built, rumple_wrinkle_mesh_pose_free);
        rumple_wrinkle_mesh_state* state = nullptr;
        expect_refused(
            rumple_wrinkle_mesh_solve(sheet.model(), &settings, nullptr, built, nullptr, nullptr, &state),
            "world_from_object: ");
    }
}

}  // namespace
}  // namespace rumple::api
