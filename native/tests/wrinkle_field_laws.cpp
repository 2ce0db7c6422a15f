// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of the Wrinkle Field: what must hold on any mesh and in any pose.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/wrinkle_field_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_field;

std::vector<MeshData> bases() {
    return {irregular_square(), tube(12, 8, 0.1f, 0.5f), shaken(tube(9, 6, 0.1f, 0.4f), 0.01f, 3), cube(),
            seam_split_cube()};
}

template <typename T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

TEST(WrinkleFieldLaws, RestAndRigidMotionGiveNoWrinkles) {
    for (const MeshData& mesh : bases()) {
        const Field field(mesh);
        for (const Pose3& pose : {mesh.positions, moved(mesh, turned_and_shifted)}) {
            const Waves waves = field.estimate_waves(pose);
            for (size_t v = 0; v < waves.height.size(); ++v) {
                EXPECT_NEAR(waves.compression[v], 1.0f, 2e-6f);
                EXPECT_LT(waves.fullness[v], 2e-3f);  // the root of a rounding
                EXPECT_EQ(formulas::attenuation(waves.fullness[v]), 0.0f);
            }
        }
    }
}

// What solve() hands on is to the bit what show() would estimate again: from the start, from the frame
// before, where the direction turned by more than a right angle, and where nothing is compressed more one way
// than another.
TEST(WrinkleFieldLaws, WavesOfTheSolveAreThoseThatAreShown) {
    const auto squeezed = [](float x, float y) {
        return [=](const Vec3& p) { return Vec3(x * p.x, y * p.y, p.z + 0.02f * std::sin(7.0f * p.x)); };
    };
    for (const Reference reference : {Reference::kStaticRest, Reference::kRestPose}) {
        for (const MeshData& mesh : bases()) {
            Field field(mesh);
            field.settings.irregularity = 0.5f;
            field.settings.rest.reference = reference;
            State before;
            FrameTime now;
            for (const auto& [x, y] : {std::pair{0.7f, 1.0f}, {1.0f, 0.6f}, {1.0f, 1.0f}, {0.8f, 0.8f}}) {
                const Pose3 pose = moved(mesh, squeezed(x, y));
                now.time += 1.0 / 30.0;
                Report unused;
                Waves solved;
                const Pose at = make_pose(*field.model, pose);
                const State state = solve(*field.model, field.settings, {}, at,
                                          before.phase.empty() ? nullptr : &before, unused, now, &solved);
                const Waves handed_on = shown_waves(*field.model, field.settings, sine(), solved, state);
                const Waves again = field.shown_waves(pose, state);
                EXPECT_TRUE(same_bits(handed_on.wave_vector, again.wave_vector));
                EXPECT_TRUE(same_bits(handed_on.height, again.height));
                EXPECT_TRUE(same_bits(handed_on.gather, again.gather));
                EXPECT_TRUE(same_bits(handed_on.compression, again.compression));
                EXPECT_TRUE(same_bits(handed_on.direction, again.direction));
                before = state;
            }
        }
    }
}

TEST(WrinkleFieldLaws, UniformStretchGivesNoHeight) {
    for (const MeshData& mesh : bases()) {
        const Waves waves = Field(mesh).estimate_waves(scaled(mesh, Vec3(1.3f)));
        for (const float height : waves.height) EXPECT_EQ(height, 0.0f);
    }
}

TEST(WrinkleFieldLaws, UniformShrinkingIsSeenEverywhere) {
    for (const MeshData& mesh : bases()) {
        const Waves waves = Field(mesh).estimate_waves(scaled(mesh, Vec3(0.6f)));
        for (const float r : waves.compression) EXPECT_NEAR(r, 0.6f, 2e-6f);
    }
}

