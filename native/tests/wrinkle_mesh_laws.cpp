// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of the Wrinkle Mesh: what must hold on any mesh and in any pose.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "base/errors.h"
#include "systems/wrinkle_mesh.h"
#include "tests/meshes.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_mesh;
using ModelHandle = std::shared_ptr<const Model>;

// A base and its fine mesh, ready to be posed.
struct Cloth {
    MeshData mesh;
    ModelHandle model;

    explicit Cloth(MeshData data, Index level = 2, AttachmentKind kind = AttachmentKind::kLimit,
                   Index steps = 0)
        : mesh(std::move(data)) {
        Source source;
        source.level = level;
        model = wrinkle_mesh::build(tests::build(mesh), source, kind, steps);
    }

    State solve(const std::vector<Vec3>& pose, const Settings& settings, const State* before = nullptr,
                Report* report = nullptr) const {
        Report unused;
        return wrinkle_mesh::solve(*model, settings, {}, {pose}, before, report ? *report : unused);
    }
    Picture show(const std::vector<Vec3>& pose, const Settings& settings, const State& state) const {
        Picture picture;
        wrinkle_mesh::show(*model, settings, {pose}, state, picture);
        return picture;
    }
    // The base squeezed along x and bent about z.
    std::vector<Vec3> squeezed(float factor, float bend = 0.0f) const {
        std::vector<Vec3> pose = mesh.positions;
        for (Vec3& p : pose) {
            p.x *= factor;
            const float angle = bend * p.x;
            p = {p.x * std::cos(angle) - p.y * std::sin(angle), p.x * std::sin(angle) + p.y * std::cos(angle),
                 p.z};
        }
        return pose;
    }
};

float largest(const std::vector<Vec3>& vectors) {
    float most = 0.0f;
    for (const Vec3& v : vectors) most = std::max(most, glm::length(v));
    return most;
}

bool same_bits(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0;
}

Settings unstretched() {
    Settings settings;
    settings.prestretch = 1.0f;
    return settings;
}

constexpr float kRounding = 2e-6f;  // metres, on bodies of about a metre

class EveryAttachment : public testing::TestWithParam<AttachmentKind> {};

TEST_P(EveryAttachment, RestStaysAtRest) {
    for (const MeshData& mesh :
         {tube(12, 8, 0.1f, 0.5f), grid(6, 5, 0.1f), triangulated(tube(9, 6, 0.1f, 0.4f))}) {
        const Cloth cloth(mesh, 2, GetParam());
        const State state = cloth.solve(mesh.positions, unstretched());
        EXPECT_LT(largest(state.offset), kRounding);
    }
}

TEST_P(EveryAttachment, RigidMotionCarriesTheFoldsAlong) {
    const Cloth cloth(tube(12, 10, 0.1f, 0.5f), 2, GetParam());
    const std::vector<Vec3> here = cloth.squeezed(0.75f);
    const State folded = cloth.solve(here, Settings{});
    ASSERT_GT(largest(folded.offset), 1e-3f);
    std::vector<Vec3> there = here;
    for (Vec3& p : there) p = Vec3(-p.y, p.x, p.z) + Vec3(0.5f, -0.25f, 1.0f);  // a quarter turn
    Report report;
    const State moved = cloth.solve(there, Settings{}, &folded, &report);
    EXPECT_EQ(report.iterations, 0);
    EXPECT_TRUE(same_bits(moved.offset, folded.offset));
    const Picture before = cloth.show(here, Settings{}, folded), after = cloth.show(there, Settings{}, moved);
    for (size_t v = 0; v < before.positions.size(); ++v) {
        const Vec3& p = before.positions[v];
        EXPECT_LT(glm::distance(after.positions[v], Vec3(-p.y, p.x, p.z) + Vec3(0.5f, -0.25f, 1.0f)),
                  kRounding);
    }
}

INSTANTIATE_TEST_SUITE_P(WrinkleMesh, EveryAttachment,
                         testing::Values(AttachmentKind::kLinear, AttachmentKind::kPnTriangle,
                                         AttachmentKind::kLimit));

