// SPDX-License-Identifier: GPL-3.0-or-later
// For tests: calls every formula of wrinkle_field.glsl by a number, so that C++ and GLSL can be compared. Columns of x
// are the arguments, columns of the result are the results; the others are zero.

FORMULA vec3 probe_3(vec4 x) { return vec3(x.x, x.y, x.z); }
FORMULA vec2 probe_2(vec4 x) { return vec2(x.x, x.y); }
FORMULA vec4 probe_out(vec3 x) { return vec4(x.x, x.y, x.z, 0.0f); }
FORMULA mat2 probe_mat(vec4 x) { return mat2(x.x, x.y, x.z, x.w); }

FORMULA mat4 probe_formula(int formula, mat4 x) {
    mat4 y = mat4(0.0f);
    if (formula == 0) {
        y[0] = probe_out(any_tangent(probe_3(x[0])));
    } else if (formula == 1) {
        y[0] = probe_out(tangent_towards(probe_3(x[0]), probe_3(x[1])));
    } else if (formula == 2) {
        vec2 v = tangent_space(probe_3(x[0]), probe_3(x[1]), probe_3(x[2]), x[3].x > 0.5f);
        y[0] = vec4(v.x, v.y, 0.0f, 0.0f);
    } else if (formula == 3) {
        vec2 v = regression_gradient(probe_mat(x[0]), probe_2(x[1]));
        y[0] = vec4(v.x, v.y, 0.0f, 0.0f);
    } else if (formula == 4) {
        WaveEstimate c = estimate_wave(probe_mat(x[0]), probe_2(x[1]), probe_2(x[2]), probe_2(x[3]), x[1].w);
        y[0] = vec4(c.r, c.fullness, 0.0f, 0.0f);
        y[1] = vec4(c.k.x, c.k.y, 0.0f, 0.0f);
        y[2] = vec4(c.k_deformed.x, c.k_deformed.y, 0.0f, 0.0f);
    } else if (formula == 5) {
        y[0] = vec4(attenuation(x[0].x), to_nearest(x[0].y), wrapped(x[0].z), activity(x[0].w));
    } else if (formula == 6) {
        Link link = link_waves(probe_3(x[0]), probe_3(x[1]), probe_3(x[2]));
        y[0] = vec4(link.flip, link.offset, misfit(link, x[3].x, x[3].y), 0.0f);
    } else if (formula == 7) {
        y[0] = vec4(relaxed(x[0].x, x[0].y, x[0].z, x[0].w), 0.0f, 0.0f, 0.0f);
    } else if (formula == 8) {
        ProfilePlace place = profile_place(x[0].x);
        y[0] = vec4(float(place.index), place.fraction, place.sign, 0.0f);
    } else if (formula == 9) {
        UvSlopes slopes = uv_slopes(probe_3(x[0]), probe_3(x[1]), probe_2(x[2]), probe_2(x[3]));
        y[0] = probe_out(slopes.u);
        y[1] = probe_out(slopes.v);
        y[2] = vec4(slopes.area, 0.0f, 0.0f, 0.0f);
    } else if (formula == 10) {
        y[0] = probe_out(parallax(probe_3(x[0]), probe_3(x[1])));
    } else if (formula == 11) {
        mat2 m = restretched(probe_mat(x[0]), probe_3(x[1]));
        y[0] = vec4(m[0][0], m[0][1], m[1][0], m[1][1]);
    } else if (formula == 12) {
        Link link = link_waves(probe_3(x[0]), probe_3(x[1]), probe_3(x[2]));
        float agreed = agreement(probe_3(x[0]), probe_3(x[1]), link, x[3].x, x[3].y);
        y[0] = vec4(agreed, kept_at_fork(agreed), 0.0f, 0.0f);
    }
    return y;
}
