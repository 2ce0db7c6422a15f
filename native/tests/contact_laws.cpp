// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of contact: the nearest place of a body, and how much room is left under a garment.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>

#include "surface/cloth/clearance.h"
#include "surface/output/attachments.h"
#include "surface/query/closest_point.h"
#include "tests/contact_bodies.h"
#include "tests/refusals.h"

namespace rumple::tests {
namespace {

// Every triangle, one after the other: those that face away do not count.
class BruteForce {
  public:
    BruteForce(const Body& body, const std::vector<Vec3>& positions) : body_(body), at_(positions) {
        for (const auto& t : body.triangles) {
            for (int k = 0; k < 3; ++k) ++sides_[std::minmax(t[k], t[(k + 1) % 3])];
        }
        for (const auto& [side, count] : sides_) {
            if (count == 1) border_.insert(border_.end(), {side.first, side.second});
        }
        std::sort(border_.begin(), border_.end());
    }

    struct Found {
        Index triangle = kNone;
        Vec3 point{0.0f};
        float squared;
        bool border = false;  // on an edge of only one triangle, or at its end
    };
    Found closest(const Vec3& p, const Vec3& normal, float reach) const {
        Found found{.squared = reach * reach};
        for (size_t i = 0; i < body_.triangles.size(); ++i) {
            const auto& t = body_.triangles[i];
            const Vec3 a = at_[t[0]], b = at_[t[1]], c = at_[t[2]];
            if (glm::dot(glm::normalize(glm::cross(b - a, c - a)), normal) < 0.1f) continue;
            const Vec3 w = closest_weights(p, a, b, c);
            const Vec3 point = w.x * a + w.y * b + w.z * c;
            const float squared = glm::dot(p - point, p - point);
            if (squared >= found.squared) continue;
            found = {Index(i), point, squared, on_border(t, w)};
        }
        return found;
    }
    bool on_border(const std::array<Index, 3>& t, const Vec3& w) const {
        constexpr float kNear = 1e-4f;
        for (int k = 0; k < 3; ++k) {
            const int next = (k + 1) % 3, opposite = (k + 2) % 3;
            if (w[opposite] < kNear && sides_.at(std::minmax(t[k], t[next])) == 1) return true;
            if (w[k] > 1.0f - kNear && std::binary_search(border_.begin(), border_.end(), t[k])) return true;
        }
        return false;
    }

