// SPDX-License-Identifier: GPL-3.0-or-later
// Tangents of a surface. One text for C++ (native/base/formulas.h) and GLSL.

// Any unit vector at right angles to the unit vector n, the same every time.
FORMULA vec3 any_tangent(vec3 n) {
    vec3 helper = abs(n.x) < 0.5f ? vec3(1.0f, 0.0f, 0.0f) : vec3(0.0f, 1.0f, 0.0f);
    return normalize(cross(n, helper));
}
