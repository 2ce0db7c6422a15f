// SPDX-License-Identifier: GPL-3.0-or-later
// The shape of a fold over its path: Gillette 2015, chapter 6. Only used inside this system.
#pragma once

#include "systems/wrinkle_paths/walk.h"

namespace rumple::wrinkle_paths {

// A smoothed path (section 6.2), cut into pieces, with the width and height of its fold (section 6.1).
struct Fold {
    std::vector<formulas::FoldEnd> ends;  // of the pieces
    std::vector<Index> first;             // segments + 1, into pieces
};
Fold make_fold(const FoldContext& context, const Settings& settings, const Path& path);

}  // namespace rumple::wrinkle_paths
