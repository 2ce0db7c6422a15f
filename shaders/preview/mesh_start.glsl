// SPDX-License-Identifier: GPL-3.0-or-later
// Where every vertex starts: at its offset from the frame before, pushed if nothing has buckled there.
//   neighbour_spans   first entry and number of entries in `neighbours`, which has four vertices in a texel
//   bounds            radius, depth, size of the push, its noise

void main() {
    int v = THIS_TEXEL(changes);
    vec4 change = TEXEL(changes, v), span = TEXEL(neighbour_spans, v), bound = TEXEL(bounds, v);
    float active_share = change.x;
    for (int i = int(span.x); i < int(span.x + span.y); ++i) {
        int neighbour = int(TEXEL(neighbours, i / 4)[i % 4]);
        active_share = max(active_share, 0.5 * TEXEL(changes, neighbour).x);  // no hard border between held and solved
    }
    ivec3 corner = ivec3(TEXEL(places, v).xyz);
    MeshFrame frame = mesh_frame(TEXEL(positions, corner.x).xyz, TEXEL(positions, corner.y).xyz,
                                 TEXEL(positions, corner.z).xyz);
    vec3 attachment = TEXEL(attachments, v).xyz;
    vec3 start = attachment + offset_to_object(frame, TEXEL(offsets, v).xyz);
    out_start = vec4(start, active_share);
    out_solved = vec4(unbuckled(start, attachment, TEXEL(normals, v).xyz, change.y, bound.z, bound.w), 0.0);
}
