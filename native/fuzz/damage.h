// SPDX-License-Identifier: GPL-3.0-or-later
// Damages states as in a broken file: their arrays are copied and sometimes changed.
#pragma once

#include <cstdint>
#include <list>
#include <vector>

#include "bytes.h"
#include "rumple.h"

namespace rumple::fuzz {

// The arrays of one struct for a function to read. The copies live as long as this object.
class Damage {
  public:
    explicit Damage(Bytes& bytes) : bytes_(bytes) {}

    // array: `count` rows of `columns` values. It becomes a copy, sometimes with a random element, a row
    // less, a row more, no row, or a null pointer with its count.
    template <typename T, typename Count>
    void operator()(const T*& array, Count& count, size_t columns = 1) {
        std::vector<T>& copy = copies(array).emplace_back(array, array + columns * size_t(count));
        const int kind = bytes_.byte();
        if (kind % 8 == 7 && !copy.empty()) copy[bytes_.byte() % copy.size()] = any(T());
        if (kind == 250 && count > 0) --count;
        if (kind == 251) {
            copy.insert(copy.end(), columns, T(0));
            ++count;
        }
        if (kind >= 252 && kind < 254) count = 0;
        array = kind >= 254 ? nullptr : copy.data();
    }

    void operator()(rumple_reference_view& view) {
        static_assert(sizeof view == 9 * 8, "a new array? damage it as well");
        (*this)(view.labels, view.labels_count);
        (*this)(view.reference, view.reference_count, 3);
        (*this)(view.past_times, view.past_times_count);
        (*this)(view.past_positions, view.past_positions_count, 3);
        if (bytes_.hostile()) view.time = double(bytes_.real(-1.0f, 1.0f));
    }

    void operator()(rumple_wrinkle_mesh_state_view& view) {
        static_assert(sizeof view == 14 * 8, "a new array? damage it as well");
        (*this)(view.offset, view.offset_count, 3);
        (*this)(view.solved_length, view.solved_length_count);
        (*this)(view.reference);
    }

  private:
    std::list<std::vector<float>>& copies(const float*) { return floats_; }
    std::list<std::vector<double>>& copies(const double*) { return doubles_; }
    std::list<std::vector<std::int32_t>>& copies(const std::int32_t*) { return numbers_; }
    std::list<std::vector<std::uint8_t>>& copies(const std::uint8_t*) { return labels_; }

    float any(float) { return bytes_.real(-2.0f, 2.0f); }
    double any(double) { return double(bytes_.real(-2.0f, 2.0f)); }
    std::int32_t any(std::int32_t) { return bytes_.whole(-3, 40); }
    std::uint8_t any(std::uint8_t) { return bytes_.byte(); }

    Bytes& bytes_;
    std::list<std::vector<float>> floats_;
    std::list<std::vector<double>> doubles_;
    std::list<std::vector<std::int32_t>> numbers_;
    std::list<std::vector<std::uint8_t>> labels_;
};

}  // namespace rumple::fuzz
