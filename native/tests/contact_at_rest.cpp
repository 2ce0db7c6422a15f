// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies of which is known where they are while the cloth is as at rest.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/contact_bodies.h"

namespace rumple::tests {
namespace {

// What is far from cloth at rest is not under it: the nearest place is that of the other triangles alone.
// What has no place at rest counts for any cloth.
TEST(Collider, WhatIsFarAtRestIsNotUnderTheCloth) {
    const Body body = sphere(14, 20, 1.0f, 0.15f, 3);
    std::vector<Vec3> rest = body.positions;
    for (Vec3& p : rest) p.x *= 2.0f;
    for (size_t v = 0; v < 60; ++v) rest[v] = Vec3(std::numeric_limits<float>::quiet_NaN());
    const float within = 1.1f;
    const Collider collider(body.positions, body.triangles, rest, within);
    const PosedCollider posed(collider, body.positions);
    Random random(5);
    int found = 0, others = 0;
    for (int i = 0; i < 400; ++i) {
        const Vec3 worn_at = rest[size_t(60 + i) % rest.size()] + 0.1f * random.vector();
        if (!(glm::length(worn_at) < 10.0f)) continue;
        Body near{body.positions, {}};
        for (Index t = 0; t < collider.triangle_count(); ++t)
            if (collider.may_be_under(t, worn_at)) near.triangles.push_back(body.triangles[t]);
        const Collider alone = near.collider();
        const Vec3 p = body.positions[size_t(i * 7) % rest.size()] + 0.2f * random.vector();
        const Vec3 normal = random.direction();
        const BodyContact expected = PosedCollider(alone, near.positions).closest(p, normal, 0.6f, kNone);
        for (const Index hint : {kNone, i * 37 % collider.triangle_count()}) {
            const BodyContact contact = posed.closest(p, normal, 0.6f, hint, &worn_at);
            ASSERT_EQ(contact.triangle == kNone, expected.triangle == kNone) << i;
            ASSERT_EQ(contact.point, expected.point) << i;
        }
        found += expected.triangle != kNone;
        others += posed.closest(p, normal, 0.6f, kNone).point != expected.point;
    }
    EXPECT_GT(found, 100);
    EXPECT_GT(others, 50);
}

// Of a tube along x, 5 cm in radius: all around it is under cloth that lies on it, or in it by a centimetre,
// within a quarter of a turn; beside a flank, at y = -0.1, its far side is not.
TEST(Collider, TheFarSideOfAnArmIsNotUnderAFlank) {
    const Body arm = body_of(tube(48, 20, 0.05f, 0.3f));
    const Collider collider(arm.positions, arm.triangles, arm.positions, 0.15f);
    int under = 0, far = 0;
    for (Index t = 0; t < collider.triangle_count(); ++t) {
        const Vec3 middle = *collider.rest_of(t), out(0.0f, middle.y, middle.z);
        const auto turned = [&](float degrees, float height) {
            const float angle = glm::radians(degrees), radius = 0.05f + height;
            const Vec3 side(0.0f, -middle.z, middle.y);
            return Vec3(middle.x, 0.0f, 0.0f) +
                   radius * glm::normalize(std::cos(angle) * out + std::sin(angle) * side);
        };
        for (const float height : {-0.01f, 0.0f, 0.02f, 0.05f})
            for (const float degrees : {0.0f, 20.0f, 45.0f})
                EXPECT_TRUE(collider.may_be_under(t, turned(degrees, height))) << degrees << " " << height;
        EXPECT_FALSE(collider.may_be_under(t, turned(0.0f, 0.2f)));
        if (middle.y < 0.04f) continue;
        ++far;
        under += collider.may_be_under(t, {middle.x, -0.08f, 0.0f});
    }
    EXPECT_GT(far, 50);
    EXPECT_EQ(under, 0);
}

// Under cloth that lies on covered skin (the lower triangle, which has no place at rest) a bare arm is not,
// though it is nearer: a layer asks of its own place. What hangs free lies on the arm, and stays on it.
TEST(Collider, ALayerAsksWhatIsUnderItsOwnPlaceAtRest) {
    const std::vector<Vec3> positions{{-1, -1, -0.02f}, {3, -1, -0.02f}, {-1, 3, -0.02f},
                                      {-1, -1, -0.01f}, {3, -1, -0.01f}, {-1, 3, -0.01f}};
    std::vector<Vec3> rest = positions;
    for (size_t v = 0; v < 3; ++v) rest[v] = Vec3(std::numeric_limits<float>::quiet_NaN());
    for (size_t v = 3; v < 6; ++v) rest[v].x += 9.0f;
    const std::vector<std::array<Index, 3>> triangles{{0, 1, 2}, {3, 4, 5}};
    const Collider collider(positions, triangles, rest, 0.15f);
    const PosedCollider posed(collider, positions);
    const Vec3 p(0.0f), up(0.0f, 0.0f, 1.0f);
    EXPECT_EQ(posed.closest(p, up, 0.1f, 0).triangle, 1);
    EXPECT_EQ(posed.closest_around(p, up, 0.1f, 0, p).triangle, 0);
    EXPECT_EQ(posed.closest_around(p, up, 0.1f, 1, p).triangle, 1);
}

}  // namespace
}  // namespace rumple::tests
