// SPDX-License-Identifier: GPL-3.0-or-later
// What looks like a garment: it has openings to put it on through.
#include <gtest/gtest.h>

#include "surface/cloth/pins.h"
#include "tests/meshes.h"

namespace rumple::tests {
namespace {

Index openings(const MeshData& mesh) {
    return count_openings(build(mesh, true));
}

// A tube of length 0.5 m whose radius grows along it.
MeshData cone(float top, float hem) {
    MeshData mesh = tube(16, 8, 1.0f, 0.5f);
    for (Vec3& p : mesh.positions) p *= Vec3(1.0f, glm::mix(top, hem, 2.0f * p.x) * Vec2(1.0f));
    return mesh;
}

TEST(Openings, ASleeveHasTwoAndASheetNone) {
    EXPECT_EQ(openings(tube(16, 8, 0.05f, 0.5f)), 2);
    EXPECT_EQ(openings(grid(8, 8, 0.1f)), 0);
}

TEST(Openings, AWideHemIsNoOutlineWhereThereIsAWaist) {
    EXPECT_EQ(openings(cone(0.15f, 0.25f)), 2);
    EXPECT_EQ(openings(cone(0.15f, 0.6f)), 2);
}

// Shorts, a short skirt, a belt: wide for their length.
TEST(Openings, AShortTubeIsNoSheetAndIsHeldAtItsTop) {
    for (const float length : {0.05f, 0.2f, 0.35f}) {
        const Surface surface = build(tube(16, 8, 0.13f, length), true);
        EXPECT_EQ(count_openings(surface), 2) << length;
        const std::vector<float> follow = suggest_follow(surface, {-1.0f, 0.0f, 0.0f});
        for (int v = 0; v < 16; ++v) EXPECT_EQ(follow[v], 1.0f) << length;
        if (length < 0.2f) continue;
        for (size_t v = follow.size() - 16; v < follow.size(); ++v) EXPECT_EQ(follow[v], 0.0f) << length;
    }
}

// An open vest, laid flat: its armholes are no legs, and its outline, which is the highest border, stays
// free.
TEST(Openings, AnOutlineWithSmallHolesIsNotHeld) {
    MeshData vest;
    vest.positions = grid(12, 12, 0.05f).positions;
    const auto is_hole = [](Index i, Index j) { return i % 6 >= 2 && i % 6 <= 3 && (j == 5 || j == 6); };
    for (Index j = 0; j < 12; ++j) {
        for (Index i = 0; i < 12; ++i) {
            const Index v = i + j * 13;
            if (!is_hole(i, j)) vest.add_polygon({v, v + 1, v + 14, v + 13});
        }
    }
    const std::vector<float> follow = suggest_follow(build(vest, true), {0.0f, 1.0f, 0.0f});
    EXPECT_EQ(follow[12 * 13], 0.0f);
    EXPECT_EQ(follow[12 * 13 + 6], 0.0f);
}

std::vector<float> held(const MeshData& mesh) {
    return suggest_follow(build(mesh, true), {0.0f, 1.0f, 0.0f});
}

// A cape, with a pocket on it; 9 x 9 vertices, 0.8 m wide and high.
TEST(Openings, ASheetIsHeldByItsUpperEnd) {
    MeshData pocket = grid(2, 2, 0.05f);
    const MeshData cape = with_part(grid(8, 8, 0.1f), pocket, {0.3f, 0.4f, 0.01f});
    const std::vector<float> follow = held(cape);
    for (int v = 0; v < 81; ++v) EXPECT_EQ(follow[v], v < 72 ? 0.0f : 1.0f) << v;
    for (size_t v = 81; v < follow.size(); ++v) EXPECT_EQ(follow[v], 0.0f) << v;
}

// Of the polygons of the first and the second part, how many are sewn on.
std::pair<Index, Index> sewn_on(const MeshData& first, const MeshData& second, const Vec3& at) {
    const std::vector<bool> sewn =
        find_sewn_on(build(with_part(first, second, at), true), {0.0f, 1.0f, 0.0f});
    const auto begin = sewn.begin() + std::ptrdiff_t(first.polygon_start.size()) - 1;
    return {Index(std::count(sewn.begin(), begin, true)), Index(std::count(begin, sewn.end(), true))};
}

TEST(SewnOn, APocketOverAndAShirtFrontUnderAnotherPartAreIfNothingHoldsThem) {
    const MeshData cape = grid(8, 8, 0.1f), pocket = grid(2, 2, 0.05f);
    EXPECT_EQ(sewn_on(cape, pocket, {0.3f, 0.4f, 0.01f}), std::pair(0, 4));
    EXPECT_EQ(sewn_on(cape, pocket, {0.3f, 0.4f, -0.01f}), std::pair(0, 4));
    EXPECT_EQ(sewn_on(cape, pocket, {0.3f, 0.4f, 0.2f}), std::pair(0, 0)) << "far away";
    EXPECT_EQ(sewn_on(cape, pocket, {0.9f, 0.4f, 0.01f}), std::pair(0, 0)) << "beside it";
    EXPECT_EQ(sewn_on(cape, pocket, {0.78f, 0.4f, 0.01f}), std::pair(0, 0)) << "a third of it is over it";
}

TEST(SewnOn, OnAShirtItIsPinnedAndOnACapeThatHangsItIsNot) {
    MeshData shirt = tube(16, 8, 0.2f, 0.5f);
    for (Vec3& p : shirt.positions) p = {p.z, p.x, p.y};
    const MeshData pocket = grid(2, 2, 0.03f);
    for (const auto& [garment, at, weight] : {std::tuple(shirt, Vec3(-0.03f, 0.2f, 0.21f), 1.0f),
                                              {grid(8, 8, 0.1f), Vec3(0.3f, 0.4f, 0.01f), 0.0f}}) {
        const std::vector<float> follow = held(with_part(garment, pocket, at));
        for (size_t v = garment.positions.size(); v < follow.size(); ++v) EXPECT_EQ(follow[v], weight);
    }
}

TEST(SewnOn, WhatHasAnOpeningHoldsItself) {  // a shirt under a jacket
    MeshData shirt = tube(16, 8, 0.2f, 0.5f), jacket = tube(16, 8, 0.21f, 0.5f);
    for (MeshData* mesh : {&shirt, &jacket})
        for (Vec3& p : mesh->positions) p = {p.y, p.x, p.z};
    EXPECT_EQ(sewn_on(jacket, shirt, {0.0f, 0.0f, 0.0f}), std::pair(0, 0));
}

// A blanket has no upper end, and of many sheets (cards of hair) none is the garment.
TEST(Openings, WhatLiesIsNotHeldNorOneOfManySheets) {
    MeshData blanket = grid(8, 8, 0.1f);
    for (Vec3& p : blanket.positions) p = {p.x, 0.1f * p.y, p.y};
    MeshData cards = with_part(grid(2, 8, 0.1f), grid(2, 8, 0.1f), {1.0f, 0.0f, 0.0f});
    for (const MeshData& mesh : {blanket, cards})
        for (const float weight : held(mesh)) EXPECT_EQ(weight, 0.0f);
}

// A tube along y, 1 m high, whose ends are closed.
MeshData closed_tube() {
    MeshData mesh = tube(16, 40, 0.1f, 1.0f);
    for (Vec3& p : mesh.positions) p = {p.y, p.x, p.z};
    const auto last = static_cast<Index>(mesh.positions.size()) - 16;
    for (Index k = 0; k < 7; ++k) {
        mesh.add_polygon({15 - k, 14 - k, k + 1, k});
        mesh.add_polygon({last + k, last + k + 1, last + 14 - k, last + 15 - k});
    }
    return mesh;
}

// Trousers of games, closed at the waist and at the hems.
TEST(Openings, AGarmentWithoutAnOpeningIsHeldByItsUpperEnd) {
    const MeshData trousers = closed_tube();
    ASSERT_EQ(openings(trousers), 0);
    const std::vector<float> follow = held(trousers);
    const float highest = 1.0f, diagonal = std::sqrt(1.0f + 2.0f * 0.2f * 0.2f);
    for (size_t v = 0; v < follow.size(); ++v) {
        const float below = highest - trousers.positions[v].y;
        if (below < 0.029f * diagonal) {
            EXPECT_EQ(follow[v], 1.0f) << v;
        } else if (below > 0.101f * diagonal) {
            EXPECT_EQ(follow[v], 0.0f) << v;
        }
    }
}

TEST(Openings, AClosedPartOfAGarmentIsNotHeld) {
    MeshData pouch = closed_tube();
    for (Vec3& p : pouch.positions) p *= 0.2f;
    const MeshData sleeve = tube(32, 60, 0.1f, 1.0f);  // along x: its ends are held
    const std::vector<float> follow = held(with_part(sleeve, pouch, {0.5f, 0.0f, 0.3f}));
    for (size_t v = sleeve.positions.size(); v < follow.size(); ++v) EXPECT_EQ(follow[v], 0.0f) << v;
}

TEST(Openings, PartsAreLookedAtOneByOne) {
    const MeshData cape = grid(8, 8, 0.1f), sleeve = tube(16, 8, 0.05f, 0.5f);
    EXPECT_EQ(openings(with_part(cape, sleeve, {0.0f, 0.0f, 2.0f})), 2);
}

// The skin that is left of a figure under its clothes: each part has one opening, where a sleeve has two.
TEST(Openings, ArmsAndFeetAreNoGarment) {
    MeshData arm = tube(16, 8, 0.05f, 0.5f);
    for (Index k = 0; k < 7; ++k) arm.add_polygon({15 - k, 14 - k, k + 1, k});  // the hand
    const MeshData arms = with_part(arm, arm, {0.0f, 0.0f, 2.0f});
    EXPECT_EQ(openings(arm), 1);
    EXPECT_EQ(openings(arms), 1);
}

}  // namespace
}  // namespace rumple::tests
