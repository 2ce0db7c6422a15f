// SPDX-License-Identifier: GPL-3.0-or-later
// Cloth that swings in cases that are worked out by hand.
#include <gtest/gtest.h>

#include "tests/base_cloth_swing.h"

namespace rumple::tests {
namespace {

using namespace base_cloth;

void expect_all(const std::vector<Vec3>& values, const Vec3& expected, float tolerance) {
    float most = 0.0f;
    for (const Vec3& value : values) most = std::max(most, glm::distance(value, expected));
    EXPECT_LT(most, tolerance);
}

Points differences(const Points& a, const Points& b) {
    Points out;
    for (size_t v = 0; v < a.size(); ++v) out.push_back(a[v] - b[v]);
    return out;
}

// Implicit Euler: v_n = v_(n-1) + h g, x_n = x_(n-1) + h v_n, so that after n steps x = h^2 g n (n + 1) / 2.
TEST(BaseClothSwingExact, FreeFall) {
    const Garment garment(tube(8, 5, 0.1f, 0.3f));
    const Points& pose = garment.mesh.positions;
    Swinging cloth(garment, in_empty_space(), exactly(0.1f, 0.02f), pose);
    cloth.settings.gravity = {0.0f, 0.0f, -9.81f};
    const double h = 0.02;
    for (int n = 5; n <= 20; n += 5) {
        cloth.play(pose);
        SCOPED_TRACE(n);
        expect_all(cloth.motion().velocity, Vec3(0, 0, -9.81 * h * n), 2e-4f);
        expect_all(differences(cloth.now.positions, pose), Vec3(0, 0, -9.81 * h * h * 0.5 * n * (n + 1)),
                   5e-5f);
    }
}

// A frame that is not a multiple of the longest step is divided evenly: 0.05 s into three.
TEST(BaseClothSwingExact, AFrameIsDividedIntoEvenSteps) {
    const Garment garment(grid(3, 3, 0.05f));
    const Points& pose = garment.mesh.positions;
    Swinging cloth(garment, in_empty_space(), exactly(0.05f, 0.02f), pose);
    cloth.settings.gravity = {0.0f, 0.0f, -9.81f};
    cloth.play(pose);
    const double h = 0.05 / 3.0;
    expect_all(differences(cloth.now.positions, pose), Vec3(0, 0, -9.81 * h * h * 6.0), 1e-6f);
}

// v_n = v_(n-1) / (1 + d h).
TEST(BaseClothSwingExact, DampingTakesVelocity) {
    const Garment garment(grid(5, 4, 0.05f));
    const Points& pose = garment.mesh.positions;
    Swinging cloth(garment, in_empty_space(), exactly(0.05f, 0.01f), pose);
    cloth.swing.damping = 7.0f;
    cloth.disturbed().velocity.assign(pose.size(), Vec3(0.5f, -1.0f, 2.0f));
    double left = 1.0;
    for (int frame = 0; frame < 4; ++frame) {
        cloth.play(pose);
        for (int step = 0; step < 5; ++step) left /= 1.0 + 7.0 * 0.01;
        expect_all(cloth.motion().velocity, Vec3(left * 0.5, -left, left * 2.0), 1e-4f);
    }
}

// Damping is of the velocity beside the animated one: what moves as the animation does keeps its velocity.
TEST(BaseClothSwingExact, DampingLeavesTheAnimatedVelocity) {
    const Garment garment(grid(5, 4, 0.05f));
    Points pose = garment.mesh.positions;
    Swinging cloth(garment, in_empty_space(), exactly(0.05f, 0.01f), pose);
    cloth.swing.damping = 7.0f;
    cloth.swing.locomotion = 1.0f;
    const Vec3 velocity(0.5f, -1.0f, 2.0f);
    cloth.disturbed().velocity.assign(pose.size(), velocity);
    for (int frame = 0; frame < 10; ++frame) {
        for (Vec3& p : pose) p += 0.05f * velocity;
        cloth.play(pose);
    }
    EXPECT_LT(farthest(cloth.now.positions, pose), 3e-4f);
}

// A sheet across the wind: a = c |w - v| (w - v); one of the two speeds is the one before the step. What
// blows along the sheet does not move it.
TEST(BaseClothSwingExact, TheAirPushesASheetAlongItsNormal) {
    const Garment garment(grid(6, 4, 0.05f));
    const Points& pose = garment.mesh.positions;
    Swinging cloth(garment, in_empty_space(), exactly(0.01f, 0.01f), pose);
    cloth.swing.drag = 3.0f;
    cloth.swing.wind = {2.0f, -1.0f, 5.0f};
    cloth.disturbed().velocity.assign(pose.size(), Vec3(0.3f, 0.0f, -1.0f));
    double v = -1.0;
    for (int frame = 0; frame < 30; ++frame) {
        cloth.play(pose);
        const double met = 0.01 * 3.0 * std::abs(5.0 - v);
        v = (v + met * 5.0) / (1.0 + met);
        ASSERT_NO_FATAL_FAILURE(expect_all(cloth.motion().velocity, Vec3(0.3, 0.0, v), 2e-4f)) << frame;
    }
    EXPECT_GT(v, 3.0);
}

// Seconds of a whole oscillation of `where` about zero, from its first to its third zero.
template <typename Where>
double period(Swinging& cloth, const Points& pose, int most_frames, Where&& where) {
    std::vector<double> zeros;
    double before = where(cloth.motion().position);
    for (int frame = 0; frame < most_frames && zeros.size() < 3; ++frame) {
        cloth.play(pose);
        const double now = where(cloth.motion().position);
        if ((before > 0.0) != (now > 0.0))
            zeros.push_back(double(cloth.swing.seconds) * (frame + before / (before - now)));
        before = now;
    }
    EXPECT_EQ(zeros.size(), 3u);
    return zeros.size() == 3 ? zeros[2] - zeros[0] : 0.0;
}

// Every vertex alike on the pull back alone: x'' = -f x.
TEST(BaseClothSwingExact, ThePullBackSwingsWithItsOwnPeriod) {
    const Garment garment(grid(5, 4, 0.05f));
    const Points& pose = garment.mesh.positions;
    Settings settings = in_empty_space();
    settings.follow = 400.0f;
    Swinging cloth(garment, settings, exactly(0.001f, 0.001f), pose);
    for (Vec3& p : cloth.disturbed().position) p.z += 0.01f;
    // Implicit Euler in the first steps: x (1 + h^2 f) = x before + h v before.
    double x = 0.01, v = 0.0;
    for (int step = 0; step < 10; ++step) {
        cloth.play(pose);
        const double next = (x + 0.001 * v) / (1.0 + 0.4e-3);
        v = (next - x) / 0.001;
        x = next;
        EXPECT_NEAR(cloth.now.positions[7].z, x, 2e-6);
    }
    const double found = period(cloth, pose, 1000, [](const Points& p) { return double(p[7].z); });
    EXPECT_NEAR(found, 2.0 * std::numbers::pi / 20.0, 0.002 * found);
}

// Strips that hang from a pinned row and swing out of their plane, hardly pulled back.
struct Strip {
    Garment garment;
    Points pose;
    Paint paint;
    Settings settings = in_empty_space();

