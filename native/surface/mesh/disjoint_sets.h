// SPDX-License-Identifier: GPL-3.0-or-later
// Union-find whose roots are the lowest members: the result does not depend on
// the order of unions. Internal to surface.
#pragma once

#include <algorithm>
#include <numeric>

#include "base/array.h"

namespace rumple {

class DisjointSets {
  public:
    explicit DisjointSets(Index count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }

    Index find(Index i) {
        while (parent_[i] != i) {
            parent_[i] = parent_[parent_[i]];
            i = parent_[i];
        }
        return i;
    }
    // The root of every member.
    std::vector<Index> roots() {
        std::vector<Index> out(parent_.size());
        for (size_t i = 0; i < out.size(); ++i) out[i] = find(static_cast<Index>(i));
        return out;
    }
    void unite(Index i, Index j) {
        i = find(i);
        j = find(j);
        parent_[std::max(i, j)] = std::min(i, j);
    }

  private:
    std::vector<Index> parent_;
};

}  // namespace rumple
