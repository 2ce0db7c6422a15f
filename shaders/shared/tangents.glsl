// SPDX-License-Identifier: GPL-3.0-or-later
// Tangents of a surface. One text for C++ (native/base/formulas.h; lane_formulas.h for four vertices at a time) and
// GLSL.

FORMULA vec2 chosen(BOOL condition, vec2 a, vec2 b) {
    return vec2(condition ? a.x : b.x, condition ? a.y : b.y);
}

FORMULA vec3 chosen(BOOL condition, vec3 a, vec3 b) {
    return vec3(condition ? a.x : b.x, condition ? a.y : b.y, condition ? a.z : b.z);
}

// A unit vector at right angles to the unit vector n. The same n always gives the same vector.
FORMULA vec3 any_tangent(vec3 n) {
    vec3 helper = chosen(abs(n.x) < 0.5f, vec3(1.0f, 0.0f, 0.0f), vec3(0.0f, 1.0f, 0.0f));
    return normalize(cross(n, helper));
}
