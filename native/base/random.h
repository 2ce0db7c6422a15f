// SPDX-License-Identifier: GPL-3.0-or-later
// Pseudo-random numbers that depend only on their arguments.
#pragma once

#include <cstdint>

namespace rumple {

// Every bit of the result depends on all bits of x. Source: the two-round hash with the least bias from C.
// Wellons' hash prospector (public domain).
inline std::uint32_t mixed_bits(std::uint32_t x) {
    x = (x ^ (x >> 16)) * 0x21F0AAADu;
    x = (x ^ (x >> 15)) * 0x735A2D97u;
    return x ^ (x >> 15);
}

inline std::uint32_t hashed(std::uint32_t seed, std::uint32_t value) {
    return mixed_bits(value * 0x9E3779B9u ^ (seed + 0x7F4A7C15u) * 0x85EBCA6Bu);
}

// A number in [-1, 1].
inline float noise(std::uint32_t seed, std::uint32_t value) {
    return static_cast<float>(hashed(seed, value) >> 8) / 8388607.5f - 1.0f;
}

}  // namespace rumple
