// SPDX-License-Identifier: GPL-3.0-or-later
// The types behind the handles of the Wrinkle Mesh, for its layers.
#pragma once

#include "api/handles.h"
#include "systems/wrinkle_mesh/wrinkle_mesh.h"

namespace rumple::api {

// The painted factors of the base that are carried to a mesh: all but the guides.
using PaintedPart = std::vector<float> wrinkle_mesh::Paint::*;
inline constexpr PaintedPart kPaintedParts[] = {
    &wrinkle_mesh::Paint::radius, &wrinkle_mesh::Paint::prestretch, &wrinkle_mesh::Paint::bending,
    &wrinkle_mesh::Paint::inside, &wrinkle_mesh::Paint::worn};

wrinkle_mesh::Settings mesh_settings(const rumple_wrinkle_mesh_settings* settings);
wrinkle_mesh::Paint mesh_painted(const rumple_wrinkle_mesh_painted& painted, const Surface& base);
rumple_wrinkle_mesh_view view_of(const wrinkle_mesh::Model& model);
rumple_wrinkle_mesh_state_view view_of(const wrinkle_mesh::State& state);
// Checked as a whole. Throws InvalidInput.
wrinkle_mesh::State state_of(const wrinkle_mesh::Model& model, const rumple_wrinkle_mesh_state_view& arrays);
rumple_wrinkle_mesh_report report_of(const wrinkle_mesh::Report& report);

}  // namespace rumple::api
