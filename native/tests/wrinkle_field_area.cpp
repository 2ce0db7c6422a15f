// SPDX-License-Identifier: GPL-3.0-or-later
// Waves as geometry have no more cloth than there is at rest, and go no farther inwards than they may.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "tests/refusals.h"
#include "tests/wrinkle_field_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_field;

std::vector<Profile> profiles() {
    std::vector<float> flat(kProfileIntervals + 1);
    for (int i = 0; i <= kProfileIntervals; ++i) flat[i] = 0.3f - 0.5f * float(i) / kProfileIntervals;
    return {sine(), accordion(), pencil_pleats(), drawn(flat)};
}

// A strip of quads along x, of length 1, as a fine mesh of so many pieces to a quad's side.
Field strip(Index pieces) {
    Plan plan;
    plan.output = Output::kGeometry;
    plan.fine.kind = FineSource::Kind::kRegular;
    plan.fine.segments = pieces;
    plan.attachment = AttachmentKind::kLinear;
    Field field(grid(16, 3, 1.0f / 16.0f), plan);
    field.settings.wavelength = 0.2f;
    return field;
}

double area_of(const PolygonMesh& mesh, std::span<const Vec3> positions) {
    double sum = 0.0;
    for (Index p = 0; p < mesh.polygons(); ++p) {
        const Index first = mesh.polygon_start[p];
        const Vec3 a = positions[mesh.corner_vertex[first]];
        for (Index k = 1; k + 1 < mesh.polygon_size(p); ++k) {
            sum += 0.5 * glm::length(glm::cross(positions[mesh.corner_vertex[first + k]] - a,
                                                positions[mesh.corner_vertex[first + k + 1]] - a));
        }
    }
    return sum;
}

// Area of what is shown over that at rest.
double area_kept(const Field& field, const Pose3& pose, const Profile& profile) {
    const Picture picture = field.show(pose, field.solve(pose), profile);
    return area_of(field.model->shown.mesh, picture.positions) /
           area_of(field.model->shown.mesh, field.model->shown.positions_rest);
}

TEST(WrinkleFieldArea, TheLengthOfASineIsAnEllipticIntegral) {
    for (const double s : {0.0, 0.1, 1.0, 3.0}) {
        const double root = std::hypot(1.0, s);
        const double exact = 2.0 / std::numbers::pi * root * std::comp_ellint_2(s / root);
        EXPECT_NEAR(wave_length(sine(), s), exact, 3e-4 * exact);
    }
}

TEST(WrinkleFieldArea, SteepnessIsTheInverseOfTheLength) {
    for (const Profile& profile : profiles()) {
        EXPECT_EQ(steepness(profile, 1.0), 0.0);
        EXPECT_EQ(steepness(profile, 0.7), 0.0);
        for (const double ratio : {1.0001, 1.02, 1.5, 4.0, 20.0})
            EXPECT_NEAR(wave_length(profile, steepness(profile, ratio)), ratio, 1e-5 * ratio);
    }
    EXPECT_EQ(steepness(drawn(std::vector<float>(kProfileIntervals + 1, 0.4f)), 1.2),
              std::numeric_limits<double>::infinity());
}

// Equation (2) is what pleats ask for; the sine's is nine tenths of it.
TEST(WrinkleFieldArea, AccordionPleatsKeepTheHeightOfThePaper) {
    Field field = strip(4);
    const Pose3 pose = scaled(field.mesh, {0.6f, 1.0f, 1.0f});
    const Waves asked = field.crush(pose);
    for (const auto& [profile, least, most] :
         {std::tuple{accordion(), 0.9999f, 1.0f}, std::tuple{sine(), 0.85f, 0.96f}}) {
        Waves waves = asked;
        keep_area(profile, waves);
        for (size_t v = 0; v < waves.height.size(); ++v) {
            EXPECT_GE(waves.height[v], least * asked.height[v]);
            EXPECT_LE(waves.height[v], most * asked.height[v] * (1.0f + 1e-6f));
        }
    }
}

