// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of the Wrinkle Mesh: what must hold on any mesh and in any pose.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "base/errors.h"
#include "systems/wrinkle_mesh/wrinkle_mesh.h"
#include "tests/wrinkle_mesh_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_mesh;
Settings unstretched() {
    Settings settings;
    settings.prestretch = 1.0f;
    return settings;
}

class EveryAttachment : public testing::TestWithParam<AttachmentKind> {};

// A ring of faces around the z axis through `centre`: of genus one, unlike any base here.
MeshData torus(Index around, Index across, float major, float minor, const Vec3& centre) {
    MeshData mesh;
    for (Index i = 0; i < around; ++i) {
        const float a = 2.0f * std::numbers::pi_v<float> * float(i) / float(around);
        for (Index j = 0; j < across; ++j) {
            const float b = 2.0f * std::numbers::pi_v<float> * float(j) / float(across);
            const float radius = major + minor * std::cos(b);
            mesh.positions.push_back(centre +
                                     Vec3(radius * std::cos(a), radius * std::sin(a), minor * std::sin(b)));
        }
    }
    for (Index i = 0; i < around; ++i) {
        for (Index j = 0; j < across; ++j) {
            const Index next = (i + 1) % around * across, here = i * across, up = (j + 1) % across;
            mesh.add_polygon({here + j, next + j, next + up, here + up});
        }
    }
    return mesh;
}

Source subdivided(Index level) {
    Source source;
    source.level = level;
    return source;
}

Source split(Index segments) {
    Source source;
    source.kind = Source::Kind::kRegular;
    source.segments = segments;
    return source;
}

Source split_below(float longest) {
    Source source;
    source.kind = Source::Kind::kLongestEdge;
    source.longest_edge = longest;
    return source;
}

Source own_mesh(const Surface& own, std::span<const std::uint8_t> attached = {}) {
    Source source;
    source.own = &own;
    source.attached = attached;
    return source;
}

TEST_P(EveryAttachment, RestStaysAtRestFromEverySource) {
    const Surface loop = tests::build(torus(24, 8, 0.1f, 0.03f, {0.25f, 0.0f, 0.0f}));
    const Surface finer = tests::build(tube(30, 20, 0.104f, 0.5f));
    for (const MeshData& mesh :
         {tube(12, 8, 0.1f, 0.5f), grid(6, 5, 0.1f), triangulated(tube(9, 6, 0.1f, 0.4f))}) {
        for (const Source& source :
             {subdivided(0), subdivided(2), split(3), split_below(0.03f), own_mesh(loop), own_mesh(finer)}) {
            const Cloth cloth(mesh, source, GetParam());
            Report report;
            State state = cloth.solve(mesh.positions, unstretched(), nullptr, &report);
            EXPECT_GT(report.iterations, 0);
            EXPECT_LT(largest(state.offset), kRounding);
            state = cloth.solve(mesh.positions, unstretched(), &state);
            EXPECT_LT(largest(state.offset), kRounding);
            const Picture picture = cloth.show(mesh.positions, unstretched(), state);
            for (size_t v = 0; v < picture.positions.size(); ++v) {
                EXPECT_LT(glm::distance(picture.positions[v], cloth.model->shown.positions_rest[v]),
                          kRounding);
            }
        }
    }
}

Vec3 turned(const Vec3& p) {
    const Vec3 axis = glm::normalize(Vec3(1, 2, 3));
    const float angle = 1.1f;
    return std::cos(angle) * p + std::sin(angle) * glm::cross(axis, p) +
           (1.0f - std::cos(angle)) * glm::dot(axis, p) * axis;
}

void expect_rigid(const Cloth& cloth) {
    const Vec3 shift(0.5f, -0.25f, 1.0f);
    const Pose3 here = cloth.squeezed(0.75f);
    const State folded = cloth.solve(here, Settings{});
    ASSERT_GT(largest(folded.offset), 1e-3f);
    Pose3 there = here;
    for (Vec3& p : there) p = turned(p) + shift;
    Report report;
    const State moved = cloth.solve(there, Settings{}, &folded, &report);
    EXPECT_EQ(report.iterations, 0);
    EXPECT_TRUE(same_bits(moved, folded));
    const Picture before = cloth.show(here, Settings{}, folded), after = cloth.show(there, Settings{}, moved);
    for (size_t v = 0; v < before.positions.size(); ++v) {
        ASSERT_LT(glm::distance(after.positions[v], turned(before.positions[v]) + shift), kRounding) << v;
    }
    // Solved anew over there, the folds are the same but for roundings, which buckling enlarges.
    const State anew = cloth.solve(there, Settings{});
    double sum = 0.0;
    for (size_t v = 0; v < anew.offset.size(); ++v) {
        const float apart = glm::distance(anew.offset[v], folded.offset[v]) / cloth.model->local_edge[v];
        sum += double(apart) * apart;
    }
    EXPECT_LT(std::sqrt(sum / double(anew.offset.size())), 0.01);
}

