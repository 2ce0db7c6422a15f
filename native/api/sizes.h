// SPDX-License-Identifier: GPL-3.0-or-later
// The list of all structs of the headers, for rumple_struct_size(). A test compares it with the headers.
#pragma once

#include <cstddef>

#include "rumple.h"

namespace rumple::api {

struct StructSize {
    const char* name;
    size_t size;
};

#define RUMPLE_SIZE(type) \
    { #type, sizeof(type) }
inline constexpr StructSize kStructSizes[] = {
    RUMPLE_SIZE(rumple_base_cloth_kept),
    RUMPLE_SIZE(rumple_base_cloth_painted),
    RUMPLE_SIZE(rumple_base_cloth_report),
    RUMPLE_SIZE(rumple_base_cloth_settings),
    RUMPLE_SIZE(rumple_base_cloth_state_view),
    RUMPLE_SIZE(rumple_base_cloth_swing),
    RUMPLE_SIZE(rumple_bodies),
    RUMPLE_SIZE(rumple_cloth_cover_settings),
    RUMPLE_SIZE(rumple_coarse_view),
    RUMPLE_SIZE(rumple_curves_view),
    RUMPLE_SIZE(rumple_dab),
    RUMPLE_SIZE(rumple_drawing_view),
    RUMPLE_SIZE(rumple_fine_plan),
    RUMPLE_SIZE(rumple_force_field),
    RUMPLE_SIZE(rumple_frame_folds_view),
    RUMPLE_SIZE(rumple_frame_view),
    RUMPLE_SIZE(rumple_frame_waves_view),
    RUMPLE_SIZE(rumple_healed_view),
    RUMPLE_SIZE(rumple_lines_view),
    RUMPLE_SIZE(rumple_pose),
    RUMPLE_SIZE(rumple_reference_settings),
    RUMPLE_SIZE(rumple_reference_view),
    RUMPLE_SIZE(rumple_scatter),
    RUMPLE_SIZE(rumple_shown_mesh_view),
    RUMPLE_SIZE(rumple_surface_plan),
    RUMPLE_SIZE(rumple_surface_view),
    RUMPLE_SIZE(rumple_waves_view),
    RUMPLE_SIZE(rumple_wrinkle_field_painted),
    RUMPLE_SIZE(rumple_wrinkle_field_plan),
    RUMPLE_SIZE(rumple_wrinkle_field_profile),
    RUMPLE_SIZE(rumple_wrinkle_field_report),
    RUMPLE_SIZE(rumple_wrinkle_field_settings),
    RUMPLE_SIZE(rumple_wrinkle_field_state_view),
    RUMPLE_SIZE(rumple_wrinkle_field_view),
    RUMPLE_SIZE(rumple_wrinkle_field_wave_parameters),
    RUMPLE_SIZE(rumple_wrinkle_layers_input),
    RUMPLE_SIZE(rumple_wrinkle_layers_painted),
    RUMPLE_SIZE(rumple_wrinkle_layers_plan),
    RUMPLE_SIZE(rumple_wrinkle_layers_state_view),
    RUMPLE_SIZE(rumple_wrinkle_layers_view),
    RUMPLE_SIZE(rumple_wrinkle_maps_plan),
    RUMPLE_SIZE(rumple_wrinkle_maps_pose),
    RUMPLE_SIZE(rumple_wrinkle_maps_settings),
    RUMPLE_SIZE(rumple_wrinkle_maps_view),
    RUMPLE_SIZE(rumple_wrinkle_mesh_measures),
    RUMPLE_SIZE(rumple_wrinkle_mesh_painted),
    RUMPLE_SIZE(rumple_wrinkle_mesh_passes_view),
    RUMPLE_SIZE(rumple_wrinkle_mesh_plan),
    RUMPLE_SIZE(rumple_wrinkle_mesh_report),
    RUMPLE_SIZE(rumple_wrinkle_mesh_settings),
    RUMPLE_SIZE(rumple_wrinkle_mesh_state_view),
    RUMPLE_SIZE(rumple_wrinkle_mesh_view),
    RUMPLE_SIZE(rumple_wrinkle_paths_painted),
    RUMPLE_SIZE(rumple_wrinkle_paths_report),
    RUMPLE_SIZE(rumple_wrinkle_paths_settings),
    RUMPLE_SIZE(rumple_wrinkle_paths_state_view),
    RUMPLE_SIZE(rumple_wrinkle_paths_view),
    RUMPLE_SIZE(rumple_wrinkle_transfer_plan),
};
#undef RUMPLE_SIZE

}  // namespace rumple::api
