// SPDX-License-Identifier: GPL-3.0-or-later
// The shape of a fold over its path: Gillette 2015, chapter 6. Inside this system only.
#pragma once

#include "systems/wrinkle_paths/walk.h"

namespace rumple::wrinkle_paths {

// A path smoothed (section 6.2), cut into pieces, with the width and height of its fold (section 6.1).
struct Fold {
    std::vector<formulas::FoldEnd> ends;  // of the pieces
    std::vector<Index> first;             // segments + 1, into pieces
};
// The context needs its pose and compression only.
Fold make_fold(const PathContext& context, const Settings& settings, const Path& path);

// Of length 1, or zero.
Vec3 unit(const Vec3& v);

}  // namespace rumple::wrinkle_paths
