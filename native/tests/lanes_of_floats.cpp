// SPDX-License-Identifier: GPL-3.0-or-later
// Four floats at a time are four floats: every lane has the bits of plain arithmetic, also where the last
// four are not whole.
#include <gtest/gtest.h>

#include <bit>
#include <random>

#include "base/solve_team.h"

namespace rumple::tests {
namespace {

std::vector<float> wild_numbers(size_t count) {
    std::mt19937 random(3);
    std::vector<float> out{0.0f, -0.0f, 1e-40f, 1e18f};
    while (out.size() < count)
        out.push_back(std::ldexp(float(random()) / 4e9f - 0.5f, int(random() % 60) - 30));
    out.resize(count);
    return out;
}

void expect_same_bits(float a, float b) {
    EXPECT_EQ(std::bit_cast<std::uint32_t>(a), std::bit_cast<std::uint32_t>(b)) << a << " and " << b;
}

std::vector<Vec3> wild_vectors(size_t count) {
    const std::vector<float> x = wild_numbers(3 * count);
    std::vector<Vec3> out;
    for (size_t v = 0; v < count; ++v) out.push_back({x[3 * v], x[3 * v + 1], x[3 * v + 2]});
    return out;
}

TEST(Lanes, RootsAndLimitsAreThoseOfTheStandardLibrary) {
    const std::vector<float> x = wild_numbers(400);
    for (size_t i = 0; i < x.size(); i += kLanes) {
        const Lanes four = load_lanes(&x[i]), root = square_root(four * four);
        const Lanes limited = within(four, all_lanes(-0.3f), all_lanes(0.2f));
        for (size_t k = 0; k < kLanes; ++k) {
            expect_same_bits(root[k], std::sqrt(x[i + k] * x[i + k]));
            expect_same_bits(limited[k], std::clamp(x[i + k], -0.3f, 0.2f));
        }
    }
}

TEST(Lanes, AreVisitedInTheirOrder) {
    for (int bits = 0; bits < 16; ++bits) {
        LaneMask mask{};
        for (int k = 0; k < kLanes; ++k) mask[k] = bits >> k & 1 ? -1 : 0;
        EXPECT_EQ(bits_of(mask), unsigned(bits));
        int found = 0, last = -1;
        for_each_true(mask, [&](int k) {
            EXPECT_GT(k, last);
            last = k;
            found |= 1 << k;
        });
        EXPECT_EQ(found, bits);
    }
}

TEST(Lanes, OfAnyCountAreLoadedAndStoredWithoutWhatLiesBehind) {
    for (size_t count = 0; count < 14; ++count) {
        const std::vector<float> from = wild_numbers(count);
        std::vector<float> to(count + 1, 7.0f);
        for_each_four(count, [&](size_t first, size_t many) {
            store_lanes(load_lanes(&from[first], many), &to[first], many);
        });
        for (size_t i = 0; i < count; ++i) expect_same_bits(to[i], from[i]);
        EXPECT_EQ(to[count], 7.0f);
    }
}

TEST(Lanes, RowsOfAnyCountBecomeColumnsAndRowsAgain) {
    for (size_t count = 0; count < 14; ++count) {
        const std::vector<Vec3> vectors = wild_vectors(count);
        std::vector<Row> rows = to_rows(vectors);
        ASSERT_EQ(rows.size() % kLanes, 0u);
        for (size_t first = 0; first < rows.size(); first += kLanes) {
            const Vec3Lanes four = columns(four_from(rows, first));
            store_rows(four, four_from(rows, first));
            for (size_t k = 0; k < kLanes; ++k) {
                const Vec3 expected = first + k < count ? vectors[first + k] : Vec3(0.0f);
                for (int i = 0; i < 3; ++i) {
                    expect_same_bits(four.at(int(k))[i], expected[i]);
                    expect_same_bits(rows[first + k].vec()[i], expected[i]);
                }
            }
        }
    }
}

TEST(Lanes, ProductsAndSumsAreThoseOfOneVector) {
    const std::vector<Vec3> a = wild_vectors(64), b(a.rbegin(), a.rend());
    std::vector<Row> rows_a = to_rows(a), rows_b = to_rows(b);
    SparseRows map;
    for (size_t first = 0; first < a.size(); first += kLanes) {
        const Vec3Lanes x = columns(four_from(rows_a, first)), y = columns(four_from(rows_b, first));
        const Vec3Lanes crossed = cross(x, y);
        const Lanes dots = dot(x, y);
        for (size_t k = 0; k < kLanes; ++k) {
            expect_same_bits(dots[k], glm::dot(a[first + k], b[first + k]));
            expect_same_bits(dots[k], dot(rows_a[first + k], rows_b[first + k]));
            const Vec3 expected = glm::cross(a[first + k], b[first + k]);
            for (int i = 0; i < 3; ++i) expect_same_bits(crossed.at(int(k))[i], expected[i]);
            map.add(Index(first + k), a[first + k].x);
        }
        map.end_row();
    }
    std::vector<Vec3> plain(size_t(map.rows())), in_rows(plain.size());
    apply<Vec3>(map, a, plain);
    apply(map, rows_a, in_rows);
    for (size_t r = 0; r < plain.size(); ++r)
        for (int i = 0; i < 3; ++i) expect_same_bits(in_rows[r][i], plain[r][i]);
}

}  // namespace
}  // namespace rumple::tests
