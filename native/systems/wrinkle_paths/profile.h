// SPDX-License-Identifier: GPL-3.0-or-later
// The cross-section of a fold: Gillette 2015, section 6.1.
#pragma once

#include <array>

#include "base/formulas.h"

namespace rumple::wrinkle_paths {

enum class Profile {
    kSpline = formulas::kFoldSpline,
    kQuartic = formulas::kFoldQuartic,
    kCircularArcs = formulas::kFoldCircularArcs,
    kSine = formulas::kFoldSine
};

// A fold in cloth of length s = L_max is L wide and h high. The table gives h / L for a ratio s / L, so that
// the profile's arc length is s. The thesis uses such a table for the circle.
class HeightTable {
  public:
    explicit HeightTable(Profile kind);
    // ratio: s / L, clamped to 1 .. kMostRatio. Linear interpolation; error below 1e-3.
    float height_over_width(float ratio) const;

  private:
    static constexpr int kIntervals = 128;
    std::array<float, kIntervals + 1> ratio_;  // at evenly spaced heights from 0
};
const HeightTable& height_table(Profile kind);

// Limit of the fold's width: L >= s / kMostRatio.
inline constexpr float kMostRatio = 1.5707964f;

}  // namespace rumple::wrinkle_paths
