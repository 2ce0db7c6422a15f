// SPDX-License-Identifier: GPL-3.0-or-later
// Rumple: dynamic wrinkles on coarse animated meshes. The input is a coarse, posed mesh. The output is a fine
// mesh with folds. This is the whole public interface: include this file and link librumple. It needs C11 or
// C++11, or later.
//
// NAMES. Every system has the same kinds of functions, which are called in this order:
//
//     rumple_X_plan_default()    the plan, from which a model is built: a plain struct with defaults
//     rumple_X_build()           the model: built once at rest, then never changed
//     rumple_X_settings_default()  the settings, which may change in every frame
//     rumple_X_paint_build()     the paint: factors per base vertex, carried to the solved vertices
//     rumple_X_pose_build()      the pose: what the positions of one frame make of the model
//     rumple_X_solve()           solves a frame from the state of the frame before: a new state, a report
//     rumple_X_show()            the shown mesh of a solved frame
//     rumple_X_get_view()        the contents of a handle: a struct of numbers and pointers
//     rumple_X_free()            frees a handle
//
// ARRAYS are a pointer and a count. They contain float, double, int32_t or uint8_t, are contiguous, and are
// in row-major order. `count` is the number of rows: 7 positions of shape (7, 3) are 21 floats and a count of
// 7. A pointer may be NULL if the count is 0. "or none" marks an array that may be missing in this way. An
// array has at most INT32_MAX rows. Input is only read during the call, and the library keeps no pointer to
// it. Output goes to arrays of the caller, with exactly the documented count, or to a handle that has a view.
//
// VIEWS point into their handle. They are valid until it is freed. Do not write through them.
//
// HANDLES are opaque. The last argument of the function that makes a handle is the address where it is
// stored. If the call fails, nothing is stored. Free each handle once, in any order: a handle keeps alive
// what it needs of others. Freeing NULL does nothing. A handle from a view or a `_shown` function is
// borrowed: do not free it. States, paint and frames know the model that they were made for. They are refused
// with any other model, even with one built from the same mesh.
//
// ERRORS. A function that can fail returns a rumple_status. rumple_error() describes which argument and which
// element of it is wrong, what was expected and what was given. "Refused:" in a comment lists input for which
// a function fails. No exception leaves the library.
//
// THREADS. Models, colliders, paint and states never change after they were made, so any number of threads
// may use one at the same time. Many threads may read a frame, but not while rumple_frame_embed() changes it.
// rumple_error() belongs to the calling thread. Large meshes are solved on up to eight threads, or on the
// number in the settings (`threads`). A wrinkle mesh is built on up to four. These threads end with the call.
// The number of threads never changes a result: the same input gives the same bits.
//
// UNITS. Positions and lengths are in object space and object units, unless stated otherwise. Time is in
// seconds. Triangles are counter-clockwise seen from outside. Matrices are in row-major order. Numbers of
// sections and equations refer to the paper that a header names. docs/ has the mathematics.
#ifndef RUMPLE_H
#define RUMPLE_H

#include "rumple/base.h"
#include "rumple/base_cloth.h"
#include "rumple/force_fields.h"
#include "rumple/surface.h"
#include "rumple/wrinkle_field.h"
#include "rumple/wrinkle_field_brush.h"
#include "rumple/wrinkle_layers.h"
#include "rumple/wrinkle_maps.h"
#include "rumple/wrinkle_mesh.h"
#include "rumple/wrinkle_paths.h"

#endif
