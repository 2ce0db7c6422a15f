# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Maps: what happens when things go wrong, and files."""
from __future__ import annotations

import os
import tempfile
import unittest
import unittest.mock
from typing import Callable

import bpy
import numpy as np
from rumple.blender import scheduler
from rumple.blender.maps import changes as maps_changes, hidden_meshes as maps_meshes, modifier as maps_modifier
from rumple.blender.nodes import maps_shader
from rumple.blender.objects import messages, modifier
from support import face, sleeve


class Wrong(face.TwoPoses, unittest.TestCase):
    """What a file may have gone through. Each is said in words, and the rest goes on."""

    def settle(self) -> None:
        self.obj.update_tag()
        bpy.context.view_layer.update()
        bpy.context.view_layer.update()

    def edit(self, change: Callable[..., object]) -> None:
        sleeve.make_active(self.rig)
        bpy.ops.object.mode_set(mode="EDIT")
        change(self.rig.data.edit_bones)
        bpy.ops.object.mode_set(mode="OBJECT")
        sleeve.make_active(self.obj)
        self.settle()

    def test_a_deleted_bone_is_named_and_the_others_go_on(self) -> None:
        self.edit(lambda bones: bones.remove(bones["brow.R"]))
        face.pose(self.rig, brow_L=0.01)
        self.assertIn("Rig has no bone brow.R", face.notes(self.obj))
        np.testing.assert_allclose(face.mask(self.obj, "Surprise"), face.weights(self.obj, "brow.L"), atol=1e-2)

    def test_a_renamed_bone_is_named(self) -> None:
        self.rig.data.bones["jaw"].name = "chin"
        maps_changes.rig_changed(self.obj)
        self.settle()
        self.assertIn("no bone jaw", face.notes(self.obj))
        face.pose(self.rig, brow_L=0.01)
        self.assertTrue(face.mask(self.obj, "Surprise").any())

    def test_a_lost_root_is_named(self) -> None:
        self.edit(lambda bones: bones.remove(bones["head"]))
        self.assertIn("Rig has no bone \"head\" to be the root", self.obj.rumple_maps.message)
        self.assertEqual(len(self.settings.poses), 2)

    def test_another_armature_without_these_bones(self) -> None:
        self.obj.modifiers["Armature"].object = sleeve.arm()
        sleeve.make_active(self.obj)
        maps_changes.rig_changed(self.obj)
        self.settle()
        self.assertIn("Arm has no bone \"head\"", self.obj.rumple_maps.message)
        self.obj.modifiers["Armature"].object = self.rig
        maps_changes.rig_changed(self.obj)
        self.settle()
        self.assertEqual(self.obj.rumple_maps.message, "")

    def test_a_mesh_without_the_vertex_group(self) -> None:
        self.obj.vertex_groups.remove(self.obj.vertex_groups["brow.L"])
        maps_changes.rig_changed(self.obj)
        face.pose(self.rig, brow_L=0.01, brow_R=0.01)
        self.assertIn("no vertex group brow.L", face.notes(self.obj))
        self.assertGreater(face.mask(self.obj, "Surprise").max(), 0.9)

    def test_weights_that_do_not_sum_to_one_are_counted(self) -> None:
        self.obj.vertex_groups["head"].add([0, 1, 2], 0.5, "REPLACE")
        maps_changes.rig_changed(self.obj)
        self.settle()
        self.assertIn("the skin weights of 3 vertices do not sum to 1", face.notes(self.obj))

    def test_images_missing_of_another_size_or_read_as_colours(self) -> None:
        for pose, size in zip(self.settings.poses, (64, 32)):
            pose.image = bpy.data.images.new(pose.name, size, size)
            pose.image.colorspace_settings.name = "Non-Color"
        self.settle()
        self.assertIn("has 32 x 32 texels, that of pose Surprise 64 x 64", face.notes(self.obj))
        self.settings.poses[0].image.colorspace_settings.name = "sRGB"
        self.settings.poses[1].image.source = "FILE"
        self.settings.poses[1].image.filepath = "//not_there.png"
        maps_changes.maps_changed(self.obj)
        self.settle()
        self.assertIn("Surprise is read as a colour", face.notes(self.obj))
        self.assertIn("Anger of pose Anger cannot be found: //not_there.png", face.notes(self.obj))

    def test_adding_a_pose_says_nothing_of_one_that_is_half_made(self) -> None:
        """It was evaluated with no name and no bones: 'pose  was stored without the root bone'."""
        obj, rig = face.scene()
        rig.pose.bones["jaw"].location.z = 0.02  # nothing has evaluated it when the button is pressed
        with unittest.mock.patch.object(messages, "_print_new") as said:
            bpy.ops.rumple.pose_add(name="Open")
        self.assertEqual([call.args[0] for call in said.call_args_list if call.args[0]], [])
        self.assertEqual([pose.name for pose in obj.rumple_maps.poses], ["Open"])

    def test_other_vertices_get_other_masks(self) -> None:
        mesh = face.sheet()
        self.obj.data = mesh
        self.settle()
        face.pose(self.rig, brow_L=0.01)
        self.assertFalse(face.mask(self.obj, "Surprise").any())     # the new mesh has no weights
        self.assertIn("have no skin weight", face.notes(self.obj))

    def test_without_a_vertex_it_says_nothing_of_arrays_and_goes_on_when_there_are_some(self) -> None:
        """'unexpected ValueError in poses.py: cannot reshape array of size 0 into shape (0)'."""
        former = self.obj.data
        self.obj.data = bpy.data.meshes.new("Nothing")
        self.settle()
        self.assertNotIn("unexpected", self.obj.rumple_maps.message + face.notes(self.obj))
        self.obj.data = former
        self.settle()
        face.pose(self.rig, brow_L=0.01)
        self.assertTrue(face.mask(self.obj, "Surprise").any())

    def test_without_an_armature_it_cannot_be_added(self) -> None:
        bpy.ops.rumple.maps_remove()
        self.obj.modifiers.remove(self.obj.modifiers["Armature"])
        with self.assertRaisesRegex(RuntimeError, "No armature deforms|poll"):
            bpy.ops.rumple.maps_add()


