// SPDX-License-Identifier: GPL-3.0-or-later
// Painting rest-pose wrinkles: laws, then cases worked by hand.
#include <gtest/gtest.h>

#include <cstring>

#include "systems/wrinkle_field/brush.h"
#include "tests/refusals.h"
#include "tests/wrinkle_field_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_field;

// A base that is painted on.
struct Easel {
    Field field;
    std::vector<Vec3> painted;

    explicit Easel(MeshData mesh)
        : field(std::move(mesh)), painted(field.mesh.positions.size(), Vec3(0.0f)) {}

    const Model& model() const { return *field.model; }
    void touch(const Pose3& pose, const Dab& dab, bool mirror = false) {
        const auto twins = mirror ? find_twins(model()) : std::vector<SurfacePoint>();
        apply(model(), lay_out(model(), pose), dab, twins, painted);
    }
    // Of vertices of the base, where they are painted; p and -p mean the same.
    static float apart(const Vec3& a, const Vec3& b) {
        return std::min(glm::length(a - b), glm::length(a + b));
    }
    Index touched() const {
        return static_cast<Index>(
            std::count_if(painted.begin(), painted.end(), [](const Vec3& p) { return p != Vec3(0.0f); }));
    }
};

// Seen from above, along -z.
Dab from_above(const Vec3& centre, const Vec3& direction, float radius) {
    Dab dab;
    dab.centre = centre;
    dab.direction = direction;
    dab.radius = radius;
    return dab;
}

// Rotation only.
Vec3 turned(const Vec3& v) {
    return turned_and_shifted(v) - turned_and_shifted(Vec3(0.0f));
}

Dab moved(Dab dab) {
    dab.centre = turned_and_shifted(dab.centre);
    dab.normal = turned(dab.normal);
    dab.view = turned(dab.view);
    dab.direction = turned(dab.direction);
    return dab;
}

MeshData centred_tube() {
    MeshData mesh = tube(16, 10, 0.1f, 0.6f);
    for (Vec3& p : mesh.positions) p.x -= 0.3f;
    return mesh;
}

// Bent, twisted and squeezed, nothing symmetric about it.
Pose3 acted(const MeshData& mesh) {
    return moved(mesh, [](const Vec3& p) {
        const float angle = 0.8f * p.x + 0.5f;
        return Vec3(0.8f * p.x + 0.2f * p.y, std::cos(angle) * p.y - std::sin(angle) * p.z + 0.7f * p.x * p.x,
                    std::sin(angle) * p.y + std::cos(angle) * p.z);
    });
}

TEST(WrinkleFieldBrushLaws, PaintingOnARigidlyMovedMeshIsPaintingAtRest) {
    for (const MeshData& mesh : {irregular_square(), centred_tube(), seam_split_cube()}) {
        Easel here(mesh), there(mesh);
        for (const Vec3 direction : {Vec3(1, 0, 0), Vec3(0.3f, 1, 0)}) {
            const Dab dab = from_above({0.1f, 0.05f, 0.1f}, direction, 0.4f);
            here.touch(mesh.positions, dab);
            there.touch(tests::moved(mesh, turned_and_shifted), moved(dab));
        }
        for (size_t v = 0; v < here.painted.size(); ++v) {
            EXPECT_LT(Easel::apart(here.painted[v], there.painted[v]), 1e-4f) << v;
        }
    }
}

TEST(WrinkleFieldBrushLaws, LengthsStayBelowOneWhateverIsPainted) {
    const MeshData mesh = centred_tube();
    const Pose3 pose = acted(mesh);
    Easel easel(mesh);
    std::mt19937 random(3);
    const auto number = [&] { return static_cast<float>(random() % 2001) / 1000.0f - 1.0f; };
    for (int k = 0; k < 400; ++k) {
        Dab dab = from_above(pose[random() % pose.size()], Vec3(number(), number(), 0.0f), 0.15f);
        dab.touch = k % 5 == 0 ? Touch::kSmooth : Touch::kPaint;
        dab.across = k % 3 == 0;
        dab.length = kLongestPainted;
        dab.falloff = static_cast<Falloff>(k % 4);
        easel.touch(pose, dab, k % 2 == 0);
        for (const Vec3& p : easel.painted) ASSERT_LT(glm::length(p), 1.0f);
    }
    EXPECT_GT(easel.touched(), 80);
    for (size_t v = 0; v < easel.painted.size(); ++v) {  // and they lie in the rest pose's tangent planes
        const Vec3 normal = glm::cross(easel.model().tangent_rest[v], easel.model().bitangent_rest[v]);
        EXPECT_NEAR(glm::dot(easel.painted[v], normal), 0.0f, 1e-6f);
    }
}

