# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps are baked in the stored pose, whatever moves the bones and keys of the rig."""
from __future__ import annotations

import unittest
from contextlib import ExitStack
from typing import Any
from unittest import mock

import bpy
import numpy as np
from mathutils import Euler
from rumple.blender.maps import pose_operators, posed_rig, stored_poses
from support import face, keyed_face, sleeve
from test_maps_bake import everything, texels

SIZE = 64


def baked(obj: bpy.types.Object) -> np.ndarray:
    obj.rumple_maps.bake_size = SIZE
    assert bpy.ops.rumple.maps_bake() == {"FINISHED"}
    return texels(obj.rumple_maps.poses[obj.rumple_maps.active].image)


def hold(rig: bpy.types.Object, name: str = "brow.L") -> bpy.types.Constraint:
    """Keep a bone at rest, whatever its channels are."""
    limit = rig.pose.bones[name].constraints.new("LIMIT_LOCATION")
    limit.owner_space = "LOCAL"
    for limited in ("use_min_x", "use_max_x", "use_min_y", "use_max_y", "use_min_z", "use_max_z"):
        setattr(limit, limited, True)
    return limit


class Held(unittest.TestCase):
    """A flat map took the place of a good one, and nothing was said: the bones did not come to the pose."""

    def setUp(self) -> None:
        self.obj, self.rig = face.scene()
        face.pose(self.rig, brow_L=-0.012)
        bpy.ops.rumple.pose_add(name="Left")
        self.expected = baked(self.obj)
        self.assertGreater(np.abs(self.expected[:, :, :2] - 0.5).max(), 0.1, "not a case of it")
        face.pose(self.rig)

    def check(self) -> None:
        bpy.context.view_layer.update()
        before = everything()
        np.testing.assert_allclose(baked(self.obj), self.expected, atol=0.01)
        self.assertEqual(everything(), before)
        self.assertEqual(self.obj.modifiers["Armature"].object, self.rig)

    def test_by_a_constraint(self) -> None:
        limit = hold(self.rig)
        self.check()
        self.assertFalse(limit.mute)

    def test_by_a_driver(self) -> None:
        self.rig.pose.bones["brow.L"].driver_add("location", 2).driver.expression = "0.001"
        self.check()
        self.assertEqual(len(self.rig.animation_data.drivers), 1)

    def test_by_rest_position(self) -> None:
        self.rig.data.pose_position = "REST"
        self.check()
        self.assertEqual(self.rig.data.pose_position, "REST")

    def test_by_its_animation(self) -> None:
        face.animate(self.rig)
        bpy.context.scene.frame_set(8)
        self.check()

    def test_by_the_eye_of_the_modifier(self) -> None:
        self.obj.modifiers["Armature"].show_viewport = False
        self.check()
        self.assertFalse(self.obj.modifiers["Armature"].show_viewport)

    def test_by_a_driver_of_this_eye(self) -> None:
        self.obj.modifiers["Armature"].driver_add("show_viewport").driver.expression = "0"
        self.check()

    def test_of_an_armature_that_is_the_parent(self) -> None:
        self.obj.parent, self.obj.parent_type = self.rig, "ARMATURE"
        self.obj.modifiers.remove(self.obj.modifiers["Armature"])
        hold(self.rig)
        np.testing.assert_allclose(baked(self.obj), self.expected, atol=0.01)
        self.assertEqual(self.obj.parent, self.rig)

    def test_by_a_pinned_shape_key(self) -> None:
        obj = keyed_face.scene()
        keyed_face.set_keys(obj, brow_L=-1)
        keyed_face.add_pose("Left")
        keyed_face.set_keys(obj)
        expected = baked(obj)
        self.assertGreater(np.abs(expected[:, :, :2] - 0.5).max(), 0.1, "not a case of it")
        obj.show_only_shape_key, obj.active_shape_key_index = True, 0
        np.testing.assert_allclose(baked(obj), expected, atol=0.01)
        self.assertTrue(obj.show_only_shape_key)

    def test_where_no_channels_make_the_pose_it_is_refused(self) -> None:
        """A bone that its constraint shears: the former map stays."""
        control = bpy.data.objects.new("Control", None)
        bpy.context.scene.collection.objects.link(control)
        bone = self.rig.pose.bones["brow.L"]
        bone.rotation_mode, bone.rotation_euler = "XYZ", (0.0, 0.7, 0.7)
        bone.constraints.new("CHILD_OF").target = control
        bpy.context.view_layer.update()
        control.scale = (1.0, 1.0, 2.0)
        bpy.context.view_layer.update()
        bpy.ops.rumple.pose_add(name="Sheared")
        here = baked(self.obj)
        image = self.obj.rumple_maps.poses["Sheared"].image
        control.scale = (1.0, 1.0, 1.0)
        bpy.context.view_layer.update()
        before = everything()
        with self.assertRaisesRegex(RuntimeError, "Face: bone brow.L of Rig does not come to where pose Sheared"):
            baked(self.obj)
        self.assertEqual((self.obj.rumple_maps.poses["Sheared"].image, everything()), (image, before))
        np.testing.assert_array_equal(texels(image), here)