    Strip(Index squares, float length) : garment(grid(1, squares, length)), pose(garment.mesh.positions) {
        for (Vec3& p : pose) p = {p.x, 0.0f, -p.y};
        for (size_t v = 0; v < pose.size(); ++v) paint.follow.push_back(v < 2 ? 1.0f : 0.0f);
        settings.gravity = {0.0f, 0.0f, -9.81f};
        settings.follow = 0.5f;
        settings.stretch = 2000.0f;
        settings.start_steps = 60;
    }
};

// One square: its two lower corners are pendulums of its side. T = 2 pi / sqrt(g / L + f), with L from the
// animated place of the pin to the corner.
TEST(BaseClothSwingExact, APendulum) {
    const Strip strip(1, 0.5f);
    Swinging cloth(strip.garment, strip.settings, exactly(0.002f, 0.002f), strip.pose, strip.paint);
    const double length = -double(cloth.now.positions[2].z);
    EXPECT_NEAR(length, 0.505, 0.01);
    for (size_t v = 2; v < 4; ++v) cloth.disturbed().position[v].y += 0.01f;
    const double found =
        period(cloth, strip.pose, 2000, [](const Points& p) { return double(p[2].y + p[3].y); });
    const double expected = 2.0 * std::numbers::pi / std::sqrt(9.81 / length + 0.5);
    EXPECT_NEAR(found, expected, 0.005 * expected);
}

// The Bessel function J0 for 0 <= x < 3, by its series; libc++ has none.
double bessel_j0(double x) {
    double sum = 0.0, term = 1.0;
    for (int k = 1; k <= 12; ++k) {
        sum += term;
        term *= -0.25 * x * x / (k * k);
    }
    return sum;
}

// A chain of 16 squares in the first shape that it swings in (D. Bernoulli 1733): y = J0(2 w sqrt(s / g)), s
// from its lower end, w = 2.4048 / 2 sqrt(g / L).
TEST(BaseClothSwingExact, AHangingChain) {
    constexpr Index kSquares = 16;
    const Strip strip(kSquares, 0.05f);
    Swinging cloth(strip.garment, strip.settings, exactly(0.002f, 0.002f), strip.pose, strip.paint);
    const Index last = 2 * kSquares;
    const double length = -double(cloth.now.positions[last].z);
    for (Vec3& p : cloth.disturbed().position) {
        const double s = std::max((length + double(p.z)) / length, 0.0);
        p.y += float(0.02 * bessel_j0(2.404826 * std::sqrt(s)));
    }
    const double found =
        period(cloth, strip.pose, 2000, [&](const Points& p) { return double(p[last].y + p[last + 1].y); });
    const double expected = 2.0 * std::numbers::pi / std::sqrt(1.4458 * 9.81 / length + 0.5);
    EXPECT_NEAR(found, expected, 0.02 * expected);
}

}  // namespace
}  // namespace rumple::tests
