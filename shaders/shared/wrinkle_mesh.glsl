// SPDX-License-Identifier: GPL-3.0-or-later
// The formulas of the Wrinkle Mesh for one vertex. Source: M. Mueller and N. Chentanez, Wrinkle Meshes, SCA 2010; the
// equation numbers are the paper's. The solver (native/systems/wrinkle_mesh) computes them for four vertices at a time.
// One text for C++ (native/base/formulas.h) and GLSL (the viewport preview).

// As in native/base/tolerances.h, which says why.
const float kMeshShortestEdge = 1e-12f;
const float kMeshShortestNormal = 1e-3f;
const float kMeshHeldStrain = 2e-4f;
const float kMeshFreeStrain = 4e-3f;
const float kMeshHeldOutside = 1e-3f;

// ---- The pose (section 4)

// An orthonormal frame of a triangle, in which offsets are stored. A collapsed triangle has zero vectors.
struct MeshFrame {
    vec3 tangent;
    vec3 bitangent;
    vec3 normal;
};

FORMULA MeshFrame mesh_frame(vec3 p0, vec3 p1, vec3 p2) {
    MeshFrame frame;
    frame.tangent = vec3(0.0f);
    frame.bitangent = vec3(0.0f);
    frame.normal = vec3(0.0f);
    vec3 edge = p1 - p0;
    vec3 n = cross(edge, p2 - p0);
    float edge_length = length(edge);
    float n_length = length(n);
    if (edge_length < kMeshShortestEdge || n_length < kMeshShortestEdge * kMeshShortestEdge) return frame;
    frame.tangent = edge / edge_length;
    frame.normal = n / n_length;
    frame.bitangent = cross(frame.normal, frame.tangent);
    return frame;
}

FORMULA vec3 offset_to_object(MeshFrame frame, vec3 offset) {
    return offset.x * frame.tangent + offset.y * frame.bitangent + offset.z * frame.normal;
}

FORMULA vec3 offset_to_frame(MeshFrame frame, vec3 offset) {
    return vec3(dot(offset, frame.tangent), dot(offset, frame.bitangent), dot(offset, frame.normal));
}

// ---- The targets of a pair (section 4.1)

// stretched: s l0. at_attachments: the length of the pair there. relief, threshold, limit: stretch_relief,
// buckling_threshold and compression_limit of the settings. (Push constants have these names: Vulkan and Metal have them
// as macros.)
FORMULA float target_length(float stretched, float at_attachments, float relief, float threshold, float limit) {
    float target = stretched + relief * max(at_attachments - stretched, 0.0f);
    target -= clamp(target - at_attachments, 0.0f, threshold * target);
    return min(limit * at_attachments, target);
}

// 0 where the base has kept its shape along a pair since it was last solved, 1 where the pair is solved in full.
FORMULA float pair_activity(float at_attachments, float solved_length, float rest) {
    float change = abs(at_attachments - solved_length) / max(rest, kMeshShortestEdge);
    float t = clamp((change - kMeshHeldStrain) / (kMeshFreeStrain - kMeshHeldStrain), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

FORMULA float pair_compression(float at_attachments, float target) {
    return 1.0f - at_attachments / max(target, kMeshShortestEdge);
}

// The push that moves a vertex of an unbuckled surface off its attachment. push: its largest size. direction: -1..1, its share and side.
FORMULA vec3 unbuckled(vec3 p, vec3 attachment, vec3 normal, float compression, float push, float direction) {
    float size = push * min(1.0f, compression / 0.1f);  // from a compression of a tenth on the push is full
    if (distance(p, attachment) >= size) return p;
    return p + size * direction * normal;
}

// ---- One iteration (sections 3.1, 4.1 and 4.2)

// Equations (3) to (5), multiplied by a stiffness: the new place of a vertex of a pair.
FORMULA vec3 projected_pair(vec3 own, vec3 other, float target, float stiffness) {
    vec3 way = other - own;
    float now = length(way);
    if (now < kMeshShortestEdge) return own;
    return own + 0.5f * stiffness * (now - target) / now * way;
}

// tangential, along_normal: the shares of the distance to the attachment by which it is pulled back.
FORMULA vec3 pulled_back(vec3 p, vec3 attachment, vec3 normal, float tangential, float along_normal) {
    vec3 away = p - attachment;
    vec3 off = dot(away, normal) * normal;
    return p - (tangential * (away - off) + along_normal * off);
}

// Above the plane at a depth below the attachment (4.2), then in the ball around it: equation (7).
FORMULA vec3 within_bounds(vec3 p, vec3 attachment, vec3 normal, float depth, float radius) {
    float height = dot(p - attachment, normal);
    vec3 above = height < -depth ? p + (-depth - height) * normal : p;
    vec3 offset = above - attachment;
    float size = length(offset);
    return size > radius ? attachment + radius / size * offset : above;
}

// A vertex takes this share of a new solution. lost: the damping of the settings.
FORMULA vec3 blended(vec3 before, vec3 after, float share, float lost) {
    return before + share * (1.0f - lost) * (after - before);
}
