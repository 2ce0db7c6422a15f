// SPDX-License-Identifier: GPL-3.0-or-later
// Labels of triangles, which compress, rest or stretch: Gillette 2015, section 4.1.2.
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

// Equations 4.4 to 4.7 for the change within the window. docs/wrinkle_paths.md explains how we read 4.5. The
// change of a triangle without area is unknown, so its label `rest` costs nothing.
LabelCosts label_costs(const Stretch& change);

// The labels with the least sum (eq. 4.3) over frames x triangles. They are exact: one minimum cut. costs:
// frame by frame. before: the fixed labels of the frame before the first; or none. Of several optima it
// returns the one with the lowest labels everywhere, so the result does not depend on the order of triangles.
// Costs are rounded to 2^-16. Cost: about 0.5 ms for one frame of 3,000 triangles.
Labels cut_labels(const TriangleNet& net, std::span<const LabelCosts> costs,
                  std::span<const std::uint8_t> before);

// The labels of a clip of any length. Up to kMostInCut triangles x frames are labelled in one cut, which
// takes about 250 MB. A longer clip is cut in pieces, each of which starts from the labels of the one before.
// A piece also contains the first kFramesAhead frames of the next one, so it has at least twice as many
// frames: 30 KB per triangle. Throws std::bad_alloc.
inline constexpr size_t kMostInCut = 500'000;
inline constexpr size_t kFramesAhead = 30;
Labels cut_clip(const TriangleNet& net, std::span<const LabelCosts> costs, size_t most_in_cut = kMostInCut);

// The cheapest label of every node independently (figure 4.1, middle). It shows the effect of the cut.
Labels cheapest_labels(std::span<const LabelCosts> costs);

// The sum of eq. 4.3 for the given labels.
double label_energy(const TriangleNet& net, std::span<const LabelCosts> costs,
                    std::span<const std::uint8_t> before, std::span<const std::uint8_t> labels);

}  // namespace rumple
