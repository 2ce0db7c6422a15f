# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Maps of shape keys: a face without an armature, and one with both."""
from __future__ import annotations

import unittest
import unittest.mock
from typing import Any, Callable

import bpy
import numpy as np
from mathutils import Euler, Matrix
from rumple.blender import handlers, scheduler
from rumple.blender.maps import changes, comparison, hidden_meshes as maps_meshes, keys as maps_keys
from support import face, keyed_face, sleeve

ROUNDING = 1e-4  # of a mask: the nodes' margin


class Masks(keyed_face.TwoPoses, unittest.TestCase):

    def test_it_adds_itself_without_an_armature_and_chooses_the_keys(self) -> None:
        self.assertEqual([m.type for m in self.obj.modifiers], ["NODES"])
        self.assertEqual([key.name for key in self.settings.keys], ["brow.L", "brow.R", "jaw", "frown", "width"])
        self.assertEqual((len(self.settings.bones), self.settings.root, self.settings.message), (0, "", ""))
        self.assertEqual(face.notes(self.obj), "")

    def test_a_mask_is_how_far_its_keys_move_the_skin_at_the_pose_and_nothing_at_rest(self) -> None:
        sums = keyed_face.weights("brow.L") + keyed_face.weights("brow.R") + keyed_face.weights("jaw")
        keyed_face.set_keys(self.obj, brow_L=1.0, brow_R=1.0, jaw=0.5)
        mask = face.mask(self.obj, "Surprise")
        np.testing.assert_allclose(mask, np.minimum(sums, 1.0), atol=1e-6)
        self.assertEqual(mask.max(), 1.0)
        self.assertFalse(face.mask(self.obj, "Anger").any())
        self.assertEqual(self.settings.poses["Surprise"].present, 1.0)
        keyed_face.set_keys(self.obj)
        self.assertFalse(face.mask(self.obj, "Surprise").any())
        self.assertEqual(self.settings.poses["Surprise"].present, 0.0)

    def test_one_brow_wrinkles_its_side_only(self) -> None:
        keyed_face.set_keys(self.obj, brow_L=0.5)
        mask = face.mask(self.obj, "Surprise")
        np.testing.assert_allclose(mask, 0.5 * keyed_face.weights("brow.L"), atol=ROUNDING)
        other = np.array([vertex.co.x < -1e-4 for vertex in self.obj.data.vertices])
        self.assertLess(mask[other].max(), 0.01)
        self.assertGreater(mask.max(), 0.4)

    def test_masks_stay_within_zero_and_one_whatever_the_keys(self) -> None:
        for block in list(self.keys)[1:]:
            block.slider_min, block.slider_max = -10.0, 10.0
        self.settings.gain = 5.0
        random = np.random.default_rng(0)
        for _ in range(10):
            names = ("brow_L", "brow_R", "jaw", "frown", "width")
            keyed_face.set_keys(self.obj, **dict(zip(names, random.uniform(-10, 10, 5))))
            for name in ("Surprise", "Anger"):
                mask = face.mask(self.obj, name)
                self.assertTrue(np.isfinite(mask).all() and mask.min() >= 0.0 and mask.max() <= 1.0)

    def test_the_face_may_move_turn_and_grow(self) -> None:
        keyed_face.set_keys(self.obj, brow_L=0.5, jaw=0.2)
        before = face.mask(self.obj, "Surprise")
        self.obj.matrix_world = (Matrix.Translation((3, 2, 1)) @ Euler((0.5, 0.7, -0.4)).to_matrix().to_4x4()
                                 @ Matrix.Diagonal((2, 2, 2, 1)))
        bpy.context.view_layer.update()
        np.testing.assert_array_equal(face.mask(self.obj, "Surprise"), before)

    def test_animated_and_driven_keys_in_any_order_of_frames(self) -> None:
        for frame, value in ((1, 0.0), (11, 1.0)):
            self.keys["brow.L"].value = value
            self.keys["brow.L"].keyframe_insert("value", frame=frame)
        self.obj["slider"] = 0.0
        driver = self.keys["brow.R"].driver_add("value").driver
        target = driver.variables.new().targets[0]
        target.id, target.data_path = self.obj, '["slider"]'
        driver.expression = "0.5 * " + driver.variables[0].name
        for frame in (6, 1, 11, 3):
            bpy.context.scene.frame_set(frame)
            left = self.keys["brow.L"].value
            for slider in (0.4, 1.0):
                self.obj["slider"] = slider
                self.obj.update_tag()
                bpy.context.view_layer.update()
                expected = left * keyed_face.weights("brow.L") + 0.5 * slider * keyed_face.weights("brow.R")
                np.testing.assert_allclose(face.mask(self.obj, "Surprise"), np.minimum(expected, 1.0), atol=ROUNDING)
        self.assertAlmostEqual(left, 0.1, 1)

    def test_playback_writes_and_compares_nothing(self) -> None:
        for frame, value in ((1, 0.0), (11, 1.0)):
            self.keys["brow.L"].value = value
            self.keys["brow.L"].keyframe_insert("value", frame=frame)
        bpy.context.scene.frame_set(1)
        with unittest.mock.patch.object(maps_meshes, "write_weights") as written, \
                unittest.mock.patch.object(comparison, "ensure") as compared:
            for frame in range(2, 12):
                bpy.context.scene.frame_set(frame)
        self.assertEqual((written.call_count, compared.call_count), (0, 0))
        self.assertEqual(bpy.context.scene.frame_current, 11)
        np.testing.assert_allclose(face.mask(self.obj, "Surprise"), keyed_face.weights("brow.L"), atol=ROUNDING)

    def test_a_muted_key_counts_as_at_rest(self) -> None:
        keyed_face.set_keys(self.obj, brow_L=1.0)
        self.keys["brow.L"].mute = True
        bpy.context.view_layer.update()
        self.assertFalse(face.mask(self.obj, "Surprise").any())
        self.assertEqual(self.settings.poses["Surprise"].present, 0.0)

    def test_without_handlers_the_masks_follow(self) -> None:
        """A machine without the add-on."""
        handlers.unregister()
        self.addCleanup(handlers.register)
        keyed_face.set_keys(self.obj, brow_L=0.25)
        np.testing.assert_allclose(face.mask(self.obj, "Surprise"), 0.25 * keyed_face.weights("brow.L"), atol=ROUNDING)

    def test_a_key_relative_to_another_counts_with_what_it_adds(self) -> None:
        both = np.array([vertex.co for vertex in self.obj.data.vertices], np.float32) + keyed_face.ways()["jaw"]
        extra = self.obj.shape_key_add(name="with jaw", from_mix=False)
        extra.data.foreach_set("co", (both + keyed_face.ways()["brow.L"]).astype(np.float32).ravel())
        extra.relative_key = self.keys["jaw"]
        bpy.ops.rumple.maps_keys()
        keyed_face.set_keys(self.obj, **{"with jaw": 1.0})
        extra.value = 1.0
        bpy.context.view_layer.update()
        keyed_face.add_pose("Extra")
        np.testing.assert_allclose(face.mask(self.obj, "Extra"), keyed_face.weights("brow.L"), atol=2e-6)

    def test_the_vertex_group_of_a_key_counts(self) -> None:
        left = self.obj.vertex_groups.new(name="left")
        left.add([v.index for v in self.obj.data.vertices if v.co.x > 0.0], 1.0, "REPLACE")
        self.keys["frown"].vertex_group = "left"
        bpy.ops.rumple.maps_keys()
        keyed_face.set_keys(self.obj, frown=1.0)
        mask = face.mask(self.obj, "Anger")
        right = np.array([v.co.x < 1e-6 for v in self.obj.data.vertices])
        self.assertFalse(mask[right].any())
        self.assertEqual(mask.max(), 1.0)


