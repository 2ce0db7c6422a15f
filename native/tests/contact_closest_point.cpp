// SPDX-License-Identifier: GPL-3.0-or-later
// The closest point of a triangle, one by one and four at a time.
#include <gtest/gtest.h>

#include <algorithm>

#include "surface/contact/triangle_packets.h"
#include "tests/contact_bodies.h"

namespace rumple::tests {
namespace {

TEST(ClosestWeights, NoSampleOfTheTriangleIsNearer) {
    Random random(1);
    int corners = 0, edges = 0, insides = 0;
    for (int i = 0; i < 300; ++i) {
        const Vec3 a = random.vector(), b = random.vector(), c = random.vector();
        const Vec3 p = 0.5f * random.vector() + (i % 2 ? (a + b + c) / 3.0f : a);
        const Vec3 w = closest_weights(p, a, b, c);
        EXPECT_NEAR(w.x + w.y + w.z, 1.0f, 2e-6f);
        EXPECT_GE(std::min({w.x, w.y, w.z}), -1e-6f);
        const int zeros = (w.x < 1e-6f) + (w.y < 1e-6f) + (w.z < 1e-6f);
        ++(zeros == 2 ? corners : zeros == 1 ? edges : insides);
        const float found = glm::distance(p, w.x * a + w.y * b + w.z * c);
        float least = found;
        constexpr int kSteps = 60;
        for (int u = 0; u <= kSteps; ++u) {
            for (int v = 0; u + v <= kSteps; ++v) {
                const float s = float(u) / kSteps, t = float(v) / kSteps;
                least = std::min(least, glm::distance(p, (1.0f - s - t) * a + s * b + t * c));
            }
        }
        EXPECT_GE(least, found - 1e-5f) << "triangle " << i;
    }
    for (const int count : {corners, edges, insides}) EXPECT_GT(count, 30);
}

// Two corners in one place, or all three on a line: there was a division of zero by zero, and what is not a
// number was taken for the nearest of all.
TEST(ClosestWeights, OfATriangleWithoutAreaAreThoseOfItsLongestSide) {
    Random random(3);
    for (int i = 0; i < 100; ++i) {
        const Vec3 a = random.vector(), b = random.vector(), p = random.vector();
        const float along = std::clamp(glm::dot(p - a, b - a) / glm::dot(b - a, b - a), 0.0f, 1.0f);
        const float least = glm::distance(p, a + along * (b - a));
        const Vec3 middle = 0.5f * (a + b);
        for (const auto& [q, r, s] :
             {std::array{a, a, b}, {a, b, a}, {b, a, a}, {a, b, middle}, {middle, a, b}}) {
            const Vec3 w = closest_weights(p, q, r, s);
            EXPECT_NEAR(glm::distance(p, w.x * q + w.y * r + w.z * s), least, 1e-4f) << i;
        }
        EXPECT_EQ(closest_weights(p, a, a, a), Vec3(1.0f, 0.0f, 0.0f));
    }
}

TEST(ClosestWeights, APointOfTheTriangleIsItsOwn) {
    Random random(2);
    for (int i = 0; i < 200; ++i) {
        const Vec3 a = random.vector(), b = random.vector(), c = random.vector();
        if (glm::length(glm::cross(b - a, c - a)) < 0.3f) continue;  // slivers: the weights are noise
        const float s = 0.5f + 0.5f * random.next(), t = (1.0f - s) * (0.5f + 0.5f * random.next());
        const Vec3 w = closest_weights((1.0f - s - t) * a + s * b + t * c, a, b, c);
        EXPECT_NEAR(w.y, s, 2e-5f);
        EXPECT_NEAR(w.z, t, 2e-5f);
    }
}

TEST(ClosestWeights, FourAtATimeAreTheSameBits) {
    Random random(4);
    for (int i = 0; i < 100; ++i) {
        PosedPackets::Packet packet;
        std::array<std::array<Vec3, 3>, kLanes> triangles;
        for (int k = 0; k < kLanes; ++k) {
            for (Vec3& corner : triangles[k]) corner = random.vector();
            if (i % 10 == k) triangles[k][1] = triangles[k][0];  // without area
            packet.a.set(k, triangles[k][0]);
            packet.b.set(k, triangles[k][1]);
            packet.c.set(k, triangles[k][2]);
        }
        const Vec3 p = 1.5f * random.vector();
        const ClosestOfFour found = closest_of(packet, Vec3Lanes(p));
        for (int k = 0; k < kLanes; ++k) {
            const Vec3 w = closest_weights(p, triangles[k][0], triangles[k][1], triangles[k][2]);
            EXPECT_EQ(found.at.v[k], w.y);
            EXPECT_EQ(found.at.w[k], w.z);
        }
    }
}

}  // namespace
}  // namespace rumple::tests