// As printed, the projected edges get shorter where the sheet bends; true lengths only turn.
TEST(WrinkleFieldLaws, BendingAloneIsHardlyCompression) {
    const MeshData mesh = grid(20, 6, 0.05f);
    const float curvature = 2.0f, angle = 1.5f;
    const Pose3 rolled = moved(mesh, [=](const Vec3& p) {
        return Vec3(std::sin(curvature * p.x) / curvature, p.y,
                    (1.0f - std::cos(curvature * p.x)) / curvature);
    });
    const Pose3 folded = moved(mesh, [=](const Vec3& p) {
        const float x = std::max(p.x - 0.5f, 0.0f);
        return Vec3(std::min(p.x, 0.5f) + x * std::cos(angle), p.y, x * std::sin(angle));
    });
    Plan as_printed;
    as_printed.true_lengths = false;
    const Field field(mesh), printed(mesh, as_printed);
    const auto most = [&](const Field& f, const Pose3& pose) {
        const Waves waves = f.estimate_waves(pose);
        return *std::max_element(waves.fullness.begin(), waves.fullness.end());
    };
    EXPECT_EQ(formulas::attenuation(most(field, rolled)), 0.0f);
    EXPECT_GT(formulas::attenuation(most(printed, rolled)), 0.0f);
    EXPECT_LT(most(field, folded), 0.5f * most(printed, folded));
}

TEST(WrinkleFieldLaws, RigidMotionChangesNoPhase) {
    for (const MeshData& mesh : {irregular_square(), tube(12, 8, 0.1f, 0.5f)}) {
        Field field(mesh);
        field.settings.wavelength = 0.15f;
        const Pose3 here = scaled(mesh, {0.7f, 1.0f, 1.0f});
        Pose3 there = here;
        for (Vec3& p : there) p = turned_and_shifted(p);
        const State state = field.solve(here);
        Report report;
        EXPECT_TRUE(same_bits(field.solve(there, &state, &report).phase, state.phase));
        EXPECT_EQ(report.largest_change, 0.0f);
    }
}

TEST(WrinkleFieldLaws, AHeldPoseStaysToTheBit) {
    for (const MeshData& mesh : bases()) {
        Field field(mesh);
        field.settings.wavelength = 0.15f;
        const Pose3 pose = moved(mesh, [](const Vec3& p) { return Vec3(0.6f + 0.1f * p.y, 1.0f, 0.9f) * p; });
        const State start = field.solve(scaled(mesh, {0.9f, 1.0f, 1.0f}));
        const State state = field.solve(pose, &start);
        EXPECT_FALSE(same_bits(state.phase, start.phase));
        for (int frame = 0; frame < 3; ++frame) {
            const State next = field.solve(pose, &state);
            EXPECT_TRUE(same_bits(next.phase, state.phase));
            EXPECT_TRUE(same_bits(next.direction, state.direction));
        }
        const State active = activated(state);
        EXPECT_FALSE(same_bits(field.solve(pose, &active).phase, state.phase));
    }
}

// A change too small to act at once is not forgotten.
TEST(WrinkleFieldLaws, SlowDriftIsRelaxedInTheEnd) {
    Field field(irregular_square());
    field.settings.wavelength = 0.15f;
    const auto pose = [&](int frame) {
        return moved(field.mesh,
                     [=](const Vec3& p) { return Vec3(0.8f * p.x + 5e-5f * float(frame) * p.y, p.y, 0.0f); });
    };
    const State start = field.solve(pose(0));
    State state = start;
    state = field.solve(pose(1), &state);
    EXPECT_TRUE(same_bits(state.phase, start.phase));
    for (int frame = 2; frame < 200; ++frame) state = field.solve(pose(frame), &state);
    EXPECT_FALSE(same_bits(state.phase, start.phase));
}

TEST(WrinkleFieldLaws, RelaxationNeverRaisesTheMisfitAndIsStable) {
    for (const float rate : {0.1f, 0.5f, 0.99f}) {
        Field field(irregular_square());
        field.settings.wavelength = 0.25f;
        field.settings.rate = rate;
        const Waves waves = field.estimate_waves(scaled(field.mesh, {0.5f, 1.0f, 1.0f}));
        std::vector<float> phase = random_phases(*field.model, 0);
        const float start = misfit(*field.model, waves, phase);
        float before = start;
        for (int block = 0; block < 10; ++block) {
            relax(*field.model, field.settings, waves, 20, phase);
            const float after = misfit(*field.model, waves, phase);
            EXPECT_LT(after, before + 1e-3f) << rate;
            before = after;
        }
        EXPECT_LT(before, 0.7f * start);
    }
}