class Files(face.TwoPoses, unittest.TestCase):

    def test_saved_and_opened_all_is_there(self) -> None:
        bpy.ops.rumple.maps_show()
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "face.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.read_homefile(use_empty=True)
            bpy.ops.wm.open_mainfile(filepath=path)
        obj, rig = bpy.data.objects["Face"], bpy.data.objects["Rig"]
        face.pose(rig, brow_L=0.01, brow_R=0.01)
        self.assertEqual(obj.rumple_maps.poses["Surprise"].present, 1.0)
        self.assertGreater(face.mask(obj, "Surprise").max(), 0.9)
        self.assertEqual(maps_shader.shown_in(obj.data.materials[0]), obj.rumple_maps.group)

    def test_a_duplicate_gets_its_own(self) -> None:
        copy = self.obj.copy()
        bpy.context.scene.collection.objects.link(copy)
        bpy.context.view_layer.update()
        copy.rumple_maps.poses["Anger"].name = "Fury"
        face.pose(self.rig, brow_L=-0.008, brow_R=-0.008, jaw=0.005)
        self.assertTrue(face.mask(copy, "Fury").any())
        self.assertTrue(face.mask(self.obj, "Anger").any())
        skins = {maps_modifier.skin(maps_modifier.find(obj)) for obj in (self.obj, copy)}
        self.assertEqual(len(skins), 2)

    def test_removed_nothing_is_left_but_the_poses(self) -> None:
        bpy.ops.rumple.maps_show()
        bpy.ops.rumple.maps_remove()
        self.assertEqual([m.name for m in self.obj.modifiers], ["Armature"])
        self.assertFalse([o for o in bpy.data.objects if maps_meshes.KEY in o])
        self.assertFalse([g for g in bpy.data.node_groups if maps_modifier.is_ours(g) or maps_shader.is_ours(g)])
        self.assertEqual([pose.name for pose in self.settings.poses], ["Surprise", "Anger"])
        face.pose(self.rig, brow_L=0.01, brow_R=0.01)
        scheduler.sync_all()
        self.assertEqual(self.settings.poses["Surprise"].present, 1.0)  # a bar may still be drawn: it was an error
        bpy.ops.rumple.maps_add()
        face.pose(self.rig, brow_L=0.01, brow_R=0.01)
        self.assertEqual(self.settings.poses["Surprise"].present, 1.0)

    def test_the_method_is_maps_unless_other_wrinkles_stand_beside_them(self) -> None:
        sleeve.make_active(self.obj)
        self.assertEqual(self.obj.rumple.method, "MAPS")
        for way in (lambda: bpy.ops.object.rumple_remove(),
                    lambda: self.obj.modifiers.remove(modifier.find(self.obj))):
            bpy.ops.object.rumple_add(method="MESH")
            scheduler.sync_all()
            self.assertEqual(self.obj.rumple.method, "MESH")
            way()
            scheduler.sync_all()
            self.assertEqual(self.obj.rumple.method, "MAPS")
        bpy.ops.rumple.maps_remove()
        self.assertEqual(self.obj.rumple.method, "NONE")
        bpy.ops.object.rumple_add(method="MAPS")
        self.assertEqual(self.obj.rumple.method, "MAPS")
        self.obj.modifiers.remove(maps_modifier.find(self.obj))
        scheduler.sync_all()
        self.assertEqual(self.obj.rumple.method, "NONE")

    def test_a_file_from_before_maps_were_a_method(self) -> None:
        self.obj.rumple.method = "NONE"
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "older.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
        obj = bpy.data.objects["Face"]
        self.assertEqual(obj.rumple.method, "MAPS")
        self.assertEqual(obj.rumple_maps.message, "")

    def test_deleted_by_blenders_own_button_its_hidden_meshes_go(self) -> None:
        self.obj.modifiers.remove(maps_modifier.find(self.obj))
        scheduler.sync_all()
        self.assertFalse([o for o in bpy.data.objects if maps_meshes.KEY in o])
