# SPDX-License-Identifier: GPL-3.0-or-later
"""Characters linked from another file, and library overrides of them: the usual way of productions."""
from __future__ import annotations

import os
import tempfile
import unittest
from typing import Any

import bpy
import numpy as np
from rumple.blender.maps import modifier as maps_modifier
from support import face, sleeve

ROUNDING = 1e-4  # of a mask


class Linked(unittest.TestCase):

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(sleeve.empty_file)
        self.library, self.shot = (os.path.join(folder.name, name) for name in ("character.blend", "shot.blend"))
        obj, rig = face.scene()
        face.two_poses(obj, rig)
        face.animate(rig)
        collection, scene = bpy.data.collections.new("Character"), bpy.context.scene
        scene.collection.children.link(collection)
        for member in (obj, rig):
            scene.collection.objects.unlink(member)
            collection.objects.link(member)
        bpy.ops.wm.save_as_mainfile(filepath=self.library)
        self.shares = face.weights(obj, "brow.L"), face.weights(obj, "brow.R")
        sleeve.empty_file()

    def link(self, kind: str, name: str) -> Any:
        with bpy.data.libraries.load(self.library, link=True) as (_, wanted):
            setattr(wanted, kind, [name])
        return getattr(wanted, kind)[0]

    def override(self) -> tuple[bpy.types.Object, bpy.types.Object]:
        """(face, rig) of an override of the whole character."""
        collection = self.link("collections", "Character")
        scene = bpy.context.scene
        scene.collection.children.link(collection)
        bpy.context.view_layer.update()
        collection.override_hierarchy_create(scene, bpy.context.view_layer, do_fully_editable=True)
        bpy.context.view_layer.update()
        return self.found()

    def found(self) -> tuple[bpy.types.Object, bpy.types.Object]:
        obj = next(o for o in bpy.data.objects if o.library is None and maps_modifier.find(o) and o.users_collection)
        sleeve.make_active(obj)
        obj.rumple_maps.active = 0
        return obj, obj.find_armature()

    def reopened(self) -> tuple[bpy.types.Object, bpy.types.Object]:
        bpy.ops.wm.save_as_mainfile(filepath=self.shot)
        bpy.ops.wm.open_mainfile(filepath=self.shot)
        return self.found()

    def check(self, obj: bpy.types.Object, left: float, right: float = 0.0, name: str = "Surprise") -> None:
        np.testing.assert_allclose(face.mask(obj, name), left * self.shares[0] + right * self.shares[1], atol=ROUNDING)
        self.assertEqual(obj.rumple_maps.message, "")

    def test_linked_it_follows_its_bones_and_nothing_is_made(self) -> None:
        collection = self.link("collections", "Character")
        bpy.context.scene.collection.children.link(collection)
        before = sorted(obj.name_full for obj in bpy.data.objects)
        obj = collection.objects["Face"]
        for frame in (11, 3, 8):
            bpy.context.scene.frame_set(frame)
            self.check(obj, face.risen(frame))
            self.assertAlmostEqual(obj.rumple_maps.poses["Surprise"].present, face.risen(frame) / 2, 4)
        self.assertEqual(sorted(obj.name_full for obj in bpy.data.objects), before)

    def test_linked_it_knows_that_its_rig_was_scaled_since(self) -> None:
        """The scale is applied in the file that it comes from, the pose is stored in it or in the shot."""
        self.override()
        bpy.ops.wm.save_as_mainfile(filepath=self.shot)
        bpy.ops.wm.open_mainfile(filepath=self.library)
        rig = bpy.data.objects["Rig"]
        rig.animation_data_clear()
        rig.scale = (100.0,) * 3
        sleeve.make_active(rig)
        bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
        bpy.ops.wm.save_as_mainfile(filepath=self.library)
        bpy.ops.wm.open_mainfile(filepath=self.shot)
        obj, rig = self.found()
        face.pose(rig, brow_L=1.0, brow_R=0.5)
        self.check(obj, 1.0, 0.5)
        self.assertEqual(face.notes(obj), "")

    def test_an_instanced_collection(self) -> None:
        empty = bpy.data.objects.new("Character", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", self.link("collections", "Character")
        bpy.context.scene.collection.objects.link(empty)
        bpy.context.scene.frame_set(7)
        self.check(empty.instance_collection.objects["Face"], face.risen(7))

    def test_an_override_is_posed_and_reopened(self) -> None:
        obj, rig = self.override()
        rig.animation_data.action = None
        face.pose(rig, brow_L=0.01, brow_R=0.005)
        self.check(obj, 1.0, 0.5)
        self.assertEqual([pose.name for pose in obj.rumple_maps.poses], ["Surprise", "Anger"])
        obj, rig = self.reopened()
        rig.animation_data.action = None
        face.pose(rig, brow_L=0.005, brow_R=0.01)
        self.check(obj, 0.5, 1.0)

    def test_settings_of_an_override_count_and_are_kept(self) -> None:
        obj, rig = self.override()
        rig.animation_data.action = None
        obj.rumple_maps.poses["Surprise"].strength = 0.5
        face.pose(rig, brow_L=0.01, brow_R=0.01)
        self.check(obj, 0.5, 0.5)
        obj, rig = self.reopened()
        rig.animation_data.action = None
        face.pose(rig, brow_L=0.01, brow_R=0.01)
        self.check(obj, 0.5, 0.5)
        bpy.ops.rumple.pose_mute()
        bpy.context.view_layer.update()
        self.assertFalse(face.mask(obj, "Surprise").any())

    def test_poses_are_added_and_updated_in_an_override(self) -> None:
        obj, rig = self.override()
        rig.animation_data.action = None
        face.pose(rig, brow_L=0.02, brow_R=0.02)
        self.assertEqual(bpy.ops.rumple.pose_update(), {"FINISHED"})
        face.pose(rig, jaw=0.01)
        self.assertEqual(bpy.ops.rumple.pose_add(name="Open"), {"FINISHED"})
        for _ in range(2):
            rig.animation_data.action = None
            face.pose(rig, brow_L=0.01, brow_R=0.02)
            self.check(obj, 0.5, 1.0)
            face.pose(rig, jaw=0.005)
            np.testing.assert_allclose(face.mask(obj, "Open"), 0.5 * face.weights(obj, "jaw"), atol=ROUNDING)
            obj, rig = self.reopened()

    def test_what_blender_forbids_in_an_override_is_said(self) -> None:
        obj, _rig = self.override()
        for refused in (bpy.ops.rumple.pose_remove, lambda: bpy.ops.rumple.pose_move(direction="DOWN")):
            with self.assertRaisesRegex(RuntimeError, "Face: it is a library override.*mute a pose instead"):
                refused()
        self.assertEqual([pose.name for pose in obj.rumple_maps.poses], ["Surprise", "Anger"])

    def test_a_linked_rig_with_a_local_mesh(self) -> None:
        rig = self.link("objects", "Rig")
        bpy.context.scene.collection.objects.link(rig)
        mesh = face.sheet()
        obj = bpy.data.objects.new("Mine", mesh)
        bpy.context.scene.collection.objects.link(obj)
        for name, share in zip(face.BROWS, self.shares):
            group = obj.vertex_groups.new(name=name)
            for vertex, weight in enumerate(share):
                group.add([vertex], float(weight), "REPLACE")
        head = obj.vertex_groups.new(name="head")
        for vertex, weight in enumerate(1.0 - self.shares[0] - self.shares[1]):
            head.add([vertex], float(weight), "REPLACE")
        obj.modifiers.new("Armature", "ARMATURE").object = rig
        sleeve.make_active(obj)
        bpy.ops.rumple.maps_add()
        bpy.context.scene.frame_set(11)
        bpy.ops.rumple.pose_add(name="Surprise")
        for frame in (1, 6, 11):
            bpy.context.scene.frame_set(frame)
            self.check(obj, face.risen(frame))
        bpy.context.scene.frame_set(6)
        self.check(self.reopened()[0], face.risen(6))
