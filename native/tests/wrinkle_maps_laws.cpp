// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of the Wrinkle Maps: what must hold for any rig and in any pose.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/wrinkle_maps_rig.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_maps;

constexpr float kRounding = 2e-5f;  // of an influence: bones of 0.1 m in single precision, ways of 0.01 m

struct Case {
    RandomRig random;
    Rig rig;
    std::shared_ptr<const Model> model;

    explicit Case(unsigned seed, Index bones = 12, Index poses = 3, bool grouped = true)
        : random(seed), rig(random.rig(bones, poses)) {
        if (grouped) rig.group[1] = rig.group[4] = rig.group[5] = 7;
        model = build(rig, random.weights(200, bones));
    }
    float influence(const Influences& at, Index bone, Index pose) const {
        return at.pose[bone * model->poses() + pose];
    }
};

TEST(WrinkleMapsLaws, AnInfluenceIsExactlyOneAtItsOwnPose) {
    for (unsigned seed = 0; seed < 50; ++seed) {
        const Case c(seed);
        for (Index k = 0; k < c.model->poses(); ++k) {
            const Influences at = evaluate(*c.model, c.rig.poses[k].bones);
            int moving = 0;
            for (Index i = 0; i < c.model->bones(); ++i) {
                moving += c.model->active[i * c.model->poses() + k];
                EXPECT_EQ(c.influence(at, i, k), c.model->active[i * c.model->poses() + k] ? 1.0f : 0.0f);
            }
            EXPECT_GT(moving, 0);
            EXPECT_EQ(presence(*c.model, at)[k], 1.0f);
        }
    }
}

TEST(WrinkleMapsLaws, EveryInfluenceIsZeroAtTheNeutralPoseAndItsOwnIsOne) {
    for (unsigned seed = 0; seed < 50; ++seed) {
        const Case c(seed);
        const Influences at = evaluate(*c.model, c.rig.neutral);
        EXPECT_EQ(*std::max_element(at.pose.begin(), at.pose.end()), 0.0f);
        EXPECT_EQ(*std::min_element(at.rest.begin(), at.rest.end()), 1.0f);
        for (const float mask : masks(*c.model, {}, at)) EXPECT_EQ(mask, 0.0f);
    }
}

TEST(WrinkleMapsLaws, InfluencesAndMasksStayWithinZeroAndOne) {
    int partly = 0;
    for (unsigned seed = 0; seed < 50; ++seed) {
        Case c(seed);
        for (const float size : {1e-4f, 1e-2f, 1.0f, 1e4f}) {
            const Influences at = evaluate(*c.model, c.random.moved(c.rig.neutral, size));
            for (const auto* values : {&at.pose, &at.rest}) {
                for (const float value : *values) {
                    EXPECT_GE(value, 0.0f);
                    EXPECT_LE(value, 1.0f);
                    partly += value > 0.0f && value < 1.0f;
                }
            }
            for (const float gain : {0.1f, 1.0f, 3.0f, 100.0f}) {
                Settings settings;
                settings.gain = gain;
                for (const float mask : masks(*c.model, settings, at)) {
                    EXPECT_GE(mask, 0.0f);
                    EXPECT_LE(mask, 1.0f);
                }
            }
        }
    }
    EXPECT_GT(partly, 1000);
}

TEST(WrinkleMapsLaws, MotionTurnAndScaleOfTheWholeHeadChangeNothing) {
    for (unsigned seed = 0; seed < 50; ++seed) {
        Case c(seed);
        const std::vector<Bone> here = c.random.moved(c.rig.neutral, 0.01f);
        const float a = c.random.number(0.0f, 6.0f), scale = c.random.number(0.5f, 2.0f);
        const Vec3 place = c.random.point(1.0f);
        const glm::mat4 root(glm::vec4(std::cos(a) * scale, std::sin(a) * scale, 0, 0),
                             glm::vec4(-std::sin(a) * scale, std::cos(a) * scale, 0, 0),
                             glm::vec4(0, 0, scale, 0), glm::vec4(place, 1));
        std::vector<Bone> there;
        for (const Bone& bone : here) {
            there.push_back({Vec3(root * glm::vec4(bone.head, 1)), Vec3(root * glm::vec4(bone.tail, 1))});
        }
        const Influences at = evaluate(*c.model, here),
                         moved = evaluate(*c.model, in_root_space(root, there));
        float largest = 0.0f;
        for (size_t e = 0; e < at.pose.size(); ++e) {
            largest = std::max(largest, at.pose[e]);
            // Bones at a metre are rounded to 1e-7 m; the way to a pose may be as short as a millimetre.
            EXPECT_NEAR(moved.pose[e], at.pose[e], 1e-3f);
        }
        EXPECT_GT(largest, 0.1f);
    }
}

