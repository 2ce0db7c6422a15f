// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/call.h"

#include <cstdio>
#include <cstring>
#include <new>

#include "api/sizes.h"
#include "base/expect.h"
#include "base/stop.h"

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
    } catch (const Stopped& stopped) {
        return keep(RUMPLE_STOPPED, stopped.what());
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

void expect_places(std::span<const Index> triangles, std::span<const Vec2> barycentric, size_t count) {
    for (size_t i = 0; i < triangles.size(); ++i) {
        expect_within("triangle " + std::to_string(i), triangles[i], 0, double(count) - 1.0);
        for (const float weight : {barycentric[i].x, barycentric[i].y})
            expect_within("barycentric: place " + std::to_string(i), weight, -1.0, 2.0);
    }
}

}  // namespace rumple::api

struct rumple_stop {
    std::atomic<bool> asked = false;
};

rumple_status rumple_stop_build(rumple_stop** stop) {
    return rumple::api::made(stop, "stop", [] { return new rumple_stop; });
}

void rumple_stop_free(rumple_stop* stop) {
    delete stop;
}

void rumple_stop_watch(const rumple_stop* stop) {
    rumple::watched_stop = stop ? &stop->asked : nullptr;
}

void rumple_stop_ask(rumple_stop* stop) {
    if (stop) stop->asked.store(true, std::memory_order_relaxed);
}

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
