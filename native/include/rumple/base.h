// SPDX-License-Identifier: GPL-3.0-or-later
// The basics of the library: export macro, status codes, error messages, versions, stopping. See rumple.h.
#ifndef RUMPLE_BASE_H
#define RUMPLE_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32) && defined(RUMPLE_BUILD)
#define RUMPLE_API __declspec(dllexport)
#elif defined(_WIN32)
#define RUMPLE_API __declspec(dllimport)
#else
#define RUMPLE_API __attribute__((visibility("default")))
#endif

// The version of this header. rumple_version() returns the version of the library.
#define RUMPLE_VERSION "0.1.0"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rumple_status {
    RUMPLE_OK = 0,
    RUMPLE_INVALID = 1,    // an argument is not valid; rumple_error() names it and its first bad element
    RUMPLE_NO_MEMORY = 2,  // there is not enough memory
    RUMPLE_INTERNAL = 3,   // an error of the library itself
    RUMPLE_STOPPED = 4     // the call was stopped by rumple_stop_ask()
} rumple_status;

// The version of the library, "major.minor.patch". A header and a library only work together if their
// versions are the same.
RUMPLE_API const char* rumple_version(void);

// The size in bytes of a struct of these headers in the compiled library. name: for example "rumple_pose". 0:
// there is no such struct. A program that loads the library at run time should compare the sizes of all
// structs before any other call.
RUMPLE_API size_t rumple_struct_size(const char* name);

// The error message of the last failed call of this thread: UTF-8, never NULL, valid until the next failed
// call of this thread. Example: "positions: vertex 12 is not finite".
RUMPLE_API const char* rumple_error(void);

// Lets one thread stop a call of another thread. Functions that build models can take seconds for large
// meshes. They check it between their steps. For a million vertices most steps take less than 0.3 s, the
// longest 4 s. All other functions are so short that they do not check it.
typedef struct rumple_stop rumple_stop;

RUMPLE_API rumple_status rumple_stop_build(rumple_stop** stop);
RUMPLE_API void rumple_stop_free(rumple_stop* stop);

// From now on, calls of this thread end with RUMPLE_STOPPED after rumple_stop_ask(stop). `stop` must not be
// freed until the thread watches another one, or none (NULL).
RUMPLE_API void rumple_stop_watch(const rumple_stop* stop);

// Asks the watching threads to stop. It may be called from any thread, and cannot be undone.
RUMPLE_API void rumple_stop_ask(rumple_stop* stop);

#ifdef __cplusplus
}
#endif

#endif
