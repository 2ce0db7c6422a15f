# SPDX-License-Identifier: GPL-3.0-or-later
"""The sister systems by the name of their method: the one list that Blender's side goes by."""
from __future__ import annotations

from dataclasses import dataclass

from .engine import Wrinkles
from .settings import FieldSettings, MeshSettings, PathsSettings
from .wrinkle_field import WrinkleField
from .wrinkle_mesh import WrinkleMesh
from .wrinkle_paths import WrinklePaths


@dataclass(frozen=True)
class System:
    """One entry of the Method enum."""

    method: str
    label: str
    tip: str
    group: str  # where its settings are: object.rumple.<group>
    settings: type
    wrinkles: type[Wrinkles]


SYSTEMS: dict[str, System] = {system.method: system for system in (
    System("MESH", "Wrinkle Mesh", "A fine mesh solved over the animated coarse one", "mesh", MeshSettings,
           WrinkleMesh),
    System("FIELD", "Wrinkle Field", "Waves on the coarse mesh itself, across the direction of compression", "field",
           FieldSettings, WrinkleField),
    System("PATHS", "Wrinkle Paths", "Crisp folds traced across the compression, which live from frame to frame",
           "paths", PathsSettings, WrinklePaths),
)}
