// SPDX-License-Identifier: GPL-3.0-or-later
// Pairs and vertices are relaxed four at a time: the same bits as one after the other, in plain floats.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "systems/wrinkle_mesh/relax.h"
#include "tests/wrinkle_mesh_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_mesh;

void project_plainly(Vec3& p1, Vec3& p2, float target, float stiffness) {
    const Vec3 difference = p2 - p1;
    const float length = std::sqrt(glm::dot(difference, difference));
    if (length < kShortestEdge) return;
    const Vec3 half = (0.5f * stiffness * (length - target) / length) * difference;
    p1 += half;
    p2 -= half;
}

size_t blocks_of(const Model& model) {
    return model.block_row.size() - 1;
}

std::vector<size_t> pairs_of(const Pairs& pairs, size_t group) {
    std::vector<size_t> out(
        size_t(pairs.run_start[pairs.group_start[group + 1]] - pairs.run_start[pairs.group_start[group]]));
    std::iota(out.begin(), out.end(), size_t(pairs.run_start[pairs.group_start[group]]));
    return out;
}

struct Frame {
    Cloth cloth;
    Settings settings;
    Pose pose;
    Targets targets;
    Pose3 start;

    // Squeezed, off its attachments, and some vertices in one place; bounded by cloth of its own that is made
    // up.
    Frame(MeshData mesh, Collision collision, bool self_contact) : cloth(std::move(mesh)) {
        settings.collision = collision;
        settings.tangential_pull = self_contact ? 0.2f : 0.0f;
        settings.normal_pull = self_contact ? 0.02f : 0.0f;
        settings.apart = settings.slide = 0.45f;
        const Model& model = *cloth.model;
        pose = make_pose(model, {cloth.squeezed(0.8f, 2.0f)});
        targets = make_targets(model, settings, {}, pair_lengths(model, pose.attachment), pose, {});
        std::mt19937 random(7);
        const auto within = [&](float least, float most) {
            return std::uniform_real_distribution<float>(least, most)(random);
        };
        const float edge = model.local_edge[0];
        for (const Vec3& a : pose.attachment)
            start.push_back(a + edge * Vec3(within(-1, 1), within(-1, 1), within(-1, 1)));
        for (size_t i = 0; i < model.distance.size(); i += 11)
            start[model.distance.b[i]] = start[model.distance.a[i]];
        for (size_t v = 0; self_contact && v < start.size(); ++v) {
            const Vec3 towards = glm::normalize(Vec3(within(-1, 1), within(-1, 1), 0.1f));
            pose.heights.push_back(within(0.1f, 2.0f) * edge);
            const float distance = within(0, edge);
            pose.self_contact.push_back(
                v % 3 == 0 ? SelfContactSide{}
                           : SelfContactSide{towards, distance, v % 2 == 0 ? distance : 2.0f * edge});
        }
    }

    Pose3 relaxed(int threads) const {
        const SolveTeam team(threads, start.size(), 1);
        Pose3 x = start;
        relax_by_blocks(*cloth.model, targets, Bounds(*cloth.model, settings, {}, pose), 3, x);
        return x;
    }

    Pose3 relaxed_plainly() const {
        const Model& model = *cloth.model;
        const Bounds bounds(model, settings, {}, pose);
        Pose3 x = start;
        for (int iteration = 0; iteration < 3; ++iteration) {
            for (const size_t between : {0, 1}) {
                for (size_t block = 0; block < blocks_of(model); ++block) {
                    for (const size_t i : pairs_of(model.distance, 2 * block + between))
                        project_plainly(x[model.distance.a[i]], x[model.distance.b[i]], targets.distance[i],
                                        1.0f);
                    for (const size_t i : pairs_of(model.bending, 2 * block + between))
                        project_plainly(x[model.bending.a[i]], x[model.bending.b[i]], targets.bending[i],
                                        targets.stiffness[i]);
                }
            }
            for (size_t v = 0; v < x.size(); ++v) {
                const Vec3 away = x[v] - pose.attachment[v];
                const Vec3 off = glm::dot(away, pose.normal[v]) * pose.normal[v];
                x[v] -= settings.tangential_pull * (away - off) + settings.normal_pull * off;
                bounds.project(v, x[v]);
            }
        }
        return x;
    }
};