TEST(WrinkleFieldBrushLaws, FoldsRunAlongTheStrokeAsItIsSeenInAnyPose) {
    const MeshData mesh = centred_tube();
    const Pose3 pose = acted(mesh);
    for (const Vec3 direction : {Vec3(1, 0, 0), Vec3(0, 1, 0), glm::normalize(Vec3(1, -0.7f, 0))}) {
        for (const bool across : {false, true}) {
            Easel easel(mesh);
            Dab dab = from_above({0.0f, 0.0f, 0.1f}, direction, 0.5f);
            dab.across = across;
            easel.touch(pose, dab);
            const Canvas canvas = lay_out(easel.model(), pose);
            const Lines lines = draw(easel.model(), canvas, easel.painted, across);
            ASSERT_GT(lines.strength.size(), 40u);
            for (size_t k = 0; k < lines.strength.size(); ++k) {
                // On the screen: the line less its component along the view.
                Vec3 seen = lines.ends[2 * k + 1] - lines.ends[2 * k];
                seen.z = 0.0f;
                EXPECT_LT(glm::length(glm::cross(seen, direction)), 2e-3f * glm::length(seen) + 1e-7f) << k;
            }
        }
    }
}

TEST(WrinkleFieldBrush, WhatIsPaintedTooLongIsNotDrawn) {
    Easel easel(irregular_square());
    easel.painted.assign(easel.painted.size(), Vec3(1e30f, 0.0f, 0.0f));
    const Canvas canvas = lay_out(easel.model(), easel.field.mesh.positions);
    EXPECT_TRUE(draw(easel.model(), canvas, easel.painted, false).ends.empty());
}

TEST(WrinkleFieldBrushLaws, TheWaveStandsAcrossTheStroke) {
    Easel easel(irregular_square());
    const Vec3 direction = glm::normalize(Vec3(2, 1, 0));
    easel.touch(easel.field.mesh.positions, from_above({0.5f, 0.5f, 0.0f}, direction, 0.4f));
    easel.field.paint.rest_wrinkle = easel.painted;
    const Waves waves = easel.field.estimate_waves(easel.field.mesh.positions);
    int wrinkled = 0;
    for (size_t v = 0; v < waves.height.size(); ++v) {
        const float p = glm::length(easel.painted[v]);
        if (p < 0.1f) continue;
        ++wrinkled;
        EXPECT_NEAR(waves.compression[v], 1.0f - p * p, 1e-5f);  // E - q (x) q shortens q by 1 - q^2
        EXPECT_NEAR(glm::dot(glm::normalize(waves.wave_vector[v]), direction), 0.0f, 1e-3f);
    }
    EXPECT_GT(wrinkled, 10);
}

TEST(WrinkleFieldBrushLaws, ThereAndBackAgainDoesNotCancel) {
    Easel easel(grid(8, 8, 0.1f));
    for (int k = 0; k < 20; ++k) {
        easel.touch(easel.field.mesh.positions,
                    from_above({0.4f, 0.4f, 0.0f}, Vec3(k % 2 == 0 ? 1 : -1, 0, 0), 0.3f));
    }
    EXPECT_NEAR(glm::length(easel.painted[4 + 4 * 9]), 0.7f, 1e-5f);
    EXPECT_NEAR(std::abs(easel.painted[4 + 4 * 9].y), 0.7f, 1e-5f);
}

TEST(WrinkleFieldBrushLaws, MirroredStrokesAreMirrored) {
    const MeshData mesh = centred_tube();
    const Pose3 pose = acted(mesh);  // the rest pose is symmetric, not this one
    Easel easel(mesh);
    for (const Index vertex : {2 + 16 * 7, 5 + 16 * 6, 3 + 16 * 5}) {  // the last one on the plane
        easel.touch(pose, from_above(pose[vertex], Vec3(0.6f, 0.8f, 0), 0.15f), true);
    }
    EXPECT_GT(easel.touched(), 20);
    for (Index j = 0; j <= 10; ++j) {
        for (Index i = 0; i < 16; ++i) {
            // Diagonals are not mirrored, so at the open ends neither are the normals.
            const float tolerance = j == 0 || j == 10 ? 2e-3f : 1e-5f;
            const Vec3 twin = easel.painted[i + 16 * (10 - j)];
            EXPECT_LT(Easel::apart(easel.painted[i + 16 * j], {-twin.x, twin.y, twin.z}), tolerance)
                << i << ' ' << j;
        }
    }
}

