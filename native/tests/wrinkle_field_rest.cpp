// SPDX-License-Identifier: GPL-3.0-or-later
// A Wrinkle Field whose rest shape adapts: compression from reference triangles (Gillette 2015, chapter 4).
#include <gtest/gtest.h>

#include <cstring>

#include "base/errors.h"
#include "tests/wrinkle_field_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_field;

template <typename T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

struct AdaptiveField : Field {
    explicit AdaptiveField(MeshData data, Reference reference = Reference::kRestPose)
        : Field(std::move(data)) {
        settings.rest.reference = reference;
        settings.wavelength = 0.1f;
    }
    State step(const Pose3& pose, double time, const State* before,
               std::span<const std::uint8_t> labels = {}) const {
        FrameTime frame_time;
        frame_time.time = time;
        frame_time.labels = labels;
        Report report;
        return wrinkle_field::solve(*model, settings, paint, make_pose(*model, pose), before, report,
                                    frame_time);
    }
    template <typename PoseAt>
    State play(double seconds, double rate, PoseAt&& pose_at) const {
        State state = step(pose_at(0.0), 0.0, nullptr);
        for (int f = 1; f <= int(std::lround(seconds * rate)); ++f)
            state = step(pose_at(f / rate), f / rate, &state);
        return state;
    }
    Waves waves(const Pose3& pose, const State& state) const {
        return wrinkle_field::estimate_waves(*model, settings, paint, pose, state.direction,
                                             reference_stretches(*model, state.reference, pose));
    }
    float mean_compression(const Pose3& pose, const State& state) const {
        const Waves at = waves(pose, state);
        double sum = 0.0;
        for (const float r : at.compression) sum += r;
        return float(sum / double(at.compression.size()));
    }
};

std::vector<MeshData> bases() {
    return {irregular_square(), tube(12, 8, 0.1f, 0.5f), shaken(tube(9, 6, 0.1f, 0.4f), 0.01f, 3), cube()};
}

TEST(WrinkleFieldRest, ARestShapeThatStaysKeepsNoReferenceAndNoBitChanges) {
    const AdaptiveField still(irregular_square(), Reference::kStaticRest);
    const Field plain = [] {
        Field field(irregular_square());
        field.settings.wavelength = 0.1f;
        return field;
    }();
    const Pose3 pose = scaled(still.mesh, {0.8f, 1.0f, 1.0f});
    const State state = still.step(pose, 2.0, nullptr), expected = plain.solve(pose);
    EXPECT_TRUE(state.reference.empty());
    EXPECT_TRUE(same_bits(state.phase, expected.phase) && same_bits(state.direction, expected.direction));
}

// The identity has an exact root: at rest the stretch is 1, 0, 1 to the bit.
TEST(WrinkleFieldRest, RestIsUnstretchedToTheBitAndRigidMotionNearlySo) {
    for (const MeshData& mesh : bases()) {
        const AdaptiveField field(mesh);
        const State at_rest = field.play(0.3, 30.0, [&](double) { return mesh.positions; });
        for (const Vec3& s : reference_stretches(*field.model, at_rest.reference, mesh.positions))
            EXPECT_EQ(s, Vec3(1, 0, 1));
        const Pose3 moved_away = moved(mesh, turned_and_shifted);
        const State moving =
            field.play(0.3, 30.0, [&](double time) { return time < 0.15 ? mesh.positions : moved_away; });
        for (const std::uint8_t label : moving.reference.labels) EXPECT_EQ(label, kRest);
        for (const Vec3& s : reference_stretches(*field.model, moving.reference, moved_away))
            EXPECT_LT(glm::distance(s, Vec3(1, 0, 1)), 1e-5f);
        const Waves waves = field.waves(moved_away, moving);
        for (const float h : waves.fullness) EXPECT_EQ(formulas::attenuation(h), 0.0f);
    }
}