class Others(unittest.TestCase):
    """What else the armature moves: a garment lies on its body in the stored pose, not through it."""

    def test_a_body_comes_to_the_pose_too(self) -> None:
        obj = sleeve.to_be_cloth()
        rig = obj.find_armature()
        sleeve.another("Inner", 0.9)
        body = bpy.data.objects["Human"]
        ring = bpy.data.objects.new("Ring", None)
        bpy.context.scene.collection.objects.link(ring)
        ring.parent, ring.parent_type, ring.parent_bone = rig, "BONE", rig.data.bones[0].name
        sleeve.make_active(obj)
        bpy.ops.rumple.maps_add()
        obj.rumple_maps.bake_source = "MESH"
        bpy.context.scene.frame_set(sleeve.LAST)
        bpy.ops.rumple.pose_add(name="Bent")
        expected = baked(obj)
        rig.data.pose_position = "REST"
        bpy.context.view_layer.update()
        before = everything()
        np.testing.assert_allclose(baked(obj), expected, atol=0.01)
        self.assertEqual(everything(), before)
        self.assertEqual(([m.object for m in body.modifiers if m.type == "ARMATURE"], body.parent), ([rig], None))
        self.assertEqual((ring.parent, ring.parent_type, ring.parent_bone), (rig, "BONE", rig.data.bones[0].name))
        self.assertEqual(bpy.data.objects["Inner"].rumple.message, "")


class Bones(unittest.TestCase):
    """Where bones belong in a pose, and that a copy of the armature comes there."""

    def setUp(self) -> None:
        self.obj, self.rig = face.scene()
        rng = np.random.default_rng(5)
        modes = ("FULL", "FIX_SHEAR", "ALIGNED", "AVERAGE", "NONE")
        for mode, bone in zip(modes, self.rig.pose.bones):
            bone.bone.inherit_scale = mode
            bone.matrix_basis = Euler(rng.normal(0.0, 0.4, 3)).to_matrix().to_4x4()
            bone.location = rng.normal(0.0, 0.01, 3)
            bone.scale = rng.uniform(0.7, 1.4, 3)
        bpy.context.view_layer.update()
        bpy.ops.rumple.pose_add(name="Any")
        self.records = self.obj.rumple_maps.poses["Any"].bones
        self.stored = {bone.name: np.array(bone.matrix) for bone in self.rig.pose.bones}

    def astray(self, armature: bpy.types.Object) -> str:
        return stored_poses.first_astray(stored_poses.matrices(self.records, armature), armature,
                                         bpy.context.evaluated_depsgraph_get())

    def test_a_copy_of_an_armature_that_is_held_comes_to_the_pose(self) -> None:
        face.pose(self.rig)
        for name in ("neck", "brow.L", "jaw"):
            hold(self.rig, name)
        with ExitStack() as ended:
            posed = posed_rig.PosedRig(bpy.context, self.obj, self.records, ended)
            self.assertNotEqual(posed.posing, self.rig)
            self.assertEqual(posed.astray(), "")
            for bone in posed.posing.pose.bones:
                np.testing.assert_allclose(bone.matrix, self.stored[bone.name], atol=1e-5, err_msg=bone.name)
        self.assertEqual((len(bpy.data.objects), len(bpy.data.armatures)), (2 + self.hidden(), 1))

    def hidden(self) -> int:
        """How many hidden objects the modifier reads."""
        return sum(obj not in set(bpy.context.scene.objects) for obj in bpy.data.objects)

    def test_no_copy_is_made_where_the_armature_itself_comes_there(self) -> None:
        face.pose(self.rig)
        with ExitStack() as ended:
            self.assertEqual(posed_rig.PosedRig(bpy.context, self.obj, self.records, ended).posing, self.rig)

    def test_after_its_scale_was_applied_the_bones_belong_elsewhere(self) -> None:
        self.assertEqual(self.astray(self.rig), "")
        self.rig.scale, self.rig.rotation_euler = (2.0, 2.0, 2.0), (0.3, 0.0, 0.5)
        bpy.context.view_layer.update()
        with bpy.context.temp_override(object=self.rig, active_object=self.rig, selected_editable_objects=[self.rig]):
            bpy.ops.object.transform_apply(location=False, rotation=True, scale=True)
        bpy.context.view_layer.update()
        self.assertIsNotNone(stored_poses.applied_since(self.records, self.rig))
        stored_poses.pose_bones(self.records, self.rig)
        bpy.context.view_layer.update()
        self.assertEqual(self.astray(self.rig), "")
        self.rig.pose.bones["jaw"].location.x += 0.01
        bpy.context.view_layer.update()
        self.assertEqual(self.astray(self.rig), "jaw")

    def test_a_bone_that_was_edited_belongs_nowhere(self) -> None:
        bpy.context.view_layer.objects.active = self.rig
        bpy.ops.object.mode_set(mode="EDIT")
        self.rig.data.edit_bones["jaw"].tail.z -= 0.01
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assertEqual(set(self.stored) - set(stored_poses.matrices(self.records, self.rig)), {"jaw"})


class GoToPose(unittest.TestCase):

    def said(self, obj: bpy.types.Object) -> list[Any]:
        operator = mock.Mock()
        pose_operators.RUMPLE_OT_pose_go._go(operator, bpy.context, obj,
                                             stored_poses.of_pose(obj.rumple_maps.poses[0]))
        return [call.args for call in operator.report.call_args_list]

    def test_it_says_which_bone_does_not_come(self) -> None:
        """It was finished without a word, and the bar showed 0."""
        obj, rig = face.scene()
        face.pose(rig, brow_L=-0.012)
        bpy.ops.rumple.pose_add(name="Left")
        face.pose(rig)
        self.assertEqual(self.said(obj), [])
        hold(rig)
        face.pose(rig)
        (kind, text), = self.said(obj)
        self.assertEqual(kind, {"WARNING"})
        self.assertEqual(text, "Rig: bone brow.L does not come to where it was stored: a constraint, a driver or Rest "
                               "Position holds it")