TEST_P(EveryAttachment, RigidMotionCarriesTheFoldsAlong) {
    const MeshData mesh = tube(12, 10, 0.1f, 0.5f);
    const Surface own = tests::build(tube(30, 40, 0.104f, 0.5f));
    for (const Source& source : {subdivided(2), split(4), own_mesh(own)}) {
        expect_rigid(Cloth(mesh, source, GetParam()));
    }
}

INSTANTIATE_TEST_SUITE_P(WrinkleMesh, EveryAttachment,
                         testing::Values(AttachmentKind::kLinear, AttachmentKind::kPnTriangle,
                                         AttachmentKind::kLimit));

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

// Mean distance between every second change of side, along all rows of the strip.
float wavelength(const Cloth& cloth, const Settings& settings, const Pose3& pose) {
    const Picture picture = cloth.show(pose, settings, cloth.solve(pose, settings));
    std::map<float, std::vector<std::pair<float, float>>> rows;  // y -> (x, height)
    for (size_t v = 0; v < picture.positions.size(); ++v) {
        const Vec3& at = cloth.model->shown.positions_rest[v];
        rows[std::round(1e4f * at.y)].push_back({at.x, picture.offset[v].z});
    }
    float length = 0.0f, crossings = 0.0f;
    for (auto& [y, row] : rows) {
        std::sort(row.begin(), row.end());
        length += row.back().first - row.front().first;
        for (size_t i = 1; i < row.size(); ++i) crossings += row[i].second * row[i - 1].second < 0.0f;
    }
    return 2.0f * length / crossings;
}

TEST(WrinkleMeshLaws, StifferClothFoldsMoreBroadly) {
    const Cloth strip(grid(64, 6, 0.02f), 1, AttachmentKind::kLinear);
    const auto mean_wavelength = [&](float stiffness) {
        Settings settings;
        settings.bending = stiffness;
        settings.hem_rings = 0;
        settings.start_iterations = 60;
        float sum = 0.0f;
        for (settings.seed = 0; settings.seed < 4; ++settings.seed) {
            sum += wavelength(strip, settings, strip.squeezed(0.85f));
        }
        return sum / 4.0f;
    };
    const float soft = mean_wavelength(0.0f), middle = mean_wavelength(0.3f), stiff = mean_wavelength(1.0f);
    EXPECT_GT(middle, 1.15f * soft);
    EXPECT_GT(stiff, 1.15f * middle);
}

TEST(WrinkleMeshLaws, TheNumberOfThreadsChangesNoBit) {
    const Cloth cloth(tube(24, 24, 0.1f, 0.5f));
    Settings settings;
    settings.threads = 1;
    const State alone = cloth.solve(cloth.squeezed(0.8f, 1.0f), settings);
    const State alone_next = cloth.solve(cloth.squeezed(0.75f, 1.2f), settings, &alone);
    for (const int threads : {2, 3, 4, 7}) {
        settings.threads = threads;
        EXPECT_TRUE(same_bits(cloth.solve(cloth.squeezed(0.8f, 1.0f), settings), alone)) << threads;
        EXPECT_TRUE(same_bits(cloth.solve(cloth.squeezed(0.75f, 1.2f), settings, &alone), alone_next))
            << threads;
    }
}

TEST(WrinkleMeshLaws, AWokenStateTakesOtherSettingsInAHeldPose) {
    const Cloth cloth(tube(12, 10, 0.1f, 0.5f));
    const State folded = cloth.solve(cloth.squeezed(0.8f), Settings{}), active = activated(folded);
    Settings soft;
    soft.bending = 0.0f;
    EXPECT_FALSE(same_bits(cloth.solve(cloth.squeezed(0.8f), soft, &active).offset, folded.offset));
    EXPECT_TRUE(same_bits(cloth.solve(cloth.squeezed(0.8f), soft, &folded).offset, folded.offset));
    Settings none;  // bounds hold active or not
    none.radius = 0.0f;
    EXPECT_EQ(largest(cloth.solve(cloth.squeezed(0.8f), none, &active).offset), 0.0f);
    EXPECT_EQ(largest(cloth.solve(cloth.squeezed(0.8f), none, &folded).offset), 0.0f);
}

