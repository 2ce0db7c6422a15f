// SPDX-License-Identifier: GPL-3.0-or-later
// Small cases of the Wrinkle Maps worked by hand, and bad input.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/refusals.h"
#include "tests/wrinkle_maps_rig.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_maps;

// Bones on their own at the origin, both ends; in pose k their head and tail are displaced by these.
Rig rig_of(const std::vector<std::vector<Bone>>& displacements, Tracked tracked = Tracked::kHead) {
    Rig rig;
    const size_t bones = displacements.front().size();
    for (size_t i = 0; i < bones; ++i) rig.names.push_back("bone" + std::to_string(i));
    rig.tracked.assign(bones, tracked);
    rig.group.assign(bones, kNone);
    rig.neutral.assign(bones, {Vec3(0), Vec3(0)});
    for (const auto& bone : displacements)
        rig.poses.push_back({"pose" + std::to_string(rig.poses.size()), bone});
    return rig;
}

SparseRows rows_of(std::initializer_list<std::vector<std::pair<Index, float>>> rows) {
    SparseRows out;
    for (const auto& row : rows) {
        for (const auto& [bone, weight] : row) out.add(bone, weight);
        out.end_row();
    }
    return out;
}

const Vec3 kZero(0.0f);

// From the origin to (0,0,2): a bone at (5,1,1/2) is projected to (0,0,1/2), a quarter of the way. As
// printed, divided by the norm and not its square, it would be (1/2 x 2) / 2 = 1/2, a length.
TEST(WrinkleMaps, AnInfluenceIsAFractionOfTheWayNotALength) {
    const auto model = build(rig_of({{{Vec3(0, 0, 2), kZero}}}), one_bone_each(1));
    EXPECT_FLOAT_EQ(evaluate(*model, std::vector<Bone>{{Vec3(5, 1, 0.5f), kZero}}).pose[0], 0.25f);
}

// The jaw goes by 20 in pose 0 and by 1 in pose 1, where the brow goes by 4. At 1 the jaw only passes by pose
// 1 on its way to pose 0: on a real face a lip that crosses 2 of its 40 mm took a mask from 0 to 0.7 within
// one frame. The brow moves in pose 1 only; a lid with 1/200 of the longest way of its pose moves in none.
TEST(WrinkleMaps, ABoneThatOnlyPassesByAPoseDoesNotMoveInIt) {
    const auto along = [](float x) { return Bone{Vec3(x, 0, 0), Vec3(0)}; };
    const auto model =
        build(rig_of({{along(20), along(0), along(0.1f)}, {along(1), along(4), along(0)}}), one_bone_each(3));
    EXPECT_EQ(model->moves, (std::vector<std::uint8_t>{1, 0, 0, 1, 0, 0}));
    const Influences at = evaluate(*model, std::vector<Bone>{along(1), along(2), along(0.1f)});
    EXPECT_EQ(at.pose, (std::vector<float>{0.05f, 0.0f, 0.0f, 0.5f, 0.0f, 0.0f}));
}

// Pose 1 is pose 0, a twentieth of it: nothing else tells it from the neutral pose, so it counts.
TEST(WrinkleMaps, AFaintCopyOfAPoseIsAPose) {
    const auto along = [](float x) { return Bone{Vec3(x, 0, 0), Vec3(0)}; };
    const auto model = build(rig_of({{along(20), along(20)}, {along(1), along(1)}}), one_bone_each(2));
    EXPECT_EQ(model->moves, (std::vector<std::uint8_t>{1, 1, 1, 1}));
    EXPECT_EQ(evaluate(*model, std::vector<Bone>{along(1), along(1)}).pose,
              (std::vector<float>{0.05f, 1.0f, 0.05f, 1.0f}));
}

