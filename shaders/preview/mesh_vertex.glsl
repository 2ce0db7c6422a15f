// SPDX-License-Identifier: GPL-3.0-or-later
// The shown mesh on the screen. uv: of the corner.

void main() {
    place = TEXEL(shown, shown_vertex).xyz;
    normal = TEXEL(shown_normals, shown_vertex).xyz;
    image_uv = uv;
    gl_Position = on_screen(place);
}
