// SPDX-License-Identifier: GPL-3.0-or-later
// The share of every round that a vertex takes, one texel per welded vertex: the largest that its links ask for.
// out_share: that share, in x.

void main() {
    vec4 vertex = TEXEL(vertices, THIS_TEXEL(vertices));
    float share = 0.0;
    for (int i = int(vertex.x); i < int(vertex.x) + int(vertex.y); ++i) share = max(share, TEXEL(solved, i).y);
    out_share = vec4(share, 0.0, 0.0, 0.0);
}
