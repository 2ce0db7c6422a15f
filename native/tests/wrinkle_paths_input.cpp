// SPDX-License-Identifier: GPL-3.0-or-later
// Bad input to the Wrinkle Paths: refused, with a message that names what is bad.
#include <gtest/gtest.h>

#include <string>

#include "base/expect.h"
#include "tests/refusals.h"
#include "tests/wrinkle_paths_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_paths;

template <float Settings::*field>
float& own(Settings& settings) {
    return settings.*field;
}
template <float ReferenceSettings::*field>
float& of_rest(Settings& settings) {
    return settings.rest.*field;
}

struct Range {
    const char* name;
    float& (*field)(Settings&);
    float low;  // refused
    float first;
    float last;
    float high;  // refused
};

const Range kRanges[] = {
    {"window", of_rest<&ReferenceSettings::window>, -0.1f, 0.0f, 10.0f, 11.0f},
    {"relaxation", of_rest<&ReferenceSettings::relaxation>, -0.1f, 0.0f, 1.0f, 1.1f},
    {"growth", of_rest<&ReferenceSettings::growth>, 0.9f, 1.0f, 1e6f, 2e6f},
    {"growth_time", of_rest<&ReferenceSettings::growth_time>, -0.1f, 0.0f, 10.0f, 11.0f},
    {"smoothing", own<&Settings::smoothing>, -0.1f, 0.0f, 10.0f, 11.0f},
    {"threshold", own<&Settings::threshold>, 1.0f, 1.01f, 1e6f, 2e6f},
    {"reach", own<&Settings::reach>, -0.1f, 0.0f, 1.0f, 1.1f},
    {"width", own<&Settings::width>, 0.0f, 1e-4f, 1e6f, 2e6f},
    {"spacing", own<&Settings::spacing>, 0.0f, 0.1f, 1e6f, 2e6f},
    {"alignment", own<&Settings::alignment>, -0.1f, 0.0f, 1e6f, 2e6f},
    {"growth_limit", own<&Settings::growth_limit>, -0.1f, 0.0f, 1e6f, 2e6f},
    {"fade", own<&Settings::fade>, -0.1f, 0.0f, 1e6f, 2e6f},
    {"height", own<&Settings::height>, -0.1f, 0.0f, 1e6f, 2e6f},
};

TEST(WrinklePathsInput, ASettingOutOfItsRangeIsNamedWithItsRangeAndValue) {
    EXPECT_NO_THROW(check(Settings{}));
    const PathCloth cloth(grid(2, 2, 0.1f));
    for (const Range& range : kRanges) {
        for (const float value : {range.first, range.last}) {
            Settings settings;
            range.field(settings) = value;
            EXPECT_NO_THROW(check(settings)) << range.name << " = " << value;
        }
        for (const float value : {range.low, range.high, kNan, kInfinity, -kInfinity}) {
            PathCloth bad = cloth;
            range.field(bad.settings) = value;
            const std::string begins = std::string(range.name) + ": expected ";
            expect_refused([&] { check(bad.settings); }, {begins, "got " + short_text(value)});
            expect_refused([&] { bad.solve(bad.mesh.positions); }, {begins});
        }
    }
    PathCloth bad = cloth;
    bad.settings.hem_rings = -1;
    expect_refused([&] { bad.solve(bad.mesh.positions); }, {"hem_rings: expected ", "got -1"});
}

TEST(WrinklePathsInput, APoseThatIsNotFiniteNamesItsFirstBadVertex) {
    const PathCloth cloth(grid(2, 2, 0.1f));
    const State state = cloth.solve(cloth.mesh.positions);
    for (const float bad : {kNan, kInfinity, -kInfinity}) {
        Pose3 pose = cloth.mesh.positions;
        pose[5].y = pose[7].x = bad;
        expect_refused([&] { cloth.solve(pose, &state); }, {"positions", "vertex 5 "});
        expect_refused([&] { cloth.show(pose, state); }, {"positions", "vertex 5 "});
        expect_refused([&] { cloth.curves(pose, state); }, {"positions", "vertex 5 "});
    }
}

TEST(WrinklePathsInput, APoseOfAnotherMeshNamesBothCounts) {
    const PathCloth cloth(grid(2, 2, 0.1f));
    for (const size_t count : {size_t(0), size_t(8), size_t(10)}) {
        expect_refused([&] { cloth.solve(Pose3(count, Vec3(0.0f))); },
                       {"positions", "expected 9 ", "got " + std::to_string(count)});
    }
}

