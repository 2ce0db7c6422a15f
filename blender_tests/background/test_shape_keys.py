# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake to Shape Keys: what is seen in any moment, and what other programs get of it."""
from __future__ import annotations

import os
import tempfile
import unittest

import bpy
import numpy as np
from mathutils.kdtree import KDTree
from rumple.blender import compat
from support import sleeve

FIRST, LAST = 4, 9


def in_world(obj: bpy.types.Object) -> np.ndarray:
    """Places of its vertices, (n, 3)."""
    matrix = np.array(sleeve.evaluated(obj).matrix_world)
    return sleeve.shown(obj) @ matrix[:3, :3].T + matrix[:3, 3]


def distance(places: np.ndarray, others: np.ndarray) -> float:
    """The farthest that one of them is from all others. Exporters split vertices and sort them."""
    tree = KDTree(len(others))
    for number, place in enumerate(others.tolist()):
        tree.insert(place, number)
    tree.balance()
    return max(tree.find(place)[2] for place in places.tolist())


class Baked(unittest.TestCase):
    """A sleeve, and its shape keys."""

    def setUp(self) -> None:
        self.obj = sleeve.scene()

    def baked(self, first: int = FIRST, last: int = LAST) -> bpy.types.Object:
        bpy.ops.object.rumple_bake_shape_keys(start=first, end=last)
        return bpy.data.objects["Sleeve shape keys"]


class Keys(Baked):

    def assert_shows(self, obj: bpy.types.Object, frame: int, subframe: float, wanted: np.ndarray) -> None:
        sleeve.at(frame, subframe)
        np.testing.assert_allclose(sleeve.shown(obj), wanted, atol=1e-6, err_msg=f"frame {frame + subframe}")

    def test_moments_between_two_frames_are_blends_of_them_and_the_ends_are_held(self) -> None:
        self.obj.rumple.bake_samples = 3  # of the clip: there is one key a frame
        sleeve.at(1)
        live = {}
        for frame in range(1, LAST + 1):
            sleeve.at(frame)
            live[frame] = sleeve.shown(self.obj)
        copy = self.baked()
        self.assertEqual([key.name for key in copy.data.shape_keys.key_blocks],
                         ["Rest", *(f"Frame {frame}" for frame in range(FIRST, LAST + 1))])
        for frame in range(FIRST, LAST):
            self.assertGreater(np.abs(live[frame + 1] - live[frame]).max(), 1e-3)
            for share in (0.0, 0.25, 0.5):
                self.assert_shows(copy, frame, share, (1.0 - share) * live[frame] + share * live[frame + 1])
        self.assert_shows(copy, LAST, 0.0, live[LAST])
        for frame, held in ((1, FIRST), (FIRST - 1, FIRST), (LAST + 1, LAST), (sleeve.LAST, LAST)):
            self.assert_shows(copy, frame, 0.5, live[held])

    def test_one_frame_is_held(self) -> None:
        sleeve.play(1, 7)
        wanted = sleeve.shown(self.obj)
        copy = self.baked(7, 7)
        for frame in (1, 7, sleeve.LAST):
            self.assert_shows(copy, frame, 0.25, wanted)

    def test_a_parent_that_deforms_does_not_deform_it_again(self) -> None:
        with sleeve.context():
            bpy.ops.object.rumple_remove()
        self.obj.modifiers.remove(self.obj.modifiers["Armature"])
        self.obj.parent, self.obj.parent_type = bpy.data.objects["Arm"], "ARMATURE"
        self.obj.location.z = 0.2
        with sleeve.context():
            bpy.ops.object.rumple_add(method="MESH")
        sleeve.play(1, LAST)
        wanted = in_world(self.obj)
        np.testing.assert_allclose(in_world(self.baked()), wanted, atol=1e-6)

    def test_it_is_right_before_the_frame_changes(self) -> None:
        sleeve.play(1, 6)
        wanted = sleeve.shown(self.obj)
        np.testing.assert_allclose(sleeve.shown(self.baked()), wanted, atol=1e-6)

    def test_its_curves_are_whole(self) -> None:
        """Their handles lie beside their keys: whoever makes them Bezier sees no loops."""
        copy = self.baked()
        animation = copy.data.shape_keys.animation_data
        self.assertEqual(animation.action.name, copy.name)
        curves = list(compat.keyed_curves(animation))
        self.assertEqual(len(curves), LAST - FIRST + 1)
        for curve in curves:
            for point in curve.keyframe_points:
                self.assertEqual(point.interpolation, "LINEAR")
                self.assertLessEqual(abs(point.handle_left.x - point.co.x), 1.0)
                self.assertLessEqual(abs(point.handle_right.x - point.co.x), 1.0)


class Exported(Baked):
    """By Blender's own exporters, read back by its own importers into an empty file."""

    MOMENTS = ((FIRST, 0.0), (FIRST, 0.5), (7, 0.0), (LAST - 1, 0.5), (LAST, 0.0))

    def setUp(self) -> None:
        super().setUp()
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.addCleanup(sleeve.empty_file)
        copy = self.baked()
        self.seen = []
        for moment in self.MOMENTS:
            sleeve.at(*moment)
            self.seen.append(in_world(copy))
        self.small = 1e-4 * float(np.linalg.norm(np.ptp(self.seen[0], axis=0)))
        for before, after in zip(self.seen, self.seen[1:]):
            self.assertGreater(distance(before, after), 10.0 * self.small)

    def path(self, name: str) -> str:
        return os.path.join(self.folder.name, name)

    def check_read(self) -> None:
        """What is in the file now moves as the copy did."""
        copy, = (obj for obj in bpy.context.scene.objects if obj.type == "MESH")
        keys = copy.data.shape_keys
        self.assertEqual(len(keys.key_blocks), 1 + LAST - FIRST + 1)
        animation = keys.animation_data
        if animation.action is None:  # 3.4 writes a clip of the object's place too, and plays the first clip alone
            animation.action = animation.nla_tracks[0].strips[0].action
        for moment, wanted in zip(self.MOMENTS, self.seen):
            sleeve.at(*moment)
            found = in_world(copy)
            self.assertLess(distance(wanted, found), self.small, moment)
            self.assertLess(distance(found, wanted), self.small, moment)

    def test_gltf(self) -> None:
        path = self.path("sleeve.glb")
        bpy.ops.export_scene.gltf(filepath=path, export_format="GLB", use_selection=True)
        sleeve.empty_file()
        bpy.ops.import_scene.gltf(filepath=path, import_shading="SMOOTH")  # 3.4 reads normals with an older NumPy alone
        self.check_read()

    def test_fbx(self) -> None:
        """As the guide says: without NLA Strips and All Actions, which are of objects alone."""
        path = self.path("sleeve.fbx")
        bpy.ops.export_scene.fbx(filepath=path, use_selection=True, bake_anim_use_nla_strips=False,
                                 bake_anim_use_all_actions=False)
        sleeve.empty_file()
        bpy.ops.import_scene.fbx(filepath=path, anim_offset=0.0)
        self.check_read()
