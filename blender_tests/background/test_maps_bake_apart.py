# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps that a second Blender bakes while the artist goes on in this one."""
from __future__ import annotations

import os
import tempfile
import time
import unittest
from unittest import mock

import bpy
import numpy as np
from rumple.blender.maps import bake, bake_apart, operators
from support import face, sleeve
from test_maps_bake import texels


class SecondBlender(face.TwoPoses, unittest.TestCase):

    def test_the_second_blender_bakes_what_was_set_at_the_beginning(self) -> None:
        """The artist goes on before the copy of the file is saved."""
        self.settings.bake_size = 64
        bpy.ops.rumple.maps_bake(every=True)
        here = [texels(pose.image) for pose in self.settings.poses]
        apart = bake_apart.ApartBake(bake.MapBake(bpy.context, self.obj, [0, 1]))
        self.settings.bake_size, self.settings.bake_deep = 32, True
        self.settings.poses.move(0, 1)
        try:
            for _ in apart.steps():
                time.sleep(0.1)
        finally:
            apart.close()
        for name, expected in zip(("Surprise", "Anger"), here):
            self.assertFalse(self.settings.poses[name].image.is_float)
            np.testing.assert_array_equal(texels(self.settings.poses[name].image), expected)


class NotInTheViewLayer(face.TwoPoses, unittest.TestCase):
    """The active armature names the mesh, which is in another scene, or excluded: the second Blender broke off."""

    def check(self) -> None:
        self.settings.bake_size = 64
        self.assertNotIn(self.obj, set(bpy.context.view_layer.objects))
        self.assertEqual(operators.target(bpy.context), self.obj)
        self.assertEqual(bpy.ops.rumple.maps_bake(every=True), {"FINISHED"})
        here = [texels(pose.image) for pose in self.settings.poses]
        apart = bake_apart.ApartBake(bake.MapBake(bpy.context, self.obj, [0, 1]))
        try:
            for _ in apart.steps():
                time.sleep(0.1)
        finally:
            apart.close()
        for pose, expected in zip(self.settings.poses, here):
            np.testing.assert_array_equal(texels(pose.image), expected)

    def test_in_another_scene(self) -> None:
        bpy.context.window.scene = scene = bpy.data.scenes.new("Another")
        scene.collection.objects.link(self.rig)
        sleeve.make_active(self.rig)
        self.check()

    def test_in_an_excluded_collection(self) -> None:
        scene, collection = bpy.context.scene, bpy.data.collections.new("Face")
        scene.collection.children.link(collection)
        collection.objects.link(self.obj)
        scene.collection.objects.unlink(self.obj)
        bpy.context.view_layer.layer_collection.children["Face"].exclude = True
        sleeve.make_active(self.rig)
        self.check()


class Events(unittest.TestCase):
    """What the bake does with the events of its window."""

    def modal(self, kind: str, value: str) -> tuple[set[str], mock.Mock]:
        """What it returns for an event, and the operator, whose steps are counted."""
        operator = mock.Mock(_running=mock.Mock(done=0, count=1), _steps=mock.MagicMock())
        operator._running.plan.names, operator._steps.__next__.return_value = [], "baking"
        return bake.RUMPLE_OT_maps_bake.modal(operator, mock.Mock(), mock.Mock(type=kind, value=value)), operator

    def test_all_go_on_to_the_window_but_the_press_of_esc(self) -> None:
        """The release of Esc arrives alone where its press ended a drag, which takes it for itself."""
        for kind, value in (("TIMER", "NOTHING"), ("MOUSEMOVE", "NOTHING"), ("A", "PRESS"), ("ESC", "RELEASE")):
            self.assertEqual(self.modal(kind, value)[0], {"PASS_THROUGH"}, kind)
        self.assertEqual(self.modal("ESC", "PRESS")[0], {"CANCELLED"})

    def test_it_waits_while_the_artist_renders(self) -> None:
        """It would make images while a job reads the file."""
        for renders in (False, True):
            with mock.patch.object(bake.scheduler, "job_runs", return_value=renders):
                answer, operator = self.modal("TIMER", "NOTHING")
            self.assertEqual((answer, operator._steps.__next__.called), ({"PASS_THROUGH"}, not renders))


