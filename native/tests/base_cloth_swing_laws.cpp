// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of cloth that swings: what must hold on any mesh and in any motion.
#include <gtest/gtest.h>

#include <limits>
#include <utility>

#include "base/random.h"
#include "tests/base_cloth_swing.h"
#include "tests/refusals.h"

namespace rumple::tests {
namespace {

using namespace base_cloth;

std::vector<MeshData> meshes() {
    return {tube(16, 10, 0.1f, 0.5f), grid(9, 7, 0.04f), triangulated(tube(12, 8, 0.1f, 0.4f))};
}

Vec3 turned(const Vec3& p, float angle) {
    const Vec3 axis = glm::normalize(Vec3(1, 2, 3));
    return std::cos(angle) * p + std::sin(angle) * glm::cross(axis, p) +
           (1.0f - std::cos(angle)) * glm::dot(axis, p) * axis;
}

template <typename Move>
Points each(Points points, Move&& move) {
    for (Vec3& p : points) p = move(p);
    return points;
}

void throw_about(Swinging& cloth, float speed) {
    std::uint32_t count = 0;
    for (Vec3& v : cloth.disturbed().velocity) {
        v += speed * Vec3(noise(3, count), noise(3, count + 1), noise(3, count + 2));
        count += 3;
    }
}

// ---------------------------------------------------------------- momentum
struct Momentum {
    glm::dvec3 linear{0.0}, angular{0.0};
    double size = 0.0;  // of the speeds, if all were one way
};
Momentum momentum(const Swinging& cloth) {
    Momentum out;
    const Motion& motion = cloth.now.state.motion;
    for (size_t v = 0; v < motion.position.size(); ++v) {
        const glm::dvec3 p = double(cloth.garment.model->area[v]) * glm::dvec3(motion.velocity[v]);
        out.linear += p;
        out.angular += glm::cross(glm::dvec3(motion.position[v]), p);
        out.size += glm::length(p);
    }
    return out;
}

TEST(BaseClothSwingLaws, LinearMomentumIsConserved) {
    for (const MeshData& mesh : meshes()) {
        const Garment garment(mesh);
        Swinging cloth(garment, in_empty_space(), exactly(1.0f / 30.0f, 1.0f / 60.0f), mesh.positions);
        cloth.disturbed().velocity.assign(mesh.positions.size(), Vec3(0.2f, 0.1f, -0.3f));
        throw_about(cloth, 2.0f);
        const Momentum first = momentum(cloth);
        const double energy_first = cloth.kinetic_energy();
        for (int frame = 0; frame < 20; ++frame) {
            cloth.play(mesh.positions);
            ASSERT_LT(glm::distance(momentum(cloth).linear, first.linear), 2e-4 * first.size) << frame;
        }
        EXPECT_LT(cloth.kinetic_energy(), 0.9 * energy_first);  // else nothing pulled
    }
}

// Implicit Euler with forces along the springs: L_n - L_(n-1) = h sum m v_n x v_(n-1), which is of the order
// of h^2 a step: it is lost as h is long.
TEST(BaseClothSwingLaws, AngularMomentumIsLostAsImplicitEulerLosesIt) {
    const Garment garment(tube(16, 10, 0.1f, 0.5f));
    const Points& pose = garment.mesh.positions;
    const auto kept = [&](float h) {
        Swinging cloth(garment, in_empty_space(), exactly(h, h), pose);
        for (size_t v = 0; v < pose.size(); ++v)
            cloth.disturbed().velocity[v] = glm::cross(Vec3(0, 0, 3), pose[v]);
        throw_about(cloth, 0.3f);
        const Momentum first = momentum(cloth);
        for (float t = 0.0f; t < 0.25f - 0.5f * h; t += h) {
            const Motion before = cloth.motion();
            const Momentum was = momentum(cloth);
            cloth.play(pose);
            glm::dvec3 lost(0.0);
            for (size_t v = 0; v < pose.size(); ++v) {
                lost += double(h) * double(garment.model->area[v]) *
                        glm::cross(glm::dvec3(cloth.motion().velocity[v]), glm::dvec3(before.velocity[v]));
            }
            const glm::dvec3 change = momentum(cloth).angular - was.angular;
            EXPECT_LT(glm::distance(change, lost), 2e-4 * glm::length(first.angular)) << t;
        }
        return glm::length(momentum(cloth).angular) / glm::length(first.angular);
    };
    const double coarse = 1.0 - kept(1.0f / 120.0f), fine = 1.0 - kept(1.0f / 240.0f);
    EXPECT_GT(coarse, 0.003);
    EXPECT_LT(coarse, 0.1);
    EXPECT_NEAR(fine, 0.5 * coarse, 0.15 * coarse);
}

// ---------------------------------------------------------------- energy
TEST(BaseClothSwingLaws, EnergyDoesNotGrow) {
    for (const MeshData& mesh : meshes()) {
        const Garment garment(mesh);
        for (const float compression : {0.3f, 30.0f}) {
            Settings settings = without_contact();
            soften(settings);
            settings.compression = settings.folded = compression;
            settings.most_cg_iterations = 300;
            const Points pose = garment.crumpled(0.95f, 1.0f, 0.05f);
            Swinging cloth(garment, settings, exactly(1.0f / 30.0f, 1.0f / 60.0f), pose);
            throw_about(cloth, 0.8f);
            const auto total = [&] {
                return cloth.kinetic_energy() +
                       energy(*garment.model, settings, pose, in_double(cloth.motion().position));
            };
            double former = total();
            const double first = former, thrown = cloth.kinetic_energy();
            for (int frame = 0; frame < 40; ++frame) {
                cloth.play(pose);
                const double now = total();
                ASSERT_LE(now, former + 1e-5 * thrown) << "frame " << frame;
                former = now;
            }
            EXPECT_LT(former, first - 0.1 * thrown);
        }
    }
}

// ---------------------------------------------------------------- rest
TEST(BaseClothSwingLaws, AHeldPoseSettlesIntoTheEquilibriumOfHangAndStaysToTheBit) {
    for (const MeshData& mesh : meshes()) {
        const Garment garment(mesh);
        const Points pose = garment.crumpled(0.9f, 1.5f, 0.1f);
        Result hanging = garment.solve({}, pose);
        ASSERT_GT(garment.settle({}, pose, hanging, {}, nullptr, 60), 0);
        Swing swing;
        swing.seconds = 1.0f / 30.0f;
        Swinging cloth(garment, {}, swing, mesh.positions);
        cloth.play(pose);
        EXPECT_GT(farthest(cloth.now.positions, hanging.positions), 2e-3f);  // on its way
        int frames = 0;
        while (cloth.now.report.steps > 0 && frames < 90) {
            cloth.play(pose);
            ++frames;
        }
        EXPECT_LT(frames, 60);
        EXPECT_LT(farthest(cloth.now.positions, hanging.positions), 2e-4f);
        const Result rest = cloth.now;
        for (int again = 0; again < 3; ++again) {
            cloth.play(pose);
            EXPECT_EQ(cloth.now.report.steps, 0);
            ASSERT_TRUE(equal_bits(cloth.now.positions, rest.positions));
            ASSERT_TRUE(equal_bits(cloth.motion().position, rest.state.motion.position));
        }
        // Wind wakes it.
        cloth.swing.wind = {2.0f, 2.0f, 5.0f};
        cloth.swing.drag = 3.0f;
        cloth.play(pose);
        EXPECT_GT(farthest(cloth.now.positions, rest.positions), 1e-4f);
    }
}

TEST(BaseClothSwingLaws, AFrameThatIsReachedByAJumpIsTheEquilibriumAtRest) {
    const Garment garment(tube(16, 10, 0.1f, 0.5f));
    const Points pose = garment.crumpled(0.9f, 1.5f, 0.1f);
    const Swinging cloth(garment, {}, {}, pose);
    EXPECT_TRUE(equal_bits(cloth.now.positions, garment.solve({}, pose).positions));
    EXPECT_EQ(cloth.kinetic_energy(), 0.0);
}

// ---------------------------------------------------------------- locomotion
// Of a garment that turns and travels as a whole, the inertia feels nothing where locomotion is 0.
TEST(BaseClothSwingLaws, RigidMotionCarriesEverythingRigidlyWithoutLocomotion) {
    for (const MeshData& mesh : meshes()) {
        const Garment garment(mesh);
        const Points pose = garment.crumpled(0.95f, 0.6f, 0.05f);
        Settings settings = without_contact();
        settings.gravity = Vec3(0.0f);
        Swing swing;
        swing.locomotion = 0.0f;
        // On its way to rest, not at it: velocities are carried too.
        Swinging still(garment, settings, swing, mesh.positions), moving = still;
        for (int frame = 1; frame <= 12; ++frame) {
            const float angle = 0.15f * float(frame * frame) / 3.0f;
            const auto move = [&](const Vec3& p) {
                return turned(p, angle) + Vec3(0.3f, 0.1f, -0.2f) * float(frame);
            };
            still.play(frame < 3 ? mesh.positions : pose);
            moving.play(each(frame < 3 ? mesh.positions : pose, move));
            ASSERT_LT(farthest(moving.now.positions, each(still.now.positions, move)), 3e-5f) << frame;
            const Points velocities =
                each(still.motion().velocity, [&](const Vec3& v) { return turned(v, angle); });
            ASSERT_LT(farthest(moving.motion().velocity, velocities), 5e-3f) << frame;
        }
        EXPECT_GT(farthest(still.now.positions, mesh.positions), 1e-3f);
    }
}

// A walk at 3 m/s that ends from one frame to the next: how far the cloth moves on the body in a frame.
float moved_by_a_stop(const Garment& garment, float locomotion, const Vec3& walk) {
    Swing swing;
    swing.locomotion = locomotion;
    swing.seconds = 1.0f / 30.0f;
    Points pose = garment.mesh.positions;
    Swinging cloth(garment, {}, swing, pose);
    const auto step = [&] {
        for (Vec3& p : pose) p += walk / 30.0f;
        cloth.play(pose);
    };
    for (int frame = 0; frame < 60; ++frame) step();
    const Points before = cloth.now.positions;
    float most = 0.0f;
    for (int frame = 0; frame < 10; ++frame) {
        cloth.play(pose);
        most = std::max(most, farthest(cloth.now.positions, before));
    }
    return most;
}

TEST(BaseClothSwingLaws, AnAbruptStopMovesNothingWithoutLocomotionAndMuchWithAll) {
    for (const MeshData& mesh : meshes()) {
        const Garment garment(mesh);
        const Vec3 walk(0.0f, 3.0f, 0.0f);
        EXPECT_LT(moved_by_a_stop(garment, 0.0f, walk), 5e-5f);
        const float some = moved_by_a_stop(garment, 0.2f, walk), all = moved_by_a_stop(garment, 1.0f, walk);
        EXPECT_GT(some, 2e-3f);
        EXPECT_GT(all, some);
        EXPECT_LT(all, 0.07f);  // from one side of the room to the other
    }
}

// Whether bones move the mesh or the object moves with it: the same motion in the world.
TEST(BaseClothSwingLaws, TheMotionOfTheObjectCountsAsThatOfTheMesh) {
    // So bent, a tube of other rings may snap to either side by a rounding.
    const Garment garment(tube(14, 9, 0.1f, 0.5f));
    Settings settings = without_contact();
    soften(settings);
    settings.gravity = Vec3(0.0f);
    Swing swing;
    swing.locomotion = 0.5f;
    Swinging in_world(garment, settings, swing, garment.mesh.positions), in_object = in_world;
    float angle = 0.0f;
    Vec3 shift(0.0f);
    for (int frame = 1; frame <= 12; ++frame) {
        const float next = 0.02f * float(frame * frame) / 3.0f;
        const Vec3 next_shift = Vec3(0.02f, 0.01f, -0.015f) * float(frame * frame);
        const Points pose = garment.crumpled(1.0f, 0.05f * float(frame), 0.0f);
        const auto move = [&](const Vec3& p) { return turned(p, next) + next_shift; };
        in_world.play(each(pose, move));
        // Object space before -> world -> object space now.
        for (int k = 0; k < 3; ++k) {
            Vec3 axis(0.0f);
            axis[k] = 1.0f;
            in_object.swing.placement.matrix[k] = turned(axis, angle - next);
        }
        in_object.swing.placement.shift = turned(shift - next_shift, -next);
        in_object.play(pose);
        ASSERT_LT(farthest(in_world.now.positions, each(in_object.now.positions, move)), 2e-4f) << frame;
        angle = next;
        shift = next_shift;
    }
    EXPECT_GT(farthest(in_object.now.positions,
                       garment.solve(settings, garment.crumpled(1.0f, 1.2f, 0.0f)).positions),
              2e-3f);
}

// ---------------------------------------------------------------- frame rates
// A sleeve that swings to and fro, once in 0.8 s: 24, 30 and 60 frames a second show the same motion.
TEST(BaseClothSwingLaws, FrameRatesGiveTheSameMotion) {
    const Garment garment(tube(16, 10, 0.1f, 0.5f));
    const auto pose_at = [&](double t) {
        const double angle = 0.6 * std::sin(2.0 * std::numbers::pi * t / 0.8) * std::min(t, 1.0);
        return each(garment.mesh.positions, [&](const Vec3& p) {
            const float a = float(angle) * std::clamp(p.x / 0.5f, 0.0f, 1.0f);
            return Vec3(p.x * std::cos(a) - p.z * std::sin(a), p.y, p.x * std::sin(a) + p.z * std::cos(a));
        });
    };
    base_cloth::Settings settings;
    soften(settings);
    // At every sixth of a second from 1 to 3 s.
    const auto played = [&](int rate) {
        Swing swing;
        swing.seconds = 1.0f / float(rate);
        Swinging cloth(garment, settings, swing, pose_at(0.0));
        std::vector<Points> out;
        for (int frame = 1; frame <= 3 * rate; ++frame) {
            cloth.play(pose_at(double(frame) / rate));
            if (frame >= rate && frame % (rate / 6) == 0) out.push_back(cloth.now.positions);
        }
        return out;
    };
    const std::vector<Points> at_24 = played(24), at_30 = played(30), at_60 = played(60);
    double apart_24 = 0.0, apart_30 = 0.0, swung = 0.0;
    for (size_t i = 0; i < at_60.size(); ++i) {
        const Points hanging = garment.solve(settings, pose_at(1.0 + double(i) / 6.0)).positions;
        for (size_t v = 0; v < hanging.size(); ++v) {
            apart_24 += double(glm::distance(at_24[i][v], at_60[i][v]));
            apart_30 += double(glm::distance(at_30[i][v], at_60[i][v]));
            swung += double(glm::distance(hanging[v], at_60[i][v]));
        }
    }
    const double count = double(at_60.size() * at_60[0].size());
    EXPECT_GT(swung / count, 1e-3);  // metres from the equilibrium, in the mean
    EXPECT_LT(apart_24, 0.3 * swung);
    EXPECT_LT(apart_30, 0.2 * swung);
}

// ---------------------------------------------------------------- input
TEST(BaseClothSwingLaws, TheSameInputGivesTheSameBits) {
    const Garment garment(tube(16, 10, 0.1f, 0.5f)), twin(tube(16, 10, 0.1f, 0.5f));
    Swinging one(garment, {}, {}, garment.mesh.positions), other(twin, {}, {}, twin.mesh.positions);
    for (int frame = 1; frame <= 5; ++frame) {
        const Points pose = garment.crumpled(1.0f - 0.03f * float(frame), 0.4f * float(frame), 0.0f);
        one.play(pose);
        other.play(pose);
        ASSERT_TRUE(equal_bits(one.now.positions, other.now.positions));
        ASSERT_TRUE(equal_bits(one.motion().velocity, other.motion().velocity));
    }
}

// A garment that is put elsewhere and turned in every frame, at frame rates from none to a frame in days.
TEST(BaseClothSwingLaws, JumpsAtAnyFrameRateStayFiniteAndWithinTheirRoom) {
    const Garment garment(tube(16, 10, 0.1f, 0.5f));
    for (const float seconds : {0.0f, 1e-6f, 1.0f / 24.0f, 3.0f, 1e6f}) {
        Swing swing;
        swing.seconds = seconds;
        swing.locomotion = 1.0f;
        swing.drag = 3.0f;
        swing.wind = {50.0f, 0.0f, 0.0f};
        Swinging cloth(garment, {}, swing, garment.mesh.positions);
        for (int frame = 0; frame < 8; ++frame) {
            const Points pose = each(garment.mesh.positions, [&](const Vec3& p) {
                return turned(p, float(frame)) + Vec3(frame % 2 ? 100.0f : 0.0f, 0.0f, 0.0f);
            });
            cloth.play(pose);
            ASSERT_LE(farthest(cloth.now.positions, pose), cloth.settings.room + 1e-4f) << seconds;
            for (const Vec3& v : cloth.motion().velocity) ASSERT_TRUE(std::isfinite(glm::length(v)));
        }
    }
}

// No step runs in a frame of zero seconds. Its cloth counted as at rest, and a held pose kept it there.
TEST(BaseClothSwingLaws, AFrameOfZeroSecondsStopsNothing) {
    const Garment garment(tube(16, 10, 0.1f, 0.5f));
    const Points& pose = garment.mesh.positions;
    Swinging cloth(garment, {}, {}, pose);
    cloth.disturbed().velocity.assign(pose.size(), Vec3(0.2f, 0.0f, 0.0f));
    cloth.play(pose);
    const float frame = std::exchange(cloth.swing.seconds, 0.0f);
    cloth.play(pose);
    const Points before = cloth.now.positions;
    cloth.swing.seconds = frame;
    cloth.play(pose);
    EXPECT_GT(farthest(cloth.now.positions, before), 1e-4f);
}

TEST(BaseClothSwingLaws, AStateThatDoesNotSwingStartsAnewAndBadInputIsNamed) {
    const Garment garment(grid(6, 6, 0.05f)), other(grid(4, 4, 0.05f));
    const Points& pose = garment.mesh.positions;
    const Result fresh = solve_swing(*garment.model, {}, {}, {}, pose, nullptr, nullptr);
    const Result hanging = garment.solve({}, pose);
    const Result foreign = solve_swing(*other.model, {}, {}, {}, other.mesh.positions, nullptr, nullptr);
    for (const State* state : {&hanging.state, &foreign.state}) {
        const Result anew = solve_swing(*garment.model, {}, {}, {}, pose, nullptr, state);
        EXPECT_TRUE(equal_bits(anew.positions, fresh.positions));
    }
    // Nor does Hang go on from one that swings.
    EXPECT_TRUE(equal_bits(garment.solve({}, pose, &fresh.state), hanging));
    const auto refused = [&](const Swing& bad, const char* name) {
        expect_refused([&] { solve_swing(*garment.model, {}, bad, {}, pose, nullptr, nullptr); }, {name});
    };
    refused({.seconds = -1.0f}, "seconds");
    refused({.longest_step = 0.0f}, "longest_step");
    refused({.newton_steps = 0}, "newton_steps");
    refused({.damping = kNan}, "damping");
    refused({.locomotion = 1.5f}, "locomotion");
    refused({.drag = -1.0f}, "drag");
    refused({.wind = {0.0f, kNan, 0.0f}}, "wind: value 0");
    refused({.placement = {.shift = {0.0f, 0.0f, kNan}}}, "placement: column 3");
}

}  // namespace
}  // namespace rumple::tests
