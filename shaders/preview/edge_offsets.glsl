// SPDX-License-Identifier: GPL-3.0-or-later
// The values that stay the same in all rounds of a frame, one texel per neighbour of a vertex.
//   solved     the offset that was last relaxed, in x
// out_link: neighbour, its weight, Link; out_solved: the offset that now counts as relaxed, its activity.

void main() {
    int i = THIS_TEXEL(neighbours);
    vec4 neighbour = TEXEL(neighbours, i);
    int v = int(neighbour.w), n = int(neighbour.x);
    Link link = link_waves(TEXEL(waves, v).xyz, TEXEL(waves, n).xyz, TEXEL(positions, n).xyz - TEXEL(positions, v).xyz);
    float weight = attenuation(TEXEL(estimate, n).z);
    float before = TEXEL(solved, i).x;
    float act = weight > 0.0 ? activity(link.offset - before) : 0.0;
    out_link = vec4(neighbour.x, weight, link.flip, link.offset);
    out_solved = vec4(act > 0.0 ? link.offset : before, act, 0.0, 0.0);
}
