# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Maps of shape keys: baked, exported, saved, duplicated, linked."""
from __future__ import annotations

import json
import os
import tempfile
import unittest
from typing import Any

import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.maps import hidden_meshes as maps_meshes, modifier as maps_modifier
from rumple.core.systems import poses_json
from support import face, keyed_face, sleeve
from test_maps_bake import everything, texels

ROUNDING = 1e-4


class Bake(unittest.TestCase):

    def setUp(self) -> None:
        self.obj = keyed_face.scene()
        self.keys = self.obj.data.shape_keys.key_blocks
        for name, values in (("Left", dict(brow_L=-1.0)), ("Right", dict(brow_R=-1.0))):
            keyed_face.set_keys(self.obj, **values)
            keyed_face.add_pose(name)
        self.settings = self.obj.rumple_maps
        self.settings.bake_size = 128
        self.obj.rumple.mesh.hem_rings = 0

    def check_sides(self) -> None:
        place = (np.arange(128) + 0.5) / 128
        for pose, centre in (("Left", 0.75), ("Right", 0.25)):
            lean = np.abs(texels(self.settings.poses[pose].image)[:, :, :2] - 0.5).max(2)
            near, far = np.abs(place - centre) < 0.25, np.abs(place - centre) > 0.35
            self.assertGreater(lean[:, near].max(), 0.1, pose)
            self.assertLess((lean[:, far] ** 2).mean(), 0.05 * (lean[:, near] ** 2).mean(), pose)

    def test_wrinkles_come_where_the_keys_compress_the_skin_and_nothing_else_changes(self) -> None:
        keyed_face.set_keys(self.obj, jaw=0.5)
        before, values = everything(), [block.value for block in self.keys]
        self.assertEqual(bpy.ops.rumple.maps_bake(every=True), {"FINISHED"})
        self.assertEqual(everything(), before)
        self.assertEqual([block.value for block in self.keys], values)
        self.check_sides()

    def test_driven_animated_and_muted_keys_are_baked_as_stored(self) -> None:
        """The pose is baked, not what a driver makes of it now."""
        self.keys["brow.L"].driver_add("value").driver.expression = "0.0"
        self.keys["brow.R"].keyframe_insert("value", frame=1)
        self.keys["brow.R"].mute = True
        bpy.context.view_layer.update()
        bpy.ops.rumple.maps_bake(every=True)
        self.check_sides()
        self.assertTrue(self.keys["brow.R"].mute)
        self.assertEqual(len(self.obj.data.shape_keys.animation_data.drivers), 1)


class Export(keyed_face.TwoPoses, unittest.TestCase):

    def test_json_and_influences(self) -> None:
        self.settings.keys["brow.L"].group = self.settings.keys["brow.R"].group = "brows"
        for frame, value in ((1, 0.0), (5, 1.0)):
            self.keys["brow.L"].value = value
            self.keys["brow.L"].keyframe_insert("value", frame=frame)
        bpy.context.scene.frame_end = 5
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "face.json")
            self.assertEqual(bpy.ops.rumple.maps_export(filepath=path, frames=True), {"FINISHED"})
            with open(path, encoding="utf-8") as file:
                rig = poses_json.from_json(file.read())
            with open(os.path.join(folder, "face.frames.json"), encoding="utf-8") as file:
                clip = json.load(file)
        self.assertEqual([key.name for key in rig.keys], ["brow.L", "brow.R", "jaw", "frown"])  # width is in no pose
        np.testing.assert_allclose([pose.keys for pose in rig.poses], [[1, 1, 0.5, 0], [0, 0, 0, 1]], atol=1e-6)
        self.assertEqual((rig.bones, rig.root), ([], ""))
        self.assertEqual(clip["keys"], [key.name for key in rig.keys])
        self.assertEqual((clip["bones"], clip["influence"][0]), ([], []))
        self.assertEqual([rows[1][0] for rows in clip["key_influence"]][::4], [0.0, 0.5])  # the mean of the brows
        self.assertEqual([rows[3][1] for rows in clip["key_influence"]], [0.0] * 5)

    def test_a_copy_with_weights_keeps_the_keys(self) -> None:
        for frame, value in ((1, 0.0), (5, 1.0)):
            for name in ("brow.L", "brow.R", "jaw"):
                self.keys[name].value = value
                self.keys[name].keyframe_insert("value", frame=frame)
        bpy.context.scene.frame_end = 5
        bpy.ops.rumple.maps_weights()
        blocks = bpy.data.objects["Face weights"].data.shape_keys.key_blocks
        bpy.context.scene.frame_set(5)
        self.assertEqual([round(blocks[name].value, 5) for name in ("brow.L", "rumple_pose_Surprise",
                                                                    "rumple_pose_Anger")], [1.0, 1.0, 0.0])

    def test_a_copy_with_weights_leaves_the_artists_action_alone(self) -> None:
        """The weights were keyed in it, and a second copy keyed it again."""
        self.keys["brow.L"].keyframe_insert("value", frame=1)
        about = self.obj.data.shape_keys.animation_data
        before = [curve.data_path for curve in compat.keyed_curves(about)]
        bpy.context.scene.frame_end = 2
        bpy.ops.rumple.maps_weights()
        self.assertEqual([curve.data_path for curve in compat.keyed_curves(about)], before)

    def test_a_hidden_face_is_refused(self) -> None:
        """Nothing moves it then: every influence was 0."""
        self.keys["brow.L"].keyframe_insert("value", frame=1)
        self.obj.hide_viewport = True
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(RuntimeError, "Face: nothing of it is shown at frame 1, it is hidden: show it"):
                bpy.ops.rumple.maps_export(filepath=os.path.join(folder, "face.json"), frames=True)
            self.assertEqual(os.listdir(folder), [])
        with self.assertRaisesRegex(RuntimeError, "it is hidden: show it"):
            bpy.ops.rumple.maps_weights()


