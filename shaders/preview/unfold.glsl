// SPDX-License-Identifier: GPL-3.0-or-later
// Gradients of the texture (equation 11), one texel per fan of corners: the mean over the fan's triangles, weighted by
// area, so that there are no gaps at their edges.
//   fans         first corner in fan_corners, number of corners
//   fan_corners  two texels each: the vertices A, B, C of its triangle; uv_B - uv_A, uv_C - uv_A
// out_u, out_v: du/dx', dv/dx'.

void main() {
    vec4 fan = TEXEL(fans, THIS_TEXEL(fans));
    vec3 u = vec3(0.0), v = vec3(0.0);
    float area = 0.0;
    for (int i = int(fan.x); i < int(fan.x) + int(fan.y); ++i) {
        vec4 triangle = TEXEL(fan_corners, 2 * i);
        vec4 uv = TEXEL(fan_corners, 2 * i + 1);
        vec3 a = TEXEL(positions, int(triangle.x)).xyz;
        UvSlopes slopes = uv_slopes(TEXEL(positions, int(triangle.y)).xyz - a,
                                    TEXEL(positions, int(triangle.z)).xyz - a, uv.xy, uv.zw);
        u += slopes.u;
        v += slopes.v;
        area += slopes.area;
    }
    float scale = area > 0.0 ? 1.0 / area : 0.0;
    out_u = vec4(scale * u, 0.0);
    out_v = vec4(scale * v, 0.0);
}
