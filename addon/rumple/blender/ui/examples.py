# SPDX-License-Identifier: GPL-3.0-or-later
"""Example scenes to open and play. Packages include them; in a checkout, scripts/examples makes them."""
from __future__ import annotations

import os
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

from .. import ui_base
from ..translation import said

FOLDER = Path(os.path.abspath(__file__)).parents[2] / "examples"
VIEW_DISTANCE = 0.85  # from its centre / the scene's diagonal: everything is visible, with a margin


def files() -> dict[str, Path]:
    """The example files by their displayed names."""
    return {path.stem.replace("_", " "): path for path in sorted(FOLDER.glob("*.blend"))}


class WM_OT_rumple_open_example(bpy.types.Operator):
    """Open a scene with wrinkles, as a new file: press Space to play it. Unsaved changes of this file are lost"""

    bl_idname = "wm.rumple_open_example"
    bl_label = "Open Example"

    name: bpy.props.StringProperty(name="Example", options={"SKIP_SAVE"})

    def execute(self, _context: bpy.types.Context) -> set[str]:
        path = files().get(self.name or next(iter(files()), ""))  # a search gives no name
        if path is None:
            known = ", ".join(files()) or "none here"
            return ui_base.refuse(self, f"There is no example named \"{self.name}\": {known}")
        result = bpy.ops.wm.read_homefile(filepath=str(path), load_ui=False)
        look_at_it()
        self.report({"INFO"}, said("Press Space to play it"))
        return result

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if bpy.data.is_dirty:
            return context.window_manager.invoke_confirm(self, event)
        return self.execute(context)


def look_at_it() -> None:
    """Point the 3D viewports, which still show the former file's view, at the scene's meshes, from the camera's
    side."""
    scene = bpy.context.scene
    corners = np.array([obj.matrix_world @ Vector(corner) for obj in scene.objects if obj.type == "MESH"
                        for corner in obj.bound_box])
    if scene.camera is None or not len(corners):
        return
    low, high = corners.min(axis=0), corners.max(axis=0)
    for area in (area for window in bpy.context.window_manager.windows for area in window.screen.areas
                 if area.type == "VIEW_3D"):
        view = area.spaces.active.region_3d
        view.view_perspective = "PERSP"
        view.view_rotation = scene.camera.matrix_world.to_quaternion()
        view.view_location = (low + high) / 2.0
        view.view_distance = VIEW_DISTANCE * Vector(high - low).length


class OBJECT_MT_rumple_examples(bpy.types.Menu):
    """Scenes with wrinkles, to open and play"""

    bl_label = "Open Example"

    def draw(self, _context: bpy.types.Context) -> None:
        # The operator must be invoked, because a file cannot be read while a menu executes it.
        self.layout.operator_context = "INVOKE_DEFAULT"
        for name in files():
            self.layout.operator("wm.rumple_open_example", text=name).name = name


def draw_button(row: bpy.types.UILayout) -> None:
    """The same menu for a header. Its tooltip describes it."""
    if files():
        row.menu("OBJECT_MT_rumple_examples", text="", icon="FILE_BLEND")


def draw_menu(layout: bpy.types.UILayout) -> None:
    """Draw the menu if there are examples."""
    if files():
        layout.separator()
        layout.menu("OBJECT_MT_rumple_examples", icon="FILE_BLEND")


def _help_entry(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    if files():
        self.layout.menu("OBJECT_MT_rumple_examples", text="Wrinkles: Open Example")


_register, _unregister = bpy.utils.register_classes_factory((WM_OT_rumple_open_example, OBJECT_MT_rumple_examples))


def register() -> None:
    _register()
    bpy.types.TOPBAR_MT_help.append(_help_entry)


def unregister() -> None:
    bpy.types.TOPBAR_MT_help.remove(_help_entry)
    _unregister()
