// SPDX-License-Identifier: GPL-3.0-or-later
// A vertex of the shown mesh is a sum of solved ones.
//   row_spans   first texel and number of texels in `rows`, which has two entries each: solved vertex, weight

void work(int v) {
    vec4 span = TEXEL(row_spans, v);
    vec3 place = vec3(0.0);
    for (int i = int(span.x); i < int(span.x + span.y); ++i) {
        vec4 two = TEXEL(rows, i);
        place += two.y * TEXEL(solved, int(two.x)).xyz + two.w * TEXEL(solved, int(two.z)).xyz;
    }
    WRITE(shown, v, vec4(place, 0.0));
}
