// SPDX-License-Identifier: GPL-3.0-or-later
// Puts a drawn layer into the viewport. Where Blender's proxy is before the layer, the layer is as near as that:
// only what is before the proxy hides it, and overlays. Depths are 0 where nothing is.
void main() {
    ivec2 at = ivec2(gl_FragCoord.xy) - origin;
    float ours = texelFetch(layer_depth, at, 0).x, theirs = texelFetch(proxy_depth, at, 0).x;
    if (ours <= 0.0) discard;
    out_color = under_overlays(texelFetch(layer, at, 0), at);
    gl_FragDepth = theirs > 0.0 ? min(ours, theirs) : ours;
}
