// SPDX-License-Identifier: GPL-3.0-or-later
// What gives folds their direction and their place: cloth that is taut, and the pull back to the attachments.
#include <gtest/gtest.h>

#include <array>

#include "base/errors.h"
#include "tests/wrinkle_mesh_stack.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_mesh;

// ---------------------------------------------------------------- taut cloth
Settings wide(float taut_range) {
    Settings settings;
    settings.prestretch = 1.08f;
    settings.slack = 1.02f;
    settings.taut_range = taut_range;
    settings.tangential_pull = 0.2f;
    settings.start_iterations = 60;
    settings.hem_rings = 0;
    return settings;
}

// A base that is as long as its slack lets it be is taut both ways: layers that are cut wider have no folds.
TEST(WrinkleMeshLayers, TautClothHasNoFolds) {
    const Stack stack(grid(8, 6, 0.05f));
    const auto highest = [&](float stretch, float taut_range) {
        const Pose3 pose = stack.moved([=](const Vec3& p) { return p * stretch; });
        const LayersState state = stack.solve({pose}, alike(stack.count(), wide(taut_range)));
        float most = 0.0f;
        for (const Vec3& p : state.solved) most = std::max(most, std::abs(p.z));
        return most;
    };
    EXPECT_LT(highest(1.02f, 0.03f), 1e-5f);
    EXPECT_LT(highest(1.05f, 0.03f), 1e-5f);
    EXPECT_GT(highest(1.02f, 0.0f), 2e-3f);
    EXPECT_GT(highest(0.99f, 0.03f), 2e-3f);
}

// Sums of the squares of how much pairs climb that lie along x, and along y.
std::array<double, 2> slopes(const Stack& stack, const Vec3& stretch, const Settings& settings) {
    const Pose3 pose = stack.moved([&](const Vec3& p) { return p * stretch; });
    const LayersState state = stack.solve({pose}, alike(stack.count(), settings));
    const Model& finest = *stack.layers->layers.back();
    std::array<double, 2> sum{};
    for (size_t i = 0; i < finest.distance.size(); ++i) {
        const Index a = finest.distance.a[i], b = finest.distance.b[i];
        const Vec3 rest = finest.positions_rest[b] - finest.positions_rest[a];
        const double climb = state.solved[b].z - state.solved[a].z;
        if (std::abs(rest.y) < 1e-4f) sum[0] += climb * climb;
        if (std::abs(rest.x) < 1e-4f) sum[1] += climb * climb;
    }
    return sum;
}

// Taut along y, slack along x: lines along y stay as straight as they were, lines across them fold.
TEST(WrinkleMeshLayers, FoldsRunAlongThePull) {
    const Stack stack(grid(8, 6, 0.05f), 1);
    const Vec3 pulled(0.98f, 1.02f, 1.0f);
    const auto everywhere = slopes(stack, pulled, wide(0.0f)), along = slopes(stack, pulled, wide(0.03f));
    EXPECT_GT(everywhere[1], 0.2 * everywhere[0]);
    EXPECT_LT(along[1], 0.15 * along[0]);
    EXPECT_GT(along[0], 0.8 * everywhere[0]);
}

// The same where nothing is stretched, but y hangs down: a leg of trousers has long folds, and no rings.
TEST(WrinkleMeshLayers, FoldsRunAlongTheHang) {
    const Stack stack(grid(8, 6, 0.05f), 1);
    const Vec3 slack(0.98f, 0.99f, 1.0f);
    Settings hanging = wide(0.03f);
    hanging.hang = Vec3(0.0f, -1.0f, 0.0f);
    const auto free = slopes(stack, slack, wide(0.03f)), along = slopes(stack, slack, hanging);
    EXPECT_GT(free[1], 0.2 * free[0]);
    EXPECT_LT(along[1], 0.5 * free[1]);
    EXPECT_LT(along[1], 0.35 * along[0]);
    // At rest along the hang there is no more cloth than there is room for; compressed along it, there is.
    const Vec3 at_rest(1.0f), squeezed(1.0f, 0.9f, 1.0f);
    EXPECT_LT(slopes(stack, at_rest, hanging)[1], 0.25 * slopes(stack, at_rest, wide(0.03f))[1]);
    EXPECT_GT(slopes(stack, squeezed, hanging)[1], 4.0 * slopes(stack, at_rest, hanging)[1]);
    hanging.hang = Vec3(0.0f, 0.0f, -1.0f);  // it lies: nothing is pulled
    EXPECT_EQ(slopes(stack, slack, hanging), free);
    hanging.hang = Vec3(0.0f, -2.0f, 0.0f);
    EXPECT_THROW(slopes(stack, slack, hanging), InvalidInput);
}

