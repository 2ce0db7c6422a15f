// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies of which is known where they are while the cloth is as at rest.
#include <gtest/gtest.h>

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
            if (!(glm::distance(*collider.rest_of(t), worn_at) > within))
                near.triangles.push_back(body.triangles[t]);
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

}  // namespace
}  // namespace rumple::tests
