// SPDX-License-Identifier: GPL-3.0-or-later
#include "calls.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <list>
#include <string>

namespace rumple::fuzz {
namespace {

std::list<Tally>& tallies() {
    static std::list<Tally> all;
    return all;
}

// Writes a line "FUNCTION CALLS ANSWERS" for each function into the file named by RUMPLE_FUZZ_CALLS.
void write_tallies() {
    const char* path = std::getenv("RUMPLE_FUZZ_CALLS");
    FILE* file = path ? std::fopen(path, "w") : nullptr;
    if (!file) return;
    for (const Tally& tally : tallies()) {
        std::fprintf(file, "%s %llu %llu\n", tally.function, static_cast<unsigned long long>(tally.calls),
                     static_cast<unsigned long long>(tally.answers));
    }
    std::fclose(file);
}

}  // namespace

Tally& tally_of(const char* function) {
    if (tallies().empty()) std::atexit(write_tallies);
    for (Tally& tally : tallies()) {
        if (std::strcmp(tally.function, function) == 0) return tally;
    }
    return tallies().emplace_back(Tally{function});
}

bool asked_to_stop = false;

rumple_status Tally::check(rumple_status status) {
    ++calls;
    answers += status == RUMPLE_OK;
    if (status == RUMPLE_OK) return status;
    const char* error = rumple_error();
    const bool is_stopped = asked_to_stop && status == RUMPLE_STOPPED;
    if (status != RUMPLE_INVALID && status != RUMPLE_NO_MEMORY && !is_stopped) fail(error, function);
    require(error && std::strlen(error) > 8, "an error without words", function);
    for (const char* internal : {"std::", "vector", "basic_string", "  ", "nan vertices", "-9223"})
        require(!std::strstr(error, internal), error, function);
    return status;
}

void fail(const char* what, const char* where) {
    std::fprintf(stderr, "FUZZ: %s: %s\n", where, what);
    std::abort();
}

void expect_finite(const char* name, const float* values, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        if (!std::isfinite(values[i]))
            fail((std::string(name) + " " + std::to_string(i) + " is not finite").c_str(), "answer");
    }
}

void expect_within(const char* name, const std::int32_t* values, size_t count, std::int32_t low,
                   std::int32_t high) {
    for (size_t i = 0; i < count; ++i) {
        if (values[i] < low || values[i] > high) {
            fail((std::string(name) + " " + std::to_string(i) + " is " + std::to_string(values[i])).c_str(),
                 "answer");
        }
    }
}

void expect_starts(const char* name, const std::int32_t* starts, size_t count, std::int32_t last) {
    require(count > 0 && starts[0] == 0 && starts[count - 1] == last, name, "answer");
    for (size_t i = 1; i < count; ++i) require(starts[i] >= starts[i - 1], name, "answer");
}

}  // namespace rumple::fuzz