// As one point of six coordinates: the way is (1,0,0, 0,2,0), of square 5. Head there, tail not: 1/5. Tail
// there: 4/5.
TEST(WrinkleMaps, HeadTailOrBothAreFollowed) {
    const std::vector<Bone> head_only{{Vec3(1, 0, 0), kZero}}, tail_only{{kZero, Vec3(0, 2, 0)}};
    const std::vector<Bone> pose{{Vec3(1, 0, 0), Vec3(0, 2, 0)}};
    const auto influence = [&](Tracked tracked, const std::vector<Bone>& bones) {
        return evaluate(*build(rig_of({pose}, tracked), one_bone_each(1)), bones).pose[0];
    };
    EXPECT_FLOAT_EQ(influence(Tracked::kBoth, head_only), 0.2f);
    EXPECT_FLOAT_EQ(influence(Tracked::kBoth, tail_only), 0.8f);
    EXPECT_EQ(influence(Tracked::kHead, head_only), 1.0f);
    EXPECT_EQ(influence(Tracked::kHead, tail_only), 0.0f);
    EXPECT_EQ(influence(Tracked::kTail, head_only), 0.0f);
    EXPECT_EQ(influence(Tracked::kTail, tail_only), 1.0f);
}

// A joint that turns in place moves its tail only.
TEST(WrinkleMaps, AJointThatOnlyTurnsIsSeenByItsTail) {
    Rig rig = rig_of({{{Vec3(0, 1, 0), Vec3(-1, 1, 0)}}});
    rig.neutral = {{Vec3(0, 1, 0), Vec3(1, 1, 0)}};
    EXPECT_THROW(build(rig, one_bone_each(1)), InvalidInput);
    rig.tracked = {Tracked::kBoth};
    const auto model = build(rig, one_bone_each(1));
    EXPECT_FLOAT_EQ(evaluate(*model, std::vector<Bone>{{Vec3(0, 1, 0), Vec3(0, 2, 0)}}).pose[0], 0.5f);
}

// Coefficients 1/2 and 1 of the two that move; the third, still in the pose, shares their mean.
TEST(WrinkleMaps, AGroupSharesTheMeanOfThoseThatMove) {
    const Bone up{Vec3(0, 0, 1), kZero}, still{kZero, kZero};
    Rig rig = rig_of({{up, up, still, up}});
    rig.group = {3, 3, 3, kNone};
    const auto model = build(rig, one_bone_each(4));
    const Influences at = evaluate(
        *model,
        std::vector<Bone>{{Vec3(0, 0, 0.5f), kZero}, up, {Vec3(0, 0, 9), kZero}, {Vec3(0, 0, 0.25f), kZero}});
    EXPECT_EQ(at.pose, (std::vector<float>{0.75f, 0.75f, 0.75f, 0.25f}));
    EXPECT_EQ(at.rest, (std::vector<float>{0.25f, 0.25f, 0.25f, 0.75f}));
    // The mean over the bones that move: (3 x 3/4 + 1/4) / 4.
    EXPECT_FLOAT_EQ(presence(*model, at)[0], 0.625f);
}

// Along (1,0,0) by 0.75 and along (1,1,0) by 0.5 (projection of (0.75, 0.25)): together 1.25, nothing is
// left.
TEST(WrinkleMaps, TheRestIsWhatThePosesLeave) {
    const auto model = build(rig_of({{{Vec3(1, 0, 0), kZero}}, {{Vec3(1, 1, 0), kZero}}}), one_bone_each(1));
    const auto at = [&](const Vec3& p) { return evaluate(*model, std::vector<Bone>{{p, kZero}}); };
    EXPECT_EQ(at(Vec3(0.75f, 0.25f, 0)).pose, (std::vector<float>{0.75f, 0.5f}));
    EXPECT_EQ(at(Vec3(0.75f, 0.25f, 0)).rest[0], 0.0f);
    // (0.25, 0, 0): 1/4 and (1/4) / 2 = 1/8.
    EXPECT_EQ(at(Vec3(0.25f, 0, 0)).rest[0], 0.625f);
}

