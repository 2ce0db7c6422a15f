// SPDX-License-Identifier: GPL-3.0-or-later
// The array types that all parts exchange: indices, vectors, sparse rows (CSR).
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace rumple {

using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
using Index = std::int32_t;

inline constexpr Index kNone = -1;

// Releases the memory that vectors took in advance while they grew: up to half of theirs. For data that
// stays.
void fit(auto&... vectors) {
    (vectors.shrink_to_fit(), ...);
}

// Rows of a sparse matrix (CSR). Row r owns entries [start[r], start[r + 1]).
// Used for every linear map between meshes: subdivision stencils, barycentric
// interpolation, painted weights. Evaluate with apply().
struct SparseRows {
    std::vector<Index> start{0};
    std::vector<Index> index;
    std::vector<float> weight;

    Index rows() const { return static_cast<Index>(start.size()) - 1; }

    void add(Index column, float value) {
        index.push_back(column);
        weight.push_back(value);
    }
    void end_row() { start.push_back(static_cast<Index>(index.size())); }
    // A copy of row r of other rows.
    void append_row(const SparseRows& from, Index r) {
        for (Index k = from.start[r]; k < from.start[r + 1]; ++k) add(from.index[k], from.weight[k]);
        end_row();
    }
    void fit() { rumple::fit(start, index, weight); }
};

// Rows that are alike but for a shift of their columns, as those of the corners of subdivided polygons. A row
// has 8 bytes, and different ones have their entries once.
struct ShiftedRows {
    std::vector<Index> first;  // per row: its lowest column
    std::vector<Index> alike;  // per row: its row of `different`
    SparseRows different;      // their columns minus the lowest one

    Index rows() const { return static_cast<Index>(first.size()); }
    // 1 + the highest column; 0 without entries.
    Index columns() const;
};

// The same rows. Cost: about 50 ns per row.
ShiftedRows find_alike(const SparseRows& rows);

// Row r: column r with weight 1.
SparseRows identity_rows(Index count);

// out[r] = sum of weight * values[index] over row r. values is indexed by column and must cover every column.
// Cost: one multiply-add per entry.
template <typename T>
void apply(const SparseRows& rows, std::span<const T> values, std::span<T> out) {
    for (Index r = 0; r < rows.rows(); ++r) {
        T sum{};
        for (Index k = rows.start[r]; k < rows.start[r + 1]; ++k) {
            sum += rows.weight[k] * values[rows.index[k]];
        }
        out[r] = sum;
    }
}

// The matrix product outer * inner: it applies first inner, then outer. Entries of one column are added up,
// and exact zeros are dropped. The columns of a row are ascending.
SparseRows compose(const SparseRows& outer, const SparseRows& inner);

}  // namespace rumple
