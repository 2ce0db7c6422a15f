# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Maps: reference poses, and masks on the evaluated mesh."""
from __future__ import annotations

import unittest
import unittest.mock
from typing import Any, Callable

import bpy
import numpy as np
from mathutils import Euler, Matrix
from rumple.blender import compat
from rumple.blender.maps import hidden_meshes as maps_meshes, modifier as maps_modifier, operators
from rumple.blender.nodes import maps_mask_tree, maps_shader
from support import face, sleeve

ROUNDING = 1e-4  # of a mask: bones of a head in single precision


class Masks(face.TwoPoses, unittest.TestCase):

    def test_a_mask_is_the_skin_weight_at_the_pose_and_nothing_at_the_neutral_one(self) -> None:
        brows = face.weights(self.obj, "brow.L") + face.weights(self.obj, "brow.R")
        face.pose(self.rig, brow_L=0.01, brow_R=0.01)
        np.testing.assert_allclose(face.mask(self.obj, "Surprise"), brows, atol=1e-6)
        self.assertFalse(face.mask(self.obj, "Anger").any())
        face.pose(self.rig)
        self.assertFalse(face.mask(self.obj, "Surprise").any())
        self.assertEqual(self.obj.rumple_maps.message, "")

    def test_one_brow_wrinkles_its_side_only(self) -> None:
        face.pose(self.rig, brow_L=0.005)
        mask = face.mask(self.obj, "Surprise")
        np.testing.assert_allclose(mask, 0.5 * face.weights(self.obj, "brow.L"), atol=ROUNDING)
        elsewhere = face.weights(self.obj, "brow.L") == 0.0
        self.assertEqual(mask[elsewhere].max(), 0.0)

    def test_the_whole_head_may_move_turn_and_grow(self) -> None:
        face.pose(self.rig, brow_L=0.005, brow_R=0.01, jaw=0.003)
        before = {name: face.mask(self.obj, name) for name in ("Surprise", "Anger")}
        self.assertGreater(before["Surprise"].max(), 0.9)
        for name, bone in (("neck", "neck"), ("head", "head")):
            self.rig.pose.bones[bone].matrix_basis = (Matrix.Translation((0.3, 0.1, 0.2))
                                                      @ Euler((0.5, 0.7, -0.4)).to_matrix().to_4x4()
                                                      @ Matrix.Diagonal((1.3, 1.3, 1.3, 1.0)))
            self.rig.location, self.rig.scale = (3.0, 0.0, 1.0), (2.0, 2.0, 2.0)
            bpy.context.view_layer.update()
            for pose, mask in before.items():
                np.testing.assert_allclose(face.mask(self.obj, pose), mask, atol=1e-3, err_msg=name)

    def test_packed_for_the_shader_as_one_by_one(self) -> None:
        face.pose(self.rig, brow_L=0.004, jaw=0.002)
        evaluated = self.obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        packed = compat.read_attribute(evaluated.data.attributes[maps_shader.MASKS.format(0)])
        np.testing.assert_array_equal(packed[:, 0], face.mask(self.obj, "Surprise"))
        np.testing.assert_array_equal(packed[:, 1], face.mask(self.obj, "Anger"))
        self.assertTrue(packed[:, :2].any(0).all())
        self.assertFalse(packed[:, 2].any())

    def test_the_mesh_stays_what_it_was(self) -> None:
        face.pose(self.rig, brow_L=0.01)
        evaluated = self.obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        self.assertEqual(len(evaluated.data.polygons), len(self.obj.data.polygons))
        with_maps = compat.positions(evaluated.data).copy()
        maps_modifier.find(self.obj).show_viewport = False
        bpy.context.view_layer.update()
        evaluated = self.obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        np.testing.assert_array_equal(compat.positions(evaluated.data), with_maps)

    def test_masks_are_there_while_the_modifier_is_shown(self) -> None:
        scene = bpy.context.scene
        for shown in (False, True):
            maps_modifier.find(self.obj).show_viewport = shown
            scene.frame_set(scene.frame_end)
            evaluated = self.obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
            for pose in self.settings.poses:
                self.assertEqual(maps_mask_tree.MASK.format(pose.name) in evaluated.data.attributes, shown)

    def test_animated_bones_in_any_order_of_frames(self) -> None:
        face.animate(self.rig)
        for frame in (6, 1, 11, 3, 8):
            bpy.context.scene.frame_set(frame)
            np.testing.assert_allclose(face.mask(self.obj, "Surprise"),
                                       face.risen(frame) * face.weights(self.obj, "brow.L"), atol=ROUNDING)

    def test_an_animated_gain_and_strength_count(self) -> None:
        face.pose(self.rig, brow_L=0.01, brow_R=0.01)
        full = face.mask(self.obj, "Surprise")
        self.settings.poses["Surprise"].strength = 0.5
        bpy.context.view_layer.update()
        np.testing.assert_allclose(face.mask(self.obj, "Surprise"), 0.5 * full, atol=1e-6)
        self.settings.poses["Surprise"].strength = 1.0
        for frame, gain in ((1, 1.0), (2, 4.0)):
            self.settings.gain = gain
            self.obj.keyframe_insert("rumple_maps.gain", frame=frame)
        bpy.context.scene.frame_set(2)
        np.testing.assert_allclose(face.mask(self.obj, "Surprise"), 4 * full / (1 + 3 * full), atol=1e-5)
        bpy.context.scene.frame_set(1)
        np.testing.assert_allclose(face.mask(self.obj, "Surprise"), full, atol=1e-6)

    def test_playback_writes_nothing_but_animated_settings(self) -> None:
        """What a handler writes costs Blender a second evaluation of the frame."""
        face.animate(self.rig)
        bpy.context.scene.frame_set(1)
        with unittest.mock.patch.object(maps_meshes, "write_weights", wraps=maps_meshes.write_weights) as written:
            for frame in range(1, 12):
                bpy.context.scene.frame_set(frame)
            self.assertEqual(written.call_count, 0)
            for frame, strength in ((1, 1.0), (11, 0.5)):
                self.settings.poses["Surprise"].strength = strength
                self.settings.poses["Surprise"].keyframe_insert("strength", frame=frame)
            bpy.context.scene.frame_set(1)
            before = written.call_count
            for frame in range(2, 12):
                bpy.context.scene.frame_set(frame)
            self.assertEqual(written.call_count - before, 10)
        brow = face.weights(self.obj, "brow.L")
        np.testing.assert_allclose(face.mask(self.obj, "Surprise"), 0.5 * brow, atol=ROUNDING)

    def test_mute_and_solo(self) -> None:
        face.pose(self.rig, brow_L=0.01, jaw=0.005)
        self.settings.poses["Surprise"].muted = True
        bpy.context.view_layer.update()
        self.assertFalse(face.mask(self.obj, "Surprise").any())
        self.assertTrue(face.mask(self.obj, "Anger").any())
        self.settings.poses["Surprise"].solo = True
        bpy.context.view_layer.update()
        self.assertTrue(face.mask(self.obj, "Surprise").any())
        self.assertFalse(face.mask(self.obj, "Anger").any())

    def test_the_bar_says_how_far_a_pose_is(self) -> None:
        face.pose(self.rig, brow_L=0.01, brow_R=0.005)
        self.assertAlmostEqual(self.settings.poses["Surprise"].present, 0.75, 4)
        self.assertEqual(self.settings.poses["Anger"].present, 0.0)

    def test_what_comes_after_keeps_the_masks(self) -> None:
        subdivision = self.obj.modifiers.new("Subdivision", "SUBSURF")
        subdivision.levels = 1
        face.pose(self.rig, brow_L=0.01, brow_R=0.01)
        mask = face.mask(self.obj, "Surprise")
        self.assertGreater(len(mask), 3 * len(self.obj.data.vertices))
        self.assertGreater(mask.max(), 0.4)


