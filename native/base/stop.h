// SPDX-License-Identifier: GPL-3.0-or-later
// Making a model takes seconds where it is large. A thread that makes one looks now and then whether anybody
// still wants it.
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>

namespace rumple {

struct Stopped : std::exception {
    const char* what() const noexcept override { return "it was stopped"; }
};

// What this thread looks at; nullptr: nothing. The threads that it starts by in_parallel() look at the same.
inline thread_local const std::atomic<bool>* watched_stop = nullptr;

// Throws Stopped where what is watched says so. Nanoseconds.
inline void stop_if_asked() {
    if (watched_stop && watched_stop->load(std::memory_order_relaxed)) throw Stopped();
}

// ... in a loop, of which this is the number of a round.
inline void stop_if_asked(std::size_t round) {
    if (round % 4096 == 0) stop_if_asked();
}

}  // namespace rumple
