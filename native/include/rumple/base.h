// SPDX-License-Identifier: GPL-3.0-or-later
// What every part of the library needs: what is exported, statuses, errors, versions. See rumple.h.
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

// The version of this header. rumple_version() has that of the library.
#define RUMPLE_VERSION "0.1.0"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rumple_status {
    RUMPLE_OK = 0,
    RUMPLE_INVALID = 1,  // an argument breaks its promise; rumple_error() names it and its first bad element
    RUMPLE_NO_MEMORY = 2,  // there is not enough memory for it
    RUMPLE_INTERNAL = 3,   // a fault of the library itself
    RUMPLE_STOPPED = 4     // rumple_stop_ask() was called for it
} rumple_status;

// The version of the library, "major.minor.patch". Headers and libraries fit when these are the same.
RUMPLE_API const char* rumple_version(void);

// The bytes of a struct of this header as the library was compiled, by name ("rumple_pose"); 0: there is none
// of that name. Who loads the library at run time compares them all before the first other call.
RUMPLE_API size_t rumple_struct_size(const char* name);

// What was wrong in the last call of this thread that did not return RUMPLE_OK: UTF-8, never NULL, valid
// until the next call of this thread that fails. Example: "positions: vertex 12 is not finite".
RUMPLE_API const char* rumple_error(void);

// By which one thread ends what another one makes. Functions of models, which take seconds where meshes are
// large, look at it between their steps: of a million vertices most take less than 0.3 s, the longest 4. The
// others end by themselves before.
typedef struct rumple_stop rumple_stop;

RUMPLE_API rumple_status rumple_stop_build(rumple_stop** stop);
RUMPLE_API void rumple_stop_free(rumple_stop* stop);

// The calls of this thread end with RUMPLE_STOPPED when that one is asked to stop. It must live until the
// thread watches another one, or none (NULL).
RUMPLE_API void rumple_stop_watch(const rumple_stop* stop);

// From any thread. It cannot be taken back.
RUMPLE_API void rumple_stop_ask(rumple_stop* stop);

#ifdef __cplusplus
}
#endif

#endif
