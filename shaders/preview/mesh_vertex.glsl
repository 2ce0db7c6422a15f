// SPDX-License-Identifier: GPL-3.0-or-later
// The shown mesh on the screen. vertex: its vertex; uv: of the corner.

void main() {
    place = TEXEL(shown, vertex).xyz;
    normal = TEXEL(shown_normals, vertex).xyz;
    image_uv = uv;
    gl_Position = on_screen(place);
}
