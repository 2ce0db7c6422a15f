// SPDX-License-Identifier: GPL-3.0-or-later
// Rumple: dynamic wrinkles on coarse animated meshes. A coarse, posed mesh goes in, folds come out.
// This is the whole public interface: include this file, link librumple. C11 or C++11 and later.
//
// ONE GRAMMAR. Every system has the same words, in the same order:
//
//     rumple_X_plan_default()    what a model is made from: a plain struct with its defaults
//     rumple_X_build()           the model: made once at rest, then never changed
//     rumple_X_settings_default()  what may differ in every frame
//     rumple_X_paint_build()     painted factors of a mesh's vertices, carried to what is solved
//     rumple_X_solve()           one frame, from the state of the frame before: a new state, and a report
//     rumple_X_show()            the mesh that is shown in that frame
//     rumple_X_get_view()        what a handle holds: a struct of numbers and pointers
//     rumple_X_free()            gives a handle back
//
// ARRAYS are a pointer and a count: float, double, int32_t or uint8_t, without gaps, the last index fastest.
// `count` is the number of rows: 7 positions of shape (7, 3) are 21 floats and a count of 7. A pointer may be
// NULL where the count is 0; an array that may be missing is then "none". At most INT32_MAX rows.
// Input is read while the call lasts; nothing keeps a pointer to it. Output goes to arrays of the caller, of
// exactly the count that is documented, or to a handle that has a view.
//
// VIEWS point into their handle. They are valid until it is freed; who holds one must not write through it.
//
// HANDLES are opaque, and made by functions whose last argument is where the handle goes. It is left as it
// was when the call fails. Each one is freed once, in any order: what a handle needs of others, it keeps.
// Freeing NULL does nothing. A handle that a view or a `_shown` function names is borrowed: do not free it.
// States, paint and frames know the model that they were made for. Given to another one, even one made of the
// same mesh, they are refused.
//
// ERRORS. A function that can fail returns a rumple_status. rumple_error() says in words which argument, and
// which element of it, is wrong, what was expected and what came. No exception leaves the library.
//
// THREADS. Models, colliders, paint and states are never changed after they were made: any number of threads
// may use one at the same time. A frame may be read by many threads, but not while rumple_frame_embed()
// changes it. rumple_error() is of the calling thread. What is large is solved on up to eight threads, which
// live as long as the call, or as many as the settings' `threads` say; a wrinkle mesh is built on up to four.
// Their number never changes a result: the same input gives the same bits.
//
// UNITS. Positions and lengths are in object space and object units unless it is said; time is in seconds.
// Triangles are counter-clockwise seen from outside. A matrix is given row by row.
//
// Numbers of sections and equations are those of the paper that a header names; docs/ has the mathematics.
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