TEST(WrinkleFieldLaws, TheThreadsDoNotMatter) {
    Field field(irregular_square());
    field.settings.irregularity = 0.5f;
    const Pose3 pose = scaled(field.mesh, {0.6f, 0.9f, 1.0f});
    field.settings.threads = 1;
    const State one = field.solve(pose);
    const Picture alone = field.show(pose, one);
    for (const int threads : {2, 3, 8}) {
        field.settings.threads = threads;
        const State many = field.solve(pose);
        EXPECT_TRUE(same_bits(many.phase, one.phase)) << threads;
        EXPECT_TRUE(same_bits(many.direction, one.direction)) << threads;
        EXPECT_TRUE(same_bits(field.show(pose, many).corner_phase, alone.corner_phase)) << threads;
    }
}

TEST(WrinkleFieldLaws, TheOrderOfTheVerticesDoesNotMatter) {
    const MeshData mesh = irregular_square();
    const std::vector<Index> order = shuffled(mesh.positions.size());
    Field field(mesh), other(reordered(mesh, order));
    for (Field* f : {&field, &other}) {
        f->settings.wavelength = 0.25f;
        f->settings.aligned_start =
            false;  // what the alignment makes of nearly equal modes hangs on roundings
        f->settings.start_rounds = 20;
    }
    const auto squeeze = [](const Vec3& p) { return Vec3(0.7f, 0.95f + 0.1f * p.x, 1.0f) * p; };
    const Pose3 pose = moved(mesh, squeeze), other_pose = moved(other.mesh, squeeze);
    const Waves waves = field.estimate_waves(pose), other_waves = other.estimate_waves(other_pose);
    const State state = field.solve(pose), other_state = other.solve(other_pose);
    for (size_t v = 0; v < order.size(); ++v) {
        const size_t w = order[v];
        EXPECT_NEAR(waves.compression[v], other_waves.compression[w], 2e-6f);
        const Vec3 k = field.direction(waves, v), other_k = other.direction(other_waves, w);
        const float sign = glm::dot(k, other_k) < 0.0f ? -1.0f : 1.0f;
        EXPECT_LT(glm::distance(k, sign * other_k), 1e-4f);
        EXPECT_LT(glm::distance(waves.wave_vector[v], sign * other_waves.wave_vector[w]), 5e-3f);
        EXPECT_LT(phase_between(random_phases(*field.model, 3)[v], random_phases(*other.model, 3)[w]), 1e-6f);
    }
    EXPECT_NEAR(misfit(*field.model, waves, state.phase),
                misfit(*other.model, other_waves, other_state.phase), 1e-3f);
}

TEST(WrinkleFieldLaws, SeamsAreWeldedForTheWavesAndOpenForTheEye) {
    Field whole(cube()), split(seam_split_cube());
    const auto squeeze = [](const Vec3& p) { return Vec3(0.7f, 1.0f, 0.95f) * p; };
    const Picture a = whole.show(moved(whole.mesh, squeeze), whole.solve(moved(whole.mesh, squeeze)));
    const Picture b = split.show(moved(split.mesh, squeeze), split.solve(moved(split.mesh, squeeze)));
    EXPECT_EQ(a.positions.size(), 8u);
    EXPECT_EQ(b.positions.size(), 24u);
    ASSERT_EQ(a.corner_weight.size(), b.corner_weight.size());
    for (size_t c = 0; c < a.corner_weight.size(); ++c) {
        EXPECT_LT(glm::distance(a.corner_weight[c], b.corner_weight[c]), 1e-6f);
    }
}

