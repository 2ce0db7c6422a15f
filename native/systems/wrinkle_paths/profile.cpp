// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_paths/profile.h"

#include <algorithm>
#include <cmath>

#include "base/elementary.h"

namespace rumple::wrinkle_paths {
namespace {

// Arc length / width of a fold with this height / width.
double arc_over_width(Profile kind, double height_over_width) {
    constexpr int kSteps = 2048;
    double sum = 0.0;
    for (int i = 0; i < kSteps; ++i) {
        const double rise = formulas::fold_profile(int(kind), float(i + 1) / kSteps).height -
                            formulas::fold_profile(int(kind), float(i) / kSteps).height;
        sum += elementary::hypot(0.5 / kSteps, height_over_width * rise);
    }
    return 2.0 * sum;
}

// At this height / width, the arc length of every profile is more than kMostRatio times its width.
constexpr double kHighest = 0.75;

}  // namespace

HeightTable::HeightTable(Profile kind) {
    for (int i = 0; i <= kIntervals; ++i) ratio_[i] = float(arc_over_width(kind, kHighest * i / kIntervals));
}

float HeightTable::height_over_width(float ratio) const {
    ratio = std::clamp(ratio, 1.0f, kMostRatio);
    const auto above = std::upper_bound(ratio_.begin(), ratio_.end(), ratio);
    const int i = std::clamp(int(above - ratio_.begin()) - 1, 0, kIntervals - 1);
    // For small heights the length grows with the square of the height, so squares are interpolated.
    const float fraction = (ratio - ratio_[i]) / (ratio_[i + 1] - ratio_[i]);
    const float low = float(i * i), high = float((i + 1) * (i + 1));
    return float(kHighest) / kIntervals * std::sqrt(low + std::max(fraction, 0.0f) * (high - low));
}

const HeightTable& height_table(Profile kind) {
    static const std::array<HeightTable, 4> tables{
        HeightTable(Profile::kSpline), HeightTable(Profile::kQuartic), HeightTable(Profile::kCircularArcs),
        HeightTable(Profile::kSine)};
    return tables[size_t(kind)];
}

}  // namespace rumple::wrinkle_paths
