// SPDX-License-Identifier: GPL-3.0-or-later
// The solver as passes over all vertices, as the graphics card runs it, with the formulas that it runs.
#include <gtest/gtest.h>

#include "base/errors.h"
#include "base/formulas.h"
#include "base/tolerances.h"
#include "systems/wrinkle_mesh/passes.h"
#include "systems/wrinkle_mesh/pose.h"
#include "tests/wrinkle_mesh_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_mesh;

TEST(Passes, ShareTheTolerancesOfTheLibrary) {
    EXPECT_EQ(formulas::kMeshShortestEdge, kShortestEdge);
    EXPECT_EQ(formulas::kMeshShortestNormal, kShortestNormal);
    EXPECT_EQ(formulas::kMeshHeldStrain, kHeldStrain);
    EXPECT_EQ(formulas::kMeshFreeStrain, kFreeStrain);
    EXPECT_EQ(formulas::kMeshHeldOutside, kHeldOutside);
}

// A frame on the card: every stage reads only what the stages before it wrote.
class Card {
  public:
    Card(const Model& model, const Settings& settings, const State& state)
        : model_(model),
          settings_(settings),
          passes_(collect_passes(model, settings, {})),
          active_(passes_.vertex.size(), 0.0f),
          solved_length_(state.solved_length) {
        for (const Index v : passes_.vertex) offset_.push_back(state.offset[size_t(v)]);
    }

    void go_on(const Pose3& positions) {
        take_pose(positions);
        find_targets();
        find_start();
        for (int i = 0; i < settings_.iterations; ++i) iterate();
        finish();
    }

    // By solved vertex, as in State::offset.
    Pose3 offsets() const {
        Pose3 out(offset_.size());
        for (size_t row = 0; row < out.size(); ++row) out[size_t(passes_.vertex[row])] = offset_[row];
        return out;
    }
    float held() const { return float(std::ranges::count(active_, 0.0f)) / float(active_.size()); }

  private:
    void take_pose(const Pose3& positions) {
        const Pose pose = make_pose(model_, {positions});
        const WeldedPose welded = weld_pose(model_, positions);
        EXPECT_EQ(welded.positions, pose.base);
        EXPECT_EQ(welded.normals, pose.base_normals);
        at_.clear();
        normal_.clear();
        frame_.clear();
        for (size_t row = 0; row < passes_.vertex.size(); ++row) {
            const auto [a, b, c] = passes_.base_vertices[row];
            at_.push_back(pose.attachment[size_t(passes_.vertex[row])]);
            normal_.push_back(pose.normal[size_t(passes_.vertex[row])]);
            frame_.push_back(
                formulas::mesh_frame(welded.positions[a], welded.positions[b], welded.positions[c]));
        }
    }

    void find_targets() {
        std::vector<float> activity(at_.size(), 0.0f);
        compression_.assign(at_.size(), 0.0f);
        target_.clear();
        for (size_t i = 0; i < passes_.pairs.size(); ++i) {
            const auto [a, b] = passes_.pairs[i];
            const float length = glm::distance(at_[a], at_[b]);
            target_.push_back(formulas::target_length(passes_.stretched[i], length, settings_.stretch_relief,
                                                      settings_.buckling_threshold,
                                                      settings_.compression_limit));
            const bool held = active_[a] <= 0.0f && active_[b] <= 0.0f;
            if (!held) solved_length_[i] = former_length_[i];
            const float act = formulas::pair_activity(length, solved_length_[i], passes_.rest[i]);
            for (const Index v : {a, b}) {
                activity[v] = std::max(activity[v], act);
                if (i < size_t(passes_.distance_count))
                    compression_[v] =
                        std::max(compression_[v], formulas::pair_compression(length, target_[i]));
            }
        }
        former_length_.clear();
        for (const auto& [a, b] : passes_.pairs) former_length_.push_back(glm::distance(at_[a], at_[b]));
        active_ = activity;
        for (size_t i = 0; i < size_t(passes_.distance_count); ++i) {
            const auto [a, b] = passes_.pairs[i];
            active_[a] = std::max(active_[a], 0.5f * activity[b]);
            active_[b] = std::max(active_[b], 0.5f * activity[a]);
        }
    }

    void find_start() {
        start_.clear();
        position_.clear();
        for (size_t v = 0; v < at_.size(); ++v) {
            start_.push_back(at_[v] + formulas::offset_to_object(frame_[v], offset_[v]));
            position_.push_back(formulas::unbuckled(start_[v], at_[v], normal_[v], compression_[v],
                                                    passes_.push[v], passes_.noise[v]));
        }
    }

    void iterate() {
        for (Index pass = 0; pass < passes_.count; ++pass) {
            const Pose3 before = position_;
            std::vector<int> projected(before.size(), 0);
            for (size_t i = 0; i < passes_.pairs.size(); ++i) {
                if (passes_.pass[i] != pass) continue;
                const auto [a, b] = passes_.pairs[i];
                const auto move = [&](Index own, Index other) {
                    position_[own] = formulas::projected_pair(before[own], before[other], target_[i],
                                                              passes_.stiffness[i]);
                    EXPECT_EQ(++projected[own], 1) << "two pairs of a vertex in a pass";
                };
                move(a, b);
                move(b, a);
            }
        }
        for (size_t v = 0; v < position_.size(); ++v) {
            position_[v] = formulas::pulled_back(position_[v], at_[v], normal_[v], settings_.tangential_pull,
                                                 settings_.normal_pull);
            position_[v] = bounded(v, position_[v]);
        }
    }