TEST(WrinkleMeshLaws, NoVertexLeavesItsRadiusOrItsPlane) {
    const Cloth cloth(tube(12, 10, 0.1f, 0.5f), 2, AttachmentKind::kLinear);
    Settings settings;
    State state;
    for (int frame = 0; frame < 6; ++frame) {
        const std::vector<Vec3> pose = cloth.squeezed(1.0f - 0.08f * float(frame), 0.8f * float(frame));
        state = cloth.solve(pose, settings, frame ? &state : nullptr);
        const Measures measures = measure(*cloth.model, settings, {}, {pose}, state);
        EXPECT_LT(measures.attachment_violation, 1e-4f);
        const Picture picture = cloth.show(pose, settings, state);
        std::vector<Vec3> normals(cloth.model->base.welded.vertex_count);
        vertex_normals(cloth.model->base, pose, normals);
        for (size_t v = 0; v < picture.offset.size(); ++v) {
            const Vec3 normal =
                glm::normalize(interpolate(cloth.model->base, cloth.model->display.places[v], normals));
            const float depth = -glm::dot(picture.offset[v], normal);
            EXPECT_LE(depth, settings.inside * cloth.model->local_edge[v] + kRounding);
        }
    }
}

TEST(WrinkleMeshLaws, TheResidualFallsWithTheIterations) {
    const Cloth cloth(tube(16, 12, 0.1f, 0.5f));
    Settings settings;
    settings.bending = 0.0f;
    float former = std::numeric_limits<float>::max();
    // From the first sweep on: that one itself may raise it, see docs/wrinkle_mesh.md.
    for (const int iterations : {1, 2, 5, 10, 20, 50}) {
        settings.start_iterations = iterations;
        Report report;
        cloth.solve(cloth.squeezed(0.85f), settings, nullptr, &report);
        EXPECT_LT(report.error_after, former) << iterations << " iterations";
        former = report.error_after;
    }
    EXPECT_LT(former, 0.03f);
}

TEST(WrinkleMeshLaws, PreStretchBelowOneKeepsRestSmoothAndAboveOneWrinklesIt) {
    const Cloth cloth(grid(8, 8, 0.05f));
    Settings settings;
    const auto height = [&](float s) {
        settings.prestretch = s;
        const State state = cloth.solve(cloth.mesh.positions, settings);
        float most = 0.0f;
        for (const Vec3& o : state.offset) most = std::max(most, std::abs(o.z));
        return most;
    };
    EXPECT_LT(height(0.9f), kRounding);
    EXPECT_LT(height(1.0f), kRounding);
    EXPECT_GT(height(1.1f), 1e-3f);
}

TEST(WrinkleMeshLaws, StifferClothFoldsMoreBroadly) {
    const Cloth cloth(grid(24, 8, 0.02f));
    const auto crossings = [&](float stiffness) {
        Settings settings;
        settings.bending = stiffness;
        settings.start_iterations = 60;
        const std::vector<Vec3> pose = cloth.squeezed(0.85f);
        const Picture picture = cloth.show(pose, settings, cloth.solve(pose, settings));
        int count = 0;  // edges whose ends lie on different sides of the sheet
        for (const Edge& e : collect_edges(cloth.model->display.mesh)) {
            count += picture.offset[e.a].z * picture.offset[e.b].z < 0.0f;
        }
        return count;
    };
    const int soft = crossings(0.0f), middle = crossings(0.5f), stiff = crossings(1.0f);
    EXPECT_GT(soft, middle);
    EXPECT_GE(middle, stiff);
}

TEST(WrinkleMeshLaws, TheNumberOfThreadsChangesNoBit) {
    const Cloth cloth(tube(24, 24, 0.1f, 0.5f));
    Settings settings;
    settings.threads = 1;
    const State alone = cloth.solve(cloth.squeezed(0.8f, 1.0f), settings);
    for (const int threads : {2, 3, 4, 7}) {
        settings.threads = threads;
        EXPECT_TRUE(same_bits(cloth.solve(cloth.squeezed(0.8f, 1.0f), settings).offset, alone.offset))
            << threads;
    }
}