// Against the triangles of the first frame, that frame is unwrinkled, whatever it does to the rest pose.
TEST(WrinkleFieldRest, TheFirstFrameHasNoWavesWithoutARestPose) {
    for (const MeshData& mesh : bases()) {
        const AdaptiveField field(mesh, Reference::kFirstFrame);
        const Pose3 first = moved(mesh, [](const Vec3& p) {
            return Vec3(0.7f * p.x + 0.2f * p.y, 0.9f * p.y - 0.3f * p.x * p.x, p.z + 0.2f * p.x);
        });
        const State state = field.step(first, 0.0, nullptr);
        for (const float r : field.waves(first, state).compression) EXPECT_NEAR(r, 1.0f, 2e-6f);
        size_t squeezed = 0;
        for (const float r : field.estimate_waves(first).compression) squeezed += r < 0.9f;
        EXPECT_GT(squeezed, field.model->tangent_rest.size() / 4);
    }
}

// The reference itself stretched: x to 0.8. Squeezed by another 0.75 along x the compression is 0.75 there,
// its direction x; the wave vector across it is 1 / 0.75 as dense as in the reference.
TEST(WrinkleFieldRest, CompressionIsMeasuredInTheReference) {
    const AdaptiveField field(irregular_square(), Reference::kFirstFrame);
    const State state = field.step(scaled(field.mesh, {0.8f, 1.0f, 1.0f}), 0.0, nullptr);
    const Pose3 pose = scaled(field.mesh, {0.6f, 1.0f, 1.0f});
    const Waves waves = field.waves(pose, state);
    for (size_t v = 0; v < waves.compression.size(); ++v) {
        EXPECT_NEAR(waves.compression[v], 0.75f, 1e-5f);
        EXPECT_NEAR(std::abs(field.direction(waves, v).x), 1.0f, 1e-4f);
        EXPECT_NEAR(std::abs(waves.wave_vector[v].x), formulas::kTwoPi / 0.1f / 0.75f, 1e-2f);
        EXPECT_NEAR(waves.wave_vector[v].y, 0.0f, 0.05f);
    }
}

// A sheared reference: its own frame has turned against the rest pose's, the stretch must not see it.
// Squeezed along the diagonal after the shear, k is the diagonal.
TEST(WrinkleFieldRest, AShearedReferenceDoesNotTurnTheWaves) {
    const AdaptiveField field(irregular_square(), Reference::kFirstFrame);
    const float shear = 0.2f;  // symmetric: no rotation
    const Pose3 first =
        moved(field.mesh, [=](const Vec3& p) { return Vec3(p.x + shear * p.y, p.y + shear * p.x, p.z); });
    const State state = field.step(first, 0.0, nullptr);
    Pose3 pose = first;
    const Vec3 diagonal = glm::normalize(Vec3(1, 1, 0));
    for (Vec3& p : pose) p -= 0.3f * glm::dot(diagonal, p) * diagonal;
    const Waves waves = field.waves(pose, state);
    for (size_t v = 0; v < waves.compression.size(); ++v) {
        EXPECT_NEAR(waves.compression[v], 0.7f, 1e-5f);
        EXPECT_NEAR(std::abs(glm::dot(field.direction(waves, v), diagonal)), 1.0f, 1e-4f);
        EXPECT_NEAR(std::abs(glm::dot(glm::normalize(waves.wave_vector[v]), diagonal)), 1.0f, 1e-4f);
    }
}

TEST(WrinkleFieldRest, ASqueezedPoseIsGivenInTo) {
    const AdaptiveField field(irregular_square());
    const Pose3 pose = scaled(field.mesh, {0.7f, 1.0f, 1.0f});
    const Labels compress(field.model->base.triangles.size(), kCompress);
    State state = field.step(pose, 0.0, nullptr);
    EXPECT_NEAR(field.mean_compression(pose, state), 0.7f, 1e-5f);
    for (int f = 1; f <= 90; ++f) state = field.step(pose, f / 30.0, &state, compress);
    const float sigma = 1.0f - 0.3f * std::pow(0.99f, 90.0f);
    EXPECT_NEAR(field.mean_compression(pose, state), sigma, 1e-4f);
}