class Poses(unittest.TestCase):

    def setUp(self) -> None:
        self.obj = keyed_face.scene()
        self.keys = self.obj.data.shape_keys.key_blocks

    def refused(self, call: Callable[..., object], *words: str) -> None:
        with self.assertRaises(RuntimeError) as caught:
            call()
        for word in words:
            self.assertIn(word, str(caught.exception))

    def test_go_to_pose_update_and_neutral(self) -> None:
        settings = keyed_face.two_poses(self.obj)
        settings.active = 0
        bpy.ops.rumple.pose_go()
        self.assertEqual([round(self.keys[n].value, 5) for n in ("brow.L", "brow.R", "jaw", "frown")], [1, 1, 0.5, 0])
        bpy.ops.rumple.pose_go(neutral=True)
        self.assertFalse(any(block.value for block in list(self.keys)[1:]))
        keyed_face.set_keys(self.obj, brow_L=0.5)
        bpy.ops.rumple.pose_update()
        self.assertEqual(settings.poses[0].present, 1.0)

    def test_a_captured_face_with_its_own_width_shows_nothing(self) -> None:
        settings = keyed_face.two_poses(self.obj)
        keyed_face.set_keys(self.obj, width=0.7)
        bpy.ops.rumple.neutral_capture()
        for name, values in (("Surprise", dict(brow_L=1.0, width=0.7)), ("Anger", dict(frown=1.0, width=0.7))):
            keyed_face.set_keys(self.obj, **values)
            settings.active = settings.poses.find(name)
            bpy.ops.rumple.pose_update()
        keyed_face.set_keys(self.obj, width=0.7)
        self.assertFalse(face.mask(self.obj, "Surprise").any())
        self.assertEqual(face.notes(self.obj), "")
        bpy.ops.rumple.neutral_rest()
        bpy.context.view_layer.update()
        self.assertTrue(face.mask(self.obj, "Surprise").any())
        self.assertIn("width has the same value in every pose: go to the neutral face and capture it",
                      face.notes(self.obj))

    def test_equal_poses_and_the_neutral_face_are_refused(self) -> None:
        keyed_face.two_poses(self.obj)
        self.refused(lambda: bpy.ops.rumple.pose_add(name="Still"), "pose Still", "no bone and no shape key moves")
        keyed_face.set_keys(self.obj, frown=1.0)
        self.refused(lambda: bpy.ops.rumple.pose_add(name="Twin"), "pose Twin", "stands as in pose Anger")
        self.assertEqual([pose.name for pose in self.obj.rumple_maps.poses], ["Surprise", "Anger"])

    def test_a_driven_key_that_cannot_go_there_is_named(self) -> None:
        settings = keyed_face.two_poses(self.obj)
        self.keys["brow.L"].driver_add("value").driver.expression = "0.25"
        settings.active = 0
        self.assertEqual(bpy.ops.rumple.pose_go(), {"FINISHED"})
        self.assertEqual(maps_keys.astray(self.obj, maps_keys.of_records(settings.poses[0].keys)), ["brow.L"])
        self.assertAlmostEqual(self.keys["brow.L"].value, 0.25, 5)
        self.assertAlmostEqual(self.keys["brow.R"].value, 1.0, 5)

    def test_renamed_and_removed_keys_are_named_and_the_others_go_on(self) -> None:
        settings = keyed_face.two_poses(self.obj)
        self.keys["jaw"].name = "Mund"
        keyed_face.set_keys(self.obj, brow_L=1.0)
        self.settle()
        self.assertIn("it has no shape key jaw: renamed or deleted?", face.notes(self.obj))
        np.testing.assert_allclose(face.mask(self.obj, "Surprise"), keyed_face.weights("brow.L"), atol=ROUNDING)
        self.obj.shape_key_remove(self.keys["brow.R"])
        self.settle()
        self.assertIn("it has no shape key brow.R, jaw", face.notes(self.obj))
        np.testing.assert_allclose(face.mask(self.obj, "Surprise"), keyed_face.weights("brow.L"), atol=ROUNDING)
        self.assertEqual(settings.message, "")
        self.obj.shape_key_clear()
        self.settle()
        self.assertIn("it has no shape key brow.L, brow.R, jaw and 2 more", settings.message)
        self.assertFalse(face.mask(self.obj, "Surprise").any())

    def settle(self) -> None:
        self.obj.data.update_tag()
        bpy.context.view_layer.update()
        scheduler.sync_all()
        bpy.context.view_layer.update()

    def test_absolute_keys_are_said(self) -> None:
        settings = keyed_face.two_poses(self.obj)
        self.obj.data.shape_keys.use_relative = False
        self.settle()
        self.assertIn("its shape keys are absolute: switch on Relative", settings.message)
        self.obj.data.shape_keys.use_relative = True
        self.settle()
        self.assertEqual(settings.message, "")

    def test_a_sculpted_key_moves_other_skin(self) -> None:
        keyed_face.two_poses(self.obj)
        keyed_face.set_keys(self.obj, frown=1.0)
        self.keys["frown"].data.foreach_set("co", np.array([v.co for v in self.obj.data.vertices], np.float32).ravel())
        self.keys["frown"].data[0].co.z += 0.01
        self.settle()
        mask = face.mask(self.obj, "Anger")
        self.assertEqual((mask[0], mask[1:].max()), (1.0, 0.0))

    def test_a_key_sculpted_while_frames_step_is_read_when_they_rest(self) -> None:
        keyed_face.two_poses(self.obj)
        self.keys["jaw"].keyframe_insert("value", frame=1)
        keyed_face.set_keys(self.obj, frown=1.0)
        self.keys["frown"].data.foreach_set("co", np.array([v.co for v in self.obj.data.vertices], np.float32).ravel())
        self.keys["frown"].data[0].co.z += 0.01
        self.obj.data.update_tag()
        bpy.context.scene.frame_set(5)
        scheduler.sync_all()
        mask = face.mask(self.obj, "Anger")
        self.assertEqual((mask[0], mask[1:].max()), (1.0, 0.0))

    def test_keys_are_left_out_and_chosen_again(self) -> None:
        settings = keyed_face.two_poses(self.obj)
        settings.active_key = settings.keys.find("brow.R")
        bpy.ops.rumple.maps_key_remove()
        keyed_face.set_keys(self.obj, brow_R=1.0)
        self.assertFalse(face.mask(self.obj, "Surprise").any())
        bpy.ops.rumple.maps_keys()
        bpy.context.view_layer.update()
        self.assertTrue(face.mask(self.obj, "Surprise").any())

    def test_every_change_can_be_undone_and_done_again(self) -> None:
        keyed_face.two_poses(self.obj)

        def now() -> Any:
            settings = bpy.data.objects["Face"].rumple_maps
            return ([(pose.name, round(pose.keys["brow.L"].value, 4)) for pose in settings.poses],
                    len(settings.neutral_keys), [key.name for key in settings.keys])

        changes = (lambda: bpy.ops.rumple.pose_update(), lambda: bpy.ops.rumple.neutral_capture(),
                   lambda: bpy.ops.rumple.neutral_rest(), lambda: bpy.ops.rumple.maps_key_remove(),
                   lambda: bpy.ops.rumple.maps_keys(), lambda: bpy.ops.rumple.pose_remove())
        bpy.ops.ed.undo_push(message="start")
        seen = [now()]
        for number, change in enumerate(changes):
            obj = bpy.data.objects["Face"]
            keyed_face.set_keys(obj, brow_L=0.3 + 0.1 * number)
            sleeve.make_active(obj)
            obj.rumple_maps.active = 0
            with sleeve.context():
                self.assertEqual(change(), {"FINISHED"})
                bpy.ops.ed.undo_push(message="in background operators push nothing")
            seen.append(now())
        for state in reversed(seen[:-1]):
            bpy.ops.ed.undo()
            self.assertEqual(now(), state)
        obj = bpy.data.objects["Face"]
        sleeve.make_active(obj)
        keyed_face.set_keys(obj, brow_L=1.0)
        np.testing.assert_allclose(face.mask(obj, "Surprise"), keyed_face.weights("brow.L"), atol=ROUNDING)