TEST(WrinkleMeshLaws, AHeldPoseStaysToTheBitAndADriftIsSolvedInTheEnd) {
    const Cloth cloth(tube(12, 10, 0.1f, 0.5f));
    const State first = cloth.solve(cloth.squeezed(0.8f), Settings{});
    const State held = cloth.solve(cloth.squeezed(0.8f), Settings{}, &first);
    EXPECT_TRUE(same_bits(held.offset, first.offset));
    State drifting = first;
    int solves = 0;
    for (int step = 1; step <= 100; ++step) {
        Report report;
        drifting = cloth.solve(cloth.squeezed(0.8f - 5e-5f * float(step)), Settings{}, &drifting, &report);
        solves += report.iterations > 0;
    }
    EXPECT_GT(solves, 0);
    EXPECT_LT(solves, 100);
    EXPECT_FALSE(same_bits(drifting.offset, first.offset));
}

TEST(WrinkleMeshLaws, AWokenStateTakesOtherSettingsInAHeldPose) {
    const Cloth cloth(tube(12, 10, 0.1f, 0.5f));
    const State folded = cloth.solve(cloth.squeezed(0.8f), Settings{});
    Settings none;
    none.radius = 0.0f;
    const State awake = woken(folded);
    EXPECT_EQ(largest(cloth.solve(cloth.squeezed(0.8f), none, &awake).offset), 0.0f);
    EXPECT_GT(largest(cloth.solve(cloth.squeezed(0.8f), none, &folded).offset), 1e-3f);
}

TEST(WrinkleMeshLaws, ColouredSweepsReachTheResidualOfThePrintedOnes) {
    const Cloth cloth(tube(16, 12, 0.1f, 0.5f));
    const std::vector<Vec3> pose = cloth.squeezed(0.8f);
    Settings settings;
    settings.start_iterations = 40;
    Report coloured, printed;
    const State a = solve(*cloth.model, settings, {}, {pose}, nullptr, coloured);
    const State b = solve_reference(*cloth.model, settings, {}, {pose}, nullptr, printed);
    EXPECT_NEAR(coloured.error_after, printed.error_after, 0.15f * printed.error_after);
    EXPECT_FALSE(same_bits(a.offset, b.offset));  // else the one is the other
}

TEST(WrinkleMeshLaws, AFlatSheetBucklesByTheNudgeOnlyAndTheSeedChoosesTheFolds) {
    const Cloth cloth(grid(10, 6, 0.05f));
    const auto offsets = [&](float nudge, std::uint32_t seed) {
        Settings settings;
        settings.nudge = nudge;
        settings.seed = seed;
        return cloth.solve(cloth.squeezed(0.85f), settings).offset;
    };
    const auto height = [](const std::vector<Vec3>& o) {
        float most = 0.0f;
        for (const Vec3& v : o) most = std::max(most, std::abs(v.z));
        return most;
    };
    EXPECT_LT(height(offsets(0.0f, 0)), kRounding);
    EXPECT_GT(height(offsets(0.02f, 0)), 2e-3f);
    EXPECT_FALSE(same_bits(offsets(0.02f, 0), offsets(0.02f, 1)));
    EXPECT_TRUE(same_bits(offsets(0.02f, 1), offsets(0.02f, 1)));
}

TEST(WrinkleMeshLaws, CollapsedPosesGiveFiniteResults) {
    const Cloth cloth(grid(4, 4, 0.1f), 2, AttachmentKind::kLimit, 1);
    std::vector<Vec3> pinched = cloth.mesh.positions, flat = cloth.mesh.positions;
    pinched[6] = pinched[7];                          // a zero-length edge
    for (Vec3& p : flat) p = Vec3(1.0f, 2.0f, 3.0f);  // all in one point
    for (const std::vector<Vec3>& pose : {pinched, flat}) {
        State state = cloth.solve(pose, Settings{});
        state = cloth.solve(cloth.mesh.positions, Settings{}, &state);
        for (const Vec3& p : cloth.show(cloth.mesh.positions, Settings{}, state).positions) {
            ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
        }
    }
}

TEST(WrinkleMeshLaws, PaintOfZeroHoldsAVertexAtItsAttachment) {
    const Cloth cloth(tube(12, 10, 0.1f, 0.5f));
    Paint paint;
    paint.radius.assign(cloth.model->attached.size(), 1.0f);
    paint.radius[40] = 0.0f;
    Report report;
    const State state = solve(*cloth.model, Settings{}, paint, {cloth.squeezed(0.75f)}, nullptr, report);
    EXPECT_EQ(glm::length(state.offset[40]), 0.0f);
    EXPECT_GT(largest(state.offset), 1e-3f);
}

