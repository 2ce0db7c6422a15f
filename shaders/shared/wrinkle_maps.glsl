// SPDX-License-Identifier: GPL-3.0-or-later
// The formulas of the Wrinkle Maps, per pixel. Source: L. Dutreve, A. Meyer and
// S. Bouakaz, Real-Time Dynamic Wrinkles of Face for Animated Skinned Mesh, ISVC
// 2009, section 5.3. One text for C++ (native/base/formulas.h) and GLSL; the
// shader nodes (addon/rumple/blender/nodes/maps_shader.py) are tested against it.

// Unit: none (length of a sum of tangent-space normals). A shorter sum has no direction.
const float kNoNormal = 1e-6f;

// A texel of a tangent-space normal map, 0..1 -> -1..1. Not normalised, because texels of eight bits are not.
FORMULA vec3 decoded(vec3 texel) { return 2.0f * texel - vec3(1.0f); }

// The inverse of decoded().
FORMULA vec3 encoded(vec3 normal) { return 0.5f * normal + vec3(0.5f); }

// Unit; straight up if the sum has no direction.
FORMULA vec3 unit_normal(vec3 sum) {
    float sum_length = length(sum);
    return sum_length > kNoNormal ? sum / sum_length : vec3(0.0f, 0.0f, 1.0f);
}

// alpha_0 of section 5.1 for a pixel: the share of the neutral pose that the poses leave.
FORMULA float rest_share(float total) { return max(0.0f, 1.0f - total); }

// First case: the wrinkle maps contain the details of the neutral map. sum: of mask x decoded wrinkle map over the
// poses; total: sum of the masks; neutral: N, decoded.
FORMULA vec3 blend_whole(vec3 sum, float total, vec3 neutral) {
    return unit_normal(sum + rest_share(total) * neutral);
}

// Second case: the wrinkle maps contain only wrinkles, so the remaining share is flat.
// WN = normalize(W.x + N.x, W.y + N.y, W.z * N.z).
FORMULA vec3 blend_wrinkles(vec3 sum, float total, vec3 neutral) {
    vec3 w = unit_normal(sum + vec3(0.0f, 0.0f, rest_share(total)));
    return unit_normal(vec3(w.x + neutral.x, w.y + neutral.y, w.z * neutral.z));
}