class KeysAndBones(unittest.TestCase):
    """The jaw has a bone, the brows have keys."""

    def setUp(self) -> None:
        self.obj, self.rig = face.scene()
        keyed_face.add_keys(self.obj, ("brow.L", "brow.R"))
        self.settings = self.obj.rumple_maps

    def pose(self, jaw: float, left: float, right: float = 0.0) -> None:
        keyed_face.set_keys(self.obj, brow_L=left, brow_R=right)
        face.pose(self.rig, jaw=jaw)

    def test_both_count_each_in_its_place(self) -> None:
        self.pose(-0.02, 1.0, 1.0)
        keyed_face.add_pose("Shout")
        self.assertEqual(self.settings.root, "head")
        self.assertEqual(len(self.settings.keys), 2)
        left, jaw = keyed_face.weights("brow.L"), face.weights(self.obj, "jaw")
        self.assertFalse(((left > 0) & (jaw > 0)).any())
        for down, up in ((1.0, 0.0), (0.5, 0.25), (0.0, 1.0), (0.0, 0.0)):
            self.pose(-0.02 * down, up)
            np.testing.assert_allclose(face.mask(self.obj, "Shout"), down * jaw + up * left, atol=ROUNDING)
        self.rig.location = (1.0, 2.0, 3.0)
        self.rig.pose.bones["neck"].rotation_mode = "XYZ"
        self.pose(-0.01, 0.5)
        before = face.mask(self.obj, "Shout")
        self.rig.pose.bones["neck"].rotation_euler = (0.4, 0.2, 0.1)
        bpy.context.view_layer.update()
        np.testing.assert_allclose(face.mask(self.obj, "Shout"), before, atol=1e-3)

    def test_a_pose_of_keys_alone_compares_no_bones(self) -> None:
        """A head that turns with its bone must not wrinkle for that."""
        self.pose(0.0, 1.0)
        keyed_face.add_pose("Brow")
        self.assertEqual((len(self.settings.bones), len(self.settings.keys)), (0, 2))
        bpy.ops.rumple.maps_bones()
        self.assertEqual(len(self.settings.bones), 3)

    def test_a_pose_of_bones_alone_compares_them_as_without_keys(self) -> None:
        self.pose(-0.02, 0.0)
        keyed_face.add_pose("Open")
        self.assertEqual(sorted(bone.name for bone in self.settings.bones), ["brow.L", "brow.R", "jaw"])
        self.pose(-0.01, 1.0)
        np.testing.assert_allclose(face.mask(self.obj, "Open"), 0.5 * face.weights(self.obj, "jaw"), atol=ROUNDING)

    def test_bones_that_came_after_a_pose_of_keys_are_at_rest_in_it(self) -> None:
        armature, self.settings.root = self.obj.modifiers["Armature"], ""
        armature.object = None
        self.pose(0.0, 1.0)
        keyed_face.add_pose("Brow")
        armature.object = self.rig
        self.settings.bones.add().name = "jaw"
        changes.rig_changed(self.obj)
        self.pose(0.0, 1.0)
        self.assertEqual(self.settings.message, "")
        self.assertIn("pose Brow was stored without jaw", face.notes(self.obj))
        np.testing.assert_allclose(face.mask(self.obj, "Brow"), keyed_face.weights("brow.L"), atol=ROUNDING)

    def test_without_its_armature_the_keys_go_on(self) -> None:
        self.pose(-0.02, 1.0)
        keyed_face.add_pose("Shout")
        self.obj.modifiers.remove(self.obj.modifiers["Armature"])
        changes.rig_changed(self.obj)
        self.pose(0.0, 1.0)
        self.assertIn("only its shape keys are compared", face.notes(self.obj))
        np.testing.assert_allclose(face.mask(self.obj, "Shout"), keyed_face.weights("brow.L"), atol=ROUNDING)
        self.assertEqual(self.settings.message, "")
