// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of layers that are solved on a coarse mesh and shown on the dense one.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "systems/wrinkle_mesh/transfer.h"
#include "tests/refusals.h"
#include "tests/wrinkle_mesh_stack.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_mesh;

struct Dense {
    MeshData mesh = tube(80, 80, 0.08f, 0.5f);
    Surface surface = tests::build(mesh);
    std::shared_ptr<const CoarseMesh> coarse = build_coarse(surface, 0.03f);
    std::shared_ptr<const Layers> layers = build_layers(coarse->surface, 2, 0, 4'000'000);
    std::shared_ptr<const Transfer> transfer;

    explicit Dense(Index level = 0)
        : transfer(build_transfer(tests::build(mesh), *coarse, *layers, level, 0, 4'000'000)) {}

    LayersState solve(const Pose3& animated, float radius) const {
        Settings settings;
        settings.radius = radius;
        std::vector<Report> reports;
        const Pose3 at = coarse_positions(*coarse, surface, animated);
        const std::vector<Paint> paint(layers->layers.size());
        return wrinkle_mesh::solve(*layers, alike(layers->layers.size(), settings), paint, {at}, nullptr,
                                   reports);
    }
    Picture show(const Pose3& animated, const LayersState& state) const {
        Picture picture;
        wrinkle_mesh::show(*transfer, *coarse, *layers, animated, state, picture);
        return picture;
    }
    Pose3 squeezed(float factor) const {
        return each_moved(mesh.positions, [=](const Vec3& p) { return p * Vec3(factor, 1.0f, 1.0f); });
    }
};

TEST(Transfer, WithoutFoldsTheDenseMeshStaysWhereItIs) {
    for (const Index level : {0, 1}) {
        const Dense dense(level);
        const Pose3 rest =
            dense.show(dense.mesh.positions, dense.solve(dense.mesh.positions, 0.0f)).positions;
        const auto turned = [](const Vec3& p) { return Vec3(-p.y, p.x, p.z) + Vec3(0.3f, -0.2f, 0.1f); };
        const Pose3 pose = each_moved(dense.mesh.positions, turned);
        const Picture picture = dense.show(pose, dense.solve(pose, 0.0f));
        for (size_t v = 0; v < rest.size(); ++v) {
            EXPECT_LT(glm::distance(picture.positions[v], turned(rest[v])), 2e-6f);
            if (level == 0) {
                EXPECT_LT(glm::distance(rest[v], dense.mesh.positions[v]), 1e-6f);
            }
        }
    }
}

TEST(Transfer, AStretchThatTheCoarseMeshHasTooIsShownAsItIs) {
    const Dense dense;
    const Pose3 pose = dense.squeezed(0.8f);
    const Picture picture = dense.show(pose, dense.solve(pose, 0.0f));
    ASSERT_EQ(picture.positions.size(), pose.size());
    for (size_t v = 0; v < pose.size(); ++v) EXPECT_LT(glm::distance(picture.positions[v], pose[v]), 2e-4f);
}

// Skinning crushes a dense mesh in the hollow of a joint. Its layers have no such crease, so what is shown
// must have none: folds that are added to the crease would cross it as it crosses itself.
TEST(Transfer, ACreaseThatOnlyTheDenseMeshHasIsSmoothed) {
    for (const Index level : {0, 1}) {
        const Dense dense(level);
        const std::set<Index> samples(dense.coarse->base_vertex.begin(), dense.coarse->base_vertex.end());
        const Pose3 rest =
            dense.show(dense.mesh.positions, dense.solve(dense.mesh.positions, 0.0f)).positions;
        Pose3 pose = dense.mesh.positions;
        Index moved = 0;
        for (Index v = 0; v < Index(pose.size()); v += 3) {
            if (samples.contains(v)) continue;
            pose[v].x += 0.012f, ++moved;  // across the next two vertices of its row
        }
        EXPECT_GT(moved, 1000);
        const Picture picture = dense.show(pose, dense.solve(pose, 0.0f));
        for (size_t v = 0; v < rest.size(); ++v)
            EXPECT_LT(glm::distance(picture.positions[v], rest[v]), 0.002f) << level;
    }
}

