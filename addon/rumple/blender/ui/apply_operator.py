# SPDX-License-Identifier: GPL-3.0-or-later
"""The button that replaces the mesh with the currently visible one: bpy.ops.object.rumple_apply()."""
from __future__ import annotations

from contextlib import contextmanager
from typing import Iterator

import bpy

from .. import scheduler, ui_base
from ..nodes import wrinkle_tree
from ..objects import modifier, runtimes, viewport_mesh
from .operators import NOT_SHOWN, remove


class OBJECT_OT_rumple_apply(ui_base.OnWrinkled, bpy.types.Operator):
    """Make the mesh what is seen now, with its wrinkles. Modifiers above them and shape keys are applied too"""

    bl_idname = "object.rumple_apply"
    bl_label = "Apply Wrinkles"

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = context.object
        scheduler.sync_all()  # a thread may still build its folds
        with _as_geometry(context, obj) as refused:
            mesh = None if refused else _wrinkled_mesh(context, obj)
            if mesh is None:
                return ui_base.refuse(self, refused or runtimes.message(obj) or NOT_SHOWN)
            _put_in_place(obj, mesh)
        return {"FINISHED"}


@contextmanager
def _as_geometry(context: bpy.types.Context, obj: bpy.types.Object) -> Iterator[str]:
    """Inside this context, waves that the materials draw are geometry of a fine mesh, because shading is not part of
    the mesh. This includes baked waves. Yields an error message or an empty text."""
    settings, nodes_mod = obj.rumple.field, modifier.find(obj)
    if obj.rumple.method != "FIELD" or settings.output != "SHADING":
        yield ""
        return
    baked = modifier.is_baked(nodes_mod)
    try:
        modifier.set_baked(nodes_mod, False)
        settings.output = "GEOMETRY"
        scheduler.sync_all()
        obj.update_tag()
        context.view_layer.update()
        yield runtimes.message(obj)
    finally:
        settings.output = "SHADING"
        if modifier.find(obj) is not None:  # nothing was applied
            modifier.set_baked(modifier.find(obj), baked)
            scheduler.sync_all()


def _wrinkled_mesh(context: bpy.types.Context, obj: bpy.types.Object) -> bpy.types.Mesh | None:
    """A new mesh, the one of renders; None if the wrinkles are not visible."""
    with viewport_mesh.paused():
        obj.update_tag()
        context.view_layer.update()
        mesh = _evaluated_mesh(context, obj)
    if wrinkle_tree.BASE_POSITION in mesh.attributes:
        return mesh
    bpy.data.meshes.remove(mesh)
    return None


def _evaluated_mesh(context: bpy.types.Context, obj: bpy.types.Object) -> bpy.types.Mesh:
    """A new mesh: the object in this frame, as later modifiers get it from the wrinkles."""
    nodes_mod = modifier.find(obj)
    later = list(obj.modifiers)[list(obj.modifiers).index(nodes_mod) + 1:]
    shown = [m for m in later if m.show_viewport]
    for m in shown:
        m.show_viewport = False
    try:
        depsgraph = context.evaluated_depsgraph_get()
        evaluated = obj.evaluated_get(depsgraph)
        return bpy.data.meshes.new_from_object(evaluated, preserve_all_data_layers=True, depsgraph=depsgraph)
    finally:
        for m in shown:
            m.show_viewport = True


def _put_in_place(obj: bpy.types.Object, mesh: bpy.types.Mesh) -> None:
    """Replace the object's mesh, and remove the modifiers and shape keys that are now part of it."""
    before = list(obj.modifiers)[:list(obj.modifiers).index(modifier.find(obj))]
    for name in [m.name for m in before]:
        obj.modifiers.remove(obj.modifiers[name])
    modifier.keep_parent_without_deforming(obj)
    former = obj.data
    if former.shape_keys is not None and former.users == 1:
        obj.shape_key_clear()
    name = former.name
    obj.data = mesh
    remove(obj)
    if former.users == 0:
        bpy.data.meshes.remove(former)
    mesh.name = name


CLASSES = (OBJECT_OT_rumple_apply,)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
