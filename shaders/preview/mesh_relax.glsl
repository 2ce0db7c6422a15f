// SPDX-License-Identifier: GPL-3.0-or-later
// One pass of an iteration: equations (3) to (5) for a pair. The pairs of a pass share no vertex.

void work(int i) {
    vec4 pair = TEXEL(pairs, i), now = TEXEL(lengths, i);
    int a = int(pair.x), b = int(pair.y);
    vec3 p1 = READ(solved, a).xyz, p2 = READ(solved, b).xyz;
    WRITE(solved, a, vec4(projected_pair(p1, p2, now.x, now.z), 0.0));
    WRITE(solved, b, vec4(projected_pair(p2, p1, now.x, now.z), 0.0));
}
