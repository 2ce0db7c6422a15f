// SPDX-License-Identifier: GPL-3.0-or-later
// The formulas of the Wrinkle Field's solver. Source: J. Loviscach, Wrinkling Coarse
// Meshes on the GPU, Eurographics 2006; equation numbers are the paper's.
// One text for C++ (native/base/formulas.h; lane_formulas.h for four vertices at a time) and GLSL (the viewport
// preview). For four vertices REAL is four floats, so formulas choose between two values instead of branching.
// nearest_integer() is elementary.h's, and GLSL's round().
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

// ---- Crush (section 4.2)

// t of a tangent frame: the vector to a neighbour, projected along the unit normal n.
FORMULA vec3 tangent_towards(vec3 displacement, vec3 n) {
    vec3 t = displacement - dot(displacement, n) * n;
    REAL t_length = length(t);
    return chosen(t_length <= kNoTangent * length(displacement), any_tangent(n), t / t_length);
}

// v of a vector to a neighbour: its direction in tangent space with its own length. As in the paper (true_length
// false) it is the projection, which is shorter if the surface bends, so that bending alone would count as
// compression.
FORMULA vec2 tangent_space(vec3 displacement, vec3 t, vec3 b, bool true_length) {
    vec2 v = vec2(dot(t, displacement), dot(b, displacement));
    REAL v_length = length(v);
    if (!true_length) return v;
    REAL d_length = length(displacement);
    return chosen(v_length <= kNoTangent * d_length, v, v * (d_length / v_length));
}

// v_i of equation (1) multiplied by the inverse of the sum of v_i (x) v_i, so that M = sum of v'_i (x)
// gradient_i. moments: this sum. Zero if the neighbours are collinear; then M is zero, as for a collapsed
// neighbourhood.
FORMULA vec2 regression_gradient(mat2 moments, vec2 v) {
    REAL det = moments[0][0] * moments[1][1] - moments[1][0] * moments[0][1];
    REAL trace = moments[0][0] + moments[1][1];
    vec2 gradient = vec2(moments[1][1] * v.x - moments[1][0] * v.y, moments[0][0] * v.y - moments[0][1] * v.x) / det;
    return chosen(det <= 1e-6f * trace * trace, vec2(0.0f, 0.0f), gradient);
}

// The wave that the deformation of a neighbourhood requires.
struct WaveEstimate {
    REAL r;           // strongest compression: length / rest length, 1 = as at rest
    REAL fullness;    // amplitude / (W/4): fullness_of()
    vec2 k;           // direction of the compression, unit, in the rest frame; sign as `before`
    vec2 k_deformed;  // k' = (L^-1)^T k of section 5.1, in the deformed frame
};

// a (x) b. Metal has no such function.
FORMULA mat2 outer_product(vec2 a, vec2 b) { return mat2(a * b.x, a * b.y); }

// M of equation (1) with another stretch: the rotation of m times `stretch` (xx, xy, yy), a symmetric tensor in the
// rest frame.
FORMULA mat2 restretched(mat2 m, vec3 stretch) {
    vec2 turn = vec2(m[0][0] + m[1][1], m[0][1] - m[1][0]);
    REAL size = length(turn);
    turn = chosen(size > 0.0f, turn / size, vec2(1.0f, 0.0f));
    return mat2(vec2(turn.x, turn.y), vec2(-turn.y, turn.x)) *
           mat2(vec2(stretch.x, stretch.y), vec2(stretch.y, stretch.z));
}

// Amplitude / (W/4), equation (2), for cloth with the compression r. r2: its square. Not in the paper: cloth that
// loses less than `threshold` of its length stays smooth. This does not affect the painted q, which alone gives
// 1 - q^2.
FORMULA REAL fullness_of(REAL r2, vec2 q, float threshold) {
    float smooth_part = 1.0f - threshold;
    REAL painted = 1.0f - dot(q, q);
    return sqrt(max(1.0f - min(r2 / (smooth_part * smooth_part), max(r2, painted * painted)), 0.0f));
}