    void finish() {
        for (size_t v = 0; v < position_.size(); ++v) {
            if (active_[v] > 0.0f) {
                const Vec3 p =
                    bounded(v, formulas::blended(start_[v], position_[v], active_[v], settings_.damping));
                offset_[v] = formulas::offset_to_frame(frame_[v], p - at_[v]);
                continue;
            }
            const Vec3 inside = bounded(v, start_[v]);
            if (glm::distance(inside, start_[v]) > formulas::kMeshHeldOutside * passes_.radius[v])
                offset_[v] = formulas::offset_to_frame(frame_[v], inside - at_[v]);
        }
    }

    Vec3 bounded(size_t v, const Vec3& p) const {
        return formulas::within_bounds(p, at_[v], normal_[v], passes_.depth[v], passes_.radius[v]);
    }

    const Model& model_;
    const Settings settings_;
    const Passes passes_;
    std::vector<float> active_, solved_length_, former_length_, target_, compression_;
    std::vector<formulas::MeshFrame> frame_;
    Pose3 offset_, at_, normal_, start_, position_;
};

// A clip whose half does not move: on the card and in the library.
void expect_the_same_clip(const Cloth& cloth, const Settings& settings, float tolerance) {
    const auto pose = [&](float turn) { return cloth.folded(0.2f, turn); };
    State state = cloth.solve(pose(0.0f), settings);
    Card card(*cloth.model, settings, state);
    float moved = 0.0f;
    for (const float turn : {0.3f, 0.6f, 0.6f, 0.9f}) {
        Report report;
        state = cloth.solve(pose(turn), settings, &state, &report);
        card.go_on(pose(turn));
        EXPECT_NEAR(card.held(), 1.0f - report.active, 1e-3f);
        const Pose3 offsets = card.offsets();
        for (size_t v = 0; v < offsets.size(); ++v) {
            EXPECT_LT(glm::distance(offsets[v], state.offset[v]), tolerance * cloth.model->local_edge[v])
                << v;
            moved = std::max(moved, glm::length(offsets[v]) / cloth.model->local_edge[v]);
        }
    }
    EXPECT_GT(moved, 0.1f);
}

TEST(Passes, SolveLikeTheLibrary) {
    for (const AttachmentKind kind :
         {AttachmentKind::kLinear, AttachmentKind::kPnTriangle, AttachmentKind::kLimit}) {
        Settings settings;
        settings.prestretch = 1.1f;
        settings.buckling_threshold = 0.01f;
        expect_the_same_clip(Cloth(grid(8, 5, 0.05f), 2, kind), settings, 1e-3f);
        settings.collision = Collision::kNone;
        settings.tangential_pull = 0.2f;
        settings.normal_pull = 0.02f;
        expect_the_same_clip(Cloth(grid(8, 5, 0.05f), 2, kind), settings, 1e-3f);
    }
}

TEST(Passes, KeepTheOrderOfManyBlocks) {
    const Cloth cloth(grid(24, 16, 0.02f), 2);
    ASSERT_GT(cloth.model->block_row.size(), 4u);
    expect_the_same_clip(cloth, Settings{}, 1e-3f);
}

TEST(Passes, HaveThePlacesOfTheAttachments) {
    const Cloth cloth(split_at_seams(shaken(cube(), 0.1f, 3)), 2);
    const Passes passes = collect_passes(*cloth.model, {}, {});
    const Pose pose = make_pose(*cloth.model, {cloth.mesh.positions});
    for (size_t row = 0; row < passes.vertex.size(); ++row) {
        Vec3 sum(0.0f);
        for (Index k = passes.limit.start[row]; k < passes.limit.start[row + 1]; ++k)
            sum += passes.limit.weight[k] * pose.base[passes.limit.index[k]];
        EXPECT_LT(glm::distance(sum, pose.attachment[size_t(passes.vertex[row])]), kRounding);
    }
}

TEST(Passes, KnowWhereTheSurfaceOfTheAttachmentsPassesTheBase) {
    for (const AttachmentKind kind : {AttachmentKind::kLinear, AttachmentKind::kLimit}) {
        const Cloth cloth(grid(4, 3, 0.1f), 2, kind);
        const Passes passes = collect_passes(*cloth.model, {}, {});
        const Pose pose = make_pose(*cloth.model, {cloth.mesh.positions});
        const WeldedPose welded = weld_pose(*cloth.model, cloth.mesh.positions);
        int met = 0;
        for (size_t row = 0; row < passes.vertex.size(); ++row) {
            const Vec2 w = passes.weights[row];
            const Vec3 of_corner(1.0f - w.x - w.y, w.x, w.y);
            for (int k = 0; k < 3; ++k) {
                if (of_corner[k] < 1.0f - kZeroWeight) continue;
                EXPECT_LT(glm::distance(welded.smooth[passes.base_vertices[row][k]],
                                        pose.attachment[size_t(passes.vertex[row])]),
                          kRounding);
                ++met;
            }
        }
        EXPECT_EQ(met, 5 * 4);  // every vertex of the base
    }
}

TEST(Passes, RefuseWhatTheyDoNotHave) {
    const Cloth cloth(grid(3, 2, 0.1f));
    Settings settings;
    settings.collision = Collision::kNeighbourhood;
    EXPECT_THROW(collect_passes(*cloth.model, settings, {}), InvalidInput);
}

}  // namespace
}  // namespace rumple::tests
