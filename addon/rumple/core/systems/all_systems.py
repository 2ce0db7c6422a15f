# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of all systems, by the name of their method. The Blender layer uses only this list."""
from __future__ import annotations

from dataclasses import dataclass, field

from ..frame.engine import Wrinkles
from ..settings.presets import MESH_PRESETS, PATHS_PRESETS, Preset
from ..settings.system_settings import FieldSettings, MeshSettings, PathsSettings
from .wrinkle_field import WrinkleField
from .wrinkle_mesh import WrinkleMesh
from .wrinkle_paths import WrinklePaths


@dataclass(frozen=True)
class System:
    """One entry of the Method enum."""

    method: str
    label: str
    tip: str
    group: str  # its settings are in object.rumple.<group>
    settings: type
    wrinkles: type[Wrinkles]
    presets: dict[str, Preset] = field(default_factory=dict)  # the first one has the default settings


SYSTEMS: dict[str, System] = {system.method: system for system in (
    System("MESH", "Wrinkle Mesh", "Geometry: the garment becomes cloth that hangs and has wide and fine folds. For "
           "garments", "mesh", MeshSettings, WrinkleMesh, MESH_PRESETS),
    System("FIELD", "Wrinkle Field", "Shading or geometry: parallel waves where the mesh is compressed. Cheap to "
           "compute; more folds can be painted by hand", "field", FieldSettings, WrinkleField),
    System("PATHS", "Wrinkle Paths", "Geometry: single crisp folds that appear, travel and fade. For captured or noisy "
           "motion; needs no rest pose", "paths", PathsSettings, WrinklePaths, PATHS_PRESETS),
)}
