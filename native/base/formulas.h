// SPDX-License-Identifier: GPL-3.0-or-later
// Compiles the formulas of shaders/shared as C++ with GLM, so that the kernels here and GLSL share one text.
// Such a file may use float, int, bool, vec2, vec3, vec4, mat2, structs and GLSL's functions. It writes 0.5f,
// uses no swizzles, and returns structs instead of using `out` parameters. FORMULA stands before every
// function. REAL and BOOL are float and bool here; lane_formulas.h compiles files that use them once more.
#pragma once

#include <glm/glm.hpp>

#include "base/elementary.h"

#define FORMULA inline

namespace rumple::formulas {

using namespace glm;
using REAL = float;
using BOOL = bool;
// Lookup finds these before GLM's functions, which are the system's.
using elementary::cos;
using elementary::nearest_integer;
using elementary::sin;

#include "shared/pn_triangle.glsl"
#include "shared/tangents.glsl"
#include "shared/wrinkle_field.glsl"
#include "shared/wrinkle_field_picture.glsl"
#include "shared/wrinkle_field_probe.glsl"
#include "shared/wrinkle_maps.glsl"
#include "shared/wrinkle_mesh.glsl"
#include "shared/wrinkle_paths.glsl"

}  // namespace rumple::formulas

#undef FORMULA
