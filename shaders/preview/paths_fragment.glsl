// SPDX-License-Identifier: GPL-3.0-or-later
// Section 7.4: the normal of every pixel, from the same lists as the shape, then the viewport's studio light. The
// result is a layer with its own depth.

void main() {
    float size = length(normal);
    vec3 n = size > 0.0 ? normal / size : vec3(0.0, 0.0, 1.0);
    vec3 base = preview.has_image > 0.0 ? texture(image, image_uv).rgb : preview.color.rgb;
    out_color = drawn_color(base, blended_normal(folds_at(list, flat_place, n, hem), n), place);
    out_depth = gl_FragCoord.z;
}
