// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/array.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstdint>
#include <string>
#include <unordered_map>

#include "base/stop.h"

namespace rumple {

SparseRows identity_rows(Index count) {
    SparseRows rows;
    for (Index r = 0; r < count; ++r) {
        rows.add(r, 1.0f);
        rows.end_row();
    }
    return rows;
}

Index ShiftedRows::columns() const {
    Index out = 0;
    for (Index r = 0; r < rows(); ++r) {
        for (Index k = different.start[alike[r]]; k < different.start[alike[r] + 1]; ++k)
            out = std::max(out, first[r] + different.index[k] + 1);
    }
    return out;
}

ShiftedRows find_alike(const SparseRows& rows) {
    ShiftedRows out;
    out.first.reserve(size_t(rows.rows()));
    out.alike.reserve(size_t(rows.rows()));
    std::unordered_map<std::string, Index> known;  // the bytes of a shifted row -> its number
    std::string bytes;
    for (Index r = 0; r < rows.rows(); ++r) {
        stop_if_asked(size_t(r));
        const auto begin = rows.index.begin() + rows.start[r], end = rows.index.begin() + rows.start[r + 1];
        const Index first = begin == end ? 0 : *std::min_element(begin, end);
        bytes.clear();
        for (Index k = rows.start[r]; k < rows.start[r + 1]; ++k) {
            const std::array<std::uint32_t, 2> entry{std::uint32_t(rows.index[k] - first),
                                                     std::bit_cast<std::uint32_t>(rows.weight[k])};
            bytes.append(reinterpret_cast<const char*>(entry.data()), sizeof(entry));
        }
        const auto [at, is_new] = known.try_emplace(bytes, out.different.rows());
        if (is_new) {
            for (Index k = rows.start[r]; k < rows.start[r + 1]; ++k)
                out.different.add(rows.index[k] - first, rows.weight[k]);
            out.different.end_row();
        }
        out.first.push_back(first);
        out.alike.push_back(at->second);
    }
    out.different.fit();
    return out;
}

SparseRows compose(const SparseRows& outer, const SparseRows& inner) {
    Index columns = 0;
    for (Index column : inner.index) columns = std::max(columns, column + 1);

    SparseRows product;
    product.start.reserve(outer.start.size());
    // One dense accumulator for all rows. `touched` lists its entries in use. Sums are in double precision,
    // so that rounding errors do not grow in long chains of compositions.
    std::vector<double> sum(columns, 0.0);
    std::vector<char> seen(columns, 0);
    std::vector<Index> touched;
    for (Index r = 0; r < outer.rows(); ++r) {
        stop_if_asked(std::size_t(r));
        touched.clear();
        for (Index k = outer.start[r]; k < outer.start[r + 1]; ++k) {
            const Index middle = outer.index[k];
            assert(middle >= 0 && middle < inner.rows());
            for (Index j = inner.start[middle]; j < inner.start[middle + 1]; ++j) {
                const Index column = inner.index[j];
                if (!seen[column]) {
                    seen[column] = 1;
                    touched.push_back(column);
                }
                sum[column] += static_cast<double>(outer.weight[k]) * inner.weight[j];
            }
        }
        std::sort(touched.begin(), touched.end());
        for (Index column : touched) {
            const float weight = static_cast<float>(sum[column]);
            if (weight != 0.0f) product.add(column, weight);
            sum[column] = 0.0;
            seen[column] = 0;
        }
        product.end_row();
    }
    return product;
}

}  // namespace rumple
