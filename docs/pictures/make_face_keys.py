# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of Wrinkle Maps on shape keys: s4_face_keys.jpg. The poses of a scene of ../shared/data become shape keys
of a mesh without any armature.

    RUMPLE_NATIVE=build/release/python blender -b --factory-startup ../shared/data/S4_face_expressions.blend \
        --python-exit-code 1 --python docs/pictures/make_face_keys.py
"""
from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Callable

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import make_face  # noqa: E402
import face_poses  # noqa: E402
import rumple  # noqa: E402
from rumple.blender import compat  # noqa: E402

FACE = ("Head", "EyesTeeth")
POSES = {"Surprise": {"Brow Up L": 1.0, "Brow Up R": 1.0, "Jaw Open": 1.0}, "Anger": {"Frown": 1.0}}
SHOWN = {"Neutral": {}, "Surprise": {"Brow Up L": 1.0, "Brow Up R": 1.0, "Jaw Open": 0.8},
         "One brow": {"Brow Up L": 1.0}, "Anger": {"Frown": 0.8}, "Half of it": {"Frown": 0.4},
         "Jaw and frown": {"Jaw Open": 1.0, "Frown": 0.7}}


def shape_of(head: bpy.types.Object) -> np.ndarray:
    evaluated = head.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return compat.positions(evaluated.data).copy()


def keyed(objects: list[bpy.types.Object], rig: bpy.types.Object) -> None:
    """Poses of the bones become shape keys; then the armature goes."""
    action = rig.animation_data.action

    def rest() -> None:
        rig.animation_data.action = None
        for bone in rig.pose.bones:
            bone.matrix_basis.identity()
        bpy.context.view_layer.update()

    def brow(name: str) -> Callable[[], None]:
        return lambda: face_poses.raise_brows(rig, (name,))

    def expression(name: str) -> Callable[[], None]:
        def go() -> None:
            rig.animation_data.action = action
            face_poses.exaggerate(rig, face_poses.HELD[name])
        return go

    poses = {"Brow Up L": brow("oculi01.L"), "Brow Up R": brow("oculi01.R"), "Jaw Open": expression("Surprise"),
             "Frown": expression("Anger")}
    for obj in objects:
        obj.shape_key_add(name="Basis")
    for name, go in poses.items():
        rest()
        go()
        for obj, shape in [(obj, shape_of(obj)) for obj in objects]:
            obj.shape_key_add(name=name, from_mix=False).data.foreach_set("co", shape.ravel())
    rest()
    for obj in objects:
        for block in list(obj.data.shape_keys.key_blocks)[1:]:
            block.value = 0.0
        for armature in [m for m in obj.modifiers if m.type == "ARMATURE"]:
            obj.modifiers.remove(armature)
        place = obj.matrix_world.copy()
        obj.parent = None
        obj.matrix_world = place
    bpy.data.objects.remove(rig)


def set_keys(values: dict[str, float]) -> None:
    for obj in (bpy.data.objects[name] for name in FACE):
        for block in list(obj.data.shape_keys.key_blocks)[1:]:
            block.value = values.get(block.name, 0.0)
    bpy.context.view_layer.update()


def wrinkle(head: bpy.types.Object) -> None:
    bpy.context.view_layer.objects.active = head
    bpy.ops.object.rumple_add(method="MAPS")
    for name, values in POSES.items():
        set_keys(values)
        bpy.ops.rumple.pose_add(name=name)
    head.rumple_maps.bake_size = make_face.SIZE
    assert bpy.ops.rumple.maps_bake(every=True) == {"FINISHED"}
    assert bpy.ops.rumple.maps_show() == {"FINISHED"}


def main() -> None:
    rumple.register()
    head = bpy.data.objects["Head"]
    keyed([bpy.data.objects[name] for name in FACE], bpy.data.objects["HeadRig"])
    wrinkle(head)
    make_face.stage(head)
    skin, coloured = head.data.materials[0], make_face.influences(head)
    with tempfile.TemporaryDirectory() as folder:
        tiles: list[tuple[str, Path]] = []
        for name, values in SHOWN.items():
            set_keys(values)
            for label, muted, material in ((name, True, skin), ("Masks", False, coloured),
                                           ("Wrinkle Maps", False, skin)):
                path = Path(folder) / f"{len(tiles)}.png"
                tiles.append((label, make_face.picture(head, muted, material, path)))
        make_face.save(tiles, 3, HERE / "s4_face_keys.jpg")


main()
