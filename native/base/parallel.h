// SPDX-License-Identifier: GPL-3.0-or-later
// A team of threads that meet at barriers. Which thread does what never
// changes the result: work of one step touches no common data.
#pragma once

#include <algorithm>
#include <barrier>
#include <cstddef>
#include <latch>
#include <new>
#include <optional>
#include <system_error>
#include <thread>
#include <vector>

namespace rumple {

class Team {
  public:
    explicit Team(int threads) : threads_(std::max(threads, 1)) {}

    // Runs work(thread) on every member and returns when all are done. Where the system gives fewer threads
    // than were asked for (a limit of a container, of memory), those that there are do the work of all. work
    // must not throw.
    template <typename Work>
    void run(Work&& work) {
        std::latch counted(1);  // nobody begins before it is known how many there are
        const auto task = [&](int thread) {
            counted.wait();
            work(thread);
        };
        Others others;
        others.start(threads_ - 1, task);
        threads_ = 1 + static_cast<int>(others.threads.size());
        barrier_.emplace(threads_);
        counted.count_down();
        work(0);
    }

    // Everyone waits here for everyone (the wait yields the processor).
    void barrier() {
        if (threads_ > 1) barrier_->arrive_and_wait();
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
    // As std::jthread, which Apple's standard library does not have: joined in any case.
    struct Others {
        std::vector<std::thread> threads;

        // As many as can be started, up to `most`, which are numbered from 1.
        template <typename Task>
        void start(int most, const Task& task) {
            try {
                threads.reserve(size_t(most));
                for (int t = 1; t <= most; ++t) threads.emplace_back([&task, t] { task(t); });
            } catch (const std::system_error&) {
            } catch (const std::bad_alloc&) {
            }
        }

        ~Others() {
            for (std::thread& thread : threads) thread.join();
        }
    };

    int threads_;
    std::optional<std::barrier<>> barrier_;  // of those that run
};

// Threads for so many items: what was asked for, or (0) one below `least_items`, else those of this machine,
// at most `most`.
inline int choose_threads(int asked, size_t items, size_t least_items, int most) {
    if (asked > 0) return asked;
    if (items < least_items) return 1;
    return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, most);
}

// work(i) for every i below count. Every item is computed by itself, so that the number of threads changes no
// bit.
template <typename Work>
void for_each_index(size_t count, int threads, Work&& work) {
    Team team(threads);
    team.run([&](int thread) {
        const Team::Range part = team.partition(0, count, thread);
        for (size_t i = part.begin; i < part.end; ++i) work(i);
    });
}

}  // namespace rumple
