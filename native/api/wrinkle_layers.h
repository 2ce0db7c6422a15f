// SPDX-License-Identifier: GPL-3.0-or-later
// The types behind the handles of the layers.
#pragma once

#include "api/handles.h"
#include "systems/wrinkle_mesh/layers.h"

struct rumple_wrinkle_layers {
    std::shared_ptr<const rumple::wrinkle_mesh::Layers> model;
    rumple::api::ShownMeshes shown;
    std::shared_ptr<const rumple::Surface> base;
};
struct rumple_wrinkle_layers_paint {
    std::shared_ptr<const rumple::wrinkle_mesh::Layers> model;
    std::vector<rumple::wrinkle_mesh::Paint> layers;
};
struct rumple_wrinkle_layers_state {
    std::shared_ptr<const rumple::wrinkle_mesh::Layers> model;
    rumple::wrinkle_mesh::LayersState state;
};
