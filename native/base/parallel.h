// SPDX-License-Identifier: GPL-3.0-or-later
// A team of threads that meet at barriers. Which thread does what never
// changes the result: work of one step touches no common data.
#pragma once

#include <algorithm>
#include <barrier>
#include <cstddef>
#include <thread>
#include <vector>

namespace rumple {

class Team {
  public:
    explicit Team(int threads) : threads_(std::max(threads, 1)), barrier_(threads_) {}

    // Runs work(thread) on every member and returns when all are done.
    // work must not throw.
    template <typename Work>
    void run(Work&& work) {
        std::vector<std::jthread> others;
        for (int t = 1; t < threads_; ++t) others.emplace_back([&work, t] { work(t); });
        work(0);
    }

    // Everyone waits here for everyone (the wait yields the processor).
    void barrier() {
        if (threads_ > 1) barrier_.arrive_and_wait();
    }

    struct Range {
        size_t begin;
        size_t end;
    };
    // The part of [begin, end) that belongs to a member.
    Range partition(size_t begin, size_t end, int thread) const {
        const size_t count = end - begin;
        return {begin + count * thread / threads_, begin + count * (thread + 1) / threads_};
    }

  private:
    int threads_;
    std::barrier<> barrier_;
};

}  // namespace rumple
