// SPDX-License-Identifier: GPL-3.0-or-later
// "Relax" (section 5.2): one round of equation (6), one texel per welded vertex. out_phase: phi, in x.

void main() {
    int v = THIS_TEXEL(vertices);
    vec4 own = TEXEL(vertices, v);
    int first = int(own.x), count = int(own.y);
    float phase = TEXEL(phases, v).x;
    float sum = 0.0;
    for (int i = first; i < first + count; ++i) {
        vec4 link = TEXEL(links, i);
        if (link.y > 0.0) sum += link.y * misfit(link_of(link.z, link.w), phase, TEXEL(phases, int(link.x)).x);
    }
    out_phase = vec4(relaxed(phase, sum, float(count), relax_rate * TEXEL(activities, v).x), 0.0, 0.0, 0.0);
}