  private:
    const Body& body_;
    const std::vector<Vec3>& at_;
    std::map<std::pair<Index, Index>, int> sides_;
    std::vector<Index> border_;
};

// The same distance but for rounding, and the same place unless two triangles are equally near.
void expect_same(const BodyContact& contact, const BruteForce::Found& brute, const Vec3& p, float reach) {
    ASSERT_EQ(contact.triangle == kNone, brute.triangle == kNone);
    if (brute.triangle == kNone) return;
    ASSERT_NEAR(glm::distance(contact.point, p), std::sqrt(brute.squared), 1e-6f);
    ASSERT_LE(glm::distance(contact.point, p), reach * 1.00001f);
    const Vec3 to = p - contact.point;
    ASSERT_NEAR(contact.distance, glm::dot(to, contact.normal), 1e-6f);
    ASSERT_NEAR(std::hypot(contact.distance, contact.beside), glm::length(to), 1e-6f);
    ASSERT_NEAR(glm::length(contact.normal), 1.0f, 1e-5f);
    if (contact.triangle != brute.triangle) return;
    ASSERT_LT(glm::distance(contact.point, brute.point), 1e-6f);
    ASSERT_EQ(contact.border, brute.border);
}

TEST(Collider, TheNearestPlaceIsThatOfAllTrianglesInEveryPoseAndWithAnyHint) {
    const Body body = sphere(14, 20, 1.0f, 0.15f, 3);
    const Collider collider = body.collider();
    Random random(3);
    int found = 0, missed = 0, on_border = 0, others = 0;
    for (int pose = 0; pose < 3; ++pose) {
        std::vector<Vec3> positions = body.positions;
        for (Vec3& p : positions) {  // bent, turned and moved
            p.x += float(pose) * 0.3f * p.z * p.z;
            if (pose == 2) p = 2.0f * Vec3(p.z, p.x, p.y) + Vec3(3.0f, 0.0f, -1.0f);
        }
        const PosedCollider posed(collider, positions);
        const BruteForce brute(body, positions);
        for (int i = 0; i < 400; ++i) {
            const Vec3 near = positions[size_t(i) % positions.size()];
            const Vec3 p = near + 0.4f * random.vector(), normal = random.direction();
            const float reach = i % 3 ? 0.5f : 0.1f;
            const BruteForce::Found expected = brute.closest(p, normal, reach);
            on_border += expected.border;
            ++(expected.triangle == kNone ? missed : found);
            const Index anything = i * 37 % collider.triangle_count();
            for (const Index hint : {kNone, anything, expected.triangle, collider.triangle_count()}) {
                SCOPED_TRACE("pose " + std::to_string(pose) + ", point " + std::to_string(i) + ", hint " +
                             std::to_string(hint));
                const BodyContact contact = posed.closest(p, normal, reach, hint);
                expect_same(contact, expected, p, reach);
                ASSERT_EQ(contact.triangle, posed.closest(p, normal, reach, kNone).triangle);
                if (HasFatalFailure()) return;
                others += contact.triangle != expected.triangle;
            }
        }
    }
    EXPECT_GT(found, 500);
    EXPECT_GT(missed, 100);
    EXPECT_GT(on_border, 50);
    EXPECT_LT(others, 4 * found / 10);  // with four hints each
}

// Over an edge or a corner all triangles there are equally near: which of them is found must not hang on
// where the search begins, or a frame that was jumped to would differ from one that was played. The boxes of
// a flat body are as near as its triangles.
TEST(Collider, OverSharedEdgesTheHintChangesNothing) {
    for (Body body : {sphere(8, 12, 1.0f, 0.15f, 3), body_of(grid(9, 9, 0.1f))}) {
        for (Vec3& p : body.positions) p += Vec3(3.0f, -1.0f, 2.0f);  // coordinates round more than distances
        const Collider collider = body.collider();
        const PosedCollider posed(collider, body.positions);
        for (const auto& corner : body.triangles) {
            const Vec3 a = body.positions[corner[0]], b = body.positions[corner[1]],
                       c = body.positions[corner[2]];
            const Vec3 n = glm::normalize(glm::cross(b - a, c - a));
            for (const Vec3& p : {a, 0.5f * (a + b) + 0.01f * n, 0.3f * b + 0.7f * c + 0.003f * n}) {
                const BodyContact alone = posed.closest(p, n, 0.2f, kNone);
                for (Index hint = 0; hint < collider.triangle_count(); ++hint)
                    ASSERT_EQ(posed.closest(p, n, 0.2f, hint).triangle, alone.triangle) << hint;
            }
        }
    }
}

// The normals there would lean with the last triangles. What the cloth is over is the end itself.
TEST(Collider, OverABorderTheClothsNormalCounts) {
    Body body = body_of(grid(4, 4, 0.25f));  // one square metre, that falls to both sides
    for (Vec3& p : body.positions) p.z = -0.1f * (p.x - 0.5f) * (p.x - 0.5f);
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    const Vec3 up(0, 0, 1), end(1.0f, 0.5f, -0.025f);
    EXPECT_FALSE(posed.closest({0.6f, 0.5f, 0.1f}, up, 0.5f, kNone).border);
    const auto over_end = [&](const Vec3& way) { return posed.closest(end + way, up, 0.5f, kNone); };
    for (const Vec3& way : {Vec3(0.04f, 0, 0.1f), Vec3(0.2f, 0, 0.1f), Vec3(0.2f, 0, -0.02f)}) {
        const BodyContact contact = over_end(way);
        ASSERT_TRUE(contact.border);
        EXPECT_LT(glm::distance(contact.point, end), 1e-6f);
        EXPECT_EQ(contact.normal, up);
        EXPECT_NEAR(contact.distance, way.z, 1e-6f);
        EXPECT_NEAR(contact.beside, way.x, 1e-6f);
    }
    EXPECT_EQ(over_end({0.04f, 0, 0.1f}).weight, 1.0f);
    EXPECT_EQ(over_end({0.2f, 0, 0.1f}).weight, 0.0f);  // far beside it says nothing
}

TEST(Collider, WhatFacesAwayDoesNotCountAndInsideIsNegative) {
    const Body body = sphere(24, 36, 1.0f);
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    const Vec3 way = glm::normalize(Vec3(1.0f, 0.4f, 0.3f));
    const auto at = [&](float radius, const Vec3& normal) {
        return posed.closest(radius * way, normal, 0.5f, kNone);
    };
    EXPECT_NEAR(at(1.2f, way).distance, 0.2f, 0.01f);
    EXPECT_NEAR(at(0.9f, way).distance, -0.1f, 0.01f);
    EXPECT_EQ(at(1.2f, way).weight, 1.0f);
    EXPECT_EQ(at(0.9f, way).weight, 1.0f);
    EXPECT_LT(glm::distance(at(1.2f, way).normal, way), 0.1f);
    EXPECT_EQ(at(1.2f, -way).triangle, kNone);
}

TEST(Collider, WhatLiesBesideAPointWeighsLess) {
    const Body body = body_of(tube(3, 4, 1.0f, 4.0f));  // sharp ridges
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    const auto weight = [&](float angle) {  // around the ridge at y = 1, z = 0
        const Vec3 way(0.0f, std::cos(angle), std::sin(angle));
        return posed.closest(Vec3(2.1f, 1.0f, 0.0f) + 0.1f * way, {0, 1, 0}, 1.0f, kNone).weight;
    };
    EXPECT_EQ(weight(0.0f), 1.0f);
    EXPECT_GT(weight(0.6f), 0.5f);  // cosine 0.83
    EXPECT_LT(weight(0.6f), 1.0f);
    EXPECT_LT(weight(0.85f), weight(0.6f));  // 0.66
}

TEST(Collider, BadInputIsNamed) {
    const Body body = sphere(4, 5, 1.0f);
    const Collider collider = body.collider();
    expect_refused([&] { Collider(body.positions, {}); }, {"body", "triangle", "none"});
    Body bad = body;
    bad.triangles[7][1] = Index(body.positions.size());
    expect_refused([&] { bad.collider(); }, {"body triangles", "triangle 7", "vertex 17 of 17"});
    bad.triangles[7][1] = -1;
    expect_refused([&] { bad.collider(); }, {"body triangles", "triangle 7", "vertex -1"});
    bad = body;
    bad.positions[3].y = kNan;
    expect_refused([&] { bad.collider(); }, {"body positions", "vertex 3", "finite"});
    expect_refused([&] { PosedCollider(collider, bad.positions); }, {"body positions", "vertex 3", "finite"});
    bad.positions.pop_back();
    expect_refused([&] { PosedCollider(collider, bad.positions); }, {"body positions", "17", "16"});
}

// ---------------------------------------------------------------- clearance

// A flat sheet at some height over a body, as the base cloth asks.
struct Sheet {
    MeshData mesh;
    Surface surface;
    ClearanceModel model;
    std::vector<Vec3> normals;

