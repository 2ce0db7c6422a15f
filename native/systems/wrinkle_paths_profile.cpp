// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_paths_profile.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rumple::wrinkle_paths {
namespace {

double square(double x) {
    return x * x;
}

double profile_at(Profile kind, double x) {
    x = std::abs(x);
    if (x >= 1.0) return 0.0;
    switch (kind) {
        case Profile::kSpline:  // three quadratic pieces (figure 6.3), uniform knots at -1, -1/3, 1/3, 1
            return x < 1.0 / 3.0 ? 1.0 - 3.0 * square(x) : 1.5 * square(1.0 - x);
        case Profile::kQuartic:
            return square(1.0 - square(x));
        case Profile::kCircularArcs:  // two parabolas are the arcs of a flat fold: equal curvature up and
                                      // down
            return x < 0.5 ? 1.0 - 2.0 * square(x) : 2.0 * square(1.0 - x);
        case Profile::kSine:
            return 0.5 * (1.0 + std::cos(std::numbers::pi * x));
    }
    return 0.0;
}

// Arc length over width of a fold h / L high.
double arc_over_width(Profile kind, double height_over_width) {
    constexpr int kSteps = 2048;
    double sum = 0.0;
    for (int i = 0; i < kSteps; ++i) {
        const double rise = profile_at(kind, (i + 1.0) / kSteps) - profile_at(kind, double(i) / kSteps);
        sum += std::hypot(0.5 / kSteps, height_over_width * rise);
    }
    return 2.0 * sum;
}

// Every profile is longer than kMostRatio times its width when it is this high over its width.
constexpr double kHighest = 0.75;

}  // namespace

float profile(Profile kind, float x) {
    return float(profile_at(kind, x));
}

HeightTable::HeightTable(Profile kind) {
    for (int i = 0; i <= kIntervals; ++i) ratio_[i] = float(arc_over_width(kind, kHighest * i / kIntervals));
}

float HeightTable::height_over_width(float ratio) const {
    ratio = std::clamp(ratio, 1.0f, kMostRatio);
    const auto above = std::upper_bound(ratio_.begin(), ratio_.end(), ratio);
    const int i = std::clamp(int(above - ratio_.begin()) - 1, 0, kIntervals - 1);
    // Length grows with the square of a small height, so squares of heights are mixed.
    const float share = (ratio - ratio_[i]) / (ratio_[i + 1] - ratio_[i]);
    const float low = float(i * i), high = float((i + 1) * (i + 1));
    return float(kHighest) / kIntervals * std::sqrt(low + std::max(share, 0.0f) * (high - low));
}

const HeightTable& height_table(Profile kind) {
    static const std::array<HeightTable, 4> tables{
        HeightTable(Profile::kSpline), HeightTable(Profile::kQuartic), HeightTable(Profile::kCircularArcs),
        HeightTable(Profile::kSine)};
    return tables[size_t(kind)];
}

float circle_half_angle(float ratio) {
    if (ratio <= 1.0f) return 0.0f;
    double phi = std::numbers::pi;
    for (int i = 0; i < 32; ++i) {
        const double change = (std::sin(phi) - phi / ratio) / (std::cos(phi) - 1.0 / ratio);  // (6.1)
        phi -= change;
        if (std::abs(change) < 1e-12) break;
    }
    return float(phi);
}

float circle_height_over_width(float ratio) {
    const double phi = circle_half_angle(ratio);
    if (phi <= 0.0) return 0.0f;
    return float((1.0 - std::cos(phi)) / (2.0 * std::sin(phi)));  // radius (1 - cos), chord 2 radius sin
}

}  // namespace rumple::wrinkle_paths
