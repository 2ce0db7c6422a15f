// SPDX-License-Identifier: GPL-3.0-or-later
// Lines that bend along the surface, and the folds of all systems that would run along them.
#include <gtest/gtest.h>

#include <cmath>

#include "base/errors.h"
#include "surface/strain/bent_lines.h"
#include "tests/wrinkle_field_cloth.h"
#include "tests/wrinkle_mesh_stack.h"
#include "tests/wrinkle_paths_cloth.h"

namespace rumple::tests {
namespace {

// 1.2 x 0.4 m, vertices 5 cm apart.
MeshData sheet() {
    return grid(24, 8, 0.05f);
}
constexpr float kLength = 1.2f, kMiddle = 0.2f;

// In its plane around a point beside it: lines along x become arcs, that of the middle one with this radius
// and as long as it was. squeeze: of what lies across them.
auto around(float radius, float squeeze = 1.0f) {
    return [=](const Vec3& p) {
        const float angle = (p.x - 0.5f * kLength) / radius, r = radius + squeeze * (p.y - kMiddle);
        return Vec3(r * std::sin(angle), r * std::cos(angle), p.z);
    };
}

struct Sheet {
    MeshData mesh = sheet();
    Surface surface = tests::build(mesh);
    BentLinesModel model = build_bent_lines(surface);

