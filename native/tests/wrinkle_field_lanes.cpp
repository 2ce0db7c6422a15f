// SPDX-License-Identifier: GPL-3.0-or-later
// The solver computes four vertices at a time. Each has the bits that it would have alone.
#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <random>

#include "tests/wrinkle_field_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_field;
namespace one = formulas;
namespace four = lane_formulas;

void expect_same_bits(float a, float b) {
    if (std::isnan(a) && std::isnan(b)) return;
    EXPECT_EQ(std::bit_cast<std::uint32_t>(a), std::bit_cast<std::uint32_t>(b)) << a << " and " << b;
}
void expect_same_bits(const Vec2& a, const Vec2& b) {
    for (int i = 0; i < 2; ++i) expect_same_bits(a[i], b[i]);
}
void expect_same_bits(const Vec3& a, const Vec3& b) {
    for (int i = 0; i < 3; ++i) expect_same_bits(a[i], b[i]);
}

// Arguments of every size. Some are zero, so that formulas take each of their choices.
struct Arguments {
    std::mt19937 random{5};

    float number() {
        if (random() % 8 == 0) return random() % 2 ? 0.0f : -0.0f;
        return std::ldexp(float(random()) / 2e9f - 1.0f, int(random() % 12) - 6);
    }
    Lanes numbers() { return Lanes{number(), number(), number(), number()}; }
    Vec2Lanes vec2() { return {numbers(), numbers()}; }
    Vec3Lanes vec3() { return {numbers(), numbers(), numbers()}; }
    four::mat2 mat2() { return {vec2(), vec2()}; }
};

template <typename Check>
void for_many(Check&& check) {
    Arguments arguments;
    for (int i = 0; i < 2000; ++i) check(arguments);
}

TEST(WrinkleFieldLanes, NearestIntegerIsThatOfFloats) {
    const float inf = std::numeric_limits<float>::infinity();
    const auto same = [](const Lanes& x) {
        const Lanes found = four::nearest_integer(x);
        for (int k = 0; k < kLanes; ++k) expect_same_bits(found[k], elementary::nearest_integer(x[k]));
    };
    same(Lanes{0.0f, -0.0f, 0.49999997f, -1e-30f});
    same(Lanes{0x1p23f, -0x1p23f - 1.0f, 1.5f, -1.5f});
    same(Lanes{0x1p31f, -3e38f, inf, std::numeric_limits<float>::quiet_NaN()});
    for_many([&](Arguments& a) { same(1000.0f * a.numbers()); });
}

TEST(WrinkleFieldLanes, CrushIsThatOfOneVertex) {
    for_many([](Arguments& a) {
        const four::mat2 m = a.mat2();
        const Vec2Lanes q = a.vec2(), before = a.vec2(), turn = a.vec2();
        const Vec3Lanes stretch = a.vec3();
        const four::WaveEstimate found = four::estimate_wave(m, q, before, turn, 0.1f);
        const four::mat2 restretched = four::restretched(m, stretch);
        for (int k = 0; k < kLanes; ++k) {
            const one::WaveEstimate expected =
                one::estimate_wave(at_lane(m, k), q.at(k), before.at(k), turn.at(k), 0.1f);
            expect_same_bits(found.r[k], expected.r);
            expect_same_bits(found.fullness[k], expected.fullness);
            expect_same_bits(found.k.at(k), expected.k);
            expect_same_bits(found.k_deformed.at(k), expected.k_deformed);
            const glm::mat2 wanted = one::restretched(at_lane(m, k), stretch.at(k));
            for (int i = 0; i < 2; ++i) expect_same_bits(restretched[i].at(k), wanted[i]);
        }
    });
}

TEST(WrinkleFieldLanes, TangentsAreThoseOfOneVertex) {
    for_many([](Arguments& a) {
        const Vec3Lanes way = a.vec3(), n = a.vec3(), t = a.vec3();
        for (const bool true_lengths : {false, true}) {
            const Vec3Lanes towards = four::tangent_towards(way, n);
            const Vec2Lanes flat = four::tangent_space(way, t, n, true_lengths);
            for (int k = 0; k < kLanes; ++k) {
                expect_same_bits(towards.at(k), one::tangent_towards(way.at(k), n.at(k)));
                expect_same_bits(flat.at(k), one::tangent_space(way.at(k), t.at(k), n.at(k), true_lengths));
            }
        }
    });
}

