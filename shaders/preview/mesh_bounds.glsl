// SPDX-License-Identifier: GPL-3.0-or-later
// The end of an iteration: the pull towards the attachment, and the bounds around it (3.1, 4.2).

void work(int v) {
    vec3 attachment = TEXEL(attachments, v).xyz, normal = TEXEL(normals, v).xyz;
    vec4 bound = TEXEL(bounds, v);
    vec3 p = pulled_back(READ(solved, v).xyz, attachment, normal, tangential_pull, normal_pull);
    WRITE(solved, v, vec4(within_bounds(p, attachment, normal, bound.y, bound.x), 0.0));
}
