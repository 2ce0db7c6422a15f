// SPDX-License-Identifier: GPL-3.0-or-later
// The type behind the handle of a coarse mesh, for the layers on it.
#pragma once

#include "api/handles.h"
#include "surface/output/coarse.h"

struct rumple_coarse {
    std::shared_ptr<const rumple::CoarseMesh> mesh;
    std::shared_ptr<const rumple::Surface> base;
};
