// SPDX-License-Identifier: GPL-3.0-or-later
// When the base cloth of a pose stays to the bit, and when it is solved again.
#include <gtest/gtest.h>

#include "surface/cloth/swing.h"
#include "tests/base_cloth_rig.h"

namespace rumple::tests {
namespace {

using namespace base_cloth;

TEST(BaseClothLaws, AHeldPoseComesToRestAndStaysToTheBit) {
    for (const MeshData& mesh : garment_meshes()) {
        const Garment garment(mesh);
        for (const Settings& settings : {weightless(), Settings{}}) {
            for (const Points& pose : {mesh.positions, garment.crumpled(0.8f, 2.0f, 0.2f)}) {
                Result result = garment.solve(settings, mesh.positions);
                result = garment.solve(settings, pose, &result.state);
                ASSERT_GT(garment.settle(settings, pose, result), 0);
                const Result first = result;
                for (int again = 0; again < 5; ++again) {
                    result = garment.solve(settings, pose, &result.state);
                    EXPECT_EQ(result.report.steps, 0);
                    ASSERT_TRUE(equal_bits(result, first)) << "solve " << again;
                }
            }
        }
    }
}

// Lengths and distances do not change then. The cloth stayed as it hung before, and a frame like that counted
// as solved.
TEST(BaseClothLaws, ClothThatTurnsAsAWholeHangsAnotherWay) {
    const auto lying = [](const Vec3& v) { return Vec3(v.x, v.z, -v.y); };
    const auto turned_about_the_vertical = [](const Vec3& v) { return Vec3(-v.y, v.x, v.z); };
    const auto all = [](const Points& points, const auto& turn) {
        Points out;
        for (const Vec3& p : points) out.push_back(turn(p));
        return out;
    };
    for (const MeshData& mesh : garment_meshes()) {
        const Garment garment(mesh);
        const Settings settings;
        Result rest;
        ASSERT_GT(garment.settle(settings, mesh.positions, rest), 0);
        const Points around = all(mesh.positions, turned_about_the_vertical);
        EXPECT_EQ(garment.solve(settings, around, &rest.state).report.steps, 0);

        const Points pose = all(mesh.positions, lying);
        Result result = garment.solve(settings, pose, &rest.state);
        EXPECT_GT(result.report.steps, 0);
        ASSERT_GT(garment.settle(settings, pose, result), 0);
        const Result anew = garment.solve(settings, pose);
        EXPECT_GT(farthest(anew.positions, all(rest.positions, lying)), 2e-3f);
        EXPECT_LT(farthest(result.positions, anew.positions), 1e-3f);

        Settings other = settings;
        other.gravity = {0.0f, settings.gravity.z, 0.0f};
        EXPECT_GT(garment.solve(other, mesh.positions, &rest.state).report.steps, 0);
    }
}

TEST(BaseClothLaws, WhatIsActivatedIsSolvedAgain) {
    const Garment garment(garment_meshes().front());
    Result rest;
    ASSERT_GT(garment.settle(Settings{}, garment.mesh.positions, rest), 0);
    const State awake = activated(rest.state);
    EXPECT_GT(garment.solve(Settings{}, garment.mesh.positions, &awake).report.steps, 0);
}

}  // namespace
}  // namespace rumple::tests
