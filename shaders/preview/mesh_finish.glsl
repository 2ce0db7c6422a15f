// SPDX-License-Identifier: GPL-3.0-or-later
// What is kept of a solve: a vertex takes its share of it, and a held vertex keeps its offset.

void work(int v) {
    vec3 attachment = TEXEL(attachments, v).xyz, normal = TEXEL(normals, v).xyz;
    vec4 start = TEXEL(starts, v), bound = TEXEL(bounds, v);
    bool is_active = start.w > 0.0;
    vec3 p = is_active ? blended(start.xyz, READ(solved, v).xyz, start.w, damping) : start.xyz;
    vec3 inside = within_bounds(p, attachment, normal, bound.y, bound.x);
    bool is_kept = !is_active && distance(inside, p) <= kMeshHeldOutside * bound.x;
    WRITE(solved, v, vec4(is_kept ? p : inside, 0.0));
    if (is_kept) return;
    ivec3 corner = ivec3(TEXEL(places, v).xyz);
    MeshFrame frame = mesh_frame(TEXEL(positions, corner.x).xyz, TEXEL(positions, corner.y).xyz,
                                 TEXEL(positions, corner.z).xyz);
    WRITE(offsets, v, vec4(offset_to_frame(frame, inside - attachment), 0.0));
}
