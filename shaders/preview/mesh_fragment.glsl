// SPDX-License-Identifier: GPL-3.0-or-later
// The viewport's studio light on the shown mesh. The result is a layer with its own depth.

void main() {
    float size = length(normal);
    vec3 base = preview.has_image > 0.0 ? texture(image, image_uv).rgb : preview.color.rgb;
    out_color = drawn_color(base, size > 0.0 ? normal / size : vec3(0.0, 0.0, 1.0), place);
    out_depth = gl_FragCoord.z;
}