TEST(WrinkleMeshLaws, ColouredSweepsReachTheResidualOfThePrintedOnes) {
    const Cloth cloth(tube(16, 12, 0.1f, 0.5f));
    const std::vector<Vec3> pose = cloth.squeezed(0.8f);
    Settings settings;
    settings.start_iterations = 40;
    Report coloured, printed;
    const State a = solve(*cloth.model, settings, {}, {pose}, nullptr, coloured);
    const State b = solve_in_order(*cloth.model, settings, {}, {pose}, nullptr, printed);
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

TEST(WrinkleMeshLaws, AWeldedSeamDoesNotTear) {
    const Cloth cloth(seam_split_cube(), 3, AttachmentKind::kLimit, 1);
    std::vector<Vec3> pose = cloth.mesh.positions;
    for (Vec3& p : pose) p.x *= 0.7f;
    Settings settings;
    settings.hem_rings = 0;  // or the fade alone would hold an open seam still
    const Picture picture = cloth.show(pose, settings, cloth.solve(pose, settings));
    const ShownMesh& display = cloth.model->shown;
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
    MeshData own = tube(30, 20, 0.104f, 0.5f);
    const Surface own_surface = tests::build(own);
    std::vector<std::uint8_t> attached(own.positions.size(), 1);
    attached[100] = 0;
    const Cloth cloth(base, own_mesh(own_surface, attached), AttachmentKind::kLimit);
    const Pose3 aside = cloth.moved([](const Vec3& p) { return p + Vec3(0.0f, 2.0f, 0.0f); });
    const State state = cloth.solve(base.positions, unstretched());
    const Picture picture = cloth.show(aside, unstretched(), cloth.solve(aside, unstretched(), &state));
    for (size_t v = 0; v < own.positions.size(); ++v) {
        EXPECT_LT(glm::distance(picture.positions[v], own.positions[v] + Vec3(0.0f, 2.0f, 0.0f)), kRounding);
    }
}

TEST(WrinkleMeshLaws, AnUnattachedVertexKnowsNoRadius) {
    const MeshData base = tube(12, 8, 0.1f, 0.5f);
    const MeshData own = tube(24, 16, 0.1f, 0.5f);
    const Surface own_surface = tests::build(own);
    std::vector<std::uint8_t> attached(own.positions.size(), 1);
    attached[200] = 0;
    Settings settings;
    settings.radius = 0.1f;
    const auto beyond = [&](std::span<const std::uint8_t> marks) {
        const Cloth cloth(base, own_mesh(own_surface, marks), AttachmentKind::kLimit);
        const State state = cloth.solve(cloth.squeezed(0.7f), settings);
        return glm::length(state.offset[200]) / (settings.radius * cloth.model->local_edge[200]);
    };
    EXPECT_LE(beyond({}), 1.001f);
    EXPECT_GT(beyond(attached), 1.5f);
}

// A vertex without faces, as a stray click leaves it, is not part of the fine mesh.
TEST(WrinkleMeshLaws, AnOwnMeshMayHaveVerticesWithoutFaces) {
    const MeshData base = tube(12, 8, 0.1f, 0.5f);
    MeshData own = tube(24, 16, 0.103f, 0.5f);
    own.positions.insert(own.positions.begin(), Vec3(0.2f, 0.0f, 0.3f));
    for (Index& v : own.corner_vertex) ++v;
    const Surface own_surface = tests::build(own);
    std::vector<std::uint8_t> attached(own.positions.size(), 1);
    attached[150] = 0;
    const Cloth cloth(base, own_mesh(own_surface, attached), AttachmentKind::kLimit);
    EXPECT_EQ(cloth.model->attachments.places.size(), own.positions.size() - 1);
    EXPECT_EQ(cloth.model->attached[149], 0);
    const State state = cloth.solve(base.positions, unstretched());
    EXPECT_LT(largest(state.offset), kRounding);
    const Picture picture = cloth.show(base.positions, unstretched(), state);
    for (size_t v = 0; v < picture.positions.size(); ++v) {
        EXPECT_LT(glm::distance(picture.positions[v], own.positions[v + 1]), kRounding) << v;
    }
}

}  // namespace
}  // namespace rumple::tests
