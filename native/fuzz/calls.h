// SPDX-License-Identifier: GPL-3.0-or-later
// Every call of the library goes through here. The promises about statuses, errors and answers are checked.
#pragma once

#include <cstddef>
#include <cstdint>

#include "rumple.h"

namespace rumple::fuzz {

// Whether the stop that this thread watches was asked for. Otherwise no call may report RUMPLE_STOPPED.
extern bool asked_to_stop;

// The number of calls of a function, and how many of them succeeded.
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

// Aborts with a message. libFuzzer keeps the input.
[[noreturn]] void fail(const char* what, const char* where);
inline void require(bool holds, const char* what, const char* where) {
    if (!holds) fail(what, where);
}

void expect_finite(const char* name, const float* values, size_t count);
void expect_within(const char* name, const std::int32_t* values, size_t count, std::int32_t low,
                   std::int32_t high);
// Checks for ascending values from 0 to `last`: the starts of rows.
void expect_starts(const char* name, const std::int32_t* starts, size_t count, std::int32_t last);

// A handle before a call writes it.
template <typename Handle>
Handle* unwritten() {
    return reinterpret_cast<Handle*>(std::uintptr_t(16));
}

}  // namespace rumple::fuzz

// CALL(rumple_x, arguments...): calls and checks, and has the function's result.
#define CALL(function, ...)                        \
    ([&] {                                         \
        static Tally& tally = tally_of(#function); \
        return tally.check(function(__VA_ARGS__)); \
    }())
// The same for a function without a result.
#define RUN(function, ...)                         \
    ([&] {                                         \
        static Tally& tally = tally_of(#function); \
        function(__VA_ARGS__);                     \
        tally.check();                             \
    }())
// The same for a function whose last argument receives a new handle. The result is this handle, or NULL.
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
