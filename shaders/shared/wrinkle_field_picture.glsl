// SPDX-License-Identifier: GPL-3.0-or-later
// The formulas that show the waves of wrinkle_field.glsl: forks, profiles and shading. Source: J. Loviscach,
// Wrinkling Coarse Meshes on the GPU, Eurographics 2006; equation numbers are the paper's.
// One text for C++ (native/base/formulas.h) and GLSL (the viewport preview).
// Needs wrinkle_field.glsl.

// Number of intervals of a profile table over half a period.
const int kProfileIntervals = 64;

// ---- Where waves disagree (not in the paper)

// How well the waves of a neighbour and a vertex agree half-way between them, -1..1: the real part of exp(i psi_n) /
// exp(i psi_0), times the cosine of the angle between both waves, because waves in different directions have no common
// phase. wave_vector, neighbour_wave_vector: the arguments of link_waves() that gave `link`.
FORMULA float agreement(vec3 wave_vector, vec3 neighbour_wave_vector, Link link, float phase, float neighbour_phase) {
    float lengths = length(wave_vector) * length(neighbour_wave_vector);
    if (lengths <= 0.0f) return 0.0f;
    float angle = abs(dot(wave_vector, neighbour_wave_vector)) / lengths;
    return angle * cos(kTwoPi * misfit(link, phase, neighbour_phase));
}

// Share of its height that a wave keeps. agreed: weighted mean of the agreement with itself (1) and with the
// neighbours. Below kFork waves fork there: 0. From kInStep on they run side by side: 1. A vertex in the middle of a
// fork agrees only with itself: 1 / (n + 1) with n neighbours, a fifth with four and less with more. Waves with a phase
// difference of an eighth of a turn agree by cos(pi / 4) = 0.7. Up to this, the eye still joins their crests.
const float kFork = 0.2f;
const float kInStep = 0.7f;
FORMULA float kept_at_fork(float agreed) {
    float x = clamp((agreed - kFork) / (kInStep - kFork), 0.0f, 1.0f);
    return x * x * (3.0f - 2.0f * x);
}

// ---- Profiles (section 6.3)

// The place of a phase in the table of half a period. The other half is its mirror image, so f is 2 pi periodic and
// f(phi) = f(-phi) by construction.
struct ProfilePlace {
    int index;       // 0 .. kProfileIntervals - 1
    float fraction;  // of the distance to the next entry
    float sign;      // of df/dphi, which is odd
};

FORMULA ProfilePlace profile_place(float phase) {
    float turn = to_nearest(phase / kTwoPi);
    float x = 2.0f * abs(turn) * float(kProfileIntervals);
    x = x >= 0.0f ? x : 0.0f;  // a phase that is no number has a place, too: int(x) of it would be any
    ProfilePlace place;
    place.index = min(int(x), kProfileIntervals - 1);
    place.fraction = x - float(place.index);
    place.sign = turn < 0.0f ? -1.0f : 1.0f;
    return place;
}

// ---- Rendering (section 6.2)

// Unit: none (sine of an angle). Corners on a line leave an area below this from rounding, which differs if products
// are fused, as on graphics cards. Its direction is random, but would count as much as a neighbour's.
const float kNoTriangle = 1e-6f;

// Contribution of a deformed triangle ABC to the gradients of uv, times its area. Corners take the mean of their fan.
struct UvSlopes {
    vec3 u;      // du/dx' of equation (11) times `area`, 1 per object unit
    vec3 v;
    float area;  // twice the triangle's area, > 0; or zero, with zero slopes
};

// b = x'_B - x'_A, c = x'_C - x'_A; uv_b, uv_c: the same differences of uv.
FORMULA UvSlopes uv_slopes(vec3 b, vec3 c, vec2 uv_b, vec2 uv_c) {
    UvSlopes result;
    vec3 normal = cross(b, c);
    result.area = length(normal);
    if (result.area <= kNoTriangle * length(b) * length(c)) result.area = 0.0f;
    vec3 n = result.area > 0.0f ? normal / result.area : vec3(0.0f);
    result.u = uv_b.x * cross(c, n) + uv_c.x * cross(n, b);
    result.v = uv_b.y * cross(c, n) + uv_c.y * cross(n, b);
    return result;
}

// Equation (10) without its factor h: the vector along the surface to the point where the ray through a crest of height
// 1 meets it. v: towards the viewer, any length; n: unit normal. Zero at the horizon.
FORMULA vec3 parallax(vec3 v, vec3 n) {
    float facing = dot(v, n);
    return (v - facing * n) * (facing / (facing * facing + 0.1f * dot(v, v)));
}
