# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist sees in Blender. It reads and writes data-blocks; the mathematics is in ../core and in native code."""
from __future__ import annotations

from . import (bake, brush, handlers, maps_bake, maps_export, maps_operators, maps_overlay, maps_panel,
               maps_pose_operators, maps_properties, operators, panels, paths_operators, paths_overlay, preview,
               properties, scheduler)

_MODULES = (properties, maps_properties, operators, paths_operators, maps_operators, maps_pose_operators, maps_export,
            maps_bake, bake, panels, maps_panel, maps_overlay, handlers, preview, paths_overlay,
            brush)  # the last three draw, each over the one before


def register() -> None:
    """Called by the add-on's __init__.py."""
    for module in _MODULES:
        module.register()
    scheduler.request()  # files that are open already; not now: Blender hides its data while an add-on registers


def unregister() -> None:
    for module in reversed(_MODULES):
        module.unregister()
