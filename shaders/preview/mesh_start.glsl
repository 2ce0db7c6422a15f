// SPDX-License-Identifier: GPL-3.0-or-later
// Where a vertex starts: at its offset from the frame before, pushed if nothing has buckled there.
//   bounds    radius, depth, size of the push, its share and side
//   starts    w: how far it is active

void work(int v) {
    vec4 span = TEXEL(pair_spans, v), change = TEXEL(changes, v), bound = TEXEL(bounds, v);
    float share = change.x;
    for (int k = int(span.x); k < int(span.x + span.z); ++k) {  // distances: no hard border between held and solved
        vec4 pair = TEXEL(pairs, int(TEXEL(pairs_of, k / 4)[k % 4]));
        share = max(share, 0.5 * TEXEL(changes, int(pair.x) + int(pair.y) - v).x);
    }
    ivec3 corner = ivec3(TEXEL(places, v).xyz);
    MeshFrame frame = mesh_frame(TEXEL(positions, corner.x).xyz, TEXEL(positions, corner.y).xyz,
                                 TEXEL(positions, corner.z).xyz);
    vec3 attachment = TEXEL(attachments, v).xyz;
    vec3 start = attachment + offset_to_object(frame, TEXEL(offsets, v).xyz);
    WRITE(starts, v, vec4(start, share));
    WRITE(solved, v, vec4(unbuckled(start, attachment, TEXEL(normals, v).xyz, change.y, bound.z, bound.w), 0.0));
}
