// SPDX-License-Identifier: GPL-3.0-or-later
// A team of threads. The assignment of work to threads never changes the result, because parallel work of one
// step shares no data that is written.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

#include "base/stop.h"

namespace rumple {

// Waits a short time for a condition, and yields the processor to other threads meanwhile. Returns whether
// the condition is true.
template <typename Condition>
bool soon(const Condition& condition) {
    constexpr int kYields = 200;  // 50 to 100 microseconds: waking a sleeping thread takes as long
    for (int i = 0; i < kYields; ++i) {
        if (condition()) return true;
        std::this_thread::yield();
    }
    return condition();
}

// A barrier for threads. It is not std::barrier or std::latch, because in MinGW these lose the notification
// that wakes a thread, so that three or more threads wait for ever.
class Barrier {
  public:
    explicit Barrier(int members = 1) : members_(members) {}

    // Call it while no thread waits.
    void set_members(int members) { members_ = members; }

    // Waits until all members have called it.
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
        if (soon(all_are_here)) return;
        std::unique_lock lock(mutex_);
        changed_.wait(lock, all_are_here);
    }

  private:
    int members_;
    std::atomic<int> arrived_ = 0;
    std::atomic<unsigned> round_ = 0;
    std::mutex mutex_;
    std::condition_variable changed_;
};

// Its threads start at the first work and live as long as the team, so that a solve of many short steps
// starts threads only once. If the system gives fewer threads than asked for (a limit of a container, or of
// memory), the existing ones do all of the work.
class Team {
  public:
    explicit Team(int threads) : threads_(std::max(threads, 1)) {}
    Team(const Team&) = delete;
    Team& operator=(const Team&) = delete;

    ~Team() {
        if (others_.empty()) return;
        begin({}, true);
        for (std::thread& thread : others_) thread.join();
    }

    // Below 2 no work can be shared. This is also so while the team works.
    int threads() const { return working_ ? 1 : threads_; }

    // Calls work(member) on every member and returns when all have ended. work may use barrier(). It must not
    // throw.
    template <typename Work>
    void run(const Work& work) {
        working_ = true;
        start();
        if (threads_ > 1) begin([&work](int member) { work(member); }, true);
        work(0);
        barrier();
        working_ = false;
    }

    // Calls work(0) here, and work(member) on the members that start before work(0) has ended. work
    // distributes its items itself, so nothing is left for a member that is late or waits for a processor. An
    // exception of a member (out of memory) is thrown here when all have ended.
    template <typename Work>
    void share(const Work& work) {
        working_ = true;
        start();
        std::exception_ptr failed;
        const auto caught = [&](int member) {
            try {
                work(member);
            } catch (...) {
                const std::lock_guard lock(mutex_);
                if (!failed) failed = std::current_exception();
            }
        };
        const auto began = Clock::now();
        if (threads_ > 1) begin(caught, false);
        caught(0);
        const auto done = Clock::now();
        if (threads_ > 1) end();
        worked_ += done - began;
        waited_ += Clock::now() - done;
        working_ = false;
        if (failed) std::rethrow_exception(failed);
    }

    // Whether waiting for the others takes so long that one thread is faster, because other programs keep the
    // processors busy.
    bool is_crowded() const { return waited_ > std::chrono::milliseconds(1) && 2 * waited_ > worked_; }

    // Waits until all members have called it. Only inside of run().
    void barrier() {
        if (threads_ > 1) barrier_.meet();
    }

    struct Range {
        size_t begin;
        size_t end;
    };
    // The part of [begin, end) that belongs to a member.
    Range partition(size_t begin, size_t end, int member) const {
        const size_t count = end - begin;
        return {begin + count * size_t(member) / size_t(threads_),
                begin + count * size_t(member + 1) / size_t(threads_)};
    }

  private:
    using Clock = std::chrono::steady_clock;
    using Task = std::function<void(int member)>;

    // Starts as many threads as possible. They are numbered from 1.
    void start() {
        if (threads_ < 2 || !others_.empty()) return;
        try {
            others_.reserve(size_t(threads_ - 1));
            for (int t = 1; t < threads_; ++t) others_.emplace_back([this, t] { stand_by(t); });
        } catch (const std::system_error&) {
        } catch (const std::bad_alloc&) {
        }
        threads_ = 1 + static_cast<int>(others_.size());
        barrier_.set_members(threads_);
    }

    // Gives the other members a task. An empty task ends them. for_all: every member takes part.
    void begin(Task task, bool for_all) {
        {
            const std::lock_guard lock(mutex_);
            task_ = std::move(task);
            for_all_ = for_all;
            open_ = true;
            round_.store(round_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
        }
        changed_.notify_all();
    }

    // After it no member begins the task, and the members that began it have ended.
    void end() {
        {
            const std::lock_guard lock(mutex_);
            open_ = false;
        }
        const auto all_are_out = [&] { return inside_.load(std::memory_order_acquire) == 0; };
        if (soon(all_are_out)) return;
        std::unique_lock lock(mutex_);
        changed_.wait(lock, all_are_out);
    }

    void stand_by(int member) {
        unsigned seen = 0;
        for (;;) {
            const auto is_next = [&] { return round_.load(std::memory_order_acquire) != seen; };
            soon(is_next);
            std::unique_lock lock(mutex_);
            changed_.wait(lock, is_next);
            seen = round_.load(std::memory_order_relaxed);
            if (!open_) continue;
            const Task& task = task_;  // valid until this member leaves
            const bool for_all = for_all_;
            inside_.fetch_add(1, std::memory_order_relaxed);
            lock.unlock();
            if (!task) return;
            task(member);
            leave();
            if (for_all) barrier_.meet();
        }
    }

    void leave() {
        const std::lock_guard lock(mutex_);
        if (inside_.fetch_sub(1, std::memory_order_release) == 1) changed_.notify_all();
    }

    int threads_;
    bool working_ = false;
    Clock::duration worked_{}, waited_{};  // total times in share()
    std::vector<std::thread> others_;      // not std::jthread, which Apple's standard library does not have
    Barrier barrier_;
    std::mutex mutex_;  // protects the members below
    std::condition_variable changed_;
    Task task_;
    bool for_all_ = false;
    bool open_ = false;
    std::atomic<unsigned> round_ = 0;
    std::atomic<int> inside_ = 0;
};

// Runs both, the second in its own thread if the system gives one. An exception is thrown here when both have
// ended. If both throw, it is the exception of the first.
template <typename First, typename Second>
void in_parallel(const First& first, const Second& second) {
    std::exception_ptr failed_first, failed_second;
    const auto caught = [](const auto& work, std::exception_ptr& failed) {
        try {
            work();
        } catch (...) {
            failed = std::current_exception();
        }
    };
    std::thread other;
    try {
        other = std::thread([&, watched = watched_stop] {
            watched_stop = watched;
            caught(second, failed_second);
        });
    } catch (const std::system_error&) {
        caught(second, failed_second);
    }
    caught(first, failed_first);
    if (other.joinable()) other.join();
    for (const std::exception_ptr& failed : {failed_first, failed_second})
        if (failed) std::rethrow_exception(failed);
}

// The number of threads for a number of items: `asked` if it is above 0; else 1 below `least_items`; else the
// number of this machine's threads, at most `most`.
inline int choose_threads(int asked, size_t items, size_t least_items, int most) {
    if (asked > 0) return asked;
    if (items < least_items) return 1;
    return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, most);
}

}  // namespace rumple