TEST(WrinkleFieldBrushLaws, WhatHasNoTwinIsNotMirrored) {
    MeshData mesh = centred_tube();
    for (Vec3& p : mesh.positions) p.x += 5.0f;
    for (const SurfacePoint& twin : find_twins(Easel(mesh).model())) EXPECT_EQ(twin.triangle, kNone);
}

TEST(WrinkleFieldBrushLaws, OnlyTheSideThatIsSeenIsTouched) {
    const MeshData mesh = centred_tube();
    Easel easel(mesh);
    easel.touch(mesh.positions, from_above({0, 0, 0.1f}, Vec3(1, 0, 0), 5.0f));
    EXPECT_GT(easel.touched(), 50);
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        if (std::abs(mesh.positions[v].z) < 1e-4f) continue;  // edge-on
        EXPECT_EQ(easel.painted[v] != Vec3(0.0f), mesh.positions[v].z > 0.0f) << v;
    }
    Easel inner(mesh);  // looking into the tube from above, at its far side
    Dab dab = from_above({0, 0, -0.1f}, Vec3(1, 0, 0), 5.0f);
    dab.normal = {0, 0, -1};
    inner.touch(mesh.positions, dab);
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        if (std::abs(mesh.positions[v].z) < 1e-4f) continue;
        EXPECT_EQ(inner.painted[v] != Vec3(0.0f), mesh.positions[v].z < 0.0f) << v;
    }
}

TEST(WrinkleFieldBrushLaws, VerticesOfASeamGetTheSame) {
    const MeshData mesh = split_at_seams(centred_tube());
    Easel easel(mesh);
    easel.touch(mesh.positions, from_above({0, 0, 0.1f}, Vec3(1, 1, 0), 0.2f), true);
    EXPECT_GT(easel.touched(), 20);
    const std::vector<Index>& welded_of = easel.model().base.welded_of;
    std::vector<Vec3> first(easel.model().base.positions_rest.size(), Vec3(9.0f));
    ASSERT_LT(first.size(), mesh.positions.size() / 3);
    for (size_t v = 0; v < welded_of.size(); ++v) {
        Vec3& value = first[welded_of[v]];
        if (value == Vec3(9.0f)) value = easel.painted[v];
        EXPECT_EQ(value, easel.painted[v]);
    }
}

TEST(WrinkleFieldBrushLaws, WhatIsNotUnderTheBrushKeepsItsBits) {
    Easel easel(grid(8, 8, 0.1f));
    for (size_t v = 0; v < easel.painted.size(); ++v) easel.painted[v] = {0.01f * float(v), 0.1f, 0.0f};
    const std::vector<Vec3> before = easel.painted;
    for (const Touch touch : {Touch::kPaint, Touch::kErase, Touch::kSmooth}) {
        Dab dab = from_above({0.2f, 0.2f, 0.0f}, Vec3(1, 1, 0), 0.15f);
        dab.touch = touch;
        easel.touch(easel.field.mesh.positions, dab);
    }
    for (size_t v = 0; v < before.size(); ++v) {
        const bool under = glm::distance(easel.field.mesh.positions[v], Vec3(0.2f, 0.2f, 0.0f)) < 0.15f;
        EXPECT_EQ(std::memcmp(&before[v], &easel.painted[v], sizeof(Vec3)) != 0, under) << v;
    }
}

TEST(WrinkleFieldBrushLaws, SmoothingLeavesAnEvenFieldAndItsSignsAlone) {
    Easel easel(grid(6, 6, 0.1f));
    for (size_t v = 0; v < easel.painted.size(); ++v)
        easel.painted[v] = Vec3(0.3f, 0.4f, 0.0f) * (v % 2 ? 1.0f : -1.0f);
    const std::vector<Vec3> before = easel.painted;
    Dab dab = from_above({0.3f, 0.3f, 0.0f}, Vec3(0.0f), 1.0f);
    dab.touch = Touch::kSmooth;
    for (int k = 0; k < 5; ++k) easel.touch(easel.field.mesh.positions, dab);
    for (size_t v = 0; v < before.size(); ++v) EXPECT_LT(Easel::apart(before[v], easel.painted[v]), 1e-5f);
}

