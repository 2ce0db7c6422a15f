// SPDX-License-Identifier: GPL-3.0-or-later
// The proxy that Blender draws instead of the folds: flat triangles with the same vertices.
void main() {
    vec3 v = TEXEL(triangles, spot.x).xyz;
    gl_Position = on_screen(TEXEL(smooths, int(v[spot.y])).xyz);
}
