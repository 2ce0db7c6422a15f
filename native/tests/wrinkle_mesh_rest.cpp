// SPDX-License-Identifier: GPL-3.0-or-later
// A Wrinkle Mesh whose rest shape adapts: reference triangles (Gillette 2015, chapter 4) scale its rest
// lengths.
#include <gtest/gtest.h>

#include <limits>

#include "base/errors.h"
#include "systems/wrinkle_mesh/pose.h"
#include "tests/wrinkle_mesh_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_mesh;

Source adaptive(FineSource::Kind kind = FineSource::Kind::kSubdivision) {
    Source source;
    source.kind = kind;
    source.level = 2;
    source.segments = 3;
    source.longest_edge = 0.03f;
    source.adaptive = true;
    return source;
}

struct AdaptiveCloth : Cloth {
    Settings settings;

    explicit AdaptiveCloth(MeshData data, const Source& source = adaptive(),
                           AttachmentKind kind = AttachmentKind::kLinear)
        : Cloth(std::move(data), source, kind) {
        settings.rest.reference = Reference::kRestPose;
    }
    State step(const Pose3& pose, double time, const State* before, std::span<const std::uint8_t> labels = {},
               Report* report = nullptr) const {
        Input input{pose};
        input.frame_time.time = time;
        input.frame_time.labels = labels;
        Report unused;
        return wrinkle_mesh::solve(*model, settings, {}, input, before, report ? *report : unused);
    }
    // pose_at(seconds), from 0 on.
    template <typename PoseAt>
    State play(double seconds, double rate, PoseAt&& pose_at) const {
        State state = step(pose_at(0.0), 0.0, nullptr);
        for (int f = 1; f <= int(std::lround(seconds * rate)); ++f)
            state = step(pose_at(f / rate), f / rate, &state);
        return state;
    }
    std::vector<float> scales(const State& state, const Pose3& positions) const {
        const wrinkle_mesh::Pose pose = make_pose(*model, {positions});
        return rest_scales(*model, settings, state.reference, pose, pair_lengths(*model, pose.attachment));
    }
    // ... from the rest pose: whatever the pose.
    std::vector<float> scales(const State& state) const { return scales(state, mesh.positions); }
};

bool same_reference(const State& a, const State& b) {
    return same_bits(a.reference.reference, b.reference.reference) &&
           same_bits(a.reference.labels, b.reference.labels) &&
           same_bits(a.reference.past_positions, b.reference.past_positions);
}

// Of the offsets, off the surface.
float highest(const State& state) {
    float most = 0.0f;
    for (const Vec3& offset : state.offset) most = std::max(most, std::abs(offset.z));
    return most;
}

float mean(const std::vector<float>& values) {
    double sum = 0.0;
    for (const float value : values) sum += value;
    return float(sum / double(values.size()));
}

std::vector<AdaptiveCloth> every_fine_mesh() {
    std::vector<AdaptiveCloth> cloths;
    using Kind = FineSource::Kind;
    for (const Kind kind : {Kind::kSubdivision, Kind::kRegular, Kind::kLongestEdge}) {
        cloths.emplace_back(tube(8, 4, 0.1f, 0.4f), adaptive(kind), AttachmentKind::kLimit);
        cloths.emplace_back(shaken(grid(4, 3, 0.1f), 0.02f, 5), adaptive(kind));
    }
    const Surface own = build(grid(9, 7, 0.05f));
    Source source = adaptive();
    source.own = &own;
    cloths.emplace_back(grid(4, 3, 0.1f), source, AttachmentKind::kLimit);
    return cloths;
}

