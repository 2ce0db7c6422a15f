// SPDX-License-Identifier: GPL-3.0-or-later
// Building a large model takes seconds. The building thread checks at intervals whether the result is still
// wanted.
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>

namespace rumple {

struct Stopped : std::exception {
    const char* what() const noexcept override { return "it was stopped"; }
};

// The flag that this thread checks; nullptr: none. The threads that it starts by in_parallel() check the same
// flag.
inline thread_local const std::atomic<bool>* watched_stop = nullptr;

// Throws Stopped if the flag is set. Takes nanoseconds.
inline void stop_if_asked() {
    if (watched_stop && watched_stop->load(std::memory_order_relaxed)) throw Stopped();
}

// The same in a loop. round: the number of the iteration.
inline void stop_if_asked(std::size_t round) {
    if (round % 4096 == 0) stop_if_asked();
}

}  // namespace rumple
