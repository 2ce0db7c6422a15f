// SPDX-License-Identifier: GPL-3.0-or-later
// "Render" (section 6), vertex stage. Triangles share no vertices. `triangle`: the welded vertices A, B, C; `corner`:
// which of them this vertex is.

float phase_here(vec4 wave, int at, vec3 x) {
    return dot(wave.xyz, x - TEXEL(positions, at).xyz) + TEXEL(phases, at).x;
}

void main() {
    int own = corner == 0 ? triangle.x : (corner == 1 ? triangle.y : triangle.z);
    vec3 x = TEXEL(positions, own).xyz;
    vec4 wave_a = TEXEL(waves, triangle.x), wave_b = TEXEL(waves, triangle.y), wave_c = TEXEL(waves, triangle.z);
    vector_a = wave_a.xyz;
    vector_b = wave_b.xyz;
    vector_c = wave_c.xyz;
    // Both are linear on the triangle, so their products in the fragment stage give equation (5).
    phase = vec3(phase_here(wave_a, triangle.x, x), phase_here(wave_b, triangle.y, x),
                 phase_here(wave_c, triangle.z, x));
    weight = vec3(corner == 0, corner == 1, corner == 2) * vec3(wave_a.w, wave_b.w, wave_c.w);
    normal = TEXEL(normals, own).xyz;
    place = x;
    image_uv = uv;
    u_slope = TEXEL(u_slopes, fan).xyz;
    v_slope = TEXEL(v_slopes, fan).xyz;
    gl_Position = on_screen(x);
}