class Files(keyed_face.TwoPoses, unittest.TestCase):

    def follows(self, obj: bpy.types.Object, value: float) -> None:
        keyed_face.set_keys(obj, brow_L=value)
        np.testing.assert_allclose(face.mask(obj, "Surprise"), value * keyed_face.weights("brow.L"), atol=ROUNDING)

    def test_saved_and_opened_all_is_there(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "face.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.read_homefile(use_empty=True)
            bpy.ops.wm.open_mainfile(filepath=path)
        obj = bpy.data.objects["Face"]
        self.follows(obj, 0.5)
        self.assertEqual(obj.rumple_maps.message, "")

    def test_a_duplicate_follows_its_own_keys(self) -> None:
        copy = self.obj.copy()
        copy.data = self.obj.data.copy()
        bpy.context.scene.collection.objects.link(copy)
        bpy.context.view_layer.update()
        self.follows(copy, 0.5)
        self.follows(self.obj, 0.25)
        np.testing.assert_allclose(face.mask(copy, "Surprise"), 0.5 * keyed_face.weights("brow.L"), atol=ROUNDING)

    def test_removed_nothing_is_left_but_the_poses(self) -> None:
        bpy.ops.rumple.maps_remove()
        self.assertFalse(list(self.obj.modifiers))
        self.assertFalse([o for o in bpy.data.objects if maps_meshes.KEY in o])
        self.assertEqual(len(bpy.data.shape_keys), 1)
        bpy.ops.rumple.maps_add()
        self.follows(self.obj, 0.75)

    def test_a_mesh_without_keys_and_armature_is_refused(self) -> None:
        bpy.ops.rumple.maps_remove()
        self.obj.shape_key_clear()
        with self.assertRaisesRegex(RuntimeError, "it has no shape keys|poll"):
            bpy.ops.rumple.maps_add()


class Linked(unittest.TestCase):

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(sleeve.empty_file)
        self.library, self.shot = (os.path.join(folder.name, name) for name in ("character.blend", "shot.blend"))
        obj = keyed_face.scene()
        keyed_face.two_poses(obj)
        block = obj.data.shape_keys.key_blocks["brow.L"]
        for frame, value in ((1, 0.0), (11, 1.0)):
            block.value = value
            block.keyframe_insert("value", frame=frame)
        collection, scene = bpy.data.collections.new("Character"), bpy.context.scene
        scene.collection.children.link(collection)
        scene.collection.objects.unlink(obj)
        collection.objects.link(obj)
        bpy.ops.wm.save_as_mainfile(filepath=self.library)
        sleeve.empty_file()

    def link(self) -> Any:
        with bpy.data.libraries.load(self.library, link=True) as (_, wanted):
            wanted.collections = ["Character"]
        bpy.context.scene.collection.children.link(wanted.collections[0])
        bpy.context.view_layer.update()
        return wanted.collections[0]

    def test_linked_it_follows_its_keys_and_nothing_is_made(self) -> None:
        obj = self.link().objects["Face"]
        before = sorted(obj.name_full for obj in bpy.data.objects)
        for frame in (11, 3, 6):
            bpy.context.scene.frame_set(frame)
            value = obj.data.shape_keys.key_blocks["brow.L"].value
            np.testing.assert_allclose(face.mask(obj, "Surprise"), value * keyed_face.weights("brow.L"), atol=ROUNDING)
            self.assertAlmostEqual(obj.rumple_maps.poses["Surprise"].present, value / 3, 4)
        self.assertGreater(value, 0.3)
        self.assertEqual(sorted(obj.name_full for obj in bpy.data.objects), before)

    def test_an_override_follows_its_own_keys_and_is_reopened(self) -> None:
        collection = self.link()
        scene = bpy.context.scene
        collection.override_hierarchy_create(scene, bpy.context.view_layer, do_fully_editable=True)
        bpy.context.view_layer.update()
        for _ in range(2):
            obj = next(o for o in bpy.data.objects if o.library is None and maps_modifier.find(o)
                       and o.users_collection)
            self.assertEqual(obj.rumple_maps.message, "")
            for frame in (11, 3):
                bpy.context.scene.frame_set(frame)
                value = obj.data.shape_keys.key_blocks["brow.L"].value
                np.testing.assert_allclose(face.mask(obj, "Surprise"), value * keyed_face.weights("brow.L"),
                                           atol=ROUNDING)
            obj.data.shape_keys.key_blocks["brow.R"].value = 0.5
            bpy.context.view_layer.update()
            expected = value * keyed_face.weights("brow.L") + 0.5 * keyed_face.weights("brow.R")
            np.testing.assert_allclose(face.mask(obj, "Surprise"), np.minimum(expected, 1.0), atol=ROUNDING)
            bpy.ops.wm.save_as_mainfile(filepath=self.shot)
            bpy.ops.wm.open_mainfile(filepath=self.shot)
