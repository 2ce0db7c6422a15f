// SPDX-License-Identifier: GPL-3.0-or-later
// Section 7.3: patterns with `parts` parts per edge on the triangles. wrinkle_paths::drawn_at() computes the same.
//   spot       index of the patch from `first_patch` on, steps of 1 / parts towards corners 1 and 2
//   patches    two texels each: triangle, its first range and the end of its ranges; parts of its edges
//   triangles  welded vertices
//   flats      welded vertices, w: factor on folds;  smooths, normals: see Drawing in wrinkle_paths/preview.h
//   uvs        three per triangle

// Weights of the corners. On an edge with fewer parts than the triangle it is the nearest point of the edge.
vec3 weights_of(ivec2 steps, ivec3 edges) {
    vec3 b = vec3(parts - steps.x - steps.y, steps.x, steps.y) / float(parts);
    for (int k = 0; k < 3; ++k) {
        int next = (k + 1) % 3;
        if (b[(k + 2) % 3] > 0.0) continue;
        b[next] = floor(b[next] * float(edges[k]) + 0.5) / float(edges[k]);
        b[k] = 1.0 - b[next];
        break;
    }
    return b;
}

void main() {
    vec4 patch_lists = TEXEL(patches, 2 * (first_patch + spot.x));
    int t = int(patch_lists.x);
    vec3 b = weights_of(spot.yz, ivec3(TEXEL(patches, 2 * (first_patch + spot.x) + 1).xyz));
    image_uv = b.x * TEXEL(uvs, 3 * t).xy + b.y * TEXEL(uvs, 3 * t + 1).xy + b.z * TEXEL(uvs, 3 * t + 2).xy;

    // In ascending order of vertices. Both triangles at an edge then compute the edge's points from the same numbers in
    // the same order, so there are no gaps.
    ivec3 v = ivec3(TEXEL(triangles, t).xyz);
    if (v.x > v.y) { v = v.yxz; b = b.yxz; }
    if (v.y > v.z) { v = v.xzy; b = b.xzy; }
    if (v.x > v.y) { v = v.yxz; b = b.yxz; }
    vec4 flat_hem = b.x * TEXEL(flats, v.x) + b.y * TEXEL(flats, v.y) + b.z * TEXEL(flats, v.z);
    vec3 p0 = TEXEL(smooths, v.x).xyz, p1 = TEXEL(smooths, v.y).xyz, p2 = TEXEL(smooths, v.z).xyz;
    vec3 n0 = TEXEL(normals, v.x).xyz, n1 = TEXEL(normals, v.y).xyz, n2 = TEXEL(normals, v.z).xyz;
    normal = b.x * n0 + b.y * n1 + b.z * n2;
    float size = length(normal);
    vec3 n = size > 0.0 ? normal / size : vec3(0.0);

    list = ivec2(patch_lists.yz);
    flat_place = flat_hem.xyz;
    hem = flat_hem.w;
    float height = folds_at(list, flat_place, n, hem).height;
    place = pn_point(p0, p1, p2, curved * n0, curved * n1, curved * n2, b.y, b.z) + height * n;
    gl_Position = on_screen(place);
}
