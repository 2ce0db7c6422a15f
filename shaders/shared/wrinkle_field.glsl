// SPDX-License-Identifier: GPL-3.0-or-later
// The formulas of the Wrinkle Field. Source: J. Loviscach, Wrinkling Coarse
// Meshes on the GPU, Eurographics 2006; equation numbers are the paper's.
// One text for C++ (native/base/formulas.h) and GLSL (the viewport preview).
// Needs tangents.glsl.

const float kTwoPi = 6.28318530717958648f;

// Unit: none. At a smaller compression ratio a neighbourhood has collapsed and has no wrinkle.
const float kCollapsed = 0.05f;

// Unit: none (sine of an angle). A tangent that is so close to the normal has no direction.
const float kNoTangent = 1e-3f;

// Unit: radians. A phase does not move by less than this, so that a standing figure comes to rest exactly. A
// ten-thousandth of a radian is 1/60,000 of a wavelength.
const float kStillPhase = 1e-4f;

// Unit: radians. See activity().
const float kHeldPhase = 2e-3f;
const float kFreePhase = 5e-2f;

// Number of intervals of a profile table over half a period.
const int kProfileIntervals = 64;

// ---- Crush (section 4.2)

// t of a tangent frame: the vector to a neighbour, projected along the unit normal n.
FORMULA vec3 tangent_towards(vec3 displacement, vec3 n) {
    vec3 t = displacement - dot(displacement, n) * n;
    float t_length = length(t);
    if (t_length <= kNoTangent * length(displacement)) return any_tangent(n);
    return t / t_length;
}

// v of a vector to a neighbour: its direction in tangent space with its own length. As in the paper (true_length
// false) it is the projection, which is shorter if the surface bends, so that bending alone would count as
// compression.
FORMULA vec2 tangent_space(vec3 displacement, vec3 t, vec3 b, bool true_length) {
    vec2 v = vec2(dot(t, displacement), dot(b, displacement));
    float v_length = length(v);
    if (!true_length || v_length <= kNoTangent * length(displacement)) return v;
    return v * (length(displacement) / v_length);
}

// v_i of equation (1) multiplied by the inverse of the sum of v_i (x) v_i, so that M = sum of v'_i (x)
// gradient_i. moments: this sum. Zero if the neighbours are collinear; then M is zero, as for a collapsed
// neighbourhood.
FORMULA vec2 regression_gradient(mat2 moments, vec2 v) {
    float det = moments[0][0] * moments[1][1] - moments[1][0] * moments[0][1];
    float trace = moments[0][0] + moments[1][1];
    if (det <= 1e-6f * trace * trace) return vec2(0.0f, 0.0f);
    return vec2(moments[1][1] * v.x - moments[1][0] * v.y, moments[0][0] * v.y - moments[0][1] * v.x) / det;
}

// The wave that the deformation of a neighbourhood requires.
struct WaveEstimate {
    float r;          // strongest compression: length / rest length, 1 = as at rest
    float fullness;   // amplitude / (W/4): fullness_of()
    vec2 k;           // direction of the compression, unit, in the rest frame; sign as `before`
    vec2 k_deformed;  // k' = (L^-1)^T k of section 5.1, in the deformed frame
};

// a (x) b. Metal has no such function.
FORMULA mat2 outer_product(vec2 a, vec2 b) { return mat2(a * b.x, a * b.y); }

// M of equation (1) with another stretch: the rotation of m times `stretch` (xx, xy, yy), a symmetric tensor in the
// rest frame.
FORMULA mat2 restretched(mat2 m, vec3 stretch) {
    vec2 turn = vec2(m[0][0] + m[1][1], m[0][1] - m[1][0]);
    float size = length(turn);
    turn = size > 0.0f ? turn / size : vec2(1.0f, 0.0f);
    return mat2(vec2(turn.x, turn.y), vec2(-turn.y, turn.x)) *
           mat2(vec2(stretch.x, stretch.y), vec2(stretch.y, stretch.z));
}

// Amplitude / (W/4), equation (2), for cloth with the compression r. r2: its square. Not in the paper: cloth that
// loses less than `threshold` of its length stays smooth. This does not affect the painted q, which alone gives
// 1 - q^2.
FORMULA float fullness_of(float r2, vec2 q, float threshold) {
    float smooth_part = 1.0f - threshold;
    float painted = 1.0f - dot(q, q);
    return sqrt(max(1.0f - min(r2 / (smooth_part * smooth_part), max(r2, painted * painted)), 0.0f));
}