TEST(WrinkleFieldBrushLaws, TheVertexOrderDoesNotMatter) {
    const MeshData mesh = irregular_square();
    const std::vector<Index> order = shuffled(mesh.positions.size());
    Easel one(mesh), other(reordered(mesh, order));
    const Dab dab = from_above({0.5f, 0.4f, 0.0f}, Vec3(0.2f, 1, 0), 0.4f);
    one.touch(one.field.mesh.positions, dab);
    other.touch(other.field.mesh.positions, dab);
    const std::vector<Vec3> here = scatter(one.model(), {}), there = scatter(other.model(), {});
    for (size_t v = 0; v < order.size(); ++v) {
        EXPECT_LT(Easel::apart(one.painted[v], other.painted[order[v]]), 1e-4f);
        EXPECT_LT(Easel::apart(here[v], there[order[v]]), 1e-5f);
    }
}

TEST(WrinkleFieldScatter, IsAFunctionOfItsSeed) {
    const Easel easel(centred_tube());
    const std::vector<Vec3> one = scatter(easel.model(), {.seed = 4}),
                            again = scatter(easel.model(), {.seed = 4}),
                            other = scatter(easel.model(), {.seed = 5});
    EXPECT_EQ(std::memcmp(one.data(), again.data(), one.size() * sizeof(Vec3)), 0);
    EXPECT_NE(std::memcmp(one.data(), other.data(), one.size() * sizeof(Vec3)), 0);
}

TEST(WrinkleFieldScatter, KeepsItsDensityAndItsLength) {
    const Easel easel(tube(48, 40, 0.15f, 0.6f));
    for (const float density : {0.0f, 0.25f, 0.6f, 1.0f}) {
        for (std::uint32_t seed = 0; seed < 5; ++seed) {
            const std::vector<Vec3> painted = scatter(easel.model(), {seed, density, 0.1f, 0.9f});
            float wrinkled = 0.0f, longest = 0.0f;
            for (const Vec3& p : painted) {
                wrinkled += p != Vec3(0.0f);
                longest = std::max(longest, glm::length(p));
            }
            EXPECT_NEAR(wrinkled / float(painted.size()), density, 1e-3f);
            EXPECT_LT(longest, 0.9f + 1e-5f);
            EXPECT_EQ(longest > 0.5f, density > 0.0f);
        }
    }
}

// A jump would stay as large as it is however fine the mesh.
TEST(WrinkleFieldScatter, IsSmoothOverTheSurface) {
    const auto largest_step = [](Index n) {
        const Easel easel(grid(n, n, 0.6f / float(n)));
        const std::vector<Vec3> painted = scatter(easel.model(), {.seed = 1, .density = 0.7f, .size = 0.2f});
        float largest = 0.0f;
        for (Index v = 1; v < static_cast<Index>(painted.size()); ++v) {
            if (v % (n + 1) != 0) largest = std::max(largest, Easel::apart(painted[v], painted[v - 1]));
        }
        return largest;
    };
    EXPECT_LT(largest_step(120), 0.35f);
    EXPECT_LT(largest_step(240), 0.6f * largest_step(120));
}

// By hand: weight 1/2 at half the radius with linear falloff, from nothing towards 0.8 across the stroke.
TEST(WrinkleFieldBrushExact, HalfWayOut) {
    Easel easel(grid(4, 4, 0.1f));
    Dab dab = from_above({0.2f, 0.1f, 0.0f}, Vec3(1, 0, 0), 0.2f);
    dab.falloff = Falloff::kLinear;
    dab.length = 0.8f;
    easel.touch(easel.field.mesh.positions, dab);
    const Vec3 p = easel.painted[2 + 5 * 2];
    EXPECT_NEAR(p.x, 0.0f, 1e-6f);
    EXPECT_NEAR(std::abs(p.y), 0.4f, 1e-6f);
    EXPECT_EQ(p.z, 0.0f);
    dab.across = true;
    easel.painted.assign(easel.painted.size(), Vec3(0.0f));
    easel.touch(easel.field.mesh.positions, dab);
    EXPECT_NEAR(std::abs(easel.painted[2 + 5 * 2].x), 0.4f, 1e-6f);
    EXPECT_NEAR(easel.painted[2 + 5 * 2].y, 0.0f, 1e-6f);
}