// The first frame knows of no past: all labels are rest, and the reference is the rest pose.
TEST(WrinkleMeshRest, AnUnmovedReferenceIsTheRestPoseToTheBit) {
    for (const AdaptiveCloth& cloth : every_fine_mesh()) {
        const Pose3 pose = cloth.squeezed(0.8f, 1.0f);
        const State adapting = cloth.step(pose, 0.0, nullptr);
        for (const float scale : cloth.scales(adapting)) EXPECT_EQ(scale, 1.0f);
        EXPECT_TRUE(same_bits(adapting, cloth.solve(pose, Settings{})));
        EXPECT_GT(largest(adapting.offset), 1e-3f);
        AdaptiveCloth still = cloth;
        still.settings.rest.reference = Reference::kStaticRest;
        EXPECT_TRUE(still.step(pose, 0.0, nullptr).reference.empty());
    }
}

TEST(WrinkleMeshRest, RestStaysAtRest) {
    for (const AdaptiveCloth& cloth : every_fine_mesh()) {
        const State state = cloth.play(0.4, 30.0, [&](double) { return cloth.mesh.positions; });
        for (const float scale : cloth.scales(state)) EXPECT_EQ(scale, 1.0f);
        EXPECT_LT(largest(state.offset), kRounding);
    }
}

TEST(WrinkleMeshRest, RigidMotionChangesNothing) {
    for (const AdaptiveCloth& cloth : every_fine_mesh()) {
        const State state = cloth.play(0.4, 30.0, [&](double time) {
            const float angle = 3.0f * float(time);
            return cloth.moved([=](const Vec3& p) {
                return Vec3(p.x * std::cos(angle) - p.y * std::sin(angle) + float(time),
                            p.x * std::sin(angle) + p.y * std::cos(angle), p.z);
            });
        });
        for (const std::uint8_t label : state.reference.labels) EXPECT_EQ(label, kRest);
        for (const float scale : cloth.scales(state)) EXPECT_EQ(scale, 1.0f);
        EXPECT_LT(largest(state.offset), 3.0f * kRounding);
    }
}

// What the first frame looks like is unwrinkled, however it is squeezed and bent: its triangles are the
// reference, and no length of the rest pose counts, not those of the smooth surface either.
TEST(WrinkleMeshRest, TheFirstFrameHasNoFoldsWithoutARestPose) {
    for (AdaptiveCloth& cloth : every_fine_mesh()) {
        cloth.settings.rest.reference = Reference::kFirstFrame;
        const Pose3 first = cloth.squeezed(0.7f, 4.0f);
        const auto first_then = [&](double time) {
            return cloth.squeezed(0.7f - 0.25f * std::min(float(time), 0.4f), 4.0f);
        };
        const State state = cloth.step(first, 0.0, nullptr);
        EXPECT_LT(largest(state.offset), 3.0f * kRounding);
        EXPECT_GT(largest(cloth.solve(first, Settings{}).offset), 1e-3f);
        EXPECT_GT(largest(cloth.play(0.4, 30.0, first_then).offset), 1e-3f);
    }
}

// sigma = 0.7 along x; relaxed by 1 % in 1/30 s its distance from 1 falls to 0.99^90 in 3 s. The reference is
// the pose over sigma.
TEST(WrinkleMeshRest, ASqueezedPoseIsGivenInTo) {
    AdaptiveCloth cloth(grid(4, 3, 0.1f));
    const Pose3 pose = cloth.squeezed(0.7f);
    const Labels compress(cloth.model->base.triangles.size(), kCompress);
    State state = cloth.step(pose, 0.0, nullptr);
    const float folds = largest(state.offset);
    for (int f = 1; f <= 90; ++f) state = cloth.step(pose, f / 30.0, &state, compress);
    const float sigma = 1.0f - 0.3f * std::pow(0.99f, 90.0f);
    const std::vector<float> scales = cloth.scales(state);
    size_t along = 0, across = 0;
    for (size_t i = 0; i < cloth.model->distance.size(); ++i) {
        const Vec3 way = cloth.model->positions_rest[cloth.model->distance.b[i]] -
                         cloth.model->positions_rest[cloth.model->distance.a[i]];
        if (way.y == 0.0f) {
            EXPECT_NEAR(scales[i], 0.7f / sigma, 1e-4f);
            ++along;
        } else if (way.x == 0.0f) {
            EXPECT_NEAR(scales[i], 1.0f, 1e-5f);
            ++across;
        }
    }
    EXPECT_GT(along, 10u);
    EXPECT_GT(across, 10u);
    EXPECT_LT(largest(state.offset), 0.9f * folds);
}

