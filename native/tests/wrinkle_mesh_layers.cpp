// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of the Wrinkle Meshes that lie one on the other.
#include <gtest/gtest.h>

#include "tests/contact_bodies.h"
#include "tests/refusals.h"
#include "tests/wrinkle_mesh_stack.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_mesh;

bool same_bits(const LayersState& a, const LayersState& b) {
    bool same = a.layers.size() == b.layers.size() && tests::same_bits(a.solved, b.solved);
    for (size_t k = 0; same && k < a.layers.size(); ++k) same = tests::same_bits(a.layers[k], b.layers[k]);
    return same;
}

float apart(const Pose3& a, const Pose3& b) {
    float most = 0.0f;
    for (size_t v = 0; v < a.size(); ++v) most = std::max(most, glm::distance(a[v], b[v]));
    return most;
}

std::vector<MeshData> meshes() {
    return {tube(12, 8, 0.1f, 0.5f), grid(8, 6, 0.05f), seam_split_cube(),
            triangulated(tube(9, 6, 0.1f, 0.4f))};
}

TEST(WrinkleMeshLayers, AtRestNothingMoves) {
    for (const MeshData& mesh : meshes()) {
        const Stack stack(mesh);
        ASSERT_EQ(stack.count(), 3u);
        std::vector<Report> reports;
        LayersState state = stack.solve({mesh.positions}, alike(3), nullptr, &reports);
        for (int again = 0; again < 2; ++again) {
            for (size_t k = 0; k < 3; ++k)
                EXPECT_LT(largest(state.layers[k].offset), kRounding) << "layer " << k;
            EXPECT_LT(apart(state.solved, stack.layers->layers[2]->positions_rest), kRounding);
            const Picture picture = stack.show(mesh.positions, mesh.positions, state);
            EXPECT_LT(apart(picture.positions, stack.layers->shown.positions_rest), kRounding);
            EXPECT_LT(largest(picture.offset), kRounding);
            state = stack.solve({mesh.positions}, alike(3), &state);
        }
        EXPECT_GT(reports[2].iterations, 0);
    }
}

// Pictures of single layers, which nobody asks for, took a quarter of the memory of a garment.
TEST(WrinkleMeshLayers, KeepNoPictureOfTheirOwn) {
    const Stack stack(tube(12, 8, 0.1f, 0.5f));
    for (const auto& layer : stack.layers->layers) EXPECT_TRUE(layer->shown.places.empty());
    EXPECT_FALSE(stack.layers->shown.places.empty());
}

TEST(WrinkleMeshLayers, WithoutRadiusTheyAreOneLimitSurfaceOnTheOther) {
    Settings still;
    still.radius = 0.0f;
    for (const MeshData& mesh : meshes()) {
        const Stack stack(mesh);
        const Pose3 pose = stack.squeezed(0.7f);
        const LayersState state = stack.solve({pose}, alike(3, still));
        Pose3 expected(stack.layers->base.welded.vertex_count);
        weld_positions(stack.layers->base, pose, expected);
        for (size_t k = 1; k < 3; ++k) {
            const SparseRows limit = subdivision_stencils(stack.layers->layers[k - 1]->solved, 1, true);
            Pose3 finer(limit.rows());
            apply<Vec3>(limit, expected, finer);
            expected = finer;
        }
        EXPECT_LT(apart(state.solved, expected), kRounding);
    }
}

Vec3 turned(const Vec3& p) {
    const Vec3 axis = glm::normalize(Vec3(1, 2, 3));
    const float angle = 1.1f;
    return std::cos(angle) * p + std::sin(angle) * glm::cross(axis, p) +
           (1.0f - std::cos(angle)) * glm::dot(axis, p) * axis;
}

