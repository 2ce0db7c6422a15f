# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Maps choose root and bones by themselves: faces, bodies, one bone, bones without a common parent. And what
reference poses are when transforms of the armature are applied."""
from __future__ import annotations

import os
import tempfile
import unittest
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Euler, Vector
from rumple.blender import scheduler
from rumple.blender.maps import rig as maps_rig, runtimes as maps_runtimes
from support import face, sleeve, vanilla_blender

# name: (parent, head, tail)
BODY: dict[str, tuple[str, Any, Any]] = {
    "root": ("", (0, 0, 0), (0, 0.2, 0)), "hips": ("root", (0, 0, 1.0), (0, 0, 1.2)),
    "chest": ("hips", (0, 0, 1.2), (0, 0, 1.5)), "head": ("chest", (0, 0, 1.5), (0, 0, 1.75)),
    "eye": ("head", (0.05, -0.1, 1.65), (0.05, -0.15, 1.65))}
for _side, _x in (("L", 1), ("R", -1)):
    BODY |= {f"arm.{_side}": ("chest", (0.2 * _x, 0, 1.45), (0.5 * _x, 0, 1.45)),
             f"hand.{_side}": (f"arm.{_side}", (0.5 * _x, 0, 1.45), (0.8 * _x, 0, 1.45)),
             f"thigh.{_side}": ("hips", (0.1 * _x, 0, 1.0), (0.1 * _x, 0, 0.55)),
             f"shin.{_side}": (f"thigh.{_side}", (0.1 * _x, 0, 0.55), (0.1 * _x, 0, 0.1))}
ARM, LEG = ("arm.L", "hand.L"), ("thigh.R", "shin.R")


def skinned(bones: dict[str, tuple[str, Any, Any]], groups: Any) -> tuple[bpy.types.Object, bpy.types.Object]:
    """(mesh, rig): a quad around the middle of every bone that has a group, which it follows alone."""
    sleeve.empty_file()
    with sleeve.context():
        rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
        bpy.context.scene.collection.objects.link(rig)
        sleeve.make_active(rig)
        bpy.ops.object.mode_set(mode="EDIT")
        for name, (parent, head, tail) in bones.items():
            bone = rig.data.edit_bones.new(name)
            bone.head, bone.tail = head, tail
            bone.parent = rig.data.edit_bones[parent] if parent else None
        bpy.ops.object.mode_set(mode="OBJECT")
        middles = [0.5 * (np.array(bones[name][1]) + np.array(bones[name][2])) for name in groups]
        corners = 0.02 * np.array([(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)])
        mesh = bpy.data.meshes.new("Body")
        mesh.from_pydata(np.concatenate([middle + corners for middle in middles]).tolist(), [],
                         [tuple(range(4 * i, 4 * i + 4)) for i in range(len(middles))])
        obj = bpy.data.objects.new("Body", mesh)
        bpy.context.scene.collection.objects.link(obj)
        for number, name in enumerate(groups):
            obj.vertex_groups.new(name=name).add(range(4 * number, 4 * number + 4), 1.0, "REPLACE")
        obj.modifiers.new("Armature", "ARMATURE").object = rig
        sleeve.make_active(obj)
        bpy.ops.object.rumple_add(method="MAPS")
    return obj, rig


def turn(rig: bpy.types.Object, **angles: float) -> None:
    """Bend bones about their x: hand_L=0.5. The others go to rest."""
    for bone in rig.pose.bones:
        bone.rotation_mode = "XYZ"
        bone.rotation_euler = Euler((angles.get(bone.name.replace(".", "_"), 0.0), 0.0, 0.0))
    with sleeve.context():
        bpy.context.view_layer.update()


def add(name: str) -> None:
    with sleeve.context():
        assert bpy.ops.rumple.pose_add(name=name) == {"FINISHED"}


def masked(obj: bpy.types.Object, pose: str) -> dict[str, float]:
    """Bone -> the mask of its quad."""
    mask = face.mask(obj, pose).reshape(-1, 4).max(1)
    return dict(zip([group.name for group in obj.vertex_groups], mask))


class Body(unittest.TestCase):

    def setUp(self) -> None:
        self.skin = [name for name in BODY if name not in ("root", "eye")]

    def two_limbs(self, groups: Any) -> tuple[bpy.types.Object, bpy.types.Object]:
        obj, rig = skinned(BODY, groups)
        turn(rig, arm_L=0.4, hand_L=1.2)
        add("Elbow")
        turn(rig, thigh_R=0.5, shin_R=1.0)
        add("Knee")
        return obj, rig

    def check_apart(self, obj: bpy.types.Object, rig: bpy.types.Object) -> None:
        """Below 1 % on other limbs, whatever the two do; all of it on the own one at its pose."""
        for elbow, knee in ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (0.5, 0.3)):
            turn(rig, arm_L=0.4 * elbow, hand_L=1.2 * elbow, thigh_R=0.5 * knee, shin_R=knee)
            for pose, limb, share in (("Elbow", ARM, elbow), ("Knee", LEG, knee)):
                found = masked(obj, pose)
                for name, value in found.items():
                    if name not in limb:
                        self.assertLess(value, 0.01, (pose, name))
                if share == 1.0:
                    self.assertGreater(min(found[name] for name in limb), 0.999, pose)

    def test_poses_of_two_limbs_stay_apart(self) -> None:
        obj, rig = self.two_limbs(self.skin)
        self.assertEqual(obj.rumple_maps.root, "hips")
        self.check_apart(obj, rig)

    def test_a_head_with_an_eye_is_no_root_for_arms(self) -> None:
        """Taken for its name it left the eye alone to be compared, and Add Reference Pose failed."""
        obj, rig = self.two_limbs([*self.skin, "eye"])
        self.assertEqual(obj.rumple_maps.root, "hips")
        self.check_apart(obj, rig)

    def test_a_head_that_nothing_hangs_from_is_no_root(self) -> None:
        bones = {name: entry for name, entry in BODY.items() if name != "eye"}
        obj, rig = skinned(bones, self.skin)
        turn(rig, hand_R=1.0)
        add("Hand")
        self.assertEqual(obj.rumple_maps.root, "hips")
        self.assertGreater(masked(obj, "Hand")["hand.R"], 0.999)

    def test_the_walking_body_changes_nothing(self) -> None:
        obj, rig = self.two_limbs(self.skin)
        turn(rig, arm_L=0.2, hand_L=0.6)
        before = face.mask(obj, "Elbow")
        rig.pose.bones["root"].location = (1.0, 2.0, 0.5)
        rig.pose.bones["root"].rotation_euler = (0.3, 0.2, 1.0)
        rig.location = (3.0, 0.0, 1.0)
        bpy.context.view_layer.update()
        np.testing.assert_allclose(face.mask(obj, "Elbow"), before, atol=1e-4)
        self.assertGreater(before.max(), 0.3)


class Few(unittest.TestCase):

    def test_the_only_bone_that_deforms_hangs_from_its_parent(self) -> None:
        obj, rig = skinned({"skull": ("", (0, 0, 0), (0, 0, 1)), "jaw": ("skull", (0, -0.1, 0), (0, -0.2, 0))}, ["jaw"])
        turn(rig, jaw=0.5)
        add("Open")
        self.assertEqual((obj.rumple_maps.root, [bone.name for bone in obj.rumple_maps.bones]), ("skull", ["jaw"]))
        turn(rig, jaw=0.5, skull=0.7)
        self.assertGreater(face.mask(obj, "Open").min(), 0.999)

    def test_bones_without_a_parent_are_compared_in_the_armature(self) -> None:
        obj, rig = skinned({"left": ("", (1, 0, 0), (1, 0, 1)), "right": ("", (-1, 0, 0), (-1, 0, 1))},
                           ["left", "right"])
        turn(rig, left=0.5)
        add("Left")
        self.assertEqual((obj.rumple_maps.root, len(obj.rumple_maps.bones)), ("", 2))
        self.assertEqual(obj.rumple_maps.message, "")
        rig.matrix_world = Euler((0.3, 0.2, 0.1)).to_matrix().to_4x4()
        rig.scale, rig.location = (2.0, 2.0, 2.0), (1.0, 2.0, 3.0)
        turn(rig, left=0.5, right=1.0)
        self.assertEqual({name: round(value, 3) for name, value in masked(obj, "Left").items()},
                         {"left": 1.0, "right": 0.0})
        turn(rig)
        self.assertLess(face.mask(obj, "Left").max(), 1e-3)

    def test_the_only_bone_of_all_is_compared_in_the_armature(self) -> None:
        obj, rig = skinned({"head": ("", (0, 0, 0), (0, 0, 1))}, ["head"])
        turn(rig, head=0.5)
        add("Nod")
        self.assertEqual((obj.rumple_maps.root, obj.rumple_maps.message), ("", ""))
        self.assertGreater(face.mask(obj, "Nod").min(), 0.999)


def settle() -> None:
    """As the timer of a window."""
    for _ in range(2):
        bpy.context.view_layer.update()
        scheduler.sync_all()


class Applied(unittest.TestCase):
    """Blender moves no stored pose when a transform of the armature is applied (Ctrl A)."""

    def setUp(self) -> None:
        self.obj, self.rig = face.scene()
        self.longer = 1.0  # how many times as long bones are now

    def pose(self, **shares: float) -> None:
        """Bones turned in place, and moved by shares of a centimetre of the rig as it was."""
        for name, share in shares.items():
            bone = self.rig.pose.bones[name.replace("_", ".")]
            bone.rotation_mode, bone.rotation_euler = "XYZ", (0.6 * share, 0.2 * share, 0.0)
            bone.location = self.longer * share * 0.01 * np.array((0.3, 0.1, 1.0))
        with sleeve.context():
            bpy.context.view_layer.update()

    def poses(self, root: str) -> None:
        self.longer = 1.0
        for name, shares in (("Surprise", (1.0, 1.0, 0.0)), ("Anger", (-1.0, -0.7, 0.5))):
            self.pose(**dict(zip(("brow_L", "brow_R", "jaw"), shares)))
            bpy.ops.rumple.pose_add(name=name)
        self.obj.rumple_maps.root = root

    def apply(self, scale: float | tuple[float, ...], turn: tuple[float, ...] = (0, 0, 0),
              location: tuple[float, ...] = (0, 0, 0)) -> None:
        self.rig.scale = (scale,) * 3 if isinstance(scale, (int, float)) else scale
        self.rig.rotation_euler, self.rig.location = turn, location
        bpy.context.view_layer.update()
        sleeve.make_active(self.rig)
        bpy.ops.object.transform_apply(location=True, rotation=True, scale=True)
        sleeve.make_active(self.obj)
        self.longer *= scale if isinstance(scale, (int, float)) else 1.0
        settle()

    def seen(self) -> np.ndarray:
        """(3, o, n) masks on the way."""
        masks = []
        for shares in ((1.0, 1.0, 0.0), (0.3, 0.6, 0.2), (-0.5, 0.2, 0.7)):
            self.pose(**dict(zip(("brow_L", "brow_R", "jaw"), shares)))
            masks.append([face.mask(self.obj, pose.name) for pose in self.obj.rumple_maps.poses])
        return np.array(masks)

    def check(self, before: np.ndarray) -> None:
        np.testing.assert_allclose(self.seen(), before, atol=1e-3)
        for name in ("Surprise", "Anger"):
            self.obj.rumple_maps.active = self.obj.rumple_maps.poses.find(name)
            bpy.ops.rumple.pose_go()
            self.assertAlmostEqual(self.obj.rumple_maps.poses[name].present, 1.0, 4)
        self.assertEqual(face.notes(self.obj), "")

    def test_reference_poses_go_along(self) -> None:
        """A rig in centimetres, or turned as other programs have it. Every mask was wholly on, or off."""
        turn, far = (0.4, -1.2, 2.0), (3.0, -1.0, 2.0)
        for root in ("head", ""):
            for neutral in ("rest", "captured"):
                for change in ((100.0,), (0.01,), (1.0, turn), (1.0, (0, 0, 0), far), (100.0, turn, far)):
                    with self.subTest(str((root, neutral, change))):
                        self.setUp()
                        self.poses(root)
                        self.pose(brow_L=0.1, brow_R=-0.1, jaw=0.1)
                        if neutral == "captured":
                            bpy.ops.rumple.neutral_capture()
                        before = self.seen()
                        self.assertGreater(np.ptp(before[1]), 0.2)
                        self.apply(*change)
                        self.check(before)

    def test_again_and_undone(self) -> None:
        self.poses("head")
        before = self.seen()
        for scale in (100.0, 0.1, 0.1):
            with sleeve.context():
                bpy.ops.ed.undo_push(message="before")
            self.apply(scale)
            self.check(before)
        with sleeve.context():
            bpy.ops.ed.undo_push(message="after")
            bpy.ops.ed.undo()
        self.obj, self.rig, self.longer = bpy.data.objects["Face"], bpy.data.objects["Rig"], 10.0
        sleeve.make_active(self.obj)
        settle()
        self.check(before)

    def test_poses_that_are_stored_later_are_of_the_rig_of_then(self) -> None:
        self.poses("head")
        self.apply(100.0)
        self.pose(brow_L=1.0, brow_R=0.0, jaw=0.0)
        bpy.ops.rumple.pose_add(name="Left")
        before = self.seen()
        self.apply(0.01)
        self.check(before)

    def test_poses_of_older_files_go_along_from_now_on(self) -> None:
        self.poses("head")
        before = self.seen()
        for pose in self.obj.rumple_maps.poses:
            for bone in pose.bones:
                bone.property_unset("rest")
        self.obj.rumple_maps.root = "head"  # as a file that is opened: everything is compared anew
        settle()
        self.check(before)
        self.apply(100.0)
        self.check(before)

    def test_an_edited_rig_keeps_its_poses(self) -> None:
        """They hold where bones are, and the artist has moved one on purpose."""
        self.poses("head")
        rig, _ = maps_rig.rig_of(self.obj)
        sleeve.make_active(self.rig)
        bpy.ops.object.mode_set(mode="EDIT")
        for end in ("head", "tail"):
            setattr(self.rig.data.edit_bones["jaw"], end, getattr(self.rig.data.edit_bones["jaw"], end) * 2.0)
        bpy.ops.object.mode_set(mode="OBJECT")
        sleeve.make_active(self.obj)
        settle()
        now, notes = maps_rig.rig_of(self.obj)
        self.assertGreater(np.abs(now.neutral - rig.neutral).max(), 0.01)
        for pose, former in zip(now.poses, rig.poses):
            np.testing.assert_array_equal(pose.bones, former.bones)
        self.assertEqual(notes, [])

    def test_a_rig_that_is_stretched_is_named(self) -> None:
        """Bones that turn in it have other ways then."""
        self.poses("head")
        self.apply((1.0, 1.0, 2.0))
        self.assertIn("Rig was stretched or mirrored since pose Surprise was stored: update it", face.notes(self.obj))


class Far(unittest.TestCase):
    """Blender has a place in the world in single precision: 10 km away, a millimetre is its last digit."""

    def setUp(self) -> None:
        self.obj, self.rig = face.scene()
        self.obj.shape_key_add(name="Basis")
        for point in self.obj.shape_key_add(name="Frown", from_mix=False).data[:20]:
            point.co.y -= 0.01

    def pose(self, share: float) -> None:
        for name, axis in (("brow.L", 0), ("brow.R", 1), ("jaw", 2)):
            bone = self.rig.pose.bones[name]
            bone.rotation_mode, bone.rotation_euler[axis], bone.location = "XYZ", share, (0.0, 0.0, 0.01 * share)
        self.rig.pose.bones["head"].rotation_mode = "XYZ"
        self.rig.pose.bones["head"].rotation_euler = (0.3 * share, 0.2, -0.4 * share)
        self.obj.data.shape_keys.key_blocks["Frown"].value = share
        bpy.context.view_layer.update()

    def poses(self, keys: bool) -> None:
        for name, share in (("Surprise", 1.0), ("Anger", -0.6)):
            self.pose(share)
            bpy.ops.rumple.pose_add(name=name)
        settings = self.obj.rumple_maps
        settings.root = "head"
        bpy.ops.rumple.maps_bones()
        for _ in range(0 if keys else len(settings.keys)):
            bpy.ops.rumple.maps_key_remove()
        self.assertEqual((len(settings.bones), len(settings.keys)), (3, int(keys)))

    def masks(self) -> np.ndarray:
        """(o, n) in the midst of the way, as nodes have them; the library has the same."""
        self.pose(0.4)
        shown = np.array([face.mask(self.obj, pose.name) for pose in self.obj.rumple_maps.poses])
        comparison = maps_runtimes.of(self.obj).comparison
        bones, keys = maps_rig.present(self.obj, comparison.rig)
        np.testing.assert_allclose(shown, comparison.frame(bones, keys=keys).pose, atol=3e-4)
        return shown

    def check(self) -> None:
        near = self.masks()
        self.assertGreater(np.ptp(near, axis=1).max(), 0.2)
        for place in ((1e3, -5e2, 3e2), (1e4, -5e3, 3e3), (-2e4, 1e5, 7e4)):
            for turn in ((0.0, 0.0, 0.0), (0.5, 0.7, -0.4)):
                for scale in (1.0, 0.01, 3.0):
                    self.rig.location, self.rig.rotation_euler, self.rig.scale = place, turn, (scale,) * 3
                    np.testing.assert_allclose(self.masks(), near, atol=1e-4, err_msg=str((place, turn, scale)))
        self.rig.location, self.rig.rotation_euler, self.rig.scale = (0,) * 3, (0,) * 3, (1,) * 3

    def test_masks_are_those_of_the_origin(self) -> None:
        for keys in (False, True):
            for root in ("head", ""):
                with self.subTest(str((keys, root))):
                    self.setUp()
                    self.poses(keys)
                    self.obj.rumple_maps.root = root
                    settle()
                    self.check()

    def test_of_bones_that_move_no_points_as_well(self) -> None:
        """An Armature modifier leaves them out, or bends what is in them."""
        self.poses(keys=True)
        near, head = self.masks(), self.rig.data.bones["head"]
        head.envelope_distance, self.rig.pose.bones["head"].bbone_curveinx = 0.01, 0.1
        for name, value in (("use_deform", False), ("bbone_segments", 4), ("use_envelope_multiply", True)):
            with self.subTest(name):
                former = getattr(head, name)
                setattr(head, name, value)
                settle()
                self.check()
                setattr(head, name, former)
                settle()
                np.testing.assert_allclose(self.masks(), near, atol=1e-6)

    def test_where_bones_rest_is_read_again(self) -> None:
        """Where nothing else has changed: the poses and the neutral one hold where bones are."""
        self.poses(keys=False)
        self.pose(0.1)
        bpy.ops.rumple.neutral_capture()
        self.masks()
        sleeve.make_active(self.rig)
        bpy.ops.object.mode_set(mode="EDIT")
        self.rig.data.edit_bones["jaw"].translate(Vector((0.01, 0.0, 0.0)))
        bpy.ops.object.mode_set(mode="OBJECT")
        sleeve.make_active(self.obj)
        settle()
        self.check()

    def test_on_a_machine_without_rumple_too(self) -> None:
        self.rig.data.bones["head"].use_deform = False
        self.poses(keys=True)
        near = self.masks()
        self.rig.location, self.rig.rotation_euler = (1e4, -5e3, 3e3), (0.5, 0.7, -0.4)
        with tempfile.TemporaryDirectory() as folder:
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, vanilla_blender.FILE))
            seen = vanilla_blender.look(Path(folder), "Face", (1,), attributes=("rumple_pose_Surprise",))
        np.testing.assert_allclose(seen[1]["rumple_pose_Surprise"][:, 0], near[0], atol=1e-4)
