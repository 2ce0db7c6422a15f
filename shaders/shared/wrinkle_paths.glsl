// SPDX-License-Identifier: GPL-3.0-or-later
// The formulas of the Wrinkle Paths. Source: R. Gillette, Augmentation of Coarse
// Meshes with Wrinkles, UBC 2015; chapter and equation numbers are the thesis's.
// One text for C++ (native/base/formulas.h) and GLSL (the viewport preview).

const int kFoldSpline = 0;
const int kFoldQuartic = 1;
const int kFoldCircularArcs = 2;
const int kFoldSine = 3;

const float kFoldPi = 3.14159265358979324f;

// ---- The cross-section (section 6.1)

// A profile of height 1 and its slope at x, from 0 at the crest to 1 at the foot.
struct FoldProfile {
    float height;
    float slope;  // d height / d x
};

// x >= 0; flat at the crest, and from the foot on.
FORMULA FoldProfile fold_profile(int kind, float x) {
    FoldProfile p;
    p.height = 0.0f;
    p.slope = 0.0f;
    if (x >= 1.0f) return p;
    float y = 1.0f - x;
    if (kind == kFoldSpline) {  // three quadratic pieces (figure 6.3), uniform knots at -1, -1/3, 1/3, 1
        bool inner = 3.0f * x < 1.0f;
        p.height = inner ? 1.0f - 3.0f * x * x : 1.5f * y * y;
        p.slope = inner ? -6.0f * x : -3.0f * y;
    } else if (kind == kFoldQuartic) {
        p.height = (1.0f - x * x) * (1.0f - x * x);
        p.slope = -4.0f * x * (1.0f - x * x);
    } else if (kind == kFoldCircularArcs) {  // parabolas: the arcs of equal radius of a flat fold
        bool inner = 2.0f * x < 1.0f;
        p.height = inner ? 1.0f - 2.0f * x * x : 2.0f * y * y;
        p.slope = inner ? -4.0f * x : -4.0f * y;
    } else {
        p.height = 0.5f * (1.0f + cos(kFoldPi * x));
        p.slope = -0.5f * kFoldPi * sin(kFoldPi * x);
    }
    return p;
}

// ---- The height beside a path (sections 7.3 and 7.4)

// One end of a straight piece of a smoothed path.
struct FoldEnd {
    vec3 at;       // object space
    float width;   // L there
    vec3 along;    // s_i of eq. 7.1: mean direction of the adjacent pieces, unit
    float height;  // signed
};

struct FoldHeight {
    float height;
    vec3 gradient;  // across the path: with the smooth normal n the normal of the fold is n - gradient
};

// The height of a piece at a point p that is projected to its `fraction`; zero if p is not on the piece.
FORMULA FoldHeight fold_at(int kind, FoldEnd a, FoldEnd b, vec3 p, float fraction) {
    FoldHeight result;
    result.height = 0.0f;
    result.gradient = vec3(0.0f, 0.0f, 0.0f);
    if (fraction < 0.0f || fraction > 1.0f) return result;
    vec3 displacement = p - mix(a.at, b.at, fraction);
    float far = length(displacement);
    float width = mix(a.width, b.width, fraction);
    float height = mix(a.height, b.height, fraction);
    FoldProfile profile = fold_profile(kind, 2.0f * far / width);
    result.height = height * profile.height;
    if (far > 0.0f) result.gradient = (height * profile.slope * 2.0f / (width * far)) * displacement;
    return result;
}

// Equations 7.1 to 7.3: p is projected along the lines between the Voronoi cells of the path, so that neighbouring
// pieces agree there. s1 belongs to the start of the piece, s0 to its end. Of both roots the greater height counts.
FORMULA FoldHeight fold_height(int kind, FoldEnd start, FoldEnd end, vec3 p) {
    vec3 z0 = end.at - start.at;
    vec3 z1 = start.at - p;
    vec3 s1 = start.along;
    vec3 s0 = end.along;
    float a = dot(z0, s0 - s1);
    float b = dot(z0, s1) + dot(z1, s0 - s1);
    float c = dot(z1, s1);
    float square = b * b - 4.0f * a * c;
    // Without cancellation: the roots are c / q and q / a.
    float q = -0.5f * (b + (b < 0.0f ? -1.0f : 1.0f) * sqrt(max(square, 0.0f)));
    bool real = square >= 0.0f;
    FoldHeight first = fold_at(kind, start, end, p, real && q != 0.0f ? c / q : -1.0f);
    FoldHeight second = fold_at(kind, start, end, p, real && a != 0.0f ? q / a : -1.0f);
    if (abs(second.height) > abs(first.height)) return second;
    return first;
}

// ---- Several folds at one point (section 7.5)

struct FoldBlend {
    float height;  // of the highest fold
    vec3 normal;   // sum of the normals of all folds, weighted by their heights
};

FORMULA FoldBlend no_folds() {
    FoldBlend blend;
    blend.height = 0.0f;
    blend.normal = vec3(0.0f, 0.0f, 0.0f);
    return blend;
}

// n: unit normal of the surface without folds; fraction: factor on the fold. Gradients are measured on flat triangles,
// so their part along n is removed.
FORMULA FoldBlend with_fold(FoldBlend blend, FoldHeight fold, vec3 n, float fraction) {
    if (fold.height == 0.0f) return blend;
    float height = fraction * fold.height;
    if (abs(height) > abs(blend.height)) blend.height = height;
    vec3 gradient = fraction * (fold.gradient - dot(fold.gradient, n) * n);
    blend.normal += abs(height) * normalize(n - gradient);
    return blend;
}

// Unit normal of the folded surface.
FORMULA vec3 blended_normal(FoldBlend blend, vec3 n) {
    float size = length(blend.normal);
    return size > 0.0f ? blend.normal / size : n;
}