TEST(WrinkleFieldRest, StretchedOutItRecovers) {
    const AdaptiveField field(irregular_square(), Reference::kFirstFrame);
    const auto there_and_back = [&](double time) {
        return scaled(field.mesh,
                      Vec3(0.75f + 0.25f * float(std::clamp(2.0 - std::abs(2.0 * time - 2.0), 0.0, 1.0))));
    };
    const State begun = field.step(there_and_back(0.0), 0.0, nullptr);
    EXPECT_NEAR(field.mean_compression(there_and_back(0.0), begun), 1.0f, 1e-5f);
    const State back = field.play(2.0, 30.0, there_and_back);
    EXPECT_LT(field.mean_compression(there_and_back(2.0), back), 0.85f);
}

TEST(WrinkleFieldRest, EveryFrameRateGivesTheSameCompression) {
    const AdaptiveField field(irregular_square());
    const auto breathing = [&](double time) {
        return scaled(field.mesh, {0.8f + 0.2f * float(std::cos(4.0 * time)), 1.0f, 1.0f});
    };
    const float of_rest = field.mean_compression(breathing(2.35), State{});
    const auto at = [&](double rate) {
        return field.mean_compression(breathing(2.35), field.play(3.0, rate, breathing));
    };
    const float at_30 = at(30.0);
    EXPECT_GT(at_30, of_rest + 0.01f);
    for (const double rate : {24.0, 60.0, 120.0})
        EXPECT_NEAR(at(rate), at_30, 0.15f * (at_30 - of_rest)) << rate;
}

TEST(WrinkleFieldRest, NeitherTheOrderOfVerticesNorThreadsChangeABit) {
    AdaptiveField field(irregular_square());
    const std::vector<Index> order = shuffled(field.mesh.positions.size());
    AdaptiveField other(reordered(field.mesh, order));
    const auto motion = [](const MeshData& mesh) {
        return [&mesh](double time) {
            return moved(mesh, [=](const Vec3& p) {
                return Vec3((1.0f - float(time) * p.y) * p.x, p.y, 0.3f * float(time) * p.x);
            });
        };
    };
    const State state = field.play(0.5, 30.0, motion(field.mesh));
    const State reordered_state = other.play(0.5, 30.0, motion(other.mesh));
    EXPECT_TRUE(same_bits(state.reference.reference, reordered_state.reference.reference));
    field.settings.threads = 3;
    const State threaded = field.play(0.5, 30.0, motion(field.mesh));
    EXPECT_TRUE(same_bits(state.phase, threaded.phase));
    EXPECT_TRUE(same_bits(state.reference.reference, threaded.reference.reference));
}

TEST(WrinkleFieldRest, WhatDoesNotFitIsNamed) {
    const AdaptiveField field(irregular_square()), other(tube(12, 8, 0.1f, 0.5f));
    const State state = field.step(field.mesh.positions, 1.0, nullptr);
    const auto refused = [](auto&& call, const std::string& part) {
        try {
            call();
            ADD_FAILURE() << "accepted: " << part;
        } catch (const InvalidInput& error) {
            EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
        }
    };
    refused([&] { field.step(field.mesh.positions, 0.5, &state); }, "time: the state is of 1.0");
    refused([&] { reference_stretches(*other.model, state.reference, other.mesh.positions); },
            "state.reference: expected 192 triangles, got 148");
    const std::vector<Vec3> few(3, Vec3(1, 0, 1));
    refused([&] { estimate_waves(*field.model, field.settings, {}, field.mesh.positions, {}, few); },
            "stretches: expected 91 welded vertices, got 3");
    EXPECT_TRUE(same_bits(activated(state).reference.reference, state.reference.reference));
}

}  // namespace
}  // namespace rumple::tests
