// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Maps of shape keys: the laws of bones hold, and keys need not share a vertex.
#include <gtest/gtest.h>

#include <algorithm>

#include "base/errors.h"
#include "tests/wrinkle_maps_rig.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_maps;

Bone key(float value) {
    return {Vec3(value, 0, 0), Vec3(0)};
}

// Keys of values 0 at rest, all on their own.
Rig keys(std::vector<std::string> names, const std::vector<std::vector<float>>& poses) {
    Rig rig;
    rig.names = std::move(names);
    rig.tracked.assign(rig.names.size(), Tracked::kKey);
    rig.group.assign(rig.names.size(), kNone);
    rig.neutral.assign(rig.names.size(), key(0));
    for (const std::vector<float>& values : poses) {
        rig.poses.push_back({"pose" + std::to_string(rig.poses.size()), {}});
        for (const float value : values) rig.poses.back().bones.push_back(key(value));
    }
    return rig;
}

SparseRows rows(const std::vector<std::vector<float>>& weights) {
    SparseRows out;
    for (const std::vector<float>& row : weights) {
        for (size_t i = 0; i < row.size(); ++i) {
            if (row[i] > 0) out.add(static_cast<Index>(i), row[i]);
        }
        out.end_row();
    }
    return out;
}

std::vector<float> masks_at(const Model& model, std::vector<Bone> now, float gain = 1.0f) {
    Settings settings;
    settings.gain = gain;
    return masks(model, settings, evaluate(model, now));
}

// Random keys, some below zero, with weights that overlap.
struct Case {
    RandomRig random;
    Rig rig;
    std::shared_ptr<const Model> model;

    explicit Case(unsigned seed) : random(seed), rig(keys({"a", "b", "c", "d", "e"}, {})) {
        for (int k = 0; k < 3; ++k) {
            std::vector<Bone> pose(5, key(0));
            pose[k] = key(random.number(0.2f, 1.0f));
            for (Bone& bone : pose) {
                if (random.number(0, 1) < 0.4f) bone = key(random.number(-1, 1));
            }
            rig.poses.push_back({"pose" + std::to_string(k), pose});
        }
        std::vector<std::vector<float>> weights(100, std::vector<float>(5));
        for (auto& row : weights) {
            for (float& weight : row) weight = std::max(0.0f, random.number(-1, 1));
        }
        model = build(rig, rows(weights));
    }
};

TEST(WrinkleMapsKeys, AnInfluenceIsExactlyOneAtItsOwnPoseAndZeroAtRest) {
    for (unsigned seed = 0; seed < 50; ++seed) {
        const Case c(seed);
        for (Index k = 0; k < c.model->poses(); ++k) {
            const Influences at = evaluate(*c.model, c.rig.poses[k].bones);
            EXPECT_EQ(presence(*c.model, at)[k], 1.0f);
            for (Index i = 0; i < c.model->bones(); ++i) {
                const Index entry = i * c.model->poses() + k;
                EXPECT_EQ(at.pose[entry], c.model->moves[entry] ? 1.0f : 0.0f);
            }
        }
        for (const float mask : masks_at(*c.model, c.rig.neutral)) EXPECT_EQ(mask, 0.0f);
    }
}

TEST(WrinkleMapsKeys, MasksStayWithinZeroAndOneWhereKeysOverlap) {
    int overlapping = 0;
    for (unsigned seed = 0; seed < 50; ++seed) {
        Case c(seed);
        overlapping += c.model->overlaps;
        for (int round = 0; round < 10; ++round) {
            std::vector<Bone> now;
            for (int i = 0; i < 5; ++i) now.push_back(key(c.random.number(-20, 20)));
            for (const float gain : {0.1f, 1.0f, 3.0f, 100.0f}) {
                for (const float mask : masks_at(*c.model, now, gain)) {
                    EXPECT_GE(mask, 0.0f);
                    EXPECT_LE(mask, 1.0f);
                }
            }
        }
    }
    EXPECT_EQ(overlapping, 50);
}

