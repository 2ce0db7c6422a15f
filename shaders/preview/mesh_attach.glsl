// SPDX-License-Identifier: GPL-3.0-or-later
// "Attach" (section 4): the attachment of a solved vertex in this pose, and the normal there.
//   places    welded vertices A, B, C of the base's triangle
//   spans     weights of B and C; first texel and number of texels in `limits`: none without limit surface
//   limits    two entries each: welded vertex, weight
//   curved    1: PN triangles, 0: flat ones

void work(int v) {
    ivec3 corner = ivec3(TEXEL(places, v).xyz);
    vec4 span = TEXEL(spans, v);
    vec3 n0 = TEXEL(base_normals, corner.x).xyz, n1 = TEXEL(base_normals, corner.y).xyz,
         n2 = TEXEL(base_normals, corner.z).xyz;
    vec3 sum = (1.0 - span.x - span.y) * n0 + span.x * n1 + span.y * n2;
    float size = length(sum);
    WRITE(normals, v, vec4(size > kMeshShortestNormal ? sum / size : vec3(0.0), 0.0));
    int begin = int(span.z), end = begin + int(span.w);
    vec3 place = vec3(0.0);
    for (int i = begin; i < end; ++i) {
        vec4 two = TEXEL(limits, i);
        place += two.y * TEXEL(positions, int(two.x)).xyz + two.w * TEXEL(positions, int(two.z)).xyz;
    }
    if (begin == end)
        place = pn_point(TEXEL(positions, corner.x).xyz, TEXEL(positions, corner.y).xyz,
                         TEXEL(positions, corner.z).xyz, curved * n0, curved * n1, curved * n2, span.x, span.y);
    WRITE(attachments, v, vec4(place, 0.0));
}