// Equation (5) is continuous: over an edge both triangles give one height, and one gradient.
TEST(WrinkleFieldLaws, TheHeightIsContinuousOverEdges) {
    Field field(tube(12, 8, 0.1f, 0.5f));
    field.settings.wavelength = 0.08f;
    const Pose3 pose = moved(field.mesh, [](const Vec3& p) { return Vec3(0.7f, 1.0f + p.x, 1.0f) * p; });
    const State state = field.solve(pose);
    const Waves waves = field.estimate_waves(pose, state.direction);
    const Surface& base = field.model->base;
    const auto vertex = [&](size_t t, int k) {
        return base.welded.corner_vertex[base.triangles[t].corner[k]];
    };
    const auto at = [&](size_t t, int k, float along) {  // on the edge from corner k to k + 1
        float weight[3] = {0.0f, 0.0f, 0.0f};
        weight[k] = 1.0f - along;
        weight[(k + 1) % 3] = along;
        return evaluate(*field.model, waves, sine(), state.phase, {Index(t), weight[1], weight[2]});
    };
    int shared = 0;
    for (size_t t = 0; t < base.triangles.size(); ++t) {
        for (size_t u = t + 1; u < base.triangles.size(); ++u) {
            for (int k = 0; k < 3; ++k) {
                for (int l = 0; l < 3; ++l) {
                    if (vertex(t, k) != vertex(u, (l + 1) % 3) || vertex(t, (k + 1) % 3) != vertex(u, l))
                        continue;
                    const Height one = at(t, k, 0.3f), other = at(u, l, 0.7f);
                    EXPECT_NEAR(one.height, other.height, 1e-6f);
                    EXPECT_LT(glm::distance(one.gradient, other.gradient), 1e-4f);
                    ++shared;
                }
            }
        }
    }
    EXPECT_GT(shared, 200);
}

// What a shader does with the corner attributes is equation (5).
TEST(WrinkleFieldLaws, InterpolatedCornersGiveTheHeight) {
    Field field(shaken(tube(9, 6, 0.1f, 0.4f), 0.01f, 3));
    field.settings.wavelength = 0.07f;
    const Pose3 pose = moved(field.mesh, [](const Vec3& p) { return Vec3(0.7f, 1.0f + p.x, 1.0f) * p; });
    const State state = field.solve(pose);
    const Picture picture = field.show(pose, state);
    const Waves waves = field.estimate_waves(pose, state.direction);
    for (Index t = 0; t < Index(field.model->base.triangles.size()); ++t) {
        const SurfacePoint place{t, 0.2f, 0.5f};
        const float b[3] = {0.3f, 0.2f, 0.5f};
        Vec3 phase(0.0f), weight(0.0f);
        for (int c = 0; c < 3; ++c) {
            phase += b[c] * picture.corner_phase[3 * t + c];
            weight += b[c] * picture.corner_weight[3 * t + c];
        }
        float height = 0.0f;
        for (int k = 0; k < 3; ++k) height += weight[k] * std::cos(phase[k]);
        EXPECT_NEAR(height, evaluate(*field.model, waves, sine(), state.phase, place).height,
                    2e-3f * field.settings.wavelength);  // the table's 64 intervals, and roundings
    }
}

TEST(WrinkleFieldLaws, TheGeometryIsTheHeightAlongTheNormal) {
    Plan plan;
    plan.output = Output::kGeometry;
    plan.fine.kind = FineSource::Kind::kRegular;
    plan.fine.segments = 5;
    plan.attachment = AttachmentKind::kLinear;
    Field field(irregular_square(), plan);
    field.settings.wavelength = 0.2f;
    const Pose3 pose = scaled(field.mesh, {0.6f, 1.0f, 1.0f});
    const State state = field.solve(pose);
    const Waves waves = field.shown_waves(pose, state);
    const Picture picture = field.show(pose, state);
    ASSERT_EQ(picture.positions.size(), field.model->shown.places.size());
    EXPECT_TRUE(picture.corner_phase.empty());
    for (size_t v = 0; v < picture.positions.size(); ++v) {
        const SurfacePoint& place = field.model->shown.places[v];
        EXPECT_NEAR(picture.positions[v].z, evaluate(*field.model, waves, sine(), state.phase, place).height,
                    1e-6f);
        EXPECT_NEAR(picture.offset[v].z, picture.positions[v].z, 1e-6f);
        EXPECT_NEAR(picture.local_offset[v].z, picture.positions[v].z, 1e-6f);
    }
}

