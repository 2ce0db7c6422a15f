// SPDX-License-Identifier: GPL-3.0-or-later
// What a solve shares out among threads: its team, and loops over items that are computed each by itself.
#pragma once

#include <algorithm>
#include <atomic>
#include <optional>
#include <vector>

#include "base/lanes.h"
#include "base/parallel.h"

namespace rumple {

// That a size asks for: more wait for one another, and for memory.
inline constexpr int kMostThreads = 8;

// The team of a solve. While it lives, for_each_part() shares out what the thread that made it does, however
// deep in calls.
class SolveTeam {
  public:
    // asked: how many threads; 0: one below `least_items`, else those of this machine, at most kMostThreads.
    // Inside of another one it is that one.
    SolveTeam(int asked, size_t items, size_t least_items) {
        if (current_) return;
        team_.emplace(choose_threads(asked, items, least_items, kMostThreads));
        asked_ = asked > 0;
        current_ = this;
    }
    SolveTeam(const SolveTeam&) = delete;
    SolveTeam& operator=(const SolveTeam&) = delete;
    ~SolveTeam() {
        if (team_) current_ = nullptr;
    }

    // Of this thread, where sharing so many items is worth it (where a number was asked for it always is), or
    // none.
    static Team* for_items(size_t items, size_t least_items) {
        if (!current_ || current_->team_->threads() < 2) return nullptr;
        Team& team = *current_->team_;
        return current_->asked_ || (items >= least_items && !team.is_crowded()) ? &team : nullptr;
    }

  private:
    static inline thread_local SolveTeam* current_ = nullptr;

    std::optional<Team> team_;  // none inside of another one
    bool asked_ = false;
};

// So many items are worth sharing out: steps of some nanoseconds, and searches of about a microsecond.
inline constexpr size_t kLeastSteps = 2'000;
inline constexpr size_t kLeastSearches = 200;

// work(begin, end) for parts of [0, count) that begin at multiples of `step`: one part, or several where
// there are least_items and this thread has a team. Every item is computed by itself, so that the number of
// threads changes no bit. What work throws is thrown here.
template <size_t step = kLanes, typename Work>
void for_each_part(size_t count, size_t least_items, Work&& work) {
    Team* const team = SolveTeam::for_items(count, least_items);
    if (!team) {
        if (count > 0) work(size_t(0), count);
        return;
    }
    // Every member has the same stretch in every loop, which its processor still holds from the loop before;
    // what it has not begun is taken by those that have ended theirs.
    constexpr size_t kPartsOfMember = 8;
    struct alignas(64) Left {  // a line of the cache
        std::atomic<size_t> next;
        size_t end;
    };
    const int members = team->threads();
    std::vector<Left> left(static_cast<size_t>(members));
    for (int m = 0; m < members; ++m) {
        const Team::Range steps = team->partition(0, (count + step - 1) / step, m);
        left[size_t(m)].next = step * steps.begin;
        left[size_t(m)].end = std::min(step * steps.end, count);
    }
    const size_t part = (count / (kPartsOfMember * size_t(members)) / step + 1) * step;
    team->share([&](int member) {
        for (int k = 0; k < members; ++k) {
            Left& from = left[size_t((member + k) % members)];
            for (size_t begin = from.next.fetch_add(part); begin < from.end;
                 begin = from.next.fetch_add(part))
                work(begin, std::min(begin + part, from.end));
        }
    });
}

// work(i) for every i below count, as for_each_part() shares it out.
template <typename Work>
void for_each_index(size_t count, size_t least_items, Work&& work) {
    for_each_part(count, least_items, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) work(i);
    });
}

// The same of few items that each take long.
template <typename Work>
void for_each_block(size_t count, size_t least_items, Work&& work) {
    for_each_part<1>(count, least_items, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) work(i);
    });
}

// for_each_four() of lanes.h, as for_each_part() shares it out.
template <typename Act>
void for_each_four_shared(size_t count, Act&& act) {
    for_each_part(count, kLeastSteps, [&](size_t begin, size_t end) {
        for_each_four(end - begin, [&](size_t first, auto how_many) { act(begin + first, how_many); });
    });
}

// out[r] = sum of weight x values[index] over row r. values: of to_rows().
inline void apply(const SparseRows& rows, std::span<const Row> values, std::span<Vec3> out) {
    for_each_index(out.size(), kLeastSteps,
                   [&](size_t r) { out[r] = Row(weighted_sum(rows, static_cast<Index>(r), values)).vec(); });
}

}  // namespace rumple
