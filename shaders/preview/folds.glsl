// SPDX-License-Identifier: GPL-3.0-or-later
// Section 7.5 at a point, from the lists of section 7.2. folds_at() of native/systems/wrinkle_paths/preview.cpp
// computes the same.
//   ranges  first piece and end of the pieces of one fold
//   ends    two texels each: FoldEnd

FoldEnd fold_end(int i) {
    vec4 a = TEXEL(ends, 2 * i), b = TEXEL(ends, 2 * i + 1);
    FoldEnd end;
    end.at = a.xyz;
    end.width = a.w;
    end.along = b.xyz;
    end.height = b.w;
    return end;
}

// list: first range of the triangle and end of its ranges. p: on the flat triangle. n, fraction: as in with_fold().
FoldBlend folds_at(ivec2 list, vec3 p, vec3 n, float fraction) {
    FoldBlend blend = no_folds();
    for (int r = list.x; r < list.y; ++r) {
        vec4 range = TEXEL(ranges, r);
        FoldEnd start = fold_end(int(range.x));
        for (int i = int(range.x); i < int(range.y); ++i) {
            FoldEnd end = fold_end(i + 1);
            blend = with_fold(blend, fold_height(profile_kind, start, end, p), n, fraction);
            start = end;
        }
    }
    return blend;
}
