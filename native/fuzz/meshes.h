// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes and poses of the fuzzer, valid and broken.
#pragma once

#include <cstdint>
#include <vector>

#include "bytes.h"

namespace rumple::fuzz {

struct Mesh {
    std::vector<float> positions;  // (n, 3)
    std::vector<std::int32_t> start{0};
    std::vector<std::int32_t> corner;
    std::vector<std::int32_t> triangle;  // (t, 3): corners
};

// A sheet, a tube, a box, a fan, and so on; sometimes with an error.
Mesh mesh(Bytes& bytes);

// (n, 3): a pose from positions at rest: compressed, bent, or with one vertex far away.
std::vector<float> pose_of(const std::vector<float>& rest, Bytes& bytes);

// `count` values from low to high.
std::vector<float> values(size_t count, float low, float high, Bytes& bytes);

}  // namespace rumple::fuzz