// Begun in a crouch there are no folds; stretched out the reference grows, and the same crouch folds.
TEST(WrinkleMeshRest, StretchedOutItRecovers) {
    AdaptiveCloth cloth(grid(4, 3, 0.1f));
    cloth.settings.rest.reference = Reference::kFirstFrame;
    const auto size = [&](float s) { return cloth.moved([=](const Vec3& p) { return s * p; }); };
    const auto there_and_back = [&](double time) {
        return size(0.75f + 0.25f * float(std::clamp(2.0 - std::abs(2.0 * time - 2.0), 0.0, 1.0)));
    };
    const State begun = cloth.step(there_and_back(0.0), 0.0, nullptr);
    EXPECT_LT(largest(begun.offset), kRounding);
    EXPECT_NEAR(mean(cloth.scales(begun, size(1.0f))), 0.75f, 1e-4f);
    const State stretched = cloth.play(1.0, 30.0, there_and_back);
    EXPECT_NEAR(mean(cloth.scales(stretched, size(1.0f))), 1.0f, 0.03f);
    EXPECT_LT(highest(stretched), 1e-5f);
    const State back = cloth.play(2.0, 30.0, there_and_back);
    EXPECT_GT(mean(cloth.scales(back, size(1.0f))), 0.9f);
    EXPECT_GT(highest(back), 5e-3f);
}

TEST(WrinkleMeshRest, EveryFrameRateGivesTheSameReference) {
    const AdaptiveCloth cloth(grid(4, 3, 0.1f));
    const auto breathing = [&](double time) {
        return cloth.squeezed(0.8f + 0.2f * float(std::cos(4.0 * time)));
    };
    const float at_30 = mean(cloth.scales(cloth.play(3.0, 30.0, breathing)));
    EXPECT_LT(at_30, 0.99f);
    for (const double rate : {24.0, 60.0, 120.0})
        EXPECT_NEAR(mean(cloth.scales(cloth.play(3.0, rate, breathing))), at_30, 0.15f * (1.0f - at_30))
            << rate;
}

TEST(WrinkleMeshRest, AHeldPoseStaysToTheBitOnceItsPastIsForgotten) {
    const AdaptiveCloth cloth(tube(8, 4, 0.1f, 0.4f));
    const auto then_held = [&](double time) {
        return cloth.squeezed(1.0f - 0.3f * float(std::min(time, 0.5)), 1.0f);
    };
    State state = cloth.play(1.0, 30.0, then_held);
    const State held = state;
    for (int f = 31; f < 60; ++f) {
        Report report;
        state = cloth.step(then_held(f / 30.0), f / 30.0, &state, {}, &report);
        EXPECT_EQ(report.iterations, 0);
    }
    EXPECT_TRUE(same_bits(state, held));
    EXPECT_TRUE(same_bits(state.reference.reference, held.reference.reference));
}

TEST(WrinkleMeshRest, TheNumberOfThreadsChangesNoBit) {
    AdaptiveCloth cloth(tube(8, 4, 0.1f, 0.4f));
    const auto motion = [&](double time) { return cloth.squeezed(1.0f - 0.3f * float(time), float(time)); };
    const State alone = cloth.play(0.5, 30.0, motion);
    for (const int threads : {1, 2, 3}) {
        cloth.settings.threads = threads;
        const State state = cloth.play(0.5, 30.0, motion);
        EXPECT_TRUE(same_bits(state, alone) && same_reference(state, alone)) << threads;
    }
}