    explicit Sheet(MeshData data)
        : mesh(std::move(data)), surface(tests::build(mesh)), model(build_clearance(surface)) {
        normals.resize(surface.welded.vertex_count);
        vertex_normals(surface, surface.positions_rest, normals);
    }
    std::vector<float> over(const Body& body, const ClearanceSettings& settings, std::vector<Index>& hints,
                            float free = 0.0f) const {
        const Collider collider = body.collider();
        const PosedCollider posed(collider, body.positions);
        const std::vector<float> all(normals.size(), free);
        return clearance(model, settings, surface.positions_rest, normals, all, &posed, hints).inwards;
    }
};

// A grid around the origin's x and y, at a height.
MeshData plate(Index n, float size, float height) {
    MeshData mesh = grid(n, n, size);
    for (Vec3& p : mesh.positions) p += Vec3(-0.5f * float(n) * size, -0.5f * float(n) * size, height);
    return mesh;
}

TEST(Clearance, OfABodyAtOneDistanceIsThatLessTheThickness) {
    const Sheet sheet(plate(10, 0.02f, 0.0f));
    ClearanceSettings settings;
    std::vector<Index> hints;
    for (const float distance : {0.02f, 0.003f, 0.0f, -0.002f}) {
        for (const float value : sheet.over(body_of(plate(8, 0.05f, -distance)), settings, hints))
            EXPECT_NEAR(value, distance - settings.thickness, 1e-6f);
    }
    // Deeper than `depth` it stays where it is; half way out in between.
    for (const float value : sheet.over(body_of(plate(8, 0.05f, settings.depth)), settings, hints))
        EXPECT_NEAR(value, 0.0f, 1e-6f);
    const float half = 0.625f * settings.depth;
    for (const float value : sheet.over(body_of(plate(8, 0.05f, half)), settings, hints))
        EXPECT_NEAR(value, 0.5f * (-half - settings.thickness), 1e-6f);
}

TEST(Clearance, WithoutABodyIsUnknown) {
    const Sheet sheet(plate(4, 0.02f, 0.0f));
    std::vector<Index> hints{1, 2, 3};
    ClearanceSettings settings;
    for (const float value :
         clearance(sheet.model, settings, sheet.surface.positions_rest, sheet.normals, {}, nullptr, hints)
             .inwards)
        EXPECT_EQ(value, settings.unknown);
    EXPECT_TRUE(hints.empty());
    for (const float value : sheet.over(body_of(plate(8, 0.05f, -0.07f)), settings, hints))
        EXPECT_NEAR(value, settings.unknown, 1e-7f);  // beyond the reach
}

// What hangs free looks for a body as far as it may go, and where there is none it may go so far. It stood a
// centimetre off its animation at most, and a skirt stayed the cone that it was animated as.
TEST(Clearance, WhatHangsFreeGoesAsFarAsItsRoomOrToTheBody) {
    const Sheet sheet(plate(10, 0.02f, 0.0f));
    const ClearanceSettings settings;
    std::vector<Index> hints;
    const auto over = [&](float distance) {
        return sheet.over(body_of(plate(16, 0.05f, -distance)), settings, hints, 0.25f);
    };
    for (const float value : over(0.12f)) EXPECT_NEAR(value, 0.12f - settings.thickness, 1e-6f);
    for (const float value : over(0.3f)) EXPECT_NEAR(value, 0.25f, 1e-6f);
    hints.clear();
    const std::vector<float> all(sheet.normals.size(), 0.25f);
    for (const float value :
         clearance(sheet.model, settings, sheet.surface.positions_rest, sheet.normals, all, nullptr, hints)
             .inwards)
        EXPECT_EQ(value, 0.25f);
}

// What is about to leave the reach fades: late, but without a jump. Ten times as fine steps are a tenth as
// high.
TEST(Clearance, ABodyThatLeavesTheReachFadesOut) {
    const Sheet sheet(plate(4, 0.02f, 0.0f));
    const ClearanceSettings settings;
    const auto highest_step = [&](float from, float to, int steps) {
        std::vector<Index> hints;
        float former = 0.0f, highest = 0.0f;
        for (int i = 0; i <= steps; ++i) {
            const float distance = from + (to - from) * float(i) / float(steps);
            const float value = sheet.over(body_of(plate(8, 0.05f, -distance)), settings, hints)[12];
            if (i > 0) highest = std::max(highest, std::abs(value - former));
            former = value;
        }
        EXPECT_NEAR(former, settings.unknown, 1e-6f);
        return highest;
    };
    const float coarse = highest_step(0.04f, 0.0605f, 41);
    EXPECT_GT(coarse, 1e-3f);
    EXPECT_LT(highest_step(0.04f, 0.0605f, 410), 0.15f * coarse);
}

// Over the end of a body its distance counts as long as it lies below more than beside (cosine 0.85, none
// from 0.6 on).
TEST(Clearance, BesideTheEndOfABodyIsFilledInWithoutASeam) {
    const Sheet sheet(grid(40, 6, 0.01f));
    Body half = body_of(plate(20, 0.02f, -0.03f));  // 40 cm across, below x < 0.1
    for (Vec3& p : half.positions) p += Vec3(-0.1f, 0.03f, 0.0f);
    ClearanceSettings settings;
    std::vector<Index> hints;
    const std::vector<float> values = sheet.over(half, settings, hints);
    const float known = 0.03f - settings.thickness;
    const float last_known = 0.1f + 0.03f * std::tan(std::acos(0.85f));
    const float first_unknown = 0.1f + 0.03f * std::tan(std::acos(0.6f));
    for (Index i = 0; i <= 40; ++i) {
        for (Index j = 0; j <= 6; ++j) {
            const float value = values[i + 41 * j];
            if (0.01f * float(i) < last_known) {
                EXPECT_NEAR(value, known, 1e-6f);
            }
            EXPECT_LE(value, known + 1e-6f);
            EXPECT_GE(value, settings.unknown - 1e-6f);
            if (i == 0) continue;
            // In an endless strip it falls as exp(-x / spread): a sixth of the rest within a centimetre.
            const float step = values[i - 1 + 41 * j] - value;
            EXPECT_GE(step, -1e-5f) << i;
            EXPECT_LE(step, 0.2f * (known - settings.unknown)) << i;
        }
    }
    for (Index j = 0; j <= 6; ++j) {
        EXPECT_NEAR(values[40 + 41 * j], settings.unknown, 0.05f * (known - settings.unknown));
        const float fading = (values[15 + 41 * j] - settings.unknown) / (known - settings.unknown);
        EXPECT_GT(fading, std::exp((last_known - 0.15f) / settings.spread) - 0.1f) << j;
        EXPECT_LT(fading, std::exp((first_unknown - 0.15f) / settings.spread) + 0.1f) << j;
    }
}

TEST(Clearance, TheSameBitsWithAndWithoutHints) {
    Body body = sphere(20, 30, 0.3f, 0.05f, 4);
    for (Vec3& p : body.positions) p = {p.x, -p.y, -p.z};  // the hole above
    MeshData mesh = plate(16, 0.03f, 0.0f);
    for (Vec3& p : mesh.positions) p.z = std::sqrt(std::max(0.31f * 0.31f - p.x * p.x - p.y * p.y, 0.0f));
    const Sheet sheet(std::move(mesh));
    std::vector<Index> none, hints;
    const std::vector<float> without = sheet.over(body, {}, none);
    for (size_t v = 0; v < without.size(); ++v) hints.push_back(Index(v * 31 % body.triangles.size()));
    for (int again = 0; again < 3; ++again) {
        const std::vector<float> with = sheet.over(body, {}, hints);
        EXPECT_EQ(std::memcmp(with.data(), without.data(), with.size() * sizeof(float)), 0);
        EXPECT_EQ(hints, none);
    }
    EXPECT_GT(std::count_if(none.begin(), none.end(), [](Index t) { return t != kNone; }), 50);
    EXPECT_GT(std::count(none.begin(), none.end(), kNone), 10);
}

// ---------------------------------------------------------------- a body in front
TEST(BodyAhead, IsTheNearestPointThatFacesTheCloth) {
    const Body body = sphere(64, 96, 0.1f);
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    const Vec3 towards(-1.0f, 0.0f, 0.0f);
    const BodyAhead found = posed.ahead({0.15f, 0.0f, 0.0f}, towards, 0.1f, 0.0f);
    EXPECT_LT(glm::distance(found.point, Vec3(0.1f, 0.0f, 0.0f)), 2e-4f);
    EXPECT_GT(found.normal.x, 0.999f);
    // Worn over the ball, too far away, and inside it deeper than asked.
    EXPECT_EQ(posed.ahead({0.15f, 0.0f, 0.0f}, -towards, 0.04f, 0.0f).triangle, kNone);
    EXPECT_EQ(posed.ahead({0.15f, 0.0f, 0.0f}, towards, 0.04f, 0.0f).triangle, kNone);
    EXPECT_EQ(posed.ahead({0.09f, 0.0f, 0.0f}, towards, 0.04f, 0.003f).triangle, kNone);
    EXPECT_NE(posed.ahead({0.09f, 0.0f, 0.0f}, towards, 0.04f, 0.02f).triangle, kNone);
}

TEST(BodyAhead, WhereTheBodyEndsNothingIsAhead) {
    const Body body = sphere(64, 96, 0.1f, 0.0f, 16);  // no lowest quarter
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    EXPECT_EQ(posed.ahead({0.0f, 0.0f, -0.12f}, {0.3f, 0.0f, 1.0f}, 0.2f, 0.0f).triangle, kNone);
}

}  // namespace
}  // namespace rumple::tests