TEST(WrinkleMeshLayers, RigidMotionCarriesTheFoldsAlong) {
    const Vec3 shift(0.5f, -0.25f, 1.0f);
    const Stack stack(tube(12, 8, 0.1f, 0.5f));
    const Pose3 here = stack.squeezed(0.75f);
    const LayersState folded = stack.solve({here}, alike(3));
    for (const State& layer : folded.layers) ASSERT_GT(largest(layer.offset), 1e-3f);
    Pose3 there = here;
    for (Vec3& p : there) p = turned(p) + shift;
    std::vector<Report> reports;
    const LayersState moved = stack.solve({there}, alike(3), &folded, &reports);
    for (size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(reports[k].iterations, 0) << "layer " << k;
        EXPECT_TRUE(tests::same_bits(moved.layers[k], folded.layers[k])) << "layer " << k;
    }
    Pose3 expected = folded.solved;
    for (Vec3& p : expected) p = turned(p) + shift;
    EXPECT_LT(apart(moved.solved, expected), 2.0f * kRounding);
}

TEST(WrinkleMeshLayers, ThreadsAndRepetitionChangeNoBit) {
    const Stack stack(tube(16, 12, 0.1f, 0.5f));
    Settings settings;
    settings.threads = 1;
    const LayersState first = stack.solve({stack.squeezed(0.8f)}, alike(3, settings));
    const LayersState next = stack.solve({stack.squeezed(0.75f)}, alike(3, settings), &first);
    for (const int threads : {1, 2, 4}) {
        settings.threads = threads;
        EXPECT_TRUE(same_bits(stack.solve({stack.squeezed(0.8f)}, alike(3, settings)), first)) << threads;
        EXPECT_TRUE(same_bits(stack.solve({stack.squeezed(0.75f)}, alike(3, settings), &first), next))
            << threads;
    }
}

TEST(WrinkleMeshLayers, AHeldPoseStaysToTheBitAndAWokenOneIsSolved) {
    const Stack stack(tube(12, 8, 0.1f, 0.5f));
    const Pose3 pose = stack.squeezed(0.8f);
    std::vector<Report> reports;
    const LayersState folded = stack.solve({pose}, alike(3));
    // From the second solve on; the first adds the offsets to positions that were rounded otherwise.
    LayersState state = folded;
    for (int again = 0; again < 5; ++again) {
        state = stack.solve({pose}, alike(3), &state, &reports);
        for (size_t k = 0; k < 3; ++k) {
            EXPECT_EQ(reports[k].active, 0.0f) << "layer " << k;
            EXPECT_TRUE(tests::same_bits(state.layers[k].offset, folded.layers[k].offset)) << "layer " << k;
        }
        EXPECT_LT(apart(state.solved, folded.solved), kRounding);
    }
    const LayersState again = stack.solve({pose}, alike(3), &state);
    EXPECT_TRUE(same_bits(again, state));
    Settings soft;
    soft.bending = 0.0f;
    const LayersState active = activated(folded);
    const LayersState softer = stack.solve({pose}, alike(3, soft), &active, &reports);
    for (size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(reports[k].active, 1.0f) << "layer " << k;
        EXPECT_FALSE(tests::same_bits(softer.layers[k].offset, folded.layers[k].offset)) << "layer " << k;
    }
}

// Squeezed cloth that may not go inwards, over a flat base. A plane is all that a layer knows of what lies
// below: where it is tilted, a vertex that slides along it comes a little deeper than the fold under it was
// high.
TEST(WrinkleMeshLayers, WithoutAGapNoLayerGoesBelowTheBase) {
    for (Index levels = 0; levels < 3; ++levels) {
        const Stack stack(grid(10, 8, 0.04f), levels);
        const std::vector<float> gap(stack.mesh.positions.size(), 0.0f);
        const Pose3 pose = stack.squeezed(0.8f);
        Input input{pose};
        input.gap = gap;
        const auto lowest_and_highest = [&](const Input& of) {
            const LayersState state = stack.solve(of, alike(size_t(levels) + 1));
            const auto [low, high] =
                std::minmax_element(state.solved.begin(), state.solved.end(),
                                    [](const Vec3& a, const Vec3& b) { return a.z < b.z; });
            return std::pair(low->z, high->z);
        };
        const auto [lowest, highest] = lowest_and_highest(input);
        EXPECT_GT(lowest, levels == 0 ? -kRounding : -0.02f * highest) << "layer " << levels;
        EXPECT_GT(highest, 0.02f) << "layer " << levels;
        EXPECT_LT(lowest_and_highest({pose}).first, -1e-3f) << "layer " << levels;
    }
}

