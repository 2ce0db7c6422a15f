// SPDX-License-Identifier: GPL-3.0-or-later
// The team of threads of a solve, and loops over items that are computed independently.
#pragma once

#include <algorithm>
#include <atomic>
#include <optional>
#include <vector>

#include "base/lanes.h"
#include "base/parallel.h"

namespace rumple {

// Largest number of threads that is chosen by size. More threads would wait for one another, and for memory.
inline constexpr int kMostThreads = 8;

// The team of a solve. During its lifetime, for_each_part() shares out the loops of the thread that made it,
// at any depth of calls.
class SolveTeam {
  public:
    // asked: the number of threads. 0: one thread below `least_items`, else the number of this machine's
    // threads, at most kMostThreads. Inside of another SolveTeam it uses that one's team.
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

    // The team of this thread if sharing this number of items is worth it, else none. It is always worth it
    // if a number of threads was asked for.
    static Team* for_items(size_t items, size_t least_items) {
        if (!current_ || current_->team_->threads() < 2) return nullptr;
        Team& team = *current_->team_;
        return current_->asked_ || (items >= least_items && !team.is_crowded()) ? &team : nullptr;
    }

  private:
    static inline thread_local SolveTeam* current_ = nullptr;

    std::optional<Team> team_;  // none inside of another SolveTeam
    bool asked_ = false;
};

// Least numbers of items that are worth sharing: steps of some nanoseconds, and searches of about a
// microsecond.
inline constexpr size_t kLeastSteps = 2'000;
inline constexpr size_t kLeastSearches = 200;

// Calls work(begin, end) for parts of [0, count) that begin at multiples of `step`. There is one part, or
// several if there are at least least_items items and this thread has a team. Every item is computed
// independently, so the number of threads changes no bit. An exception of work is thrown here.
template <size_t step = kLanes, typename Work>
void for_each_part(size_t count, size_t least_items, Work&& work) {
    Team* const team = SolveTeam::for_items(count, least_items);
    if (!team) {
        if (count > 0) work(size_t(0), count);
        return;
    }
    // Every member has the same range in every loop, so its processor still has the data of the loop before
    // in its cache. Members that have finished their range take parts that others have not begun.
    constexpr size_t kPartsOfMember = 8;
    struct alignas(64) Left {  // one cache line
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

// Calls work(i) for every i below count, shared out like for_each_part().
template <typename Work>
void for_each_index(size_t count, size_t least_items, Work&& work) {
    for_each_part(count, least_items, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) work(i);
    });
}

// The same for a few items that each take long.
template <typename Work>
void for_each_block(size_t count, size_t least_items, Work&& work) {
    for_each_part<1>(count, least_items, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) work(i);
    });
}

// for_each_four() of lanes.h, shared out like for_each_part().
template <typename Act>
void for_each_four_shared(size_t count, Act&& act) {
    for_each_part(count, kLeastSteps, [&](size_t begin, size_t end) {
        for_each_four(end - begin, [&](size_t first, auto how_many) { act(begin + first, how_many); });
    });
}

// out[r] = sum of weight * values[index] over row r. values: from to_rows().
inline void apply(const SparseRows& rows, std::span<const Row> values, std::span<Vec3> out) {
    for_each_index(out.size(), kLeastSteps,
                   [&](size_t r) { out[r] = Row(weighted_sum(rows, static_cast<Index>(r), values)).vec(); });
}

}  // namespace rumple