// m: M of equation (1). q: painted rest-pose wrinkle in the rest frame, shorter than 1 (section 7). before: k of the
// frame before, or zero. turn: (cos, sin) of the angle by which irregularity rotates the wave away from k. threshold:
// as in fullness_of().
FORMULA WaveEstimate estimate_wave(mat2 m, vec2 q, vec2 before, vec2 turn, float threshold) {
    mat2 mq = m * (mat2(1.0f) - outer_product(q, q));  // M (E - q (x) q)
    mat2 c = transpose(mq) * mq;
    REAL mean = 0.5f * (c[0][0] + c[1][1]);
    REAL half_difference = 0.5f * (c[0][0] - c[1][1]);
    REAL large = mean + sqrt(half_difference * half_difference + c[1][0] * c[1][0]);
    REAL det = mq[0][0] * mq[1][1] - mq[1][0] * mq[0][1];
    WaveEstimate result;
    // The smaller eigenvalue from the determinant: no cancellation if it is small.
    REAL r2 = large > 0.0f ? det * det / large : 0.0f;
    result.r = sqrt(r2);
    // The longer column of C - large E is the eigenvector of the smaller one.
    vec2 column_0 = vec2(c[0][0] - large, c[0][1]);
    vec2 column_1 = vec2(c[1][0], c[1][1] - large);
    vec2 k = chosen(dot(column_0, column_0) > dot(column_1, column_1), column_0, column_1);
    REAL k_length = length(k);
    vec2 fallback = chosen(dot(before, before) > 0.0f, before, vec2(1.0f, 0.0f));
    k = chosen(k_length > 1e-6f * large, k / k_length, fallback);
    k = chosen(dot(k, before) < 0.0f, -k, k);
    result.k = k;
    result.fullness = result.r < kCollapsed ? 0.0f : fullness_of(r2, q, threshold);
    vec2 turned = vec2(turn.x * k.x - turn.y * k.y, turn.y * k.x + turn.x * k.y);
    // (M^-1)^T from the cofactors of M.
    vec2 k_deformed =
        vec2(mq[1][1] * turned.x - mq[0][1] * turned.y, mq[0][0] * turned.y - mq[1][0] * turned.x) / det;
    result.k_deformed = chosen(result.r < kCollapsed, vec2(0.0f, 0.0f), k_deformed);
    return result;
}

// ---- Relax (section 5.2)

// The weight of a neighbour. In the paper it is max(min(4 h - 0.2, 1), 0) with h in the unit of its scene. Here h is
// relative to W/4, its largest value.
FORMULA REAL attenuation(REAL fullness) { return clamp(4.0f * fullness - 0.2f, 0.0f, 1.0f); }

// The difference from the nearest integer, in [-1/2, 1/2].
FORMULA REAL to_nearest(REAL x) { return x - nearest_integer(x); }

// The relation of the phases of two neighbours, half-way between them:
// psi_n - psi_0 = flip phi_n - phi_0 + offset.
struct Link {
    REAL flip;    // sgn(k'_n . k'_0)
    REAL offset;  // radians
};

FORMULA Link link_of(REAL flip, REAL offset) {
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
FORMULA REAL misfit(Link link, REAL phase, REAL neighbour_phase) {
    return to_nearest((link.flip * neighbour_phase - phase + link.offset) / kTwoPi);
}

// The share of a relaxation round for a link whose offset has changed by this amount (radians) since it was last
// relaxed: 0 below the jitter of bone matrices, 1 from where the change becomes visible. It starts with a jump. With a
// smooth start, slow drift would be relaxed by almost nothing and then count as done, so it would never be followed.
FORMULA REAL activity(REAL change) {
    return abs(change) < kHeldPhase ? 0.0f : min(abs(change) / kFreePhase, 1.0f);
}

// A phase in [-pi, pi).
FORMULA REAL wrapped(REAL phase) { return kTwoPi * to_nearest(phase / kTwoPi); }

// Equation (6): phi_0 - epsilon dE_0/dphi_0, with dE_0/dphi_0 = -1/(pi N) sum of w_n misfit_n.
// rate = epsilon / (2 pi^2): 1 gives the mean of the neighbours' values. Stable below 1, because then the steps of
// neighbours never overshoot together.
FORMULA REAL relaxed(REAL phase, REAL weighted_misfit_sum, REAL neighbours, REAL rate) {
    REAL change = neighbours > 0.0f ? rate * kTwoPi * weighted_misfit_sum / neighbours : 0.0f;
    return abs(change) < kStillPhase ? phase : wrapped(phase + change);
}