// How far folds are from where they were solved, summed over some vertices: with what is done about that, and
// as subdivision alone leaves them.
struct Missed {
    double with = 0.0, without = 0.0;
    void add(const Vec3& solved, const Vec3& found, const Vec3& smooth) {
        with += glm::distance(found, solved);
        without += glm::distance(smooth, solved);
    }
    void check(double share) const {
        EXPECT_GT(without, 0.0);
        EXPECT_LT(with, share * without);
    }
};

// Subdivision alone would lower folds of five edges by a fifth where they are shown.
TEST(WrinkleMeshLayers, FoldsThatAreShownGoNearlyThroughTheSolvedVertices) {
    for (const MeshData& mesh : meshes()) {
        const Stack stack(mesh);
        const Pose3 pose = stack.squeezed(0.8f);
        const LayersState state = stack.solve({pose}, alike(3));
        const Picture picture = stack.show(pose, pose, state);
        const Pose3 offset = offsets(*stack.layers, pose, state);
        const SparseRows& rows = stack.layers->shown.from_solved;
        Pose3 smooth(rows.rows());
        apply<Vec3>(rows, offset, smooth);
        Missed missed;
        for (Index r = 0; r < rows.rows(); ++r) {
            for (Index k = rows.start[r]; k < rows.start[r + 1]; ++k) {
                if (rows.weight[k] < 0.5f || rows.start[r + 1] - rows.start[r] < 5) continue;  // on no vertex
                missed.add(offset[rows.index[k]], picture.offset[r], smooth[r]);
            }
        }
        missed.check(0.4);
    }
}

// ... and by a quarter in the layer that rides on them: here that one has no folds of its own.
TEST(WrinkleMeshLayers, ALayerRidesNearlyThroughTheSolvedVerticesOfTheOneBelow) {
    for (const MeshData& mesh : {tube(12, 8, 0.1f, 0.5f), grid(8, 6, 0.05f)}) {
        const Stack below(mesh, 0), both(mesh, 1);
        const Pose3 pose = below.squeezed(0.9f);
        std::vector<Settings> settings = alike(2);
        settings[0].apart = settings[0].slide = settings[1].radius = 0.0f;
        const Pose3 solved = offsets(*below.layers, pose, below.solve({pose}, {settings[0]}));
        const Pose3 ridden = offsets(*both.layers, pose, both.solve({pose}, settings));
        const PolygonMesh& coarse = below.layers->layers[0]->solved;
        const SparseRows limit = subdivision_stencils(coarse, 1, true);
        const SparseRows from = refine_subdivision(coarse, 1).vertex_from_parent;
        Pose3 smooth(limit.rows());
        apply<Vec3>(limit, solved, smooth);
        Missed missed;
        for (Index v = 0; v < from.rows(); ++v) {
            if (from.start[v + 1] - from.start[v] == 1)
                missed.add(solved[from.index[from.start[v]]], ridden[v], smooth[v]);
        }
        // A seventh of an edge, the bound, is less than what such narrow folds miss.
        missed.check(0.75);
    }
}

// Two frames of one pose over bodies, or none, a millimetre thick.
Pose3 solved_over(const Stack& stack, const std::vector<Settings>& settings, const Pose3& pose,
                  const std::vector<float>& gap, const PosedCollider* bodies,
                  const std::vector<Index>& hint) {
    Input input{pose};
    input.gap = gap;
    input.thickness = 0.001f;
    if (bodies) {
        input.bodies = bodies;
        input.body_hint = hint;
    }
    const LayersState state = stack.solve(input, settings);
    return stack.solve(input, settings, &state).solved;
}

