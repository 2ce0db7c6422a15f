// SPDX-License-Identifier: GPL-3.0-or-later
// "Crush" (section 4.2), one texel per welded vertex. wrinkle_field::estimate_waves() computes the same.
//   vertices   first neighbour, number of neighbours, W (0 if the rest pose has no frame), mask
//   wave_parameters  q, angle of the irregularity
//   neighbours neighbour, gradient, the vertex itself
//   before     k of the frame before, in xy
//   stretches  xx, xy, yy of U from the reference triangles if the rest shape adapts; else unused
// out_waves: 2 pi / W k' and h; out_estimate: k, fullness, r.

void main() {
    int v = THIS_TEXEL(vertices);
    vec4 own = TEXEL(vertices, v);
    vec3 x = TEXEL(positions, v).xyz;
    vec3 n = TEXEL(normals, v).xyz;
    out_waves = vec4(0.0);
    out_estimate = vec4(1.0, 0.0, 0.0, 1.0);
    if (own.z <= 0.0 || dot(n, n) == 0.0) return;
    int first = int(own.x);
    vec3 t = tangent_towards(TEXEL(positions, int(TEXEL(neighbours, first).x)).xyz - x, n);
    vec3 b = cross(n, t);
    mat2 m = mat2(0.0);  // equation (1)
    for (int i = first; i < first + int(own.y); ++i) {
        vec4 neighbour = TEXEL(neighbours, i);
        vec3 displacement = TEXEL(positions, int(neighbour.x)).xyz - x;
        m += outer_product(tangent_space(displacement, t, b, true_lengths), neighbour.yz);
    }
    if (adaptive) m = restretched(m, TEXEL(stretches, v).xyz);
    vec4 wanted = TEXEL(wave_parameters, v);
    WaveEstimate estimate = estimate_wave(m, wanted.xy, TEXEL(before, v).xy, wanted.zw, buckling_limit);
    float fullness = estimate.fullness * own.w;
    out_waves.xyz = (kTwoPi / own.z) * (estimate.k_deformed.x * t + estimate.k_deformed.y * b);
    out_waves.w = 0.25 * own.z * strength * fullness;  // equation (2)
    out_estimate = vec4(estimate.k, fullness, estimate.r);
}