// A sheet sheared by x' = x + y: the fold that is seen along (0, 1) was the line along (-1, 1) at rest, so
// the compression is along (1, 1).
TEST(WrinkleFieldBrushExact, Sheared) {
    Easel easel(grid(4, 4, 0.1f));
    const Pose3 pose = moved(easel.field.mesh, [](const Vec3& p) { return Vec3(p.x + p.y, p.y, 0.0f); });
    easel.touch(pose, from_above({0.4f, 0.2f, 0.0f}, Vec3(0, 1, 0), 0.15f));
    const Vec3 p = easel.painted[2 + 5 * 2];
    // True lengths make M a fit where the pose stretches unevenly with direction; the fit is that of
    // estimate_waves().
    EXPECT_LT(Easel::apart(glm::normalize(p), glm::normalize(Vec3(1, 1, 0))), 1e-5f);
    EXPECT_NEAR(glm::length(p), 0.7f, 1e-6f);
}

TEST(WrinkleFieldBrushExact, ErasingTakesItsShareAndInTheEndAll) {
    Easel easel(grid(2, 2, 0.1f));
    easel.painted.assign(9, Vec3(0.6f, 0.0f, 0.0f));
    Dab dab = from_above({0.1f, 0.1f, 0.0f}, Vec3(0.0f), 0.05f);
    dab.touch = Touch::kErase;
    dab.strength = 0.25f;
    easel.touch(easel.field.mesh.positions, dab);
    EXPECT_NEAR(easel.painted[4].x, 0.45f, 1e-6f);
    EXPECT_EQ(easel.painted[0].x, 0.6f);
    for (int k = 0; k < 40; ++k) easel.touch(easel.field.mesh.positions, dab);
    EXPECT_EQ(easel.painted[4], Vec3(0.0f));
}

// One painted vertex among eight neighbours: the mean of |p| exp(2 i angle) around it is 0, and 1/8 of it at
// a corner's neighbour in the middle of the fan.
TEST(WrinkleFieldBrushExact, SmoothingSpreadsASpike) {
    Easel easel(grid(4, 4, 0.1f));
    easel.painted[2 + 5 * 2] = Vec3(0.8f, 0.0f, 0.0f);
    Dab dab = from_above({0.2f, 0.2f, 0.0f}, Vec3(0.0f), 0.11f);
    dab.touch = Touch::kSmooth;
    dab.falloff = Falloff::kConstant;
    dab.strength = 0.5f;
    easel.touch(easel.field.mesh.positions, dab);
    EXPECT_NEAR(easel.painted[2 + 5 * 2].x, 0.4f, 1e-6f);
    EXPECT_NEAR(std::abs(easel.painted[3 + 5 * 2].x), 0.5f * 0.8f / 6.0f, 1e-6f);
    EXPECT_EQ(easel.painted[4 + 5 * 2], Vec3(0.0f));
}

TEST(WrinkleFieldBrushInput, IsRefusedByName) {
    Easel easel(grid(2, 2, 0.1f));
    const auto message = [&](const Dab& dab) {
        return refusal([&] { easel.touch(easel.field.mesh.positions, dab); });
    };
    Dab dab = from_above({0, 0, 0}, Vec3(1, 0, 0), 0.1f);
    EXPECT_EQ(message(dab), "not refused");
    easel.painted[3] = Vec3(1.0f, 0.2f, 0.0f);
    EXPECT_NE(message(dab).find("vertex 3 has length"), std::string::npos) << message(dab);
    easel.painted[3] = Vec3(NAN, 0.0f, 0.0f);
    EXPECT_NE(message(dab).find("vertex 3 is not finite"), std::string::npos) << message(dab);
    easel.painted[3] = Vec3(0.0f);
    dab.radius = 0.0f;
    EXPECT_NE(message(dab).find("radius"), std::string::npos);
    dab.radius = 0.1f;
    dab.length = 1.0f;
    EXPECT_NE(message(dab).find("length"), std::string::npos);
    dab.length = 0.5f;
    dab.direction.y = NAN;
    EXPECT_NE(message(dab).find("direction"), std::string::npos);
}

// A direction along the view has no image on the surface; a collapsed neighbourhood has no direction: nothing
// is painted there, and nothing becomes NaN.
TEST(WrinkleFieldBrushInput, UndefinedDirectionsPaintNothing) {
    Easel easel(grid(2, 2, 0.1f));
    easel.touch(easel.field.mesh.positions, from_above({0.1f, 0.1f, 0.0f}, Vec3(0, 0, 1), 0.5f));
    EXPECT_EQ(easel.touched(), 0);
    easel.touch(scaled(easel.field.mesh, Vec3(0.0f)), from_above({0, 0, 0}, Vec3(1, 0, 0), 0.5f));
    EXPECT_EQ(easel.touched(), 0);
}

}  // namespace
}  // namespace rumple::tests