// A tube over a tube: squeezed along, it may not fold into the body.
TEST(WrinkleMeshLayers, NoLayerOnTheFirstIsInsideABody) {
    const Body body = body_of(tube(96, 60, 0.095f, 1.0f));
    const Collider collider = body.collider();
    std::vector<Vec3> under = body.positions;
    for (Vec3& p : under) p.x -= 0.25f;
    const PosedCollider bodies(collider, under);
    const Stack stack(tube(24, 16, 0.1f, 0.5f));
    Pose3 pose = stack.squeezed(0.8f);
    std::vector<Index> hint(pose.size());
    std::vector<float> gap(pose.size(), 0.02f);  // knows nothing
    for (size_t v = 0; v < pose.size(); ++v) {
        const Vec3 out = glm::normalize(Vec3(0.0f, pose[v].y, pose[v].z));
        hint[v] = bodies.closest(pose[v], out, 0.1f, kNone).triangle;
        ASSERT_NE(hint[v], kNone);
    }
    const auto deepest = [&](const PosedCollider* known) {
        float most = -1.0f;
        for (const Vec3& p : solved_over(stack, alike(3), pose, gap, known, hint)) {
            const Vec3 out = glm::normalize(Vec3(0.0f, p.y, p.z));
            most = std::max(most, -bodies.closest(p, out, 0.1f, kNone).distance);
        }
        return most;
    };
    EXPECT_LT(deepest(&bodies), 1e-4f);
    EXPECT_GT(deepest(nullptr), 1e-3f);
}

TEST(WrinkleMeshLayers, NoLayerIsBehindABodyInFront) {
    const Body body = ceiling(0.004f);
    const Collider collider = body.collider();
    const PosedCollider bodies(collider, body.positions);
    const Stack stack(grid(10, 8, 0.04f));
    const Pose3 pose = stack.squeezed(0.8f);
    const std::vector<float> gap(pose.size(), 0.02f);
    const std::vector<Index> hint(pose.size(), kNone);  // nothing is worn under it
    Settings settings;
    settings.apart = settings.slide = 0.45f;
    std::vector<Settings> all = alike(3, settings);
    const auto highest = [&](const PosedCollider* known) {
        float most = 0.0f;
        for (const Vec3& p : solved_over(stack, all, pose, gap, known, hint)) most = std::max(most, p.z);
        return most;
    };
    EXPECT_LT(highest(&bodies), 0.003f + 1e-4f);
    EXPECT_GT(highest(nullptr), 0.006f);
    all[0].radius = 0.0f;  // a layer that cannot move finds nothing: the next ones look all the same
    EXPECT_LT(highest(&bodies), 0.003f + 1e-4f);
    EXPECT_GT(highest(nullptr), 0.006f);
}

TEST(WrinkleMeshLayers, AnUnpaintedRadiusLeavesItsLayerFlat) {
    const Stack stack(tube(12, 8, 0.1f, 0.5f));
    const Pose3 pose = stack.squeezed(0.8f);
    for (size_t flat = 0; flat < 3; ++flat) {
        std::vector<Paint> paint(3);
        paint[flat].radius.assign(stack.layers->layers[flat]->attached.size(), 0.0f);
        const LayersState state = stack.solve({pose}, alike(3), nullptr, nullptr, paint);
        for (size_t k = 0; k < 3; ++k) {
            const float most = largest(state.layers[k].offset);
            if (k == flat) {
                EXPECT_EQ(most, 0.0f);
            } else {
                EXPECT_GT(most, 1e-3f) << "layer " << k;
            }
        }
    }
}

TEST(WrinkleMeshLayers, PaintIsCarriedFromLayerToLayer) {
    const Stack stack(grid(8, 6, 0.05f));
    std::vector<float> painted;
    for (const Vec3& p : stack.mesh.positions) painted.push_back(p.x / 0.4f);
    const std::vector<std::vector<float>> carried = carry_paint(*stack.layers, painted);
    ASSERT_EQ(carried.size(), 3u);
    for (size_t k = 0; k < 3; ++k) {
        const Model& layer = *stack.layers->layers[k];
        ASSERT_EQ(carried[k].size(), layer.attached.size());
        for (size_t v = 0; v < carried[k].size(); ++v) {
            if (layer.border_ring[v] < 3)
                continue;  // near corners the limit surface is not where linear paint is
            EXPECT_NEAR(carried[k][v], layer.positions_rest[v].x / 0.4f, 1e-5f) << "layer " << k;
        }
    }
    // 1 all over was 1 but for a rounding, and folds multiplied it.
    painted.assign(painted.size(), 0.7f);
    for (const std::vector<float>& layer : carry_paint(*stack.layers, painted))
        EXPECT_EQ(layer, std::vector<float>(layer.size(), 0.7f));
}