TEST(Relaxing, FourAtATimeAndOnAnyThreadsHasTheBitsOfOneAfterTheOther) {
    for (const Collision collision : {Collision::kNone, Collision::kPlane, Collision::kNeighbourhood}) {
        for (const bool self_contact : {false, true}) {
            for (const auto& [columns, rows] :
                 {std::pair(1, 1), std::pair(2, 1), std::pair(5, 3), std::pair(7, 4), std::pair(40, 8)}) {
                const Frame frame(grid(columns, rows, 0.1f), collision, self_contact);
                const Pose3 plain = frame.relaxed_plainly();
                EXPECT_NE(plain, frame.start);
                for (const int threads : {1, 2, 3, 4, 8}) {
                    const Pose3 x = frame.relaxed(threads);
                    EXPECT_EQ(std::memcmp(x.data(), plain.data(), x.size() * sizeof(Vec3)), 0)
                        << columns << " x " << rows << ", collision " << int(collision) << ", self-contact "
                        << self_contact << ", threads " << threads;
                }
            }
        }
    }
}

// Threads may then sweep all blocks at the same time, and after that all that lies between two of them.
void expect_blocks_apart(const Model& model) {
    const size_t blocks = blocks_of(model);
    for (const size_t between : {0, 1}) {
        std::vector<size_t> block_of(model.attached.size(),
                                     blocks);  // that sweeps a vertex; blocks: none yet
        for (const Pairs* pairs : {&model.distance, &model.bending}) {
            for (size_t block = 0; block < blocks; ++block) {
                for (const size_t i : pairs_of(*pairs, 2 * block + between)) {
                    for (const Index v : {pairs->a[i], pairs->b[i]}) {
                        EXPECT_TRUE(block_of[v] == blocks || block_of[v] == block) << "vertex " << v;
                        block_of[v] = block;
                    }
                }
            }
        }
    }
}

void expect_every_pair_in_one_run(const Pairs& pairs, size_t vertices) {
    EXPECT_EQ(pairs.run_start.front(), 0);
    EXPECT_EQ(size_t(pairs.run_start.back()), pairs.size());
    EXPECT_EQ(size_t(pairs.group_start.back()), pairs.run_start.size() - 1);
    for (size_t run = 0; run + 1 < pairs.run_start.size(); ++run) {
        EXPECT_LT(pairs.run_start[run], pairs.run_start[run + 1]);
        std::vector<bool> used(vertices, false);
        for (Index i = pairs.run_start[run]; i < pairs.run_start[run + 1]; ++i) {
            for (const Index v : {pairs.a[i], pairs.b[i]}) {
                EXPECT_FALSE(used[v]) << "run " << run << ", vertex " << v;
                used[v] = true;
            }
        }
    }
}

TEST(Relaxing, BlocksThatAreSweptAtTheSameTimeShareNoVertex) {
    for (const auto& [columns, rows] : {std::pair(40, 8), std::pair(8, 40), std::pair(120, 2)}) {
        const Cloth cloth(grid(columns, rows, 0.1f));
        EXPECT_GE(blocks_of(*cloth.model), 4u);
        expect_blocks_apart(*cloth.model);
        expect_every_pair_in_one_run(cloth.model->distance, cloth.model->attached.size());
        expect_every_pair_in_one_run(cloth.model->bending, cloth.model->attached.size());
    }
}

// In blocks, an edit of a small mesh would reach farther.
TEST(Relaxing, ASmallMeshIsOneBlock) {
    EXPECT_EQ(blocks_of(*Cloth(grid(15, 15, 0.1f)).model), 1u);
}

// A triangle that extends over several blocks makes them longer.
TEST(Relaxing, BlocksShareNoVertexOverLongTrianglesEither) {
    MeshData mesh = grid(40, 8, 0.1f);
    const auto by_x = [&](const Vec3& p, const Vec3& q) { return p.x < q.x; };
    const auto [low, high] = std::minmax_element(mesh.positions.begin(), mesh.positions.end(), by_x);
    const auto first = Index(low - mesh.positions.begin()), last = Index(high - mesh.positions.begin());
    mesh.positions.push_back(0.5f * (mesh.positions[first] + mesh.positions[last]) + Vec3(0, 0, 0.1f));
    mesh.add_polygon({first, last, Index(mesh.positions.size()) - 1});
    const Cloth whole(grid(40, 8, 0.1f)), with_sliver(std::move(mesh));
    EXPECT_LT(blocks_of(*with_sliver.model), blocks_of(*whole.model));
    expect_blocks_apart(*with_sliver.model);
}

}  // namespace
}  // namespace rumple::tests
