// SPDX-License-Identifier: GPL-3.0-or-later
// The base cloth and what is worn under it.
#include <gtest/gtest.h>

#include "base/solve_team.h"
#include "surface/cloth/cover.h"
#include "surface/output/attachments.h"
#include "tests/base_cloth_rig.h"

namespace rumple::tests {
namespace {

using namespace base_cloth;

constexpr float kBall = 0.3f;  // radius

// A square sheet, moulded on a sphere around the origin of the given radius.
MeshData cap(float radius) {
    MeshData mesh = grid(14, 14, 0.025f);
    for (Vec3& p : mesh.positions) {
        const Vec3 way(p.x - 0.175f, p.y - 0.175f, 0.3f);
        p = radius * glm::normalize(way);
    }
    return mesh;
}

Body ball() {
    return sphere(64, 96, kBall);
}

// Nothing painted: neither pinned nor held firmly.
Settings loose() {
    Settings settings;
    settings.follow = 20.0f;
    return settings;
}

// Of the smooth cloth from the ball, at every vertex.
std::vector<float> heights(const Garment& garment, const Points& positions) {
    Points smooth(positions.size());
    apply<Vec3>(garment.model->limit, positions, smooth);
    std::vector<float> out;
    for (const Vec3& p : smooth) out.push_back(glm::length(p) - kBall);
    return out;
}

TEST(BaseClothContact, ASheetPressedOnASphereRestsOnIt) {
    const Body body = ball();
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    const Settings settings = loose();
    const float thickness = settings.clearance.thickness;
    for (const float above : {0.01f, 0.004f, -0.002f}) {
        const Garment garment(cap(kBall + above));
        Result result;
        ASSERT_GT(garment.settle(settings, garment.mesh.positions, result, {}, &posed), 0) << above;
        int resting = 0;
        const std::vector<float> smooth = heights(garment, result.positions);
        for (size_t v = 0; v < smooth.size(); ++v) {
            EXPECT_GT(smooth[v], thickness - 5e-4f) << "vertex " << v << " from " << above;
            // All but the hem, which hangs free.
            const bool lies = std::abs(smooth[v] - thickness) < 5e-4f;
            resting += lies;
            const bool inner = !garment.model->surface.boundary_vertex[v];
            if (inner) {
                EXPECT_TRUE(lies) << "vertex " << v << " from " << above << " at " << smooth[v];
            }
        }
        EXPECT_GT(resting, 150);
        EXPECT_GT(result.report.touching, 0.7f);
        EXPECT_EQ(result.report.body_known, 1.0f);
        for (const float gap : result.gap) EXPECT_GE(gap, 0.0f);
    }
}

// The gap is what the next layer may go inwards.
TEST(BaseClothContact, TheGapIsTheHeightAboveTheInnerSurface) {
    const Body body = ball();
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    Settings settings = loose();
    settings.gravity = Vec3(0.0f);
    const Garment garment(cap(kBall + 0.01f));
    const Result result = garment.solve(settings, garment.mesh.positions, nullptr, {}, &posed);
    const std::vector<float> smooth = heights(garment, result.positions);
    for (size_t v = 0; v < smooth.size(); ++v) {
        if (garment.model->surface.boundary_vertex[v]) continue;
        EXPECT_NEAR(result.gap[v], smooth[v] - settings.clearance.thickness, 3e-4f) << v;
    }
}

TEST(BaseClothContact, AGarmentInsideTheBodyComesOutAndADeepOneStays) {
    const Body body = body_of(tube(64, 40, 0.1f, 0.8f));
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    Settings settings;
    settings.gravity = Vec3(0.0f);
    const auto radii = [&](float inside) {
        MeshData mesh = tube(32, 16, 0.1f - inside, 0.4f);
        for (Vec3& p : mesh.positions) p.x += 0.2f;
        const Garment garment(mesh);
        Result result;
        EXPECT_GT(garment.settle(settings, mesh.positions, result, {}, &posed, 40), 0) << inside;
        Points smooth(mesh.positions.size());
        apply<Vec3>(garment.model->limit, result.positions, smooth);
        std::vector<float> out;
        for (const Vec3& p : smooth) out.push_back(std::hypot(p.y, p.z));
        return out;
    };
    // The stretched cloth presses on the body: the inner surface gives way a little, and is put back.
    for (const float r : radii(0.002f)) EXPECT_NEAR(r, 0.1f + settings.clearance.thickness, 1e-3f);
    const MeshData deep = tube(32, 16, 0.1f - 1.2f * settings.clearance.depth, 0.4f);
    const Garment garment(deep);
    Points smooth(deep.positions.size());
    apply<Vec3>(garment.model->limit, deep.positions, smooth);
    const std::vector<float> stayed = radii(1.2f * settings.clearance.depth);
    for (size_t v = 0; v < smooth.size(); ++v)
        EXPECT_NEAR(stayed[v], std::hypot(smooth[v].y, smooth[v].z), 1e-6f);
}

// An arm beside a flank, animated so far into it that only its outer side is out: the flank is not pulled
// over it. What hangs free lies on whatever comes under it.
TEST(BaseClothContact, ABodyThatIsFarAtRestIsNotComeOutOf) {
    const Body body = body_of(tube(64, 40, 0.1f, 0.8f));
    std::vector<Vec3> elsewhere = body.positions;
    for (Vec3& p : elsewhere) p.y += 0.5f;
    MeshData mesh = tube(32, 16, 0.098f, 0.4f);
    for (Vec3& p : mesh.positions) p.x += 0.2f;
    const Garment garment(mesh);
    Settings settings;
    settings.gravity = Vec3(0.0f);
    const auto over = [&](std::span<const Vec3> rest, const Paint& paint = {}) {
        const Collider collider(body.positions, body.triangles, rest, 0.15f);
        const PosedCollider posed(collider, body.positions);
        return garment.solve(settings, mesh.positions, nullptr, paint, &posed);
    };
    const Result out = over({}), under = over(body.positions), beside = over(elsewhere);
    EXPECT_EQ(farthest(out.positions, under.positions), 0.0f);
    EXPECT_GT(farthest(out.positions, mesh.positions), 4e-3f);
    EXPECT_LT(farthest(beside.positions, mesh.positions), 1e-3f);
    EXPECT_EQ(beside.report.body_known, 0.0f);
    Paint hangs_free;
    hangs_free.room.assign(mesh.positions.size(), 8.0f);
    EXPECT_GT(over(elsewhere, hangs_free).report.body_known, 0.9f);
}

// A body that moves under a resting sheet wakes it; one that only turns with it does not.
TEST(BaseClothContact, ABodyThatMovesWakesTheCloth) {
    Body body = ball();
    const Collider collider = body.collider();
    const Settings settings = loose();
    const Garment garment(cap(kBall + 0.004f));
    Result result;
    const PosedCollider still(collider, body.positions);
    ASSERT_GT(garment.settle(settings, garment.mesh.positions, result, {}, &still), 0);
    std::vector<Vec3> up = body.positions;
    for (Vec3& p : up) p.z += 0.003f;
    const PosedCollider risen(collider, up);
    const Result activated = garment.solve(settings, garment.mesh.positions, &result.state, {}, &risen);
    EXPECT_GT(activated.report.steps, 0);
    EXPECT_GT(farthest(activated.positions, result.positions), 1e-3f);
    const Result held = garment.solve(settings, garment.mesh.positions, &result.state, {}, &still);
    EXPECT_TRUE(equal_bits(held, result));
}

// The body in its pose, the cloth on it, the smooth surface that is lifted out of it.
TEST(BaseClothContact, ThreadsChangeNoBit) {
    const Body body = ball();
    const Collider collider = body.collider();
    const Garment garment(cap(kBall - 0.002f));
    const CoverModel cover = build_cover(garment.model->surface);
    const Points pose = garment.moved([](const Vec3& p) { return p * Vec3(1.02f, 1.0f, 1.0f); });
    Result alone;
    Points lifted_alone;
    for (const int threads : {1, 2, 3, 8}) {
        const SolveTeam team(threads, body.positions.size(), 1);
        const PosedCollider posed(collider, body.positions);
        const Result first = garment.solve(loose(), garment.mesh.positions, nullptr, {}, &posed);
        const Result next = garment.solve(loose(), pose, &first.state, {}, &posed);
        const Points lifted =
            cover_over(garment.model->surface, cover, {}, posed, garment.mesh.positions, next.body_hint)
                .lifts;
        if (threads == 1) {
            alone = next;
            lifted_alone = lifted;
        }
        EXPECT_TRUE(equal_bits(next, alone)) << threads;
        EXPECT_TRUE(equal_bits(lifted, lifted_alone)) << threads;
    }
    EXPECT_GT(alone.report.steps, 0);
    EXPECT_NE(lifted_alone, Points(pose.size(), Vec3(0.0f)));
}

TEST(BaseClothContact, ForgottenHintsChangeNoClearanceAndHardlyThePositions) {
    const Body body = ball();
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    const Garment garment(cap(kBall + 0.004f));
    const Result first = garment.solve(loose(), garment.mesh.positions, nullptr, {}, &posed);
    State forgetful = first.state;
    forgetful.body_hint.clear();
    const Points pose = garment.moved([](const Vec3& p) { return p * Vec3(1.02f, 1.0f, 1.0f); });
    const Result with = garment.solve(loose(), pose, &first.state, {}, &posed);
    const Result without = garment.solve(loose(), pose, &forgetful, {}, &posed);
    EXPECT_TRUE(equal_bits(with, without));
    EXPECT_GT(with.report.steps, 0);
}

TEST(BaseClothContact, WithoutBodiesTheClothSinksByTheUnknownClearanceOnly) {
    const MeshData mesh = grid(8, 8, 0.03f);
    const Garment garment(mesh);
    Result result;
    ASSERT_GT(garment.settle(loose(), mesh.positions, result), 0);
    EXPECT_TRUE(result.body_hint.empty());
    const float unknown = loose().clearance.unknown;
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        EXPECT_NEAR(result.positions[v].z, -unknown, 1e-5f);
        EXPECT_NEAR(result.gap[v], 0.0f, 1e-5f);
    }
    EXPECT_EQ(result.report.touching, 1.0f);
    EXPECT_EQ(result.report.body_known, 0.0f);
}

// An arm that is pressed against the flank of a shirt: the shirt stays on its side, and gives way when the
// arm comes nearer.
TEST(BaseClothContact, ClothStaysBeforeABodyInFront) {
    const Garment garment(grid(10, 10, 0.03f));
    Settings settings = loose();
    settings.gravity = Vec3(0.0f, 0.0f, 9.81f);
    const float thickness = settings.clearance.thickness;
    Result result;
    for (const float height : {0.012f, 0.008f, 0.002f}) {
        const Body body = ceiling(height);
        const Collider collider = body.collider();
        const PosedCollider posed(collider, body.positions);
        result = garment.solve(settings, garment.mesh.positions, &result.state, {}, &posed);
        EXPECT_GT(result.report.steps, 0) << height;
        ASSERT_GT(garment.settle(settings, garment.mesh.positions, result, {}, &posed), 0) << height;
        // Nearer than the thickness the garment is as it is animated.
        const float before = std::max(height - thickness, 0.0f);
        for (const Vec3& p : result.positions) EXPECT_NEAR(p.z, before, 1e-5f) << height;
    }
    const Result free = garment.solve(settings, garment.mesh.positions);
    for (const Vec3& p : free.positions) EXPECT_GT(p.z, 0.015f);
}

}  // namespace
}  // namespace rumple::tests
