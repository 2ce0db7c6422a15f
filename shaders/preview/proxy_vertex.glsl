// SPDX-License-Identifier: GPL-3.0-or-later
// The coarse mesh that Blender draws meanwhile.
void main() {
    vec3 v = TEXEL(triangles, spot.x).xyz;
    gl_Position = on_screen(TEXEL(positions, int(v[spot.y])).xyz);
}