TEST(WrinklePathsInput, AStateOfAnotherMeshOrOfALaterTimeIsRefused) {
    const PathCloth cloth(grid(2, 2, 0.1f)), other(grid(3, 3, 0.1f));
    const State foreign = other.solve(other.mesh.positions);
    expect_refused([&] { cloth.solve(cloth.mesh.positions, &foreign); }, {"state.labels", "expected 8 "});
    State late = cloth.solve(cloth.mesh.positions);
    late.reference.time = 5.0;
    Input input;
    input.positions = cloth.mesh.positions;
    input.frame_time.time = 4.0;
    Report report;
    const Pose pose = make_pose(*cloth.model, input.positions);
    expect_refused([&] { solve(*cloth.model, cloth.settings, {}, input, pose, &late, report); },
                   {"time: ", "5.0", "4.0"});
    State spoiled = cloth.solve(cloth.mesh.positions);
    spoiled.paths = {{7, 1.0f, {{0, kNone, {0.1f, 0.1f}}, {3, kNone, {0.1f, 0.1f}}}}};
    expect_refused([&] { cloth.solve(cloth.mesh.positions, &spoiled); }, {"state.paths: path 7, point 1"});
    expect_refused([&] { cloth.show(cloth.mesh.positions, spoiled); }, {"state.paths: path 7, point 1"});
    spoiled.paths.clear();
    const auto refuses = [&](const char* name, const std::function<void(State&)>& spoil) {
        State bad = cloth.solve(cloth.mesh.positions);
        bad.paths = {{7, 1.0f, {{0, kNone, {0.1f, 0.1f}}, {0, kNone, {0.2f, 0.1f}}}}};
        EXPECT_NO_THROW(cloth.solve(cloth.mesh.positions, &bad));
        spoil(bad);
        expect_refused([&] { cloth.solve(cloth.mesh.positions, &bad); }, {std::string("state.") + name});
    };
    refuses("labels: number 3 ", [](State& s) { s.reference.labels[3] = 9; });
    refuses("reference: number 2 ", [](State& s) { s.reference.reference[2].x2 = kNan; });
    refuses("reference: number 2 ", [](State& s) { s.reference.reference[2].y2 = -1.0f; });
    refuses("shapes: number 2 ", [](State& s) { s.shapes[2].x1 = kNan; });
    refuses("compression: number 5 ", [](State& s) { s.compression[5] = 0.0f; });
    refuses("past_times: number 0 ", [](State& s) { s.reference.past_times[0] = 9.0; });
    refuses("past_times", [](State& s) { s.reference.past_times.clear(); });
    refuses("past_positions: number 4 ", [](State& s) { s.reference.past_positions[4].y = kInfinity; });
    refuses("past_positions: expected 9 ", [](State& s) { s.reference.past_positions.pop_back(); });
    refuses("path_fade: number 0 ", [](State& s) { s.paths[0].fade = 1.5f; });
}

TEST(WrinklePathsInput, LabelsPaintAndTimesAreChecked) {
    const PathCloth cloth(grid(2, 2, 0.1f));
    Input input;
    input.positions = cloth.mesh.positions;
    Report report;
    const auto call = [&](const Paint& paint) {
        const Pose pose = make_pose(*cloth.model, input.positions);
        return solve(*cloth.model, cloth.settings, paint, input, pose, nullptr, report);
    };
    expect_refused([&] { call({std::vector<float>(5, 1.0f)}); }, {"paint.mask", "expected 9 ", "got 5"});
    std::vector<float> mask(9, 1.0f);
    mask[4] = 1.5f;
    expect_refused([&] { call({mask}); }, {"paint.mask: vertex 4: expected 0 to 1, got 1.5"});
    mask[4] = kNan;
    expect_refused([&] { call({mask}); }, {"paint.mask: vertex 4: expected 0 to 1, got "});
    Labels labels(7, kRest);
    input.frame_time.labels = labels;
    expect_refused([&] { call({}); }, {"labels", "expected 8 ", "got 7"});
    labels.assign(8, 3);
    input.frame_time.labels = labels;
    expect_refused([&] { call({}); }, {"labels: expected 0..2, got 3"});
    input.frame_time.labels = {};
    input.frame_time.time = std::numeric_limits<double>::quiet_NaN();
    expect_refused([&] { call({}); }, {"time: "});
    input.frame_time.time = 1.0;
    input.frame_time.next_positions = cloth.mesh.positions;
    input.frame_time.next_time = 1.0;
    expect_refused([&] { call({}); }, {"next_time: expected later than 1.0"});
    const std::vector<Vec3> two(18, Vec3(0.0f));
    const std::vector<double> backwards{1.0, 0.5};
    expect_refused(
        [&] { label_clip(cloth.model->base, cloth.model->triangles, cloth.settings.rest, backwards, two); },
        {"times: ", "frame 1 "});
    expect_refused(
        [&] {
            label_clip(cloth.model->base, cloth.model->triangles, cloth.settings.rest, backwards,
                       std::span(two).first(17));
        },
        {"2 frames of 9 vertices", "got 17"});
}

// Collapsed and duplicated triangles are not refused: they have no direction, and folds end at them.
TEST(WrinklePathsInput, CollapsedTrianglesAreTolerated) {
    PathCloth cloth(grid(8, 8, 0.03f));
    Pose3 pose = cloth.squeezed(0.6f);
    for (int i = 30; i < 45; ++i) pose[i] = pose[30];
    Report report;
    State state = cloth.solve(cloth.mesh.positions);
    for (int f = 0; f < 20; ++f) {
        state = cloth.solve(f % 2 ? pose : cloth.squeezed(0.6f), &state, &report);
        ASSERT_EQ(cloth.validate(state), "");
        for (const Vec3& p : cloth.show(f % 2 ? pose : cloth.squeezed(0.6f), state).positions)
            ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
    }
    EXPECT_GT(report.collapsed_triangles, 0);
    state = cloth.solve(Pose3(pose.size(), Vec3(1.0f)), &state, &report);  // all at one point
    EXPECT_EQ(report.collapsed_triangles, 128);
    EXPECT_EQ(cloth.validate(state), "");
}

TEST(WrinklePathsInput, AClipOfOneFrameIsAllRest) {
    const PathCloth cloth(grid(2, 2, 0.1f));
    const std::vector<double> times{0.0};
    EXPECT_EQ(label_clip(cloth.model->base, cloth.model->triangles, cloth.settings.rest, times,
                         cloth.mesh.positions),
              Labels(8, kRest));
}

}  // namespace
}  // namespace rumple::tests