// Influences 1 and 1/2 at weights 1/4 and 1/2, the rest belongs to a bone that is not of the rig: 1/4 + 1/4.
TEST(WrinkleMaps, AMaskIsTheWeightedSumAndWeightsAreMadeToSumToOne) {
    const Bone up{Vec3(0, 0, 1), kZero};
    const auto model = build(rig_of({{up, up}}), rows_of({{{0, 0.25f}, {1, 0.5f}, {kNone, 0.25f}},
                                                          {{0, 1.0f}, {1, 2.0f}, {kNone, 1.0f}},  // sums to 4
                                                          {},
                                                          {{kNone, 1.0f}},
                                                          {{0, 0.998f}}}));
    EXPECT_EQ(model->unnormalised, 1);
    EXPECT_EQ(model->unbound, 1);
    const Influences at = evaluate(*model, std::vector<Bone>{up, {Vec3(0, 0, 0.5f), kZero}});
    EXPECT_EQ(masks(*model, {}, at), (std::vector<float>{0.5f, 0.5f, 0.0f, 0.0f, 1.0f}));
    // Gain 3 of a reach of 3/4: 9/4 over 5/2 = 0.9, times the mean influence (1/2) / (3/4).
    Settings settings;
    settings.gain = 3.0f;
    EXPECT_FLOAT_EQ(masks(*model, settings, at)[0], 0.6f);
}

TEST(WrinkleMaps, TheRootSpaceIsTheRootsOwn) {
    glm::mat4 root(2.0f);  // twice as large, turned by a quarter about z, at (1,2,3)
    root[0] = {0, 2, 0, 0};
    root[1] = {-2, 0, 0, 0};
    root[3] = {1, 2, 3, 1};
    const std::vector<Bone> bones = in_root_space(root, std::vector<Bone>{{Vec3(1, 4, 3), Vec3(-1, 2, 5)}});
    EXPECT_LT(glm::distance(bones[0].head, Vec3(1, 0, 0)), 1e-6f);
    EXPECT_LT(glm::distance(bones[0].tail, Vec3(0, 1, 1)), 1e-6f);
}

// Half of W = (3,0,4)/5 and half of what is left: flat in the second case, N = (0,0,1) in both.
TEST(WrinkleMaps, HalfAMaskIsTheMeanOfTheNormals) {
    const std::vector<Vec3> wrinkle{{0.6f, 0.0f, 0.8f}};
    const std::vector<float> half{0.5f};
    const Vec3 mean = glm::normalize(Vec3(0.3f, 0.0f, 0.9f));
    for (const Maps maps : {Maps::kWhole, Maps::kWrinkles}) {
        EXPECT_LT(glm::distance(blend(maps, Vec3(0, 0, 1), wrinkle, half), mean), 1e-6f);
    }
}

// W = (3,0,4)/5 and N = (0,3,4)/5: (3/5, 3/5, 16/25) normalised.
TEST(WrinkleMaps, WrinklesAddToTheNeutralDetailsAsPrinted) {
    const std::vector<Vec3> wrinkle{{0.6f, 0.0f, 0.8f}};
    const Vec3 normal = blend(Maps::kWrinkles, Vec3(0.0f, 0.6f, 0.8f), wrinkle, std::vector<float>{1.0f});
    EXPECT_LT(glm::distance(normal, glm::normalize(Vec3(0.6f, 0.6f, 0.64f))), 1e-6f);
}

// ---------------------------------------------------------------- bad input

TEST(WrinkleMapsInput, APoseThatIsTheNeutralPoseOrAnotherPoseIsNamed) {
    Rig rig = RandomRig(0).rig(5, 3);
    const SparseRows weights = one_bone_each(5);
    EXPECT_NO_THROW(build(rig, weights));
    Rig bad = rig;
    bad.poses[1].bones = rig.neutral;
    expect_refused([&] { build(bad, weights); }, {"pose1", "the neutral pose"});
    bad = rig;
    bad.poses[2].bones = rig.poses[0].bones;
    expect_refused([&] { build(bad, weights); }, {"pose2", "as in pose pose0"});
    // Closer than bones jitter counts as the same; ten times farther does not.
    bad.poses[2].bones[0].head.x += 5e-7f;
    expect_refused([&] { build(bad, weights); }, {"pose2"});
    bad.poses[2].bones[0].head.x += 1e-5f;
    EXPECT_NO_THROW(build(bad, weights));
}