TEST(WrinkleMapsLaws, TheOrderOfPosesAndBonesDoesNotMatter) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        Case c(seed, 12, 6);
        Rig turned = c.rig;
        std::reverse(turned.poses.begin(), turned.poses.end());
        const SparseRows weights = c.random.weights(200, 12);
        const auto model = build(c.rig, weights), other = build(turned, weights);
        const std::vector<Bone> here = c.random.moved(c.rig.neutral, 0.01f);
        const std::vector<float> a = masks(*model, {}, evaluate(*model, here));
        const std::vector<float> b = masks(*other, {}, evaluate(*other, here));
        for (Index k = 0; k < 6; ++k) {
            for (Index v = 0; v < 200; ++v) EXPECT_EQ(a[k * 200 + v], b[(5 - k) * 200 + v]);
        }
    }
}

TEST(WrinkleMapsLaws, AVertexOfOneBoneHasItsInfluence) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        Case c(seed, 12, 7);
        const auto model = build(c.rig, one_bone_each(12));
        const Influences at = evaluate(*model, c.random.moved(c.rig.neutral, 0.01f));
        for (const float gain : {1.0f, 4.0f}) {
            Settings settings;
            settings.gain = gain;
            const std::vector<float> mask = masks(*model, settings, at);
            for (Index k = 0; k < 7; ++k) {
                for (Index i = 0; i < 12; ++i) EXPECT_EQ(mask[k * 12 + i], at.pose[i * 7 + k]);
            }
        }
    }
}

// Figure 5: what one bone does is seen where that bone has weight, and nowhere else.
TEST(WrinkleMapsLaws, ABoneThatStaysNeutralShowsNothing) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        const Case c(seed, 12, 3, false);
        std::vector<Bone> one = c.rig.neutral;
        one[0] = c.rig.poses[0].bones[0];
        const std::vector<float> mask = masks(*c.model, {}, evaluate(*c.model, one));
        const SparseRows& weights = c.model->weights;
        int shown = 0;
        for (Index v = 0; v < weights.rows(); ++v) {
            float weight = 0.0f;
            for (Index e = weights.start[v]; e < weights.start[v + 1]; ++e) {
                if (weights.index[e] == 0) weight += weights.weight[e];
            }
            EXPECT_FLOAT_EQ(mask[v], weight);
            shown += weight > 0.0f;
        }
        EXPECT_GT(shown, 0);
        EXPECT_LT(shown, weights.rows());
    }
}

TEST(WrinkleMapsLaws, AnInfluenceIsTheShareOfTheWay) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        const Case c(seed, 12, 3, false);
        for (const float t : {0.0f, 0.2f, 0.5f, 0.9f, 1.0f}) {
            std::vector<Bone> between = c.rig.neutral;
            for (size_t i = 0; i < between.size(); ++i) {
                const Bone& to = c.rig.poses[0].bones[i];
                between[i] = {glm::mix(between[i].head, to.head, t), glm::mix(between[i].tail, to.tail, t)};
            }
            const Influences at = evaluate(*c.model, between);
            for (Index i = 0; i < 12; ++i) {
                EXPECT_NEAR(c.influence(at, i, 0), c.model->moves[i * 3] ? t : 0.0f, kRounding);
            }
        }
    }
}

TEST(WrinkleMapsLaws, MasksAreTheWeightedSumForAnyNumberOfPoses) {
    for (Index poses = 1; poses <= kMostPoses; ++poses) {
        Case c(unsigned(poses), 20, poses);
        const Influences at = evaluate(*c.model, c.random.moved(c.rig.neutral, 0.01f));
        const std::vector<float> mask = masks(*c.model, {}, at);
        const SparseRows& weights = c.model->weights;
        for (Index k = 0; k < poses; ++k) {
            for (Index v = 0; v < weights.rows(); ++v) {
                double sum = 0.0;
                for (Index e = weights.start[v]; e < weights.start[v + 1]; ++e) {
                    sum += double(weights.weight[e]) * c.influence(at, weights.index[e], k);
                }
                EXPECT_NEAR(mask[k * weights.rows() + v], sum, 1e-6);
            }
        }
    }
}

TEST(WrinkleMapsLaws, MoreGainShowsMoreAndKeepsWhereAMapShows) {
    Case c(1);
    const Influences at = evaluate(*c.model, c.random.moved(c.rig.neutral, 0.01f));
    std::vector<float> former(size_t(c.model->poses()) * c.model->vertices(), 0.0f);
    for (const float gain : {0.1f, 0.5f, 1.0f, 2.0f, 8.0f, 100.0f}) {
        Settings settings;
        settings.gain = gain;
        const std::vector<float> mask = masks(*c.model, settings, at);
        for (size_t e = 0; e < mask.size(); ++e) {
            EXPECT_GE(mask[e], former[e] - 1e-6f);
            if (gain > 0.1f) {
                EXPECT_EQ(mask[e] > 0.0f, former[e] > 0.0f);
            }
        }
        former = mask;
    }
}

