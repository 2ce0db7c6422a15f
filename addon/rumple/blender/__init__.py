# SPDX-License-Identifier: GPL-3.0-or-later
"""The Blender layer: user interface, handlers and data-blocks. The mathematics is in ../core and in native code.

Each entry of this list imports only from later ones: ui, farm, bake, brush, maps, ui_base.py, frame, viewport,
first_click, objects, nodes, scheduler.py, translation.py, manual.py, compat.py
(blender_tests/without_blender/test_import_order.py).
"""
from __future__ import annotations

from . import handlers, manual, scheduler, translation
from .bake import operators as bake_operators
from .brush import operators as brush_operators
from .farm import command as farm_command, operators as farm_operators
from .maps import (bake as maps_bake, export as maps_export, operators as maps_operators, overlay as maps_overlay,
                   panel as maps_panel, pose_operators as maps_pose_operators, properties as maps_properties)
from .objects import guide_curves, properties
from .ui import (apply_operator, copy_settings, examples, fabrics, guide_operators, healing, held_mouse, menus,
                 operators, paint_operators, panels, paths_operators, rebuild_progress, saved_settings, thumbnails,
                 wave_materials, weight_tools)
from .viewport import paths_overlay, preview

# The last three draw, in this order.
_MODULES = (manual, translation, properties, guide_curves, maps_properties, thumbnails, fabrics, operators,
            wave_materials, apply_operator, paint_operators, guide_operators, paths_operators, held_mouse,
            rebuild_progress, healing, copy_settings, saved_settings, weight_tools, examples, maps_operators,
            maps_pose_operators, maps_export, maps_bake, bake_operators, panels, menus, maps_panel, maps_overlay,
            handlers, farm_command, farm_operators, preview, paths_overlay, brush_operators)


def register() -> None:
    """Called by the add-on's __init__.py."""
    for module in _MODULES:
        module.register()
    # for a file that is already open; later, because Blender hides its data while an add-on registers
    scheduler.request()


def unregister() -> None:
    for module in reversed(_MODULES):
        module.unregister()
