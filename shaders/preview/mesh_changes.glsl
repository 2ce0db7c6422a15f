// SPDX-License-Identifier: GPL-3.0-or-later
// What has changed around a vertex: x: how far it is active, of all its pairs; y: the largest compression, of those that
// keep distances.
//   pair_spans   first entry, number of entries, and number of distance pairs, which come first, in `pairs_of`
//   pairs_of     four pairs in a texel

void work(int v) {
    vec4 span = TEXEL(pair_spans, v);
    vec2 change = vec2(0.0);
    for (int k = 0; k < int(span.y); ++k) {
        int at = int(span.x) + k, i = int(TEXEL(pairs_of, at / 4)[at % 4]);
        vec4 now = TEXEL(lengths, i);
        change.x = max(change.x, pair_activity(now.w, now.y, TEXEL(pairs, i).w));
        if (k < int(span.z)) change.y = max(change.y, pair_compression(now.w, now.x));
    }
    WRITE(changes, v, vec4(change, 0.0, 0.0));
}
