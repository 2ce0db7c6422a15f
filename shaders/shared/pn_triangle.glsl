// SPDX-License-Identifier: GPL-3.0-or-later
// PN triangles: A. Vlachos et al., Curved PN Triangles, 2001, section 3.1.
// One text for C++ (native/base/formulas.h) and GLSL (the viewport preview).

// A third of the way from p to `other`, projected to the tangent plane at p with the unit normal n.
FORMULA vec3 pn_control(vec3 p, vec3 n, vec3 other) { return (2.0f * p + other - dot(other - p, n) * n) / 3.0f; }

// The cubic Bezier triangle at weight u of corner 1 and v of corner 2. n0 to n2: unit normals at the corners; zero
// normals give a flat triangle.
FORMULA vec3 pn_point(vec3 p0, vec3 p1, vec3 p2, vec3 n0, vec3 n1, vec3 n2, float u, float v) {
    float w = 1.0f - u - v;
    vec3 b01 = pn_control(p0, n0, p1);
    vec3 b10 = pn_control(p1, n1, p0);
    vec3 b12 = pn_control(p1, n1, p2);
    vec3 b21 = pn_control(p2, n2, p1);
    vec3 b20 = pn_control(p2, n2, p0);
    vec3 b02 = pn_control(p0, n0, p2);
    vec3 edge_mean = (b01 + b10 + b12 + b21 + b20 + b02) / 6.0f;
    vec3 corner_mean = (p0 + p1 + p2) / 3.0f;
    vec3 centre = edge_mean + (edge_mean - corner_mean) / 2.0f;
    return w * w * w * p0 + u * u * u * p1 + v * v * v * p2 +
           3.0f * (w * w * u * b01 + w * u * u * b10 + u * u * v * b12 + u * v * v * b21 + v * v * w * b20 +
                   v * w * w * b02) +
           6.0f * w * u * v * centre;
}
