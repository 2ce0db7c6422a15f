// SPDX-License-Identifier: GPL-3.0-or-later
// Polygons of the base cloth that have turned over are opened; all else stays.
#include <gtest/gtest.h>

#include "surface/cloth/untangle.h"
#include "tests/base_cloth_rig.h"
#include "tests/refusals.h"

namespace rumple::tests {
namespace {

constexpr Index kColumns = 8, kRows = 5;
constexpr float kSide = 0.01f;

// A sheet in the xy plane that has slid by 3 mm; its columns 3 and 4 have passed through one another.
struct Tangled {
    MeshData sheet = grid(kColumns, kRows, kSide);
    Surface surface = tests::build(sheet);
    Points cloth;

    Tangled() {
        for (const Vec3& p : sheet.positions) {
            const Index column = static_cast<Index>(std::lround(p.x / kSide));
            const float pressed = column == 3 ? 1.2f : column == 4 ? -1.2f : 0.0f;
            cloth.push_back(p + Vec3(0.003f + pressed * kSide, 0.0f, 0.001f * float(column)));
        }
    }
    int turned_over(const Points& positions) const {
        int count = 0;
        for (Index t = 0; t < static_cast<Index>(surface.triangles.size()); ++t) {
            const auto [a, b, c] = welded_vertices(surface, t);
            count += glm::cross(positions[b] - positions[a], positions[c] - positions[a]).z < 0.0f;
        }
        return count;
    }
};

TEST(BaseClothUntangle, TurnedPolygonsAreOpenedAndTheOthersStayToTheBit) {
    const Tangled tangled;
    EXPECT_EQ(tangled.turned_over(tangled.cloth), 2 * kRows);
    const Points out = untangled(tangled.surface, tangled.sheet.positions, tangled.cloth);
    EXPECT_EQ(tangled.turned_over(out), 0);
    for (size_t v = 0; v < out.size(); ++v) {
        const float x = tangled.sheet.positions[v].x / kSide;
        if (x > 2.5f && x < 4.5f) continue;
        EXPECT_EQ(out[v], tangled.cloth[v]);
    }
}

TEST(BaseClothUntangle, WhereNothingIsTurnedNothingMoves) {
    const Tangled tangled;
    const Points bent = Garment(tangled.sheet).crumpled(0.7f, 20.0f, 0.3f);
    EXPECT_EQ(untangled(tangled.surface, tangled.sheet.positions, bent), bent);
}

TEST(BaseClothUntangle, WhatTheAnimationHasTurnedStays) {
    const Tangled tangled;
    EXPECT_EQ(untangled(tangled.surface, tangled.cloth, tangled.cloth), tangled.cloth);
}

// A sweater whose skinning tears at the armpits had spikes there, longer than in the animation.
TEST(BaseClothUntangle, APointThatSticksOutOfTheAnimationIsNoGuide) {
    const Tangled tangled;
    Points torn = tangled.sheet.positions;
    for (Vec3& p : torn)
        if (std::lround(p.x / kSide) == 3 && std::lround(p.y / kSide) == 2) p.z += 10.0f * kSide;
    const Points out = untangled(tangled.surface, torn, tangled.cloth);
    EXPECT_NE(out, tangled.cloth);  // the rest of the columns is opened
    for (const Edge& edge : tangled.surface.edges) {
        const auto length = [&](const Points& p) { return glm::distance(p[edge.a], p[edge.b]); };
        EXPECT_LE(length(out), std::max(2.0f * kSide, length(tangled.cloth)) + 1e-6f);
    }
}

TEST(BaseClothUntangle, WhatDoesNotFitIsNamed) {
    const Tangled tangled;
    const Points few(3);
    expect_refused([&] { untangled(tangled.surface, few, tangled.cloth); }, {"animated"});
    expect_refused([&] { untangled(tangled.surface, tangled.cloth, few); }, {"positions"});
}

}  // namespace
}  // namespace rumple::tests