// Keys are not shares of a whole, as skin weights are: one that is not in the pose takes nothing from it.
TEST(WrinkleMapsKeys, AnotherKeyOnTheSameSkinTakesNothing) {
    const auto model = build(keys({"brow", "scream", "smile"}, {{1, 0, 0}, {0, 1, 1}}),
                             rows({{1.0f, 1.0f, 1.0f}, {0.5f, 0.0f, 0.25f}}));
    const std::vector<float> brow = masks_at(*model, {key(1), key(0), key(0)});
    EXPECT_EQ(brow, (std::vector<float>{1.0f, 0.5f, 0.0f, 0.0f}));
    const std::vector<float> half = masks_at(*model, {key(0), key(0.5f), key(1)});
    EXPECT_EQ(half,
              (std::vector<float>{0.0f, 0.0f, 0.75f, 0.25f}));  // two keys: the mean where both are in full
}

TEST(WrinkleMapsKeys, GainLiftsWhatFadesAndNothingElse) {
    const auto model = build(keys({"brow", "nose"}, {{1, 1}}), rows({{0.25f, 0.0f}, {1.0f, 1.0f}}));
    const std::vector<float> mask = masks_at(*model, {key(0.5f), key(0.5f)}, 3.0f);
    EXPECT_FLOAT_EQ(mask[0], 0.5f * gained(0.25f, 3.0f));
    EXPECT_FLOAT_EQ(mask[1], 0.5f);
}

// A bone of 0.1 m that moves 5 mm beside a key of 1: by one measure for both the bone would not move.
TEST(WrinkleMapsKeys, KeysAndBonesAreMeasuredEachByTheirOwn) {
    RandomRig random(3);
    for (const float value : {0.001f, 1.0f, 100.0f}) {
        Rig rig = random.rig(4, 0);
        rig.names.push_back("key");
        rig.tracked.push_back(Tracked::kKey);
        rig.group.push_back(kNone);
        rig.neutral.push_back(key(0));
        std::vector<Bone> pose = rig.neutral;
        pose[1].head.x += 0.005f;  // tracked: the tail only
        pose[2].tail.x += 0.005f;
        pose[4] = key(value);
        rig.poses.push_back({"open", pose});
        const auto model = build(rig, rows({{0, 0, 1, 0, 1}}));
        EXPECT_EQ(model->moves, (std::vector<std::uint8_t>{0, 0, 1, 0, 1})) << value;
        EXPECT_FLOAT_EQ(masks_at(*model, pose)[0], 1.0f);
        pose[4] = key(0);
        EXPECT_NEAR(masks_at(*model, pose)[0], 0.5f, 1e-5f);
    }
}

TEST(WrinkleMapsKeys, SkinWeightsSumToOneWithoutThoseOfKeys) {
    Rig rig = keys({"key"}, {});
    rig.names.push_back("bone");
    rig.tracked.push_back(Tracked::kBoth);
    rig.group.push_back(kNone);
    rig.neutral.push_back({Vec3(0), Vec3(0, 0.1f, 0)});
    rig.poses.push_back({"pose", {key(1), {Vec3(0.01f, 0, 0), Vec3(0.01f, 0.1f, 0)}}});
    const auto model = build(rig, rows({{0.5f, 2.0f}, {0.5f, 0.0f}, {0.0f, 0.0f}}));
    EXPECT_EQ(model->weights.weight, (std::vector<float>{0.5f, 1.0f, 0.5f}));
    EXPECT_EQ(model->unnormalised, 1);
    EXPECT_EQ(model->unbound, 1);
}

TEST(WrinkleMapsKeys, WhatDoesNotMoveIsRefusedInWords) {
    const auto refused = [](const Rig& rig, const SparseRows& weights, const char* words) {
        try {
            build(rig, weights);
            ADD_FAILURE() << words;
        } catch (const InvalidInput& error) {
            EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
        }
    };
    refused(keys({"a"}, {{0}}), rows({}), "pose pose0: no bone and no shape key moves in it");
    refused(keys({"a"}, {{1}, {1}}), rows({}), "every bone and shape key stands as in pose pose0");
    refused(keys({"a"}, {{1}}), rows({{1.5f}}),
            "vertex 0: expected a weight of 0 to 1 for shape key a, got 1.5");
}

}  // namespace
}  // namespace rumple::tests