// What is shown over the animated mesh is where it was solved.
TEST(WrinkleMeshLayers, EmbeddedInTheAnimatedMeshItIsWhereItWasSolved) {
    for (const MeshData& mesh : meshes()) {
        const Stack stack(mesh);
        const Pose3 positions = stack.squeezed(0.8f);
        const Pose3 animated =
            stack.moved([](const Vec3& p) { return Vec3(p.x, 0.9f * p.y + 0.1f * p.x, p.z); });
        const LayersState state = stack.solve({positions}, alike(3));
        const Picture solved = stack.show(positions, positions, state);
        const Picture picture = stack.show(animated, positions, state);
        EXPECT_LT(apart(picture.positions, solved.positions), kRounding);
        Pose3 base(stack.layers->base.welded.vertex_count);
        weld_positions(stack.layers->base, animated, base);
        std::vector<SurfaceFrame> frames(stack.layers->base.triangles.size());
        triangle_frames(stack.layers->base, base, frames);
        float moved = 0.0f;
        for (size_t v = 0; v < picture.positions.size(); ++v) {
            const SurfacePoint& place = stack.layers->shown.places[v];
            const Vec3 back = interpolate(stack.layers->base, place, base) +
                              frames[place.triangle].to_object(picture.local_offset[v]);
            ASSERT_LT(glm::distance(back, picture.positions[v]), kRounding) << v;
            moved = std::max(moved, glm::distance(picture.local_offset[v], solved.local_offset[v]));
        }
        EXPECT_GT(moved, 1e-3f);
    }
}

// Viewports with fewer steps show the solved vertices themselves; renders are what they are without.
TEST(WrinkleMeshLayers, InViewportsTheFoldsAreThoseOfRenders) {
    for (const MeshData& mesh : meshes()) {
        const Stack stack(mesh);
        const auto stepped = build_layers(tests::build(mesh), 2, 1, 4'000'000, 0);
        ASSERT_TRUE(stepped->shown_in_viewport);
        EXPECT_FALSE(stack.layers->shown_in_viewport);
        const Pose3 pose = stack.squeezed(0.8f);
        const LayersState state = stack.solve({pose}, alike(3));
        const Picture render = stack.show(pose, pose, state);
        Picture same, fewer;
        show(*stepped, pose, pose, state, same);
        show(*stepped, pose, pose, state, fewer, true);
        EXPECT_EQ(same.positions, render.positions);
        const ShownMesh& shown = *stepped->shown_in_viewport;
        ASSERT_EQ(shown.from_solved.index.size(), fewer.positions.size());  // one solved vertex for each
        for (size_t v = 0; v < fewer.positions.size(); ++v)
            EXPECT_EQ(fewer.positions[v], state.solved[shown.from_solved.index[v]]) << v;
        EXPECT_LT(3 * fewer.positions.size(), render.positions.size());
    }
}

TEST(WrinkleMeshLayers, BadInputIsNamed) {
    const Stack stack(grid(4, 4, 0.05f));
    const Pose3& pose = stack.mesh.positions;
    expect_refused([&] { stack.solve({pose}, alike(2)); }, {"settings", "3", "2"});
    const std::vector<float> gap(7, 0.0f);
    Input input{pose};
    input.gap = gap;
    expect_refused([&] { stack.solve(input, alike(3)); }, {"gap", "25", "7"});
    expect_refused([&] { build_layers(tests::build(stack.mesh), -1, 0, 1000); }, {"levels"});
    expect_refused([&] { build_layers(tests::build(stack.mesh), 6, 0, 1000); }, {"1000"});
    expect_refused([&] { build_layers(tests::build(stack.mesh), 1, 1, 1000, -1); }, {"viewport_steps"});
}

}  // namespace
}  // namespace rumple::tests
