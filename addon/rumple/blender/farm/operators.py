# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators that export the baked clip for other programs: bpy.ops.object.rumple_publish(), rumple_vat()."""
from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy

from ...core.files.clip_folder import megabytes
from ...core.files.clip_manifest import ClipFault, Manifest
from .. import ui_base
from ..bake.playback import BakeError
from ..objects import modifier
from ..translation import said
from . import publish, shown, vat


class _OfClip(ui_base.OnWrinkled):
    """Mixin for operators: calls export() with the folder `publish` beside the blend file."""

    bl_options = {"REGISTER"}
    report: Any  # the Operator's

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not super().poll(context):
            return False
        why = ("Bake first: the baked clip is exported" if not modifier.is_baked(modifier.find(context.object)) else
               "" if bpy.data.filepath else "Save the file first: the export is stored beside it")
        return ui_base.may_run(cls, why)

    def export(self, context: bpy.types.Context, manifest: Manifest, folder: Path) -> shown.Exported:
        raise NotImplementedError

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene, obj = context.scene, context.object
        now = scene.frame_current, scene.frame_subframe
        try:
            done = self.export(context, shown.clip_shown(obj), Path(bpy.data.filepath).parent / "publish")
        except (BakeError, ClipFault) as error:
            return ui_base.refuse(self, error)
        finally:
            scene.frame_set(now[0], subframe=now[1])
        self.report({"INFO"}, said(f"{obj.name}: {done.frames} frames of {done.vertices} points, "
                                   f"{megabytes(done.bytes)} MB{done.note}: {done.path}"))
        return {"FINISHED"}


class OBJECT_OT_rumple_publish(_OfClip, bpy.types.Operator):
    """Write the baked clip as USD, with all modifiers, into the folder "publish" beside the file"""

    bl_idname = "object.rumple_publish"
    bl_label = "Publish to USD"

    scheme: bpy.props.EnumProperty(name="Subdivision", description="How readers subdivide the mesh",
                                   items=(("none", "None", "As it is, with normals"),
                                          ("catmullClark", "Catmull-Clark", "Smoothed by the reader")))
    attributes: bpy.props.BoolProperty(name="Attributes", description="The wrinkles' attributes, too, as primvars")

    def export(self, context: bpy.types.Context, manifest: Manifest, folder: Path) -> shown.Exported:
        return publish.publish(context, context.object, manifest, folder, self.scheme, self.attributes)


class OBJECT_OT_rumple_vat(_OfClip, bpy.types.Operator):
    """Write the baked clip as vertex animation textures (OpenVAT) into the folder "publish" beside the file"""

    bl_idname = "object.rumple_vat"
    bl_label = "Export Vertex Animation"

    image: bpy.props.EnumProperty(name="Image", default="png", items=(
        ("png", "PNG", "16 bits; the report says the largest error"),
        ("exr", "OpenEXR", "32-bit floats"), ("both", "Both", "PNG and OpenEXR")))
    in_place: bpy.props.BoolProperty(name="In Place", description="Take the root motion (the mean motion of all "
                                     "points) out of the textures and write it into the JSON, for the engine to move "
                                     "the object by")

    def export(self, context: bpy.types.Context, manifest: Manifest, folder: Path) -> shown.Exported:
        return vat.export(context, context.object, manifest, folder, self.image, self.in_place)


CLASSES: tuple[Any, ...] = (OBJECT_OT_rumple_publish, OBJECT_OT_rumple_vat)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