TEST(Transfer, WhatMovesAsAWholeCarriesEveryVertexAsFar) {
    for (const Index level : {0, 1}) {
        const Dense dense(level);
        LayersState state = dense.solve(dense.mesh.positions, 0.0f);
        const Picture bare = dense.show(dense.mesh.positions, state);
        const Vec3 way(0.01f, -0.02f, 0.03f);
        for (Vec3& p : state.solved) p += way;
        const Picture moved = dense.show(dense.mesh.positions, state);
        for (size_t v = 0; v < bare.positions.size(); ++v) {
            EXPECT_LT(glm::distance(moved.positions[v], bare.positions[v] + way), 2e-6f);
            EXPECT_LT(glm::distance(moved.offset[v], way), 2e-6f);
        }
    }
}

TEST(Transfer, ASqueezedTubeFoldsAsItsLayersDo) {
    const Dense dense;
    const Pose3 pose = dense.squeezed(0.8f);
    const LayersState state = dense.solve(pose, 1.0f);
    const auto rms = [](const std::vector<Vec3>& ways) {
        double sum = 0.0;
        for (const Vec3& way : ways) sum += glm::dot(way, way);
        return std::sqrt(sum / double(ways.size()));
    };
    const double layers =
        rms(offsets(*dense.layers, coarse_positions(*dense.coarse, dense.surface, pose), state));
    EXPECT_GT(layers, 1e-3);
    EXPECT_NEAR(rms(dense.show(pose, state).offset), layers, 0.15 * layers);
}

TEST(Transfer, WhatIsFarFromTheCoarseMeshStaysPut) {
    MeshData mesh = grid(40, 40, 0.006f);
    const Index first = Index(mesh.positions.size());
    for (const Vec3& p : grid(1, 1, 0.006f).positions) mesh.positions.push_back(p + Vec3(0.5f, 0.1f, 0.0f));
    mesh.add_polygon({first, first + 1, first + 3, first + 2});
    const Surface surface = tests::build(mesh);
    const auto coarse = build_coarse(surface, 0.03f);
    const auto layers = build_layers(coarse->surface, 1, 0, 4'000'000);
    const auto transfer = build_transfer(tests::build(mesh), *coarse, *layers, 0, 0, 4'000'000);
    LayersState state;
    state.solved = layers->layers.back()->positions_rest;
    for (Vec3& p : state.solved) p.z += 0.01f;
    Picture picture;
    show(*transfer, *coarse, *layers, mesh.positions, state, picture);
    for (Index v = 0; v < Index(mesh.positions.size()); ++v) {
        const float up = picture.positions[v].z - mesh.positions[v].z;
        if (v >= first)
            EXPECT_EQ(up, 0.0f);
        else
            EXPECT_NEAR(up, 0.01f, 1e-5f);
    }
}

// A mesh with its coarse mesh, whose finest layer is lifted.
struct Lifted {
    MeshData mesh;
    Surface surface = tests::build(mesh);
    std::shared_ptr<const CoarseMesh> coarse = build_coarse(surface, 0.03f);
    std::shared_ptr<const Layers> layers = build_layers(coarse->surface, 1, 0, 4'000'000);

    // lift: from the finest layer's vertices at rest to how far each goes up. Returns the same of the mesh's.
    template <typename Lift>
    std::vector<float> shown(Lift&& lift) const {
        const auto transfer = build_transfer(tests::build(mesh), *coarse, *layers, 0, 0, 4'000'000);
        LayersState state;
        for (const Vec3& p : layers->layers.back()->positions_rest)
            state.solved.push_back(p + Vec3(0.0f, 0.0f, lift(p)));
        Picture picture;
        wrinkle_mesh::show(*transfer, *coarse, *layers, mesh.positions, state, picture);
        std::vector<float> up;
        for (size_t v = 0; v < mesh.positions.size(); ++v)
            up.push_back(picture.positions[v].z - mesh.positions[v].z);
        return up;
    }
};

