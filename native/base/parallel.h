// SPDX-License-Identifier: GPL-3.0-or-later
// A team of threads that meet at barriers. Which thread does what never
// changes the result: work of one step touches no common data.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

namespace rumple {

// Where threads meet. Not std::barrier, nor std::latch: those of MinGW lose the call that wakes a thread, so
// that three threads and more wait for ever.
class Barrier {
  public:
    // How many they are; before, nobody passes wait_until_open().
    void open(int members) {
        {
            const std::lock_guard lock(mutex_);
            members_ = members;
        }
        changed_.notify_all();
    }
    void wait_until_open() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return members_ > 0; });
    }

    // Everyone waits here for everyone: a moment without the system, which is often enough, then asleep.
    void meet() {
        const unsigned round = round_.load(std::memory_order_acquire);
        if (arrived_.fetch_add(1, std::memory_order_acq_rel) + 1 == members_) {
            arrived_.store(0, std::memory_order_relaxed);
            {
                const std::lock_guard lock(mutex_);
                round_.store(round + 1, std::memory_order_release);
            }
            changed_.notify_all();
            return;
        }
        const auto all_are_here = [&] { return round_.load(std::memory_order_acquire) != round; };
        for (int i = 0; i < kYields; ++i) {
            if (all_are_here()) return;
            std::this_thread::yield();
        }
        std::unique_lock lock(mutex_);
        changed_.wait(lock, all_are_here);
    }

  private:
    static constexpr int kYields = 32;

    int members_ = 0;
    std::atomic<int> arrived_ = 0;
    std::atomic<unsigned> round_ = 0;
    std::mutex mutex_;
    std::condition_variable changed_;
};

class Team {
  public:
    explicit Team(int threads) : threads_(std::max(threads, 1)) {}

    // Runs work(thread) on every member and returns when all are done. Where the system gives fewer threads
    // than were asked for (a limit of a container, of memory), those that there are do the work of all. work
    // must not throw.
    template <typename Work>
    void run(Work&& work) {
        Barrier barrier;
        barrier_ = &barrier;
        const auto task = [&](int thread) {
            barrier.wait_until_open();  // nobody begins before it is known how many there are
            work(thread);
        };
        Others others;
        others.start(threads_ - 1, task);
        threads_ = 1 + static_cast<int>(others.threads.size());
        barrier.open(threads_);
        work(0);
    }

    // Everyone waits here for everyone.
    void barrier() {
        if (threads_ > 1) barrier_->meet();
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
    Barrier* barrier_ = nullptr;  // of those that run
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
