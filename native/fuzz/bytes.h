// SPDX-License-Identifier: GPL-3.0-or-later
// Reads values from the fuzzer's bytes: mostly valid numbers, and sometimes numbers that no caller should
// give. After the last byte all values are valid, so a short input is complete.
#pragma once

#include <stddef.h>

#include <cstdint>
#include <limits>
#include <vector>

namespace rumple::fuzz {

inline constexpr float kHostileReals[] = {std::numeric_limits<float>::quiet_NaN(),
                                          std::numeric_limits<float>::infinity(),
                                          -std::numeric_limits<float>::infinity(),
                                          -1.0f,
                                          0.0f,
                                          1e-30f,
                                          1e9f,
                                          1e14f,
                                          1e20f,
                                          std::numeric_limits<float>::max()};
inline constexpr std::int32_t kHostileNumbers[] = {-1, std::numeric_limits<std::int32_t>::min(),
                                                   std::numeric_limits<std::int32_t>::max(), 1'000'001};

class Bytes {
  public:
    Bytes(const std::uint8_t* data, size_t size) : at_(data), end_(data + size) {}

    bool empty() const { return at_ == end_; }
    std::uint8_t byte() { return empty() ? 0 : *at_++; }
    // 0..count - 1.
    int below(int count) { return count > 0 ? byte() % count : 0; }
    bool hostile() { return byte() >= 250; }

    float real(float low, float high) {
        const int b = byte();
        constexpr int kGood = 256 - int(std::size(kHostileReals));
        return b >= kGood ? kHostileReals[b - kGood] : low + (high - low) * float(b) / float(kGood - 1);
    }
    std::int32_t whole(std::int32_t low, std::int32_t high) {
        const int b = byte();
        constexpr int kGood = 256 - int(std::size(kHostileNumbers));
        return b >= kGood ? kHostileNumbers[b - kGood] : low + b % (high - low + 1);
    }

    // In half of the cases, changes up to three fields of a struct with default values.
    template <typename... Fields>
    void vary(Fields&... fields) {
        for (int changes = below(8) - 4; changes > 0; --changes) {
            int left = below(sizeof...(fields));
            ((left-- == 0 ? change(fields) : void()), ...);
        }
    }

  private:
    void change(float& field) {
        constexpr float kSome[] = {0.0f, 0.01f, 0.1f, 0.3f, 0.5f, 0.9f, 1.0f, 2.0f, 10.0f, 100.0f};
        const int b = byte();
        field = b >= 224 ? kHostileReals[b % std::size(kHostileReals)] : kSome[b % std::size(kSome)];
    }
    void change(double& field) {
        float value = 0.0f;
        change(value);
        field = double(value);
    }
    void change(std::int32_t& field) { field = whole(0, 8); }
    void change(std::uint32_t& field) { field = std::uint32_t(byte()) * 0x01010101u; }
    void change(bool& field) { field = byte() % 2 == 1; }
    void change(float (&field)[3]) {
        for (float& value : field) value = real(-2.0f, 2.0f);
    }

    const std::uint8_t* at_;
    const std::uint8_t* end_;
};

}  // namespace rumple::fuzz
