// SPDX-License-Identifier: GPL-3.0-or-later
// The targets of the pairs of one pass (section 4.1), and how much their vertices have to move.
//   pairs        the other vertex or -1, s l0, stiffness, l0
//   former       attachments of the frame before
//   starts       w: what was active in the frame before
//   lengths      of the frame before: target, length when it was solved last
//   changes      of the passes before: activity, compression

void main() {
    int v = THIS_TEXEL(pairs);
    vec4 pair = TEXEL(pairs, v);
    vec4 change = is_first ? vec4(0.0) : TEXEL(changes, v);
    out_length = vec4(0.0);
    out_change = change;
    if (pair.x < 0.0) return;
    int other = int(pair.x);
    float now = distance(TEXEL(attachments, v).xyz, TEXEL(attachments, other).xyz);
    bool held = TEXEL(starts, v).w <= 0.0 && TEXEL(starts, other).w <= 0.0;
    float solved = held ? TEXEL(lengths, v).y : distance(TEXEL(former, v).xyz, TEXEL(former, other).xyz);
    float target = target_length(pair.y, now, stretch_relief, buckling_threshold, compression_limit);
    out_length = vec4(target, solved, 0.0, 0.0);
    out_change.x = max(change.x, pair_activity(now, solved, pair.w));
    if (is_distance) out_change.y = max(change.y, pair_compression(now, target));
}
