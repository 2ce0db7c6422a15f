// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/array.h"

#include <algorithm>
#include <cassert>

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
