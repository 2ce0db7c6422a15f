// SPDX-License-Identifier: GPL-3.0-or-later
// What Blender draws in place of the folds: straight triangles over the same vertices.
void main() {
    vec3 v = TEXEL(triangles, spot.x).xyz;
    gl_Position = on_screen(TEXEL(smooths, int(v[spot.y])).xyz);
}
