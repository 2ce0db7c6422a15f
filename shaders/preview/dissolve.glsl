// SPDX-License-Identifier: GPL-3.0-or-later
// The waves as they are drawn, one texel per welded vertex. They are lower where they disagree with waves around them.
//   waves      wave vector and h, from "Crush"
// out_waves: the same with the reduced h.

void main() {
    int v = THIS_TEXEL(vertices);
    vec4 own = TEXEL(vertices, v);
    vec4 wave = TEXEL(waves, v);
    float phase = TEXEL(phases, v).x;
    float sum = 1.0, weights = 1.0;
    for (int i = int(own.x); i < int(own.x) + int(own.y); ++i) {
        vec4 link = TEXEL(links, i);
        int n = int(link.x);
        sum += link.y * agreement(wave.xyz, TEXEL(waves, n).xyz, link_of(link.z, link.w), phase, TEXEL(phases, n).x);
        weights += link.y;
    }
    out_waves = vec4(wave.xyz, wave.w * kept_at_fork(sum / weights));
}
