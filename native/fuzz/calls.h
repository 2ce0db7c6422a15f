// SPDX-License-Identifier: GPL-3.0-or-later
// Every call of the library goes through here: what it promises of statuses, errors and answers is held.
#pragma once

#include <cstddef>
#include <cstdint>

#include "rumple.h"

namespace rumple::fuzz {

// Whether this thread watches what was asked to stop: else no call says that it was.
extern bool asked_to_stop;

// How often a function was called, and how often it did what it was asked for.
struct Tally {
    const char* function;
    std::uint64_t calls = 0;
    std::uint64_t answers = 0;

    rumple_status check(rumple_status status);
    template <typename Value>
    Value check(Value value) {
        ++calls;
        ++answers;
        return value;
    }
    void check() {
        ++calls;
        ++answers;
    }
};
Tally& tally_of(const char* function);

// Breaks off with what is wrong; libFuzzer keeps the input.
[[noreturn]] void fail(const char* what, const char* where);
inline void require(bool holds, const char* what, const char* where) {
    if (!holds) fail(what, where);
}

void expect_finite(const char* name, const float* values, size_t count);
void expect_within(const char* name, const std::int32_t* values, size_t count, std::int32_t low,
                   std::int32_t high);
// Ascending from 0 to `last`: where rows of something begin.
void expect_starts(const char* name, const std::int32_t* starts, size_t count, std::int32_t last);

// A handle that no call has written.
template <typename Handle>
Handle* unwritten() {
    return reinterpret_cast<Handle*>(std::uintptr_t(16));
}

}  // namespace rumple::fuzz

// CALL(rumple_x, arguments...): its result.
#define CALL(function, ...)                        \
    ([&] {                                         \
        static Tally& tally = tally_of(#function); \
        return tally.check(function(__VA_ARGS__)); \
    }())
// ... of a function that gives nothing back.
#define RUN(function, ...)                         \
    ([&] {                                         \
        static Tally& tally = tally_of(#function); \
        function(__VA_ARGS__);                     \
        tally.check();                             \
    }())
// ... whose last argument is where a new handle goes: that handle, or NULL.
#define MAKE(Handle, function, ...)                                                                          \
    ([&]() -> Handle* {                                                                                      \
        Handle* new_handle = unwritten<Handle>();                                                            \
        if (CALL(function, __VA_ARGS__ __VA_OPT__(, ) & new_handle) == RUMPLE_OK) {                          \
            require(new_handle&& new_handle != unwritten<Handle>(), "no handle was made", #function);        \
            return new_handle;                                                                               \
        }                                                                                                    \
        require(new_handle == unwritten<Handle>(), "a handle was written by a call that failed", #function); \
        return nullptr;                                                                                      \
    }())