TEST(WrinkleMapsLaws, AMutedPoseShowsNothingAndLeavesTheOthersAlone) {
    Case c(2);
    const Influences at = evaluate(*c.model, c.random.moved(c.rig.neutral, 0.01f));
    Settings settings;
    settings.strength = {1.0f, 0.0f, 0.5f};
    const std::vector<float> all = masks(*c.model, {}, at), some = masks(*c.model, settings, at);
    const Index n = c.model->vertices();
    for (Index v = 0; v < n; ++v) {
        EXPECT_EQ(some[v], all[v]);
        EXPECT_EQ(some[n + v], 0.0f);
        EXPECT_NEAR(some[2 * n + v], 0.5f * all[2 * n + v], 1e-7f);
    }
}

// ---------------------------------------------------------------- 5.3

struct Pixel {
    Vec3 neutral;
    std::vector<Vec3> wrinkles;
    std::vector<float> masks;
};

Vec3 random_normal(RandomRig& random) {
    return glm::normalize(
        Vec3(random.number(-0.7f, 0.7f), random.number(-0.7f, 0.7f), random.number(0.3f, 1.0f)));
}

Pixel random_pixel(RandomRig& random, Index poses) {
    Pixel pixel{random_normal(random), {}, {}};
    for (Index k = 0; k < poses; ++k) {
        pixel.wrinkles.push_back(random_normal(random));
        pixel.masks.push_back(random.number(0.0f, 1.0f));
    }
    return pixel;
}

TEST(WrinkleMapsBlend, IsAUnitNormalThatLeavesTheSurface) {
    RandomRig random(0);
    for (int round = 0; round < 500; ++round) {
        const Pixel pixel = random_pixel(random, round % 17);
        for (const Maps maps : {Maps::kWhole, Maps::kWrinkles}) {
            const Vec3 normal = blend(maps, pixel.neutral, pixel.wrinkles, pixel.masks);
            EXPECT_NEAR(glm::length(normal), 1.0f, 1e-6f);
            EXPECT_GT(normal.z, 0.0f);
        }
    }
}

TEST(WrinkleMapsBlend, IsTheNeutralMapWhereNoPoseIsPresent) {
    RandomRig random(1);
    for (int round = 0; round < 100; ++round) {
        Pixel pixel = random_pixel(random, 4);
        std::fill(pixel.masks.begin(), pixel.masks.end(), 0.0f);
        for (const Maps maps : {Maps::kWhole, Maps::kWrinkles}) {
            EXPECT_LT(glm::distance(blend(maps, pixel.neutral, pixel.wrinkles, pixel.masks), pixel.neutral),
                      1e-6f);
        }
    }
}

// "In the second case, a simple averaging will cause [a loss of static details]."
TEST(WrinkleMapsBlend, FlatWrinkleMapsKeepTheDetailsOfTheNeutralMap) {
    RandomRig random(2);
    for (int round = 0; round < 100; ++round) {
        Pixel pixel = random_pixel(random, 3);
        std::fill(pixel.wrinkles.begin(), pixel.wrinkles.end(), Vec3(0, 0, 1));
        EXPECT_LT(
            glm::distance(blend(Maps::kWrinkles, pixel.neutral, pixel.wrinkles, pixel.masks), pixel.neutral),
            1e-6f);
        pixel.masks = {1.0f, 0.0f, 0.0f};
        EXPECT_EQ(blend(Maps::kWhole, pixel.neutral, pixel.wrinkles, pixel.masks), Vec3(0, 0, 1));
    }
}

TEST(WrinkleMapsBlend, AFullMaskShowsItsMapOnAFlatNeutral) {
    RandomRig random(3);
    for (int round = 0; round < 100; ++round) {
        Pixel pixel = random_pixel(random, 1);
        pixel.masks[0] = 1.0f;
        EXPECT_LT(
            glm::distance(blend(Maps::kWhole, pixel.neutral, pixel.wrinkles, pixel.masks), pixel.wrinkles[0]),
            1e-6f);
        EXPECT_LT(glm::distance(blend(Maps::kWrinkles, Vec3(0, 0, 1), pixel.wrinkles, pixel.masks),
                                pixel.wrinkles[0]),
                  1e-6f);
    }
}

TEST(WrinkleMapsBlend, TheOrderOfPosesDoesNotMatter) {
    RandomRig random(4);
    for (int round = 0; round < 100; ++round) {
        Pixel pixel = random_pixel(random, 8);
        for (const Maps maps : {Maps::kWhole, Maps::kWrinkles}) {
            const Vec3 normal = blend(maps, pixel.neutral, pixel.wrinkles, pixel.masks);
            Pixel turned = pixel;
            std::reverse(turned.wrinkles.begin(), turned.wrinkles.end());
            std::reverse(turned.masks.begin(), turned.masks.end());
            EXPECT_LT(glm::distance(blend(maps, turned.neutral, turned.wrinkles, turned.masks), normal),
                      1e-5f);
        }
    }
}

}  // namespace
}  // namespace rumple::tests
