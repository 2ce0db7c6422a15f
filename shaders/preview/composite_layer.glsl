// SPDX-License-Identifier: GPL-3.0-or-later
// Draws a layer into the viewport. If Blender's proxy is nearer than the layer, the layer takes the proxy's depth. So
// only objects in front of the proxy hide it, and overlays. A depth of 0 means an empty pixel.
void main() {
    ivec2 at = ivec2(gl_FragCoord.xy) - origin;
    float ours = texelFetch(layer_depth, at, 0).x, theirs = texelFetch(proxy_depth, at, 0).x;
    if (ours <= 0.0) discard;
    out_color = under_overlays(texelFetch(layer, at, 0), at);
    gl_FragDepth = theirs > 0.0 ? min(ours, theirs) : ours;
}