TEST(WrinkleFieldLanes, RelaxationIsThatOfOneVertex) {
    for_many([](Arguments& a) {
        const Vec3Lanes wave = a.vec3(), other = a.vec3(), way = a.vec3();
        const Lanes phase = a.numbers(), other_phase = a.numbers(), sum = a.numbers(), rate = a.numbers();
        const Lanes count = {0.0f, 1.0f, 5.0f, 6.0f};
        const four::Link link = four::link_waves(wave, other, way);
        const Lanes misfit = four::misfit(link, phase, other_phase);
        const Lanes relaxed = four::relaxed(phase, sum, count, rate), weight = four::attenuation(sum);
        for (int k = 0; k < kLanes; ++k) {
            const one::Link expected = one::link_waves(wave.at(k), other.at(k), way.at(k));
            expect_same_bits(link.flip[k], expected.flip);
            expect_same_bits(link.offset[k], expected.offset);
            expect_same_bits(misfit[k], one::misfit(expected, phase[k], other_phase[k]));
            expect_same_bits(relaxed[k], one::relaxed(phase[k], sum[k], count[k], rate[k]));
            expect_same_bits(weight[k], one::attenuation(sum[k]));
        }
    });
}

// The neighbours of a vertex in the order of its columns.
std::vector<Index> in_columns(const Model& model, size_t v) {
    const NeighbourColumns& columns = model.columns;
    std::vector<Index> found(static_cast<size_t>(columns.count[v / kLanes][v % kLanes]));
    for (size_t k = 0; k < found.size(); ++k)
        found[k] = columns.vertex[size_t(columns.start[v / kLanes]) + k][v % kLanes];
    return found;
}

TEST(WrinkleFieldLanes, ColumnsHaveEveryNeighbourInItsOrder) {
    for (const MeshData& mesh : {irregular_square(), tube(7, 3, 0.1f, 1.0f), cube()}) {
        const Field field(mesh);
        const Model& model = *field.model;
        for (size_t v = 0; v < model.base.positions_rest.size(); ++v) {
            std::vector<Index> expected;
            for (Index i = model.neighbour_start[v]; i < model.neighbour_start[v + 1]; ++i)
                expected.push_back(model.neighbours[i].vertex);
            EXPECT_EQ(in_columns(model, v), expected);
        }
    }
}

// A round of equation (6), one vertex after the other, in the order of its neighbours.
TEST(WrinkleFieldLanes, ARoundHasTheBitsOfOneVertexAfterTheOther) {
    Field field(irregular_square());
    field.paint.mask.assign(field.mesh.positions.size(), 1.0f);  // by it some have no wave
    for (size_t v = 0; v < field.paint.mask.size(); v += 3) field.paint.mask[v] = 0.0f;
    const Waves waves = field.estimate_waves(scaled(field.mesh, {0.7f, 1.0f, 1.0f}));
    const std::vector<float> before = random_phases(*field.model, 3);
    std::vector<float> after = before;
    relax(*field.model, field.settings, waves, 1, after);
    size_t moved = 0;
    for (size_t v = 0; v < before.size(); ++v) {
        float sum = 0.0f;
        const std::vector<Index> neighbours = in_columns(*field.model, v);
        for (const Index n : neighbours) {
            const float weight = one::attenuation(waves.fullness[n]);
            const one::Link link = one::link_waves(waves.wave_vector[v], waves.wave_vector[n],
                                                   waves.positions[n] - waves.positions[v]);
            if (weight > 0.0f) sum += weight * one::misfit(link, before[v], before[n]);
        }
        expect_same_bits(after[v],
                         one::relaxed(before[v], sum, float(neighbours.size()), field.settings.rate));
        moved += after[v] != before[v];
    }
    EXPECT_GT(moved, before.size() / 2);
}

}  // namespace
}  // namespace rumple::tests
