// SPDX-License-Identifier: GPL-3.0-or-later
// The smooth surface of a base cloth stays off what is worn under it.
#include <gtest/gtest.h>

#include "surface/cloth/cover.h"
#include "surface/output/attachments.h"
#include "surface/output/shown_mesh.h"
#include "tests/base_cloth_rig.h"
#include "tests/refusals.h"

namespace rumple::tests {
namespace {

constexpr float kBall = 0.1f;

// Few, large faces around a ball, with their vertices just outside of it: its smooth surface cuts deep into
// it.
struct Wrapped {
    Surface surface = tests::build(cage());
    CoverModel cover = build_cover(surface);
    Body body = sphere(48, 64, kBall);
    Collider collider = body.collider();
    PosedCollider bodies{collider, body.positions};
    Points positions = cage().positions;
    std::vector<Index> hints = std::vector<Index>(positions.size(), 0);

    static MeshData cage() {
        MeshData mesh = tube(7, 3, 1.02f * kBall, 0.16f);
        for (Vec3& p : mesh.positions) {
            p.x -= 0.08f;
            p *= 1.02f * kBall / glm::length(p);
        }
        return mesh;
    }
    Points covered(const CoverSettings& settings = {}) const {
        const Points lifts = cover_over(surface, cover, settings, bodies, positions, hints).lifts;
        Points out = positions;
        for (size_t v = 0; v < out.size(); ++v) out[v] += lifts[v];
        return out;
    }
    // The smooth surface, sampled finely.
    Points fine_points(const Points& at) const {
        FineSource source;
        source.level = 4;
        const Attachments fine =
            attach_refined(surface, source, refine(surface, source), AttachmentKind::kLimit);
        Points welded(surface.welded.vertex_count), normals(welded.size()), points(fine.places.size());
        weld_positions(surface, at, welded);
        attach(surface, fine, welded, normals, points);
        return points;
    }
    // Height of its lowest point over the ball: below 0 inside of it.
    float lowest(const Points& at) const {
        float least = 1.0f;
        for (const Vec3& p : fine_points(at)) least = std::min(least, glm::length(p) - kBall);
        return least;
    }
};

TEST(BaseClothCover, ASmoothSurfaceThatCutsThroughABodyIsLiftedOutOfIt) {
    const Wrapped wrapped;
    EXPECT_LT(wrapped.lowest(wrapped.positions), -0.008f);
    EXPECT_GT(wrapped.lowest(wrapped.covered()), 0.001f);
}

// Where skin is deleted under the cloth, its border lies between the tested points, beside all of them: it
// came through the shoulder of a shirt, as specks.
TEST(BaseClothCover, TheBorderOfABodyBetweenTheTestedPointsIsCovered) {
    const MeshData sheet = grid(2, 2, 0.03f);
    const Surface surface = tests::build(sheet);
    const Vec3 place(0.037f, 0.037f, 0.001f);  // of a scrap of skin, 1 mm above the cloth
    const Body scrap{{place, place + Vec3(0.001f, 0.0f, 0.0f), place + Vec3(0.0f, 0.001f, 0.0f)},
                     {{0, 1, 2}}};
    const Collider collider = scrap.collider();
    const PosedCollider bodies(collider, scrap.positions);
    const std::vector<Index> hints(sheet.positions.size(), 0);
    const CoverSettings settings{.thickness = 0.002f};
    const Points lifts =
        cover_over(surface, build_cover(surface), settings, bodies, sheet.positions, hints).lifts;
    EXPECT_GT(lifts[4].z, 0.001f);  // the vertex in the middle
}

// A sheet 8 mm over the ground, with a bump between two of its vertices that is 5 mm high: folds of a Wrinkle
// Field went into what is as high as this bump, because they knew the room at the vertices only.
TEST(BaseClothCover, RoomForFoldsIsThatBetweenTheVerticesToo) {
    const MeshData sheet = grid(4, 4, 0.03f);
    const Surface surface = tests::build(sheet);
    Body ground{{{-1.0f, -1.0f, -0.008f}, {2.0f, -1.0f, -0.008f}, {-1.0f, 2.0f, -0.008f}}, {{0, 1, 2}}};
    const auto room_over = [&](const Body& body) {
        const Collider collider = body.collider();
        const PosedCollider bodies(collider, body.positions);
        const std::vector<Index> hints(sheet.positions.size(), 0);
        const Cover found =
            cover_over(surface, build_cover(surface), {.thickness = 0.002f}, bodies, sheet.positions, hints);
        for (const Vec3& lift : found.lifts) EXPECT_EQ(lift, Vec3(0.0f));
        return found.room;
    };
    for (const float room : room_over(ground)) EXPECT_NEAR(room, 0.006f, 1e-6f);
    const Vec3 top(0.045f, 0.06f, -0.003f);  // half-way from vertex 11 to vertex 12
    for (const Vec3& p : {top, top + Vec3(0.002f, 0.0f, 0.0f), top + Vec3(0.0f, 0.002f, 0.0f)})
        ground.positions.push_back(p);
    ground.triangles.push_back({3, 4, 5});
    const std::vector<float> room = room_over(ground);
    EXPECT_NEAR(room[11], 0.001f, 1e-6f);
    EXPECT_NEAR(room[12], 0.001f, 1e-6f);
    EXPECT_NEAR(room[0], 0.006f, 1e-6f);
    EXPECT_NEAR(room[24], 0.006f, 1e-6f);
}

TEST(BaseClothCover, WhatIsOffTheBodyStaysToTheBit) {
    Wrapped wrapped;
    for (Vec3& p : wrapped.positions) p *= 1.4f;
    EXPECT_EQ(wrapped.covered(), wrapped.positions);
}

TEST(BaseClothCover, WhereNoBodyWasFoundNothingIsLifted) {
    Wrapped wrapped;
    wrapped.hints.assign(wrapped.hints.size(), kNone);
    EXPECT_EQ(wrapped.covered(), wrapped.positions);
}

TEST(BaseClothCover, WhatIsHiddenDeepInsideStaysThere) {
    Wrapped wrapped;
    for (Vec3& p : wrapped.positions) p *= 0.6f;
    EXPECT_EQ(wrapped.covered(), wrapped.positions);
}

TEST(BaseClothCover, WhatDoesNotFitIsNamed) {
    Wrapped wrapped;
    wrapped.hints.pop_back();
    expect_refused([&] { wrapped.covered(); }, {"hints"});
    wrapped.positions.pop_back();
    expect_refused([&] { wrapped.covered(); }, {"positions"});
    expect_refused([] { Wrapped().covered({.thickness = -1e-3f}); }, {"thickness"});
    expect_refused([] { Wrapped().covered({.depth = 0.0f}); }, {"depth"});
}

}  // namespace
}  // namespace rumple::tests