class Poses(unittest.TestCase):

    def setUp(self) -> None:
        self.obj, self.rig = face.scene()

    def test_the_first_pose_chooses_root_and_bones(self) -> None:
        settings = face.two_poses(self.obj, self.rig)
        self.assertEqual(settings.root, "head")
        self.assertEqual(sorted(bone.name for bone in settings.bones), ["brow.L", "brow.R", "jaw"])

    def test_selected_bones_are_chosen(self) -> None:
        sleeve.make_active(self.rig)
        bpy.ops.object.mode_set(mode="POSE")
        for bone in self.rig.pose.bones:
            (bone if bpy.app.version >= (5, 0, 0) else bone.bone).select = bone.name == "brow.L"
        face.pose(self.rig, brow_L=0.01)
        self.assertEqual(bpy.ops.rumple.pose_add(name="Left"), {"FINISHED"})    # the armature is active
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assertEqual([bone.name for bone in self.obj.rumple_maps.bones], ["brow.L"])

    def test_of_two_meshes_on_a_rig_the_selected_one_is_posed_else_the_one_with_poses(self) -> None:
        """It was the first by its name, also where that has no pose."""
        face.two_poses(self.obj, self.rig)
        other = self.obj.copy()
        other.data, other.name = self.obj.data.copy(), "Another"
        bpy.context.scene.collection.objects.link(other)
        other.rumple_maps.poses.clear()
        sleeve.make_active(self.rig)
        bpy.ops.object.mode_set(mode="POSE")
        self.assertEqual(operators.target(bpy.context), self.obj)
        other.select_set(True)
        self.assertEqual(operators.target(bpy.context), other)
        bpy.ops.object.mode_set(mode="OBJECT")

    def test_go_to_pose_update_move_remove(self) -> None:
        settings = face.two_poses(self.obj, self.rig)
        settings.active = 0
        bpy.ops.rumple.pose_go()
        self.assertEqual((settings.poses[0].present, settings.poses[1].present), (1.0, 0.0))
        bpy.ops.rumple.pose_go(neutral=True)
        self.assertEqual((settings.poses[0].present, settings.poses[1].present), (0.0, 0.0))
        face.pose(self.rig, brow_L=0.02)
        bpy.ops.rumple.pose_update()
        face.pose(self.rig, brow_L=0.01)
        self.assertAlmostEqual(settings.poses[0].present, 0.5, 4)
        bpy.ops.rumple.pose_move(direction="DOWN")
        self.assertEqual(([pose.name for pose in settings.poses], settings.active), (["Anger", "Surprise"], 1))
        self.assertAlmostEqual(settings.poses[1].present, 0.5, 4)
        bpy.ops.rumple.pose_remove()
        self.assertEqual(([pose.name for pose in settings.poses], settings.active), (["Anger"], 0))
        with sleeve.context():
            bpy.context.view_layer.update()
        evaluated = self.obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        self.assertNotIn("rumple_pose_Surprise", evaluated.data.attributes)

    def test_a_renamed_pose_renames_its_attribute_and_names_stay_unique(self) -> None:
        settings = face.two_poses(self.obj, self.rig)
        settings.poses[0].name = "Anger"
        self.assertEqual([pose.name for pose in settings.poses], ["Anger.001", "Anger"])
        face.pose(self.rig, brow_L=0.01)
        self.assertTrue(face.mask(self.obj, "Anger.001").any())
        bpy.ops.rumple.pose_add(name="Anger")
        self.assertEqual(settings.poses[2].name, "Anger.002")

    def test_a_captured_neutral_pose(self) -> None:
        settings = face.two_poses(self.obj, self.rig)
        face.pose(self.rig, brow_L=0.005, brow_R=0.005)
        bpy.ops.rumple.neutral_capture()
        face.pose(self.rig, brow_L=0.005, brow_R=0.005)
        self.assertEqual(settings.poses["Surprise"].present, 0.0)
        face.pose(self.rig, brow_L=0.0075, brow_R=0.0075)
        self.assertAlmostEqual(settings.poses["Surprise"].present, 0.5, 3)
        bpy.ops.rumple.pose_go(neutral=True)
        self.assertAlmostEqual(self.rig.pose.bones["brow.L"].location.length, 0.005, 6)
        bpy.ops.rumple.neutral_rest()
        bpy.context.view_layer.update()
        self.assertAlmostEqual(settings.poses["Surprise"].present, 0.5, 3)

    def refused(self, call: Callable[..., object], *words: str) -> None:
        """Operators raise in background mode what they report in the window."""
        with self.assertRaises(RuntimeError) as caught:
            call()
        for word in words:
            self.assertIn(word, str(caught.exception))

    def test_equal_poses_are_refused_by_name_and_nothing_is_lost(self) -> None:
        settings = face.two_poses(self.obj, self.rig)
        face.pose(self.rig, brow_L=0.01, brow_R=0.01)
        self.refused(lambda: bpy.ops.rumple.pose_add(name="Twin"), "pose Twin", "as in pose Surprise")
        face.pose(self.rig)
        self.refused(lambda: bpy.ops.rumple.pose_add(name="Still"), "pose Still", "neutral pose")
        self.assertEqual([pose.name for pose in settings.poses], ["Surprise", "Anger"])
        settings.active = 1
        before = [tuple(bone.matrix) for bone in settings.poses[1].bones]
        self.refused(bpy.ops.rumple.pose_update, "pose Anger", "neutral pose")
        self.assertEqual([tuple(bone.matrix) for bone in settings.poses[1].bones], before)
        face.pose(self.rig, brow_L=0.01, brow_R=0.01)
        self.refused(bpy.ops.rumple.neutral_capture, "pose Surprise", "neutral pose")
        self.assertEqual(len(settings.neutral), 0)
        self.assertEqual(settings.poses["Surprise"].present, 1.0)

    def test_every_change_can_be_undone_and_done_again(self) -> None:
        face.two_poses(self.obj, self.rig)

        def now() -> Any:
            settings = bpy.data.objects["Face"].rumple_maps
            return ([(pose.name, pose.muted, pose.solo, tuple(pose.bones["brow.L"].head)) for pose in settings.poses],
                    len(settings.neutral))

        def here(change: Callable[..., object]) -> None:
            sleeve.make_active(bpy.data.objects["Face"])
            bpy.context.object.rumple_maps.active = 0
            with sleeve.context():
                self.assertEqual(change(), {"FINISHED"})
                bpy.ops.ed.undo_push(message="in background operators push nothing")

        operators = bpy.ops.rumple
        changes = (lambda: operators.pose_rename(name="Awe"), lambda: operators.pose_mute(mute=True),
                   lambda: operators.pose_mute(mute=False), lambda: operators.pose_solo(solo=True),
                   lambda: operators.pose_solo(solo=False), lambda: operators.pose_move(direction="DOWN"),
                   operators.pose_update, operators.neutral_capture, operators.neutral_rest, operators.pose_remove)
        bpy.ops.ed.undo_push(message="start")
        seen = [now()]
        for number, change in enumerate(changes):
            face.pose(bpy.data.objects["Rig"], brow_L=0.002 + 0.0001 * number)
            here(change)
            seen.append(now())
            self.assertNotEqual(seen[-1], seen[-2], number)
        for state in reversed(seen[:-1]):
            bpy.ops.ed.undo()
            self.assertEqual(now(), state)
        for state in seen[1:]:
            bpy.ops.ed.redo()
            self.assertEqual(now(), state)

    def test_mute_and_solo_act_on_the_active_pose(self) -> None:
        settings = face.two_poses(self.obj, self.rig)
        settings.active = 1
        bpy.ops.rumple.pose_mute()
        self.assertEqual([pose.muted for pose in settings.poses], [False, True])
        bpy.ops.rumple.pose_solo()
        settings.active = 0
        bpy.ops.rumple.pose_solo()
        self.assertEqual([pose.solo for pose in settings.poses], [True, False])
        bpy.ops.rumple.pose_rename(name="Anger")
        self.assertEqual([pose.name for pose in settings.poses], ["Anger.001", "Anger"])

    def test_sixteen_poses_and_not_one_more(self) -> None:
        for number in range(16):
            face.pose(self.rig, brow_L=0.001 * (number + 1), brow_R=0.001 * (number % 3))
            bpy.ops.rumple.pose_add(name="P")
        face.pose(self.rig, jaw=0.01)
        self.refused(lambda: bpy.ops.rumple.pose_add(name="P"), "16 reference poses")
        face.pose(self.rig, brow_L=0.016, brow_R=0.0)
        self.assertAlmostEqual(face.mask(self.obj, "P.015").max(), face.weights(self.obj, "brow.L").max(), 5)
