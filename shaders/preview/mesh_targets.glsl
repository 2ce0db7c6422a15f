// SPDX-License-Identifier: GPL-3.0-or-later
// The target of a pair (section 4.1).
//   pairs     two vertices, s l0, l0
//   starts    w: how far a vertex was active in the frame before
//   lengths   target, length at the attachments when it was solved last, stiffness, length in this frame

void work(int i) {
    vec4 pair = TEXEL(pairs, i), before = READ(lengths, i);
    int a = int(pair.x), b = int(pair.y);
    float now = distance(TEXEL(attachments, a).xyz, TEXEL(attachments, b).xyz);
    bool held = TEXEL(starts, a).w <= 0.0 && TEXEL(starts, b).w <= 0.0;
    float target = target_length(pair.z, now, stretch_relief, buckling_threshold, compression_limit);
    WRITE(lengths, i, vec4(target, held ? before.y : before.w, before.z, now));
}
