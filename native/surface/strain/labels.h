// SPDX-License-Identifier: GPL-3.0-or-later
// What a triangle is doing: Gillette 2015, section 4.1.2.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "surface/mesh/triangle_net.h"
#include "surface/strain/flat_triangle.h"

namespace rumple {

// In the order in which the label costs are distances on a line.
enum Label : std::uint8_t { kCompress = 0, kRest = 1, kStretch = 2 };
using Labels = std::vector<std::uint8_t>;

// B(l, l') = kLabelStep |l - l'|: 0.2 next to rest, 0.4 between compress and stretch.
inline constexpr double kLabelStep = 0.2;

using LabelCosts = std::array<double, 3>;  // A(i, C), A(i, R), A(i, S)

// Equations 4.4 to 4.7 of the change since a while ago; 4.5 as docs/wrinkle_paths.md reads it. Nothing is
// known of a triangle without area: it costs nothing to rest.
LabelCosts label_costs(const Stretch& change);
// ... 4.5 as it is printed. For tests.
LabelCosts label_costs_printed(const Stretch& change);

// The labels of least sum (eq. 4.3) over frames x triangles, exactly: one minimum cut. costs: frame after
// frame. before: labels of the frame before the first, fixed; or none. Of several optima the one with the
// lowest labels everywhere: it does not depend on the order of triangles. Costs are rounded to 2^-16. Cost:
// about 0.5 ms for one frame of 3,000 triangles.
Labels cut_labels(const TriangleNet& net, std::span<const LabelCosts> costs,
                  std::span<const std::uint8_t> before);

// The labels of a clip of any length: in one cut up to kMostInCut triangles x frames, which take about 250
// MB. A longer clip in pieces that go on from one another's labels; each sees kFramesAhead frames of the
// next, so it has twice as many at least: 30 KB a triangle. Throws std::bad_alloc.
inline constexpr size_t kMostInCut = 500'000;
inline constexpr size_t kFramesAhead = 30;
Labels cut_clip(const TriangleNet& net, std::span<const LabelCosts> costs, size_t most_in_cut = kMostInCut);

// The cheapest label of every node for itself (figure 4.1, middle): to see what the cut does.
Labels cheapest_labels(std::span<const LabelCosts> costs);

// The sum of eq. 4.3 for given labels.
double label_energy(const TriangleNet& net, std::span<const LabelCosts> costs,
                    std::span<const std::uint8_t> before, std::span<const std::uint8_t> labels);

}  // namespace rumple