TEST(WrinkleMapsInput, CountsThatDifferAreNamed) {
    const Rig rig = RandomRig(0).rig(5, 2);
    const SparseRows weights = one_bone_each(5);
    Rig bad = rig;
    bad.tracked.pop_back();
    expect_refused([&] { build(bad, weights); }, {"tracked", "5 bones", "got 4"});
    bad = rig;
    bad.group.push_back(0);
    expect_refused([&] { build(bad, weights); }, {"group", "5 bones", "got 6"});
    bad = rig;
    bad.poses[1].bones.pop_back();
    expect_refused([&] { build(bad, weights); }, {"pose pose1", "5 bones", "got 4"});
    bad = rig;
    bad.neutral.pop_back();
    expect_refused([&] { build(bad, weights); }, {"the neutral pose", "5 bones", "got 4"});
    const auto model = build(rig, weights);
    expect_refused([&] { evaluate(*model, std::vector<Bone>(4)); }, {"the present pose", "5 bones", "got 4"});
    expect_refused([&] { masks(*model, {}, Influences{}); }, {"influences", "10", "got 0"});
    expect_refused([&] { build(RandomRig(0).rig(20, 17), weights); }, {"poses", "at most 16", "got 17"});
}

TEST(WrinkleMapsInput, WhatIsNotFiniteIsNamed) {
    Rig rig = RandomRig(0).rig(5, 2);
    const auto model = build(rig, one_bone_each(5));
    std::vector<Bone> bones = rig.neutral;
    bones[3].tail.y = kNan;
    expect_refused([&] { evaluate(*model, bones); }, {"the present pose", "tail of bone bone3"});
    rig.poses[1].bones[2].head.x = std::numeric_limits<float>::infinity();
    expect_refused([&] { build(rig, one_bone_each(5)); }, {"pose pose1", "head of bone bone2"});
    glm::mat4 root(1.0f);
    root[2][1] = kNan;
    expect_refused([&] { in_root_space(root, bones); }, {"root", "not finite"});
    expect_refused([&] { in_root_space(glm::mat4(0.0f), bones); }, {"root", "no inverse"});
}

TEST(WrinkleMapsInput, TheFirstBadWeightIsNamed) {
    const Rig rig = RandomRig(0).rig(2, 1);
    expect_refused([&] { build(rig, rows_of({{{0, 1.0f}}, {{2, 1.0f}}})); }, {"vertex 1", "0 to 1", "got 2"});
    expect_refused([&] { build(rig, rows_of({{{-2, 1.0f}}})); }, {"vertex 0", "got -2"});
    expect_refused([&] { build(rig, rows_of({{{0, 1.0f}}, {{0, -1.0f}}})); }, {"vertex 1", ">= 0", "got -1"});
    expect_refused([&] { build(rig, rows_of({{{0, kNan}}})); }, {"vertex 0", "got nan"});
    SparseRows rows = one_bone_each(2);
    rows.start[1] = 3;
    expect_refused([&] { build(rig, rows); }, {"ascending starts"});
}

TEST(WrinkleMapsInput, ASettingOutOfItsRangeIsNamed) {
    for (const float gain : {0.1f, 100.0f}) EXPECT_NO_THROW(check({gain, {}}, 2));
    for (const float gain : {0.0f, 101.0f, kNan})
        expect_refused([&] { check({gain, {}}, 2); }, {"gain: expected"});
    EXPECT_NO_THROW(check({1.0f, {0.0f, 1.0f}}, 2));
    expect_refused([&] { check({1.0f, {1.0f}}, 2); }, {"strength", "2 values", "got 1"});
    expect_refused([&] { check({1.0f, {0.0f, 1.5f}}, 2); }, {"strength 1", "got 1.5"});
}

}  // namespace
}  // namespace rumple::tests
