# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Maps on a real face whose expressions are shape keys: made of the poses of its bones, which then go."""
from __future__ import annotations

import os
import unittest
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix
from rumple.blender import compat
from rumple.blender.maps import runtimes as maps_runtimes
from rumple.blender.nodes import maps_mask_tree

DATA = Path(os.environ["RUMPLE_DATA"])
HELD = {"Surprise": 21, "Anger": 51, "Laughing": 81, "Crying": 111}  # frames that hold these expressions
BROWS = {"Brow L": "oculi01.L", "Brow R": "oculi01.R"}
RAISED = 0.009  # metres


class FaceOfKeys(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        bpy.ops.wm.open_mainfile(filepath=str(DATA / "S4_face_expressions.blend"))
        cls.head, rig = bpy.data.objects["Head"], bpy.data.objects["HeadRig"]
        shapes = {}
        for name, frame in HELD.items():
            bpy.context.scene.frame_set(frame)
            shapes[name] = cls.positions()
        rig.animation_data.action = None
        for name, bone_name in BROWS.items():
            for bone in rig.pose.bones:
                bone.matrix_basis.identity()
            bone = rig.pose.bones[bone_name]
            bone.matrix = Matrix.Translation((0.0, 0.0, RAISED)) @ bone.bone.matrix_local
            bpy.context.view_layer.update()
            shapes[name] = cls.positions()
        cls.head.shape_key_add(name="Basis")
        for name, shape in shapes.items():
            cls.head.shape_key_add(name=name, from_mix=False).data.foreach_set("co", shape.ravel())
        for nodes_mod in list(cls.head.modifiers):
            cls.head.modifiers.remove(nodes_mod)
        cls.head.parent = None
        bpy.data.objects.remove(rig)
        bpy.context.view_layer.objects.active = cls.head
        assert bpy.ops.object.rumple_add(method="MAPS") == {"FINISHED"}
        for pose, names in (("Both brows", BROWS), ("Anger", ("Anger",))):
            cls.set_keys(**{name: 1.0 for name in names})
            assert bpy.ops.rumple.pose_add(name=pose) == {"FINISHED"}
        cls.settings = cls.head.rumple_maps

    @classmethod
    def positions(cls) -> np.ndarray:
        evaluated = cls.head.evaluated_get(bpy.context.evaluated_depsgraph_get())
        return compat.positions(evaluated.data).copy()

    @classmethod
    def set_keys(cls, **values: float) -> None:
        for block in list(cls.head.data.shape_keys.key_blocks)[1:]:
            block.value = values.get(block.name, 0.0)
        bpy.context.view_layer.update()

    def masks(self) -> Any:
        attributes = self.head.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.attributes
        return {pose.name: compat.read_attribute(attributes[maps_mask_tree.MASK.format(pose.name)])[:, 0]
                for pose in self.settings.poses}

    def test_one_at_the_pose_and_nothing_at_rest(self) -> None:
        self.assertEqual((self.settings.message, maps_runtimes.of(self.head).notes), ("", []))
        self.set_keys()
        self.assertFalse(any(mask.any() for mask in self.masks().values()))
        self.set_keys(Anger=1.0)
        masks = self.masks()
        self.assertEqual((masks["Anger"].max(), self.settings.poses["Anger"].present), (1.0, 1.0))
        self.assertFalse(masks["Both brows"].any())
        self.assertGreater((masks["Anger"] > 0.3).mean(), 0.05)
        self.set_keys(Laughing=1.0, Crying=1.0)  # keys of no pose
        self.assertFalse(any(mask.any() for mask in self.masks().values()))

    def test_one_brow_wrinkles_its_side_only(self) -> None:
        """Below 1 % on the other, as with bones."""
        across = np.array([vertex.co.x for vertex in self.head.data.vertices])
        for name, side in (("Brow L", 1.0), ("Brow R", -1.0)):
            self.set_keys(**{name: 1.0})
            mask = self.masks()["Both brows"]
            self.assertGreater(mask[side * across > 0.005].max(), 0.9, name)
            self.assertLess(mask[side * across < -0.005].max(), 0.01, name)

    def test_masks_stay_within_zero_and_one_and_rise_on_the_way(self) -> None:
        former = np.zeros(len(self.head.data.vertices), np.float32)
        for value in np.linspace(0.0, 1.0, 6):
            self.set_keys(Anger=float(value), Crying=0.5, **{"Brow L": 1.0})
            masks = self.masks()
            self.assertTrue(all(mask.min() >= 0.0 and mask.max() <= 1.0 for mask in masks.values()))
            self.assertGreaterEqual((masks["Anger"] - former).min(), 0.0)
            former = masks["Anger"]
