// SPDX-License-Identifier: GPL-3.0-or-later
// What does not change between the rounds of a frame, one texel per neighbour of a vertex.
// out_link: neighbour, its weight, Link.

void main() {
    vec4 neighbour = TEXEL(neighbours, THIS_TEXEL(neighbours));
    int v = int(neighbour.w), n = int(neighbour.x);
    Link link = link_waves(TEXEL(waves, v).xyz, TEXEL(waves, n).xyz, TEXEL(positions, n).xyz - TEXEL(positions, v).xyz);
    out_link = vec4(neighbour.x, attenuation(TEXEL(crushed, n).z), link.flip, link.offset);
}
