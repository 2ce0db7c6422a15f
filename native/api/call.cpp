// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/call.h"

#include <cstdio>
#include <cstring>
#include <new>

#include "api/sizes.h"

namespace rumple::api {
namespace {

thread_local char last_error[2048] = "";

rumple_status keep(rumple_status status, const char* text) noexcept {
    std::snprintf(last_error, sizeof last_error, "%s", text);
    return status;
}

}  // namespace

rumple_status keep_exception() noexcept {
    try {
        throw;
    } catch (const InvalidInput& error) {
        return keep(RUMPLE_INVALID, error.what());
    } catch (const TopologyError& error) {
        return keep(RUMPLE_INVALID, error.what());
    } catch (const std::bad_alloc&) {
        return keep(RUMPLE_NO_MEMORY, "there is not enough memory");
    } catch (const std::exception& error) {
        return keep(RUMPLE_INTERNAL, error.what());
    } catch (...) {
        return keep(RUMPLE_INTERNAL, "an unknown fault");
    }
}

void expect_rows(const char* name, size_t count, size_t expected) {
    if (count == expected) return;
    throw InvalidInput(std::string(name) + ": expected " + std::to_string(expected) + " rows, got " +
                       std::to_string(count));
}

void expect_rows_or_none(const char* name, size_t count, size_t expected) {
    if (count > 0) expect_rows(name, count, expected);
}

}  // namespace rumple::api

const char* rumple_version(void) {
    return RUMPLE_VERSION;
}

const char* rumple_error(void) {
    return rumple::api::last_error;
}

size_t rumple_struct_size(const char* name) {
    if (!name) return 0;
    for (const auto& [known, size] : rumple::api::kStructSizes) {
        if (std::strcmp(known, name) == 0) return size;
    }
    return 0;
}
