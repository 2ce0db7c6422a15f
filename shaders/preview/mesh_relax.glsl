// SPDX-License-Identifier: GPL-3.0-or-later
// One pass of an iteration: equations (3) to (5) for the pair of every vertex, if it has one in this pass.

void main() {
    int v = THIS_TEXEL(pairs);
    vec4 pair = TEXEL(pairs, v);
    vec4 own = TEXEL(solved, v);
    out_solved = own;
    if (pair.x >= 0.0)
        out_solved.xyz = projected_pair(own.xyz, TEXEL(solved, int(pair.x)).xyz, TEXEL(lengths, v).x, pair.z);
}
