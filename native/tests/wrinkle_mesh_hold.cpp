// SPDX-License-Identifier: GPL-3.0-or-later
// A held pose of the Wrinkle Mesh: nothing moves, and nothing is forgotten.
#include <gtest/gtest.h>

#include "tests/wrinkle_mesh_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_mesh;

TEST(WrinkleMeshHold, TheSecondAndTheTenthSolveOfAPoseAreTheFirstToTheBit) {
    const Cloth cloth(tube(12, 10, 0.1f, 0.5f));
    for (const OffsetSpace space : {OffsetSpace::kTriangle, OffsetSpace::kWorld}) {
        for (const Collision collision : {Collision::kPlane, Collision::kNeighbourhood}) {
            Settings settings;
            settings.offset_space = space;
            settings.collision = collision;
            State state = cloth.solve(cloth.mesh.positions, settings);
            // Large and small motions, the small ones within what is held in full or in part.
            for (const float factor : {0.8f, 0.75f, 0.7499f, 0.749f, 0.746f, 0.9f}) {
                const Pose3 pose = cloth.squeezed(factor, 1.0f);
                const State first = state = cloth.solve(pose, settings, &state);
                for (int again = 2; again <= 10; ++again) {
                    Report report;
                    state = cloth.solve(pose, settings, &state, &report);
                    ASSERT_EQ(report.iterations, 0);
                    ASSERT_TRUE(same_bits(state, first)) << "solve " << again << " at " << factor;
                }
            }
        }
    }
}

TEST(WrinkleMeshHold, AStandingLegStaysToTheBitWhileTheArmMoves) {
    const Cloth cloth(grid(20, 4, 0.05f), 2, AttachmentKind::kLinear);
    const Pose3 squeezed = cloth.squeezed(0.8f);
    const State first = cloth.solve(squeezed, Settings{});
    Pose3 pose = squeezed;
    for (Vec3& p : pose) {
        if (p.x > 0.6f) p.x = 0.6f + 0.8f * (p.x - 0.6f);
    }
    Report report;
    const State second = cloth.solve(pose, Settings{}, &first, &report);
    EXPECT_GT(report.active, 0.2f);
    EXPECT_LT(report.active, 0.6f);
    size_t stayed = 0, moved = 0;
    for (size_t v = 0; v < first.offset.size(); ++v) {
        const bool same = first.offset[v] == second.offset[v];
        if (cloth.model->positions_rest[v].x < 0.6f) {
            ASSERT_TRUE(same) << "vertex " << v;
            ++stayed;
        } else {
            moved += !same;
        }
    }
    EXPECT_GT(stayed, 0u);
    EXPECT_GT(moved, 0u);
}

TEST(WrinkleMeshHold, ADriftTooSlowToBeSeenInOneFrameIsSolvedInTheEnd) {
    const Cloth cloth(tube(12, 10, 0.1f, 0.5f));
    State state = cloth.solve(cloth.squeezed(0.95f), Settings{});
    const State first = state;
    constexpr int kSteps = 2000;
    int solves = 0;
    Report report;
    for (int step = 1; step <= kSteps; ++step) {
        state =
            cloth.solve(cloth.squeezed(0.95f - 0.15f * float(step) / kSteps), Settings{}, &state, &report);
        solves += report.iterations > 0;
    }
    EXPECT_GT(solves, 0);
    EXPECT_LT(solves, kSteps);
    EXPECT_FALSE(same_bits(state.offset, first.offset));
    Report at_once;
    cloth.solve(cloth.squeezed(0.8f), Settings{}, nullptr, &at_once);
    EXPECT_LT(report.error_after, 1.25f * at_once.error_after);
}

TEST(WrinkleMeshHold, AStateOfAnotherMeshIsNotUsed) {
    const Cloth cloth(grid(6, 6, 0.1f)), other(grid(4, 4, 0.1f));
    const State foreign = other.solve(other.squeezed(0.8f), Settings{});
    const Pose3 pose = cloth.squeezed(0.8f);
    EXPECT_TRUE(same_bits(cloth.solve(pose, Settings{}, &foreign), cloth.solve(pose, Settings{})));
}

}  // namespace
}  // namespace rumple::tests