class TakenOver(face.TwoPoses, unittest.TestCase):
    """What another Blender has baked, while the artist went on here."""

    def setUp(self) -> None:
        super().setUp()
        self.settings.bake_size = 16
        self.plan = bake.MapBake(bpy.context, self.obj, [0, 1])
        self.pixels = np.linspace(0.0, 1.0, 4 * 16 * 16, dtype=np.float32)
        self.pixels[3::4] = 1.0

    def check_taken(self, pose: bpy.types.PropertyGroup) -> None:
        flat = np.array(pose.image.pixels[:], np.float32)
        np.testing.assert_allclose(flat, self.pixels, atol=1 / 255)
        self.assertEqual((self.plan.names, self.plan.gone), ([pose.image.name], []))

    def test_settings_of_the_bake_that_were_changed_do_not_count(self) -> None:
        """After another Size a blank map took the place of the good one, and an error followed."""
        with tempfile.TemporaryDirectory() as folder:
            self.settings.bake_size, self.settings.bake_deep, self.settings.bake_folder = 32, True, folder
            self.plan.take("Surprise", self.pixels)
            self.assertEqual(os.listdir(folder), [])
        self.check_taken(self.settings.poses["Surprise"])
        self.assertFalse(self.settings.poses["Surprise"].image.is_float)

    def test_poses_that_were_moved_and_added_get_their_own_map(self) -> None:
        """The map went to the pose that had the place in the list by then."""
        face.pose(self.rig, jaw=-0.01)
        bpy.ops.rumple.pose_add(name="New")
        self.settings.poses.move(2, 0)
        self.settings.poses.move(1, 2)
        self.plan.take("Surprise", self.pixels)
        self.check_taken(self.settings.poses["Surprise"])
        self.assertEqual([pose.name for pose in self.settings.poses if pose.image], ["Surprise"])

    def test_without_wrinkle_maps_the_poses_stay_and_get_theirs(self) -> None:
        self.assertEqual(bpy.ops.rumple.maps_remove(), {"FINISHED"})
        self.plan.take("Surprise", self.pixels)
        self.check_taken(self.settings.poses["Surprise"])

    def test_the_map_of_what_is_gone_is_not_kept_and_this_is_said(self) -> None:
        poses = self.settings.poses

        def rename(owner: bpy.types.PropertyGroup | bpy.types.Object) -> None:
            owner.name = "Another"
        for change in (lambda: poses.remove(0), lambda: rename(poses[0]), lambda: rename(self.obj),
                       lambda: bpy.data.objects.remove(self.obj)):
            self.setUp()
            poses, images = self.settings.poses, len(bpy.data.images)
            change()
            self.plan.take("Surprise", self.pixels)
            self.assertEqual((self.plan.names, self.plan.gone, len(bpy.data.images)), ([], ["Surprise"], images))
            operator = mock.Mock()
            self.assertEqual(bake.RUMPLE_OT_maps_bake._finished(operator, self.plan), {"CANCELLED"})
            (kind, text), = (call.args for call in operator.report.call_args_list)
            self.assertEqual(kind, {"WARNING"})
            self.assertRegex(text, "^Face: .*no map: Surprise$")

    def test_a_former_map_is_never_replaced_by_a_blank_one(self) -> None:
        former = self.settings.poses[0].image = bpy.data.images.new("Good", 16, 16)
        images = len(bpy.data.images)
        with self.assertRaises(Exception):
            self.plan.take("Surprise", self.pixels[:-4])
        self.assertEqual((self.settings.poses[0].image, len(bpy.data.images)), (former, images))

    def test_an_undo_may_have_made_the_references_of_the_bake_invalid(self) -> None:
        """As here, where the file is opened again."""
        with tempfile.TemporaryDirectory() as folder:
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "face.blend"))
            bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)
        self.plan.take("Surprise", self.pixels)
        self.check_taken(bpy.data.objects["Face"].rumple_maps.poses["Surprise"])