// ---------------------------------------------------------------- the pull back
// Compressed cloth solved from two starts that lie apart along the surface, within the radius.
TEST(WrinkleMeshPull, FoldsFromTwoStartsComeNearer) {
    const Cloth cloth(grid(10, 8, 0.04f));
    const Pose3 pose = cloth.squeezed(0.85f);
    const auto apart_after = [&](float tangential, float normal) {
        Settings settings;
        settings.tangential_pull = tangential;
        settings.normal_pull = normal;
        State a = cloth.solve(pose, settings), b = a;
        for (size_t v = 0; v < b.offset.size(); ++v)
            b.offset[v] += 0.4f * cloth.model->local_edge[v] * Vec3(0.5f, 0.8f, 0.0f);
        for (int frame = 0; frame < 10; ++frame) {
            for (State* state : {&a, &b}) {
                const State active = activated(*state);
                *state = cloth.solve(pose, settings, &active);
            }
        }
        double sum = 0.0;
        for (size_t v = 0; v < b.offset.size(); ++v) {
            const double d = glm::distance(a.offset[v], b.offset[v]) / cloth.model->local_edge[v];
            sum += d * d;
        }
        return std::sqrt(sum / double(b.offset.size()));
    };
    const double without = apart_after(0.0f, 0.0f);
    EXPECT_LT(apart_after(0.1f, 0.0f), 0.7 * without);
    EXPECT_LT(apart_after(0.1f, 0.1f), 0.5 * without);
}

// All vertices moved alike: no pair changes its length, so that the pull alone moves them.
TEST(WrinkleMeshPull, TakesItsShareOfTheWayInEveryPass) {
    const Cloth cloth(grid(4, 4, 0.1f), 0, AttachmentKind::kLinear);
    Settings settings;
    settings.hem_rings = 0;
    settings.damping = 0.0f;
    settings.iterations = 1;
    settings.tangential_pull = 0.25f;
    settings.normal_pull = 0.5f;
    settings.offset_space = OffsetSpace::kWorld;
    const Vec3 away(0.004f, 0.002f, 0.003f);
    State state = cloth.solve(cloth.mesh.positions, settings);
    for (Vec3& o : state.offset) o = away;
    state = activated(state);
    for (const Vec3& o : cloth.solve(cloth.mesh.positions, settings, &state).offset)
        EXPECT_LT(glm::distance(o, away * Vec3(0.75f, 0.75f, 0.5f)), kRounding);
}

// Cloth that hangs free is wide enough: what it is pressed together makes its folds.
TEST(WrinkleMeshLayers, WhatHangsFreeIsCutNoWider) {
    const Stack stack(grid(10, 8, 0.04f), 1);
    const Pose3 pose = stack.squeezed(0.95f);
    Settings settings, wider;
    wider.prestretch = 1.1f;
    const auto solved = [&](const Settings& of, float worn) {
        std::vector<Paint> paint(stack.count());
        for (size_t k = 0; k < paint.size(); ++k)
            paint[k].worn.assign(stack.layers->layers[k]->positions_rest.size(), worn);
        return stack.solve({pose}, alike(2, of), nullptr, nullptr, paint).solved;
    };
    EXPECT_EQ(solved(wider, 1.0f), stack.solve({pose}, alike(2, wider)).solved);
    EXPECT_EQ(solved(wider, 0.0f), stack.solve({pose}, alike(2, settings)).solved);
    EXPECT_NE(solved(wider, 0.0f), solved(wider, 1.0f));
}

}  // namespace
}  // namespace rumple::tests
