// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps overlays that Blender has already drawn (bones, outlines, wires, empties) above what is drawn here.
// overlays: their pixels, multiplied by alpha, then in sRGB unless overlays_are_linear.
float linear_of(float value) {
    return value < 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4);
}

// color: scene linear. at: pixel of the viewport. The overlays begin at overlays_corner.
vec4 under_overlays(vec4 color, ivec2 at) {
    ivec2 texel = at - overlays_corner, size = textureSize(overlays, 0);
    if (min(texel.x, texel.y) < 0 || texel.x >= size.x || texel.y >= size.y) return color;
    vec4 above = texelFetch(overlays, texel, 0);
    if (max(above.a, max(above.r, max(above.g, above.b))) <= 0.0) return color;
    vec3 linear = overlays_are_linear != 0
        ? above.rgb
        : vec3(linear_of(above.r), linear_of(above.g), linear_of(above.b));
    return vec4(linear + (1.0 - above.a) * clamp(color.rgb, 0.0, 1.0), 1.0);
}
