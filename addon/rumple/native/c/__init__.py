# SPDX-License-Identifier: GPL-3.0-or-later
"""The C header for ctypes. Written by scripts/declarations.py from native/include: change that."""
from __future__ import annotations

from typing import Any

from .base import *
from .surface import *
from .base_cloth import *
from .force_fields import *
from .wrinkle_mesh import *
from .wrinkle_layers import *
from .wrinkle_field import *
from .wrinkle_field_brush import *
from .wrinkle_paths import *
from .wrinkle_maps import *

FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    **BASE_FUNCTIONS,
    **SURFACE_FUNCTIONS,
    **BASE_CLOTH_FUNCTIONS,
    **FORCE_FIELDS_FUNCTIONS,
    **WRINKLE_MESH_FUNCTIONS,
    **WRINKLE_LAYERS_FUNCTIONS,
    **WRINKLE_FIELD_FUNCTIONS,
    **WRINKLE_FIELD_BRUSH_FUNCTIONS,
    **WRINKLE_PATHS_FUNCTIONS,
    **WRINKLE_MAPS_FUNCTIONS,
}
STRUCTS: dict[str, Any] = {
    "rumple_surface_plan": SurfacePlan,
    "rumple_healed_view": HealedView,
    "rumple_surface_view": SurfaceView,
    "rumple_coarse_view": CoarseView,
    "rumple_fine_plan": FinePlan,
    "rumple_shown_mesh_view": ShownMeshView,
    "rumple_pose": Pose,
    "rumple_frame_view": FrameView,
    "rumple_reference_settings": ReferenceSettings,
    "rumple_reference_view": ReferenceView,
    "rumple_bodies": Bodies,
    "rumple_base_cloth_settings": BaseClothSettings,
    "rumple_base_cloth_swing": BaseClothSwing,
    "rumple_base_cloth_painted": BaseClothPainted,
    "rumple_base_cloth_state_view": BaseClothStateView,
    "rumple_base_cloth_kept": BaseClothKept,
    "rumple_base_cloth_report": BaseClothReport,
    "rumple_cloth_cover_settings": ClothCoverSettings,
    "rumple_force_field": ForceField,
    "rumple_wrinkle_mesh_plan": WrinkleMeshPlan,
    "rumple_wrinkle_mesh_view": WrinkleMeshView,
    "rumple_wrinkle_mesh_settings": WrinkleMeshSettings,
    "rumple_wrinkle_mesh_painted": WrinkleMeshPainted,
    "rumple_wrinkle_mesh_state_view": WrinkleMeshStateView,
    "rumple_wrinkle_mesh_report": WrinkleMeshReport,
    "rumple_wrinkle_mesh_measures": WrinkleMeshMeasures,
    "rumple_wrinkle_mesh_passes_view": WrinkleMeshPassesView,
    "rumple_wrinkle_layers_plan": WrinkleLayersPlan,
    "rumple_wrinkle_layers_view": WrinkleLayersView,
    "rumple_wrinkle_layers_painted": WrinkleLayersPainted,
    "rumple_wrinkle_layers_state_view": WrinkleLayersStateView,
    "rumple_wrinkle_layers_input": WrinkleLayersInput,
    "rumple_wrinkle_transfer_plan": WrinkleTransferPlan,
    "rumple_wrinkle_field_plan": WrinkleFieldPlan,
    "rumple_wrinkle_field_view": WrinkleFieldView,
    "rumple_wrinkle_field_settings": WrinkleFieldSettings,
    "rumple_wrinkle_field_profile": WrinkleFieldProfile,
    "rumple_wrinkle_field_painted": WrinkleFieldPainted,
    "rumple_wrinkle_field_state_view": WrinkleFieldStateView,
    "rumple_wrinkle_field_report": WrinkleFieldReport,
    "rumple_frame_waves_view": FrameWavesView,
    "rumple_waves_view": WavesView,
    "rumple_wrinkle_field_wave_parameters": WrinkleFieldWaveParameters,
    "rumple_dab": Dab,
    "rumple_scatter": Scatter,
    "rumple_lines_view": LinesView,
    "rumple_wrinkle_paths_view": WrinklePathsView,
    "rumple_wrinkle_paths_settings": WrinklePathsSettings,
    "rumple_wrinkle_paths_painted": WrinklePathsPainted,
    "rumple_wrinkle_paths_state_view": WrinklePathsStateView,
    "rumple_wrinkle_paths_report": WrinklePathsReport,
    "rumple_frame_folds_view": FrameFoldsView,
    "rumple_curves_view": CurvesView,
    "rumple_drawing_view": DrawingView,
    "rumple_wrinkle_maps_pose": WrinkleMapsPose,
    "rumple_wrinkle_maps_plan": WrinkleMapsPlan,
    "rumple_wrinkle_maps_view": WrinkleMapsView,
    "rumple_wrinkle_maps_settings": WrinkleMapsSettings,
}