TEST(WrinkleMeshLaws, AWeldedSeamDoesNotTear) {
    const Cloth cloth(seam_split_cube(), 3, AttachmentKind::kLimit, 1);
    std::vector<Vec3> pose = cloth.mesh.positions;
    for (Vec3& p : pose) p.x *= 0.7f;
    const Picture picture = cloth.show(pose, Settings{}, cloth.solve(pose, Settings{}));
    const Display& display = cloth.model->display;
    size_t pairs = 0;
    for (size_t a = 0; a < display.positions_rest.size(); ++a) {
        for (size_t b = a + 1; b < display.positions_rest.size(); ++b) {
            if (display.positions_rest[a] != display.positions_rest[b]) continue;
            ++pairs;
            EXPECT_EQ(picture.positions[a], picture.positions[b]);
        }
    }
    EXPECT_GT(pairs, 0u);
}

TEST(WrinkleMeshLaws, AnOwnMeshKeepsItsDetailsAndItsLooseVerticesFollow) {
    const MeshData base = tube(12, 8, 0.1f, 0.5f);
    const MeshData own = tube(30, 20, 0.104f, 0.5f);
    const Surface own_surface = tests::build(own);
    std::vector<std::uint8_t> attached(own.positions.size(), 1);
    attached[100] = 0;
    Source source;
    source.kind = Source::Kind::kOwn;
    source.own = &own_surface;
    source.attached = attached;
    const ModelHandle model = wrinkle_mesh::build(tests::build(base), source, AttachmentKind::kLimit, 0);
    Report report;
    const State state = solve(*model, unstretched(), {}, {base.positions}, nullptr, report);
    Picture picture;
    show(*model, unstretched(), {base.positions}, state, picture);
    for (size_t v = 0; v < own.positions.size(); ++v) {
        EXPECT_LT(glm::distance(picture.positions[v], own_surface.positions_rest[v]), kRounding);
    }
    source.farthest = 1e-4f;
    EXPECT_THROW(wrinkle_mesh::build(tests::build(base), source, AttachmentKind::kLimit, 0), InvalidInput);
}

TEST(WrinkleMeshLaws, NeighbourhoodCollisionStaysAboveItsFloor) {
    const Cloth cloth(grid(8, 8, 0.05f), 2, AttachmentKind::kLinear);
    Settings settings;
    settings.collision = Collision::kNeighbourhood;
    settings.inside = 0.2f;
    const std::vector<Vec3> pose = cloth.squeezed(0.8f);
    const State state = cloth.solve(pose, settings);
    float deepest = 0.0f;
    for (size_t v = 0; v < state.offset.size(); ++v) {
        EXPECT_GE(state.offset[v].z, -0.2f * cloth.model->local_edge[v] - kRounding);
        deepest = std::min(deepest, state.offset[v].z);
    }
    EXPECT_LT(deepest, 0.0f);
}

TEST(WrinkleMeshInput, SettingsOutOfRangeAreNamed) {
    const Cloth cloth(grid(2, 2, 0.1f));
    Settings settings;
    settings.bending = std::numeric_limits<float>::quiet_NaN();
    try {
        cloth.solve(cloth.mesh.positions, settings);
        FAIL();
    } catch (const InvalidInput& error) {
        EXPECT_NE(std::string(error.what()).find("bending"), std::string::npos) << error.what();
    }
    settings = {};
    settings.compression_limit = 0.5f;
    EXPECT_THROW(check(settings), InvalidInput);
    EXPECT_NO_THROW(check(Settings{}));
}

TEST(WrinkleMeshInput, BadPosesNameTheVertex) {
    const Cloth cloth(grid(2, 2, 0.1f));
    std::vector<Vec3> pose = cloth.mesh.positions;
    pose[5].y = std::numeric_limits<float>::quiet_NaN();
    try {
        cloth.solve(pose, Settings{});
        FAIL();
    } catch (const InvalidInput& error) {
        EXPECT_NE(std::string(error.what()).find("vertex 5"), std::string::npos) << error.what();
    }
    pose.pop_back();
    EXPECT_THROW(cloth.solve(pose, Settings{}), InvalidInput);
}

}  // namespace
}  // namespace rumple::tests
