// SPDX-License-Identifier: GPL-3.0-or-later
// The share of every relaxation round that a vertex takes, one texel per welded vertex: the largest share of its links.
// out_activity: this share, in x.

void main() {
    vec4 own = TEXEL(vertices, THIS_TEXEL(vertices));
    float largest = 0.0;
    for (int i = int(own.x); i < int(own.x) + int(own.y); ++i) largest = max(largest, TEXEL(solved, i).y);
    out_activity = vec4(largest, 0.0, 0.0, 0.0);
}
