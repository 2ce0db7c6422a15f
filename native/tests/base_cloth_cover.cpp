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
        const Points lifts = lifts_over(surface, cover, settings, bodies, positions, hints);
        Points out = positions;
        for (size_t v = 0; v < out.size(); ++v) out[v] += lifts[v];
        return out;
    }
    // Height of the lowest point of the smooth surface over the ball, sampled finely: below 0 inside of it.
    float lowest(const Points& at) const {
        FineSource source;
        source.level = 4;
        const Attachments fine =
            attach_refined(surface, source, refine(surface, source), AttachmentKind::kLimit);
        Points welded(surface.welded.vertex_count), normals(welded.size()), points(fine.places.size());
        weld_positions(surface, at, welded);
        attach(surface, fine, welded, normals, points);
        float least = 1.0f;
        for (const Vec3& p : points) least = std::min(least, glm::length(p) - kBall);
        return least;
    }
};

TEST(BaseClothCover, ASmoothSurfaceThatCutsThroughABodyIsLiftedOutOfIt) {
    const Wrapped wrapped;
    EXPECT_LT(wrapped.lowest(wrapped.positions), -0.008f);
    EXPECT_GT(wrapped.lowest(wrapped.covered()), 0.001f);
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