// A smooth surface has the points of an irregular flat mesh elsewhere in its plane; crests stay straight.
TEST(WrinkleFieldLaws, CrestsAreStraightOnTheSmoothSurfaceToo) {
    Plan plan;
    plan.output = Output::kGeometry;
    plan.fine.level = 3;
    Field field(irregular_square(), plan);
    field.settings.wavelength = 0.25f;
    const Pose3 pose = scaled(field.mesh, {0.5f, 1.0f, 1.0f});
    const State state = field.solve(pose);
    const Waves waves = field.shown_waves(pose, state);
    const Picture picture = field.show(pose, state);
    for (const Vec3& p : picture.positions) {
        const float phase = std::abs(waves.wave_vector[0].x) * (p.x - waves.positions[0].x);
        const float sign = waves.wave_vector[0].x < 0.0f ? -1.0f : 1.0f;
        EXPECT_NEAR(p.z, waves.height[0] * std::cos(sign * phase + state.phase[0]), 0.02f * waves.height[0]);
    }
}

TEST(WrinkleFieldLaws, NothingBreaksOnBrokenSurfaces) {
    // A fan of one triangle, collapsed edges, a flipped corner, a fold onto itself, a point.
    for (const MeshData& mesh : bases()) {
        const Field field(mesh);
        for (const Pose3& pose :
             {scaled(mesh, Vec3(0.0f)), scaled(mesh, Vec3(0.0f, 1.0f, 1.0f)),
              scaled(mesh, Vec3(1e-4f, 1.0f, 1.0f)), scaled(mesh, Vec3(-1.0f, 1.0f, 1.0f)),
              moved(mesh, [](const Vec3& p) { return Vec3(std::abs(p.x - 0.3f), p.y, p.z); })}) {
            State state = field.solve(pose);
            state = field.solve(pose, &state);
            const Picture picture = field.show(pose, state);
            for (const float phase : state.phase) EXPECT_TRUE(std::isfinite(phase));
            for (size_t c = 0; c < picture.corner_phase.size(); ++c) {
                EXPECT_TRUE(std::isfinite(glm::length(picture.corner_phase[c])));
                EXPECT_TRUE(std::isfinite(glm::length(picture.corner_weight[c])));
            }
        }
    }
}

TEST(WrinkleFieldLaws, AStateOfAnotherModelCountsAsNone) {
    const Field field(irregular_square()), other(cube());
    const Pose3 pose = scaled(field.mesh, {0.6f, 1.0f, 1.0f});
    const State strange = other.solve(scaled(other.mesh, {0.6f, 1.0f, 1.0f}));
    EXPECT_TRUE(same_bits(field.solve(pose, &strange).phase, field.solve(pose).phase));
}

TEST(WrinkleFieldLaws, TheSeedChoosesAndIrregularityDisturbs) {
    Field field(irregular_square());
    field.settings.wavelength = 0.25f;
    const Pose3 pose = scaled(field.mesh, {0.6f, 1.0f, 1.0f});
    const State first = field.solve(pose);
    EXPECT_TRUE(same_bits(first.phase, field.solve(pose).phase));
    field.settings.seed = 5;
    EXPECT_FALSE(same_bits(first.phase, field.solve(pose).phase));
    const Waves tidy = field.estimate_waves(pose);
    field.settings.irregularity = 1.0f;
    const Waves wild = field.estimate_waves(pose);
    float least = 1.0f;
    for (size_t v = 0; v < tidy.height.size(); ++v) {
        EXPECT_EQ(tidy.compression[v], wild.compression[v]);
        least = std::min(least, std::abs(glm::dot(glm::normalize(tidy.wave_vector[v]),
                                                  glm::normalize(wild.wave_vector[v]))));
    }
    EXPECT_LT(least, 0.98f);
    EXPECT_GT(least, 0.4f);
}

}  // namespace
}  // namespace rumple::tests