// One reference triangle of the square's two is 0.8 of the rest. A pair in it is 0.8, one in the other 1, one
// along the diagonal 0.9, and one from the one into the other (a bending pair) 0.9 too.
TEST(WrinkleMeshRest, APairBetweenTwoTrianglesTakesTheirMean) {
    Source source = adaptive(FineSource::Kind::kRegular);
    source.segments = 2;
    const AdaptiveCloth cloth(grid(1, 1, 1.0f), source);
    State state = cloth.step(cloth.mesh.positions, 0.0, nullptr);
    FlatTriangle& smaller = state.reference.reference[0];  // (0, 0), (1, 0), (1, 1)
    smaller = {0.8f * smaller.x1, 0.8f * smaller.x2, 0.8f * smaller.y2};
    const std::vector<float> scales = cloth.scales(state);
    size_t counts[3] = {0, 0, 0};  // 0.8, 0.9, 1
    const auto expect_scale = [&](const Pairs& pairs, size_t i, float scale) {
        const Vec3 a = cloth.model->positions_rest[pairs.a[i]], b = cloth.model->positions_rest[pairs.b[i]];
        const float side_a = a.x - a.y, side_b = b.x - b.y;  // above 0: in the smaller triangle
        const float expected = side_a >= 0.0f && side_b >= 0.0f && side_a + side_b > 0.0f   ? 0.8f
                               : side_a <= 0.0f && side_b <= 0.0f && side_a + side_b < 0.0f ? 1.0f
                                                                                            : 0.9f;
        EXPECT_NEAR(scale, expected, 1e-6f) << a.x << ' ' << a.y << ' ' << b.x << ' ' << b.y;
        ++counts[int(std::lround(10.0f * expected)) - 8];
    };
    for (size_t i = 0; i < cloth.model->distance.size(); ++i)
        expect_scale(cloth.model->distance, i, scales[i]);
    for (size_t i = 0; i < cloth.model->bending.size(); ++i)
        expect_scale(cloth.model->bending, i, scales[cloth.model->distance.size() + i]);
    for (const size_t count : counts) EXPECT_GT(count, 2u);
}

void expect_refused(const std::function<void()>& call, const std::string& part) {
    try {
        call();
        ADD_FAILURE() << "accepted: " << part;
    } catch (const InvalidInput& error) {
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
}

TEST(WrinkleMeshRest, WhatDoesNotFitIsNamed) {
    const AdaptiveCloth cloth(grid(2, 2, 0.1f));
    const Pose3& rest = cloth.mesh.positions;
    const State state = cloth.step(rest, 1.0, nullptr);
    AdaptiveCloth fixed = cloth;
    fixed.model = Cloth(grid(2, 2, 0.1f)).model;
    expect_refused([&] { fixed.step(rest, 0.0, nullptr); }, "reference: the model was built for");
    expect_refused([&] { cloth.step(rest, 0.5, &state); }, "time: the state is of 1.0");
    State spoiled = state;
    spoiled.reference.reference[3].y2 = std::numeric_limits<float>::quiet_NaN();
    expect_refused([&] { cloth.step(rest, 1.5, &spoiled); }, "state.reference: number 3");
    const Labels few(7, kRest);
    expect_refused([&] { cloth.step(rest, 1.5, &state, few); }, "labels: expected 8 triangles, got 7");
    AdaptiveCloth bad = cloth;
    bad.settings.rest.relaxation = 2.0f;
    expect_refused([&] { bad.step(rest, 0.0, nullptr); }, "relaxation: expected");
    AdaptiveCloth still = cloth;  // a state that was solved for a rest shape that stays starts a reference
    still.settings.rest.reference = Reference::kStaticRest;
    const State before = still.step(rest, 1.0, nullptr);
    EXPECT_FALSE(cloth.step(rest, 1.1, &before).reference.empty());
    EXPECT_TRUE(same_reference(activated(state), state));
}

}  // namespace
}  // namespace rumple::tests
