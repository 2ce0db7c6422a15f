// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numbers>

#include "base/elementary.h"

namespace rumple {
namespace {

// Numbers between low and high, the same on every system.
class Numbers {
  public:
    double between(double low, double high) {
        state_ = state_ * 6364136223846793005u + 1442695040888963407u;
        return low + (high - low) * (double(state_ >> 11) * 0x1p-53);
    }

  private:
    std::uint64_t state_ = 1;
};

// least: sines and cosines near zero are looked at as if they were so large, for there MinGW's own are wrong.
double units_off(double got, double expected, double least = 0.0) {
    const double size = std::max(std::abs(expected), least);
    return std::abs(got - expected) / (std::nextafter(size, std::numeric_limits<double>::infinity()) - size);
}

// The system's own functions are within a unit of the true value, or two.
constexpr double kOfTheSystem = 2.0;

TEST(Elementary, AreAsNearToTheTruthAsTheirHeaderSays) {
    Numbers numbers;
    for (int i = 0; i < 200000; ++i) {
        const double x = numbers.between(-100.0, 100.0), y = numbers.between(-100.0, 100.0);
        const double base = numbers.between(0.01, 3.0), power = numbers.between(-5.0, 5.0);
        ASSERT_LE(units_off(elementary::sin(x), std::sin(x), 0.01), 2.0 + kOfTheSystem) << x;
        ASSERT_LE(units_off(elementary::cos(x), std::cos(x), 0.01), 2.0 + kOfTheSystem) << x;
        ASSERT_LE(units_off(elementary::exp(x), std::exp(x)), 2.0 + kOfTheSystem) << x;
        ASSERT_LE(units_off(elementary::log(base), std::log(base)), 2.0 + kOfTheSystem) << base;
        ASSERT_LE(units_off(elementary::atan2(y, x), std::atan2(y, x)), 5.0 + kOfTheSystem) << y << " " << x;
        ASSERT_LE(units_off(elementary::hypot(x, y), std::hypot(x, y)), 2.0 + kOfTheSystem) << x << " " << y;
        ASSERT_LE(units_off(elementary::pow(base, power), std::pow(base, power)),
                  3.0 * (1.0 + std::abs(power * std::log(base))) + kOfTheSystem)
            << base << " " << power;
    }
}

TEST(Elementary, AtTheirEdges) {
    using std::numbers::pi;
    EXPECT_EQ(elementary::sin(0.0), 0.0);
    EXPECT_EQ(elementary::cos(0.0), 1.0);
    EXPECT_EQ(elementary::exp(0.0), 1.0);
    EXPECT_EQ(elementary::log(1.0), 0.0);
    EXPECT_EQ(elementary::pow(0.7, 0.0), 1.0);
    EXPECT_EQ(elementary::exp(1000.0), std::numeric_limits<double>::infinity());
    EXPECT_EQ(elementary::exp(-1000.0), 0.0);
    EXPECT_TRUE(std::isnan(elementary::exp(std::numeric_limits<double>::quiet_NaN())));
    for (const double y : {0.0, -0.0}) {
        for (const double x : {0.0, -0.0, 1.0, -1.0}) {
            EXPECT_EQ(elementary::atan2(y, x), std::atan2(y, x));
            EXPECT_EQ(std::signbit(elementary::atan2(y, x)), std::signbit(std::atan2(y, x)));
        }
    }
    EXPECT_EQ(elementary::atan2(1.0, 0.0), pi / 2.0);
    EXPECT_NEAR(elementary::sin(1e6 * pi), 0.0, 1e-9);
    EXPECT_LE(std::abs(elementary::sin(1e300)), 1.0);
    for (int quarter = -8; quarter <= 8; ++quarter) {
        const double angle = quarter * pi / 2.0;
        EXPECT_NEAR(elementary::sin(angle), std::sin(angle), 1e-16);
        EXPECT_NEAR(elementary::cos(angle), std::cos(angle), 1e-16);
    }
}

TEST(Elementary, NearestIntegerIsThatOfTheSystem) {
    Numbers numbers;
    for (int i = 0; i < 100000; ++i) {
        const float exponent = float(numbers.between(-3.0, 40.0)), sign = i % 2 ? 1.0f : -1.0f;
        const float x = sign * std::exp2(exponent);
        EXPECT_EQ(elementary::nearest_integer(x), std::nearbyint(x)) << x;
        EXPECT_EQ(elementary::nearest_integer(std::round(x)), std::round(x)) << x;
    }
    const float infinite = std::numeric_limits<float>::infinity();
    for (const float x :
         {0.0f, -0.0f, 1.0f, -1.0f, 0.5f, -0.5f, 1.5f, -2.5f, 0.49999997f, 0.99999994f, -0.99999994f,
          0x1p-149f, -0x1p-149f, 0x1p23f, -0x1p23f, 8388607.5f, -8388607.5f, infinite, -infinite})
        EXPECT_EQ(elementary::nearest_integer(x), std::nearbyint(x)) << x;
    EXPECT_TRUE(std::isnan(elementary::nearest_integer(std::numeric_limits<float>::quiet_NaN())));
}

// What is written here is what every compiler on every system must get.
TEST(Elementary, HaveTheSameBitsOnEverySystem) {
    Numbers numbers;
    std::uint64_t hash = 14695981039346656037u;
    const auto add = [&](double value) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &value, sizeof bits);
        hash = (hash ^ bits) * 1099511628211u;
    };
    for (int i = 0; i < 100000; ++i) {
        const double x = numbers.between(-50.0, 50.0), y = numbers.between(-3.0, 3.0);
        for (const double value :
             {elementary::sin(x), elementary::cos(x), elementary::exp(x), elementary::log(std::abs(x)),
              elementary::atan2(y, x), elementary::pow(std::abs(x), y), elementary::hypot(x, y)})
            add(value);
        add(double(elementary::sin(float(x))));
    }
    EXPECT_EQ(hash, 2037234479872521511u);
}

}  // namespace
}  // namespace rumple
