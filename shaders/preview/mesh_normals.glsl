// SPDX-License-Identifier: GPL-3.0-or-later
// The normal of a shown vertex: the sum of its polygons' unit normals by their angles there, as in Blender.
//   corner_spans   first texel and number of texels in `corners`: the vertices after, opposite and before a corner

vec3 corner_normal(vec3 own, ivec3 others) {
    vec3 after = TEXEL(shown, others.x).xyz, before = TEXEL(shown, others.z).xyz;
    vec3 n = cross(TEXEL(shown, others.y).xyz - own, before - after);  // of a triangle, too: there `before` is opposite
    vec3 a = after - own, b = before - own;
    float size = length(n);
    return size > 0.0 ? atan(length(cross(a, b)), dot(a, b)) / size * n : vec3(0.0);
}

void work(int v) {
    vec4 span = TEXEL(corner_spans, v);
    vec3 own = TEXEL(shown, v).xyz, sum = vec3(0.0);
    for (int i = int(span.x); i < int(span.x + span.y); ++i) sum += corner_normal(own, ivec3(TEXEL(corners, i).xyz));
    WRITE(shown_normals, v, vec4(sum, 0.0));
}