// By hand: a strip squeezed to a share of its length, and its waves. Without the limit it has 3 % too much.
TEST(WrinkleFieldArea, ASqueezedStripHasTheAreaOfRest) {
    Field field = strip(24);
    for (const float squeezed : {0.95f, 0.8f, 0.6f}) {
        const Pose3 pose = scaled(field.mesh, {squeezed, 1.0f, 1.0f});
        for (const Profile& profile : {sine(), pencil_pleats()}) {
            field.settings.keep_area = true;
            const double kept = area_kept(field, pose, profile);
            EXPECT_LT(kept, 1.003) << squeezed;
            EXPECT_GT(kept, 0.99) << squeezed;
        }
        field.settings.keep_area = false;
        EXPECT_GT(area_kept(field, pose, sine()), 1.0 + 0.1 * std::min(1.0 - squeezed, 0.25)) << squeezed;
    }
}

TEST(WrinkleFieldArea, WhateverStrengthAndPaintAskForTheLimitHolds) {
    Field field = strip(24);
    const Pose3 pose = scaled(field.mesh, {0.8f, 1.0f, 1.0f});
    field.settings.strength = 3.0f;
    field.paint.mask.assign(field.mesh.positions.size(), 2.0f);
    EXPECT_NEAR(area_kept(field, pose, sine()), 1.0, 0.012);
    field.settings.keep_area = false;
    EXPECT_GT(area_kept(field, pose, sine()), 2.0);
    field.settings.keep_area = true;
    field.settings.strength = 0.05f;  // and what asks for less gets less
    field.paint.mask.clear();
    EXPECT_LT(area_kept(field, pose, sine()), 0.81);
}

// Squeezed one way and stretched the other by as much, there is no cloth left over.
TEST(WrinkleFieldArea, WhatIsSpentOnStretchIsNotFolded) {
    const Field field = strip(8);
    Waves waves = field.crush(scaled(field.mesh, {0.8f, 1.25f, 1.0f}));
    keep_area(sine(), waves);
    for (const float height : waves.height) EXPECT_LT(height, 1e-3f * field.settings.wavelength);
    waves = field.crush(scaled(field.mesh, {0.8f, 1.1f, 1.0f}));
    for (const float gather : waves.gather) EXPECT_NEAR(gather, 1.0f / 0.88f, 1e-5f);
    waves = field.crush(scaled(field.mesh, {0.8f, 0.9f, 1.0f}));  // folds run one way: the other stays short
    for (const float gather : waves.gather) EXPECT_NEAR(gather, 1.0f / 0.8f, 1e-5f);
}

TEST(WrinkleFieldArea, APaintedRestWrinkleIsClothThatThePainterAdded) {
    Field field = strip(8);
    field.paint.rest_wrinkle.assign(field.mesh.positions.size(), Vec3(0.5f, 0.0f, 0.0f));
    const Waves waves = field.crush(field.mesh.positions);
    for (const float gather : waves.gather) EXPECT_NEAR(gather, 1.0f / 0.75f, 1e-5f);
}

TEST(WrinkleFieldArea, WavesGoNoFartherInwardsThanTheirGap) {
    Field field = strip(12);
    const Pose3 pose = scaled(field.mesh, {0.7f, 1.0f, 1.0f});
    const State state = field.solve(pose);
    std::vector<float> gap(field.mesh.positions.size());
    for (size_t v = 0; v < gap.size(); ++v) gap[v] = 0.02f * field.mesh.positions[v].x;
    const Picture free = field.show(pose, state),
                  bound = wrinkle_field::show(*field.model, field.settings, sine(), {}, pose, state, gap);
    int lifted = 0;
    for (size_t v = 0; v < bound.positions.size(); ++v) {
        const float lowest = -0.02f / 0.7f * bound.positions[v].x;
        EXPECT_NEAR(bound.positions[v].z, std::max(free.positions[v].z, lowest), 1e-6f);
        lifted += bound.positions[v].z > free.positions[v].z + 1e-4f;
    }
    EXPECT_GT(lifted, 100);
    gap.pop_back();
    expect_refused([&] { wrinkle_field::show(*field.model, {}, sine(), {}, pose, state, gap); }, {"gap"});
}

}  // namespace
}  // namespace rumple::tests
