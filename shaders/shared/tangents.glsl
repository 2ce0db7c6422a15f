// SPDX-License-Identifier: GPL-3.0-or-later
// Tangents of a surface. One text for C++ (native/base/formulas.h) and GLSL.

// A unit vector at right angles to the unit vector n. The same n always gives the same vector.
FORMULA vec3 any_tangent(vec3 n) {
    vec3 helper = abs(n.x) < 0.5f ? vec3(1.0f, 0.0f, 0.0f) : vec3(0.0f, 1.0f, 0.0f);
    return normalize(cross(n, helper));
}