    template <typename Move>
    std::vector<SpareCloth> bent(Move&& move, float radius) const {
        return spare_cloth(surface, model, moved(mesh, move), radius);
    }
    // The vertex in the middle.
    static constexpr size_t kMiddleVertex = 4 * 25 + 12;
};

float most_without_place(const std::vector<SpareCloth>& spare) {
    float most = 0.0f;
    for (const SpareCloth& s : spare)
        for (int k = 0; k < 3; ++k)
            most = std::max(
                {most, std::abs(s.without_place.diagonal[k]), std::abs(s.without_place.off_diagonal[k])});
    return most;
}

// ---------------------------------------------------------------- laws
TEST(BentLines, NoneAtRestNorMovedRigidly) {
    const Sheet sheet;
    EXPECT_EQ(most_without_place(sheet.bent([](const Vec3& p) { return p; }, 1.0f)), 0.0f);
    EXPECT_EQ(most_without_place(sheet.bent(turned_and_shifted, 1.0f)), 0.0f);
}

// Lines along a tube are straight, wherever the surface itself is bent; so are those of even stretch and
// shear.
TEST(BentLines, NoneWhereTheSurfaceRollsUpOrStretchesEvenly) {
    const Sheet sheet;
    EXPECT_EQ(most_without_place(sheet.bent(
                  [](const Vec3& p) { return Vec3(0.2f * std::sin(5 * p.x), p.y, 0.2f * std::cos(5 * p.x)); },
                  0.5f)),
              0.0f);
    EXPECT_EQ(most_without_place(sheet.bent(
                  [](const Vec3& p) { return Vec3(0.7f * p.x + 0.3f * p.y, 1.4f * p.y, p.z); }, 0.5f)),
              0.0f);
}

TEST(BentLines, AreThoseOfTheRestShapeThatIsTurned) {
    const Sheet sheet;
    const auto bend = around(0.4f);
    const auto here = sheet.bent(bend, 0.3f);
    const auto turned = sheet.bent([&](const Vec3& p) { return turned_and_shifted(bend(p)); }, 0.3f);
    const Vec3 across(0, 1, 0), origin = turned_and_shifted(Vec3(0.0f));
    EXPECT_NEAR(here[Sheet::kMiddleVertex].share_without_place(across),
                turned[Sheet::kMiddleVertex].share_without_place(turned_and_shifted(across) - origin), 1e-4f);
}

// ---------------------------------------------------------------- by hand
// On a circle of twice the radius, curvature x radius is 1/2: a third of the way from 1/4 to 1, where the
// smooth step is 1/9 x (3 - 2/3) = 7/27. A quadratic over the next vertices is off by some per cent.
TEST(BentLines, ShareOfACircleByHand) {
    const Sheet sheet;
    const auto share = [&](float radius, const Vec3& direction) {
        return sheet.bent(around(0.4f), radius)[Sheet::kMiddleVertex].share_without_place(direction);
    };
    const Vec3 across(0, 1, 0), along(1, 0, 0);
    EXPECT_NEAR(share(0.2f, across), 7.0f / 27.0f, 0.02f);
    EXPECT_NEAR(share(0.2f, along), 0.0f, 1e-5f);  // what runs across the arcs runs straight
    EXPECT_FLOAT_EQ(share(0.45f, across), 1.0f);
    EXPECT_EQ(share(0.09f, across), 0.0f);
    EXPECT_EQ(share(0.0f, across), 0.0f);
    const float half = std::sqrt(0.5f);
    EXPECT_NEAR(share(0.45f, Vec3(half, half, 0)), 0.5f, 0.1f);
}

// ---------------------------------------------------------------- in every system
// So wide a circle that what lies inside the middle is hardly compressed along the arcs.
constexpr float kWide = 2.0f, kMore = 3.0f, kSqueezed = 0.8f;
// At its ends lines end: nothing is known of how they bend there.
bool away_from_ends(float x) {
    return std::abs(x - 0.5f * kLength) < 0.4f;
}
const auto straight = [](const Vec3& p) { return Vec3(p.x, kSqueezed * p.y, p.z); };

TEST(BentLines, BearNoFoldsOfTheMesh) {
    const Stack stack(sheet(), 1);
    const auto solved = [&](const Pose3& pose, float bend_radius) {
        wrinkle_mesh::Settings settings;
        settings.hem_rings = 0;
        settings.start_iterations = 60;
        settings.bend_radius = bend_radius;
        return stack.solve({pose}, alike(stack.count(), settings)).solved;
    };
    // Outside: inside the arcs are shorter than at rest, and bear folds across.
    const auto highest = [&](const Pose3& positions) {
        const Pose3& rest = stack.layers->layers.back()->positions_rest;
        float most = 0.0f;
        for (size_t v = 0; v < rest.size(); ++v)
            if (away_from_ends(rest[v].x) && rest[v].y > 0.29f)
                most = std::max(most, std::abs(positions[v].z));
        return most;
    };
    const Pose3 arcs = stack.moved(around(kWide, kSqueezed)), lines = stack.moved(straight);
    EXPECT_GT(highest(solved(arcs, 0.0f)), 0.002f);
    EXPECT_LT(highest(solved(arcs, kMore)), 0.0005f);
    EXPECT_EQ(solved(lines, kMore), solved(lines, 0.0f));  // along straight lines as before, to the bit
}

TEST(BentLines, BearNoWavesOfTheField) {
    Field field(sheet());
    const auto height = [&](const Pose3& pose, float bend_radius) {
        field.settings.bend_radius = bend_radius;
        return field.estimate_waves(pose).height[Sheet::kMiddleVertex];
    };
    const Pose3 arcs = moved(field.mesh, around(kWide, kSqueezed)), lines = moved(field.mesh, straight);
    EXPECT_GT(height(arcs, 0.0f), 2e-3f);
    EXPECT_LT(height(arcs, kMore), 1e-5f);
    EXPECT_EQ(height(lines, kMore), height(lines, 0.0f));
    // What is painted for the rest pose is the artist's: it stays as high as it is there.
    field.paint.rest_wrinkle.assign(field.mesh.positions.size(), Vec3(0.0f, 0.5f, 0.0f));
    EXPECT_GT(height(arcs, kMore), 1e-3f);
}

TEST(BentLines, BearNoPaths) {
    PathCloth cloth(sheet());
    cloth.settings.rest.reference = Reference::kStaticRest;
    const auto paths = [&](const Pose3& pose, float bend_radius) {
        cloth.settings.bend_radius = bend_radius;
        int count = 0;
        for (const wrinkle_paths::Path& path : cloth.solve(pose).paths) {
            count +=
                std::any_of(path.points.begin(), path.points.end(), [&](const wrinkle_paths::PathPoint& p) {
                    return away_from_ends(
                        cloth.mesh.positions[cloth.model->triangles.net.vertex[3 * p.triangle]].x);
                });
        }
        return count;
    };
    const Pose3 arcs = cloth.moved(around(kWide, 0.5f)),
                lines = cloth.moved([](const Vec3&p) { return Vec3(p.x, 0.5f * p.y, p.z); });
    EXPECT_GT(paths(arcs, 0.0f), 2);
    EXPECT_EQ(paths(arcs, kMore), 0);
    EXPECT_EQ(paths(lines, kMore), paths(lines, 0.0f));
}

// Crushed to a line, to a point, and farther apart than any cloth: nothing that is no number.
TEST(BentLines, OfAWildFrameAreNumbers) {
    const Sheet sheet;
    const auto finite = [&](const auto& move) {
        for (const SpareCloth& s : sheet.bent(move, 0.2f)) {
            for (const Vec3& e : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)})
                if (!std::isfinite(s.share_without_place(e))) return false;
        }
        return true;
    };
    EXPECT_TRUE(finite([](const Vec3& p) { return Vec3(p.x, 0.0f, 0.0f); }));
    EXPECT_TRUE(finite([](const Vec3&) { return Vec3(0.0f); }));
    EXPECT_TRUE(
        finite([](const Vec3& p) { return 1e8f * Vec3(std::sin(1e4f * p.x), std::cos(3e4f * p.y), p.x); }));
    EXPECT_TRUE(finite([](const Vec3& p) { return Vec3(1e8f * p.x, 1e-12f * p.y, 0.0f); }));
}

TEST(BentLines, RadiusIsChecked) {
    const Stack stack(sheet(), 0);
    wrinkle_mesh::Settings mesh;
    mesh.bend_radius = -1.0f;
    EXPECT_THROW(stack.solve({stack.mesh.positions}, {mesh}), InvalidInput);
    Field field(sheet());
    field.settings.bend_radius = -1.0f;
    EXPECT_THROW(field.estimate_waves(field.mesh.positions), InvalidInput);
    PathCloth cloth(sheet());
    cloth.settings.bend_radius = -1.0f;
    EXPECT_THROW(cloth.solve(cloth.mesh.positions), InvalidInput);
}

}  // namespace
}  // namespace rumple::tests