// Two shells, and vertices of the upper one that lie nearer to the lower one: each moves as its own layers
// do.
TEST(Transfer, APartFollowsItsOwnPartOfTheCoarseMesh) {
    MeshData mesh = grid(40, 40, 0.006f);
    const Index first = Index(mesh.positions.size());
    add_part(mesh, grid(40, 40, 0.006f), {0.0f, 0.0f, 0.004f});
    for (Index v = first; v < Index(mesh.positions.size()); v += 5) mesh.positions[v].z = 0.0004f;
    for (int round = 0; round < 10; ++round) {  // vertices of the coarse mesh stay up
        const auto coarse = build_coarse(build(mesh), 0.03f);
        for (const Index v : coarse->base_vertex)
            if (v >= first) mesh.positions[v].z = 0.004f;
    }
    const std::vector<float> up =
        Lifted{mesh}.shown([](const Vec3& p) { return p.z > 0.002f ? 0.02f : 0.0f; });
    for (Index v = 0; v < Index(up.size()); ++v) EXPECT_NEAR(up[v], v < first ? 0.0f : 0.02f, 2e-4f) << v;
}

// Two halves of a sheet that hang together by a strip of a face's width. The coarse mesh does not have the
// strip: its vertices are nearest to one half or to the other, and would be torn apart in the middle.
TEST(Transfer, AStripBetweenTwoPartsIsNotTorn) {
    const MeshData mesh = grid(40, 40, 0.006f);
    MeshData cut;
    std::vector<Index> number(mesh.positions.size(), kNone);
    for (Index v = 0; v < Index(mesh.positions.size()); ++v) {
        const Index i = v % 41, j = v / 41;
        if (i > 16 && i < 24 && j != 20 && j != 21) continue;
        number[v] = Index(cut.positions.size());
        cut.positions.push_back(mesh.positions[v]);
    }
    for (size_t k = 0; k < mesh.corner_vertex.size(); k += 4) {
        const Index* corner = &mesh.corner_vertex[k];
        const auto at = [&](int c) { return number[corner[c]]; };
        if (at(0) != kNone && at(1) != kNone && at(2) != kNone && at(3) != kNone)
            cut.add_polygon({at(0), at(1), at(2), at(3)});
    }
    const std::vector<float> up = Lifted{cut}.shown([](const Vec3& p) { return p.x > 0.12f ? 0.02f : 0.0f; });
    for (Index i = 10; i < 30; ++i)
        EXPECT_LT(std::abs(up[number[i + 1 + 20 * 41]] - up[number[i + 20 * 41]]), 0.008f) << i;
    EXPECT_NEAR(up[number[10 + 20 * 41]], 0.0f, 1e-4f);
    EXPECT_NEAR(up[number[30 + 20 * 41]], 0.02f, 1e-4f);
}

TEST(Transfer, RefusesAnotherModelsStateAndMesh) {
    const Dense dense;
    LayersState state = dense.solve(dense.mesh.positions, 0.0f);
    const Pose3 fewer(dense.mesh.positions.begin(), dense.mesh.positions.end() - 1);
    expect_refused([&] { dense.show(fewer, state); }, {"positions"});
    state.solved.pop_back();
    expect_refused([&] { dense.show(dense.mesh.positions, state); }, {"state"});
    const auto other = build_layers(tests::build(grid(4, 4, 0.1f)), 1, 0, 1'000);
    expect_refused([&] { build_transfer(tests::build(dense.mesh), *dense.coarse, *other, 0, 0, 4'000'000); },
                   {"layers"});
}

}  // namespace
}  // namespace rumple::tests