// m: M of equation (1). q: painted rest-pose wrinkle in the rest frame, shorter than 1 (section 7). before: k of the
// frame before, or zero. turn: (cos, sin) of the angle by which irregularity rotates the wave away from k. threshold:
// as in fullness_of().
FORMULA WaveEstimate estimate_wave(mat2 m, vec2 q, vec2 before, vec2 turn, float threshold) {
    mat2 mq = m * (mat2(1.0f) - outer_product(q, q));  // M (E - q (x) q)
    mat2 c = transpose(mq) * mq;
    float mean = 0.5f * (c[0][0] + c[1][1]);
    float half_difference = 0.5f * (c[0][0] - c[1][1]);
    float large = mean + sqrt(half_difference * half_difference + c[1][0] * c[1][0]);
    float det = mq[0][0] * mq[1][1] - mq[1][0] * mq[0][1];
    WaveEstimate result;
    // The smaller eigenvalue from the determinant: no cancellation if it is small.
    float r2 = large > 0.0f ? det * det / large : 0.0f;
    result.r = sqrt(r2);
    // The longer column of C - large E is the eigenvector of the smaller one.
    vec2 column_0 = vec2(c[0][0] - large, c[0][1]);
    vec2 column_1 = vec2(c[1][0], c[1][1] - large);
    vec2 k = dot(column_0, column_0) > dot(column_1, column_1) ? column_0 : column_1;
    float k_length = length(k);
    k = k_length > 1e-6f * large ? k / k_length : (dot(before, before) > 0.0f ? before : vec2(1.0f, 0.0f));
    if (dot(k, before) < 0.0f) k = -k;
    result.k = k;
    result.fullness = 0.0f;
    result.k_deformed = vec2(0.0f, 0.0f);
    if (result.r < kCollapsed) return result;
    result.fullness = fullness_of(r2, q, threshold);
    vec2 turned = vec2(turn.x * k.x - turn.y * k.y, turn.y * k.x + turn.x * k.y);
    // (M^-1)^T from the cofactors of M.
    result.k_deformed =
        vec2(mq[1][1] * turned.x - mq[0][1] * turned.y, mq[0][0] * turned.y - mq[1][0] * turned.x) / det;
    return result;
}

// ---- Relax (section 5.2)

// The weight of a neighbour. In the paper it is max(min(4 h - 0.2, 1), 0) with h in the unit of its scene. Here h is
// relative to W/4, its largest value.
FORMULA float attenuation(float fullness) { return clamp(4.0f * fullness - 0.2f, 0.0f, 1.0f); }

// x - floor(x + 1/2): the difference from the nearest integer, in [-1/2, 1/2).
FORMULA float to_nearest(float x) { return x - floor(x + 0.5f); }

// The relation of the phases of two neighbours, half-way between them:
// psi_n - psi_0 = flip phi_n - phi_0 + offset.
struct Link {
    float flip;    // sgn(k'_n . k'_0)
    float offset;  // radians
};

FORMULA Link link_of(float flip, float offset) {
    Link result;
    result.flip = flip;
    result.offset = offset;
    return result;
}

// wave_vector: 2 pi / W k', radians per object unit. displacement: x'_n - x'_0; p = (x'_0 + x'_n) / 2.
FORMULA Link link_waves(vec3 wave_vector, vec3 neighbour_wave_vector, vec3 displacement) {
    Link result;
    result.flip = dot(neighbour_wave_vector, wave_vector) < 0.0f ? -1.0f : 1.0f;
    result.offset = -0.5f * (result.flip * dot(neighbour_wave_vector, displacement) + dot(wave_vector, displacement));
    return result;
}

// (psi_n - psi_0) / 2 pi - i of the error E_0, in turns, with the integer i that makes it smallest.
FORMULA float misfit(Link link, float phase, float neighbour_phase) {
    return to_nearest((link.flip * neighbour_phase - phase + link.offset) / kTwoPi);
}

// The share of a relaxation round for a link whose offset has changed by this amount (radians) since it was last
// relaxed: 0 below the jitter of bone matrices, 1 from where the change becomes visible. It starts with a jump. With a
// smooth start, slow drift would be relaxed by almost nothing and then count as done, so it would never be followed.
FORMULA float activity(float change) {
    return abs(change) < kHeldPhase ? 0.0f : min(abs(change) / kFreePhase, 1.0f);
}

// A phase in [-pi, pi).
FORMULA float wrapped(float phase) { return kTwoPi * to_nearest(phase / kTwoPi); }

// Equation (6): phi_0 - epsilon dE_0/dphi_0, with dE_0/dphi_0 = -1/(pi N) sum of w_n misfit_n.
// rate = epsilon / (2 pi^2): 1 gives the mean of the neighbours' values. Stable below 1, because then the steps of
// neighbours never overshoot together.
FORMULA float relaxed(float phase, float weighted_misfit_sum, float neighbours, float rate) {
    if (neighbours <= 0.0f) return phase;
    float change = rate * kTwoPi * weighted_misfit_sum / neighbours;
    return abs(change) < kStillPhase ? phase : wrapped(phase + change);
}

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
