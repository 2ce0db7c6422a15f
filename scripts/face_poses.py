# SPDX-License-Identifier: GPL-3.0-or-later
"""The face of ../shared/data/S4_face_expressions.blend: its expressions, and Wrinkle Maps with two reference poses, as
an artist adds them. For pictures and clips; run inside Blender.
"""
from __future__ import annotations

import bpy
from mathutils import Matrix, Quaternion, Vector

HELD = {"Neutral": 1, "Surprise": 21, "Anger": 51, "Laughing": 81, "Crying": 111}  # frames of the clip
BROWS = ("oculi01.L", "oculi01.R")
RAISED = 0.009  # metres: the clip's own brows hardly rise
RAISED_FROM, RAISED_TO = (6, 16, 26, 36), (0.0, 1.0, 1.0, 0.0)  # frames, shares: with the clip's Surprise
PRONOUNCED = 1.25  # "these expressions should be strongly pronounced" (Dutreve 2009, section 4)


def go_to(rig: bpy.types.Object, frame: int) -> None:
    """A frame of the clip. It keys no brow's location, which would stay where it was."""
    for bone in rig.pose.bones:
        bone.matrix_basis.identity()
    bpy.context.scene.frame_set(frame)


def exaggerate(rig: bpy.types.Object, frame: int) -> None:
    """Every bone goes farther than in that frame."""
    go_to(rig, frame)
    for bone in rig.pose.bones:
        axis, angle = bone.matrix_basis.to_quaternion().to_axis_angle()
        place = PRONOUNCED * bone.matrix_basis.to_translation()
        bone.matrix_basis = Matrix.Translation(place) @ Quaternion(axis, PRONOUNCED * angle).to_matrix().to_4x4()
    bpy.context.view_layer.update()


def raise_brows(rig: bpy.types.Object, names: tuple[str, ...] = BROWS) -> None:
    """From where they are at rest."""
    for name in names:
        bone = rig.pose.bones[name]
        bone.matrix = Matrix.Translation((0.0, 0.0, RAISED)) @ bone.bone.matrix_local
    bpy.context.view_layer.update()


def key_brows(rig: bpy.types.Object) -> None:
    """Let the brows of the clip rise with Surprise."""
    for name in BROWS:
        bone = rig.pose.bones[name]
        up = bone.bone.matrix_local.to_3x3().inverted() @ Vector((0.0, 0.0, RAISED))
        for frame, share in zip(RAISED_FROM, RAISED_TO):
            bone.location = share * up
            bone.keyframe_insert("location", frame=frame)


def add_maps(head: bpy.types.Object, rig: bpy.types.Object, size: int) -> None:
    """Wrinkle Maps with the poses Surprise and Anger, baked and shown: one click, but for their size (texels)."""
    bpy.context.view_layer.objects.active = head
    assert bpy.ops.object.rumple_add(method="MAPS") == {"FINISHED"}
    for name in ("Surprise", "Anger"):
        exaggerate(rig, HELD[name])
        if name == "Surprise":
            raise_brows(rig)
        assert bpy.ops.rumple.pose_add(name=name) == {"FINISHED"}
    head.rumple_maps.bake_size = size
    assert bpy.ops.rumple.maps_bake(every=True) == {"FINISHED"}
    assert bpy.ops.rumple.maps_show() == {"FINISHED"}
