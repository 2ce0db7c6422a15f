# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Maps on an object that also shows a Wrinkle Mesh, Field or Paths: both are there, in every frame."""
from __future__ import annotations

import os
import tempfile
import unittest
from pathlib import Path
from unittest import mock
from typing import Any

import bpy
import numpy as np
from rumple.blender import compat, handlers, scheduler
from rumple.blender.maps import (changes as maps_changes, hidden_meshes as maps_meshes, modifier as maps_modifier,
                                 runtimes as maps_runtimes)
from rumple.blender.objects import modifier
from test_maps_render import Renders
from support import face, sleeve, vanilla_blender

ROUNDING = 1e-4  # of a mask
METHODS = ("MESH", "FIELD", "PATHS")


def add_wrinkles(obj: bpy.types.Object, method: str) -> None:
    obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 1, 0
    obj.rumple.field.output = "GEOMETRY"
    sleeve.make_active(obj)
    with sleeve.context():
        assert bpy.ops.object.rumple_add(method=method) == {"FINISHED"}


class Beside(unittest.TestCase):

    def setUp(self) -> None:
        self.obj, self.rig = face.scene()
        face.two_poses(self.obj, self.rig)
        face.animate(self.rig)

    def check(self, frame: int) -> None:
        bpy.context.scene.frame_set(frame)
        self.assertEqual((self.obj.rumple.message, self.obj.rumple_maps.message), ("", ""))
        expected = face.carried(self.obj, face.risen(frame) * face.weights(self.obj, "brow.L"))
        np.testing.assert_allclose(face.mask(self.obj, "Surprise"), expected, atol=ROUNDING)
        self.assertGreater(expected.max(), 0.0)

    def fine(self) -> bool:
        return len(sleeve.shown(self.obj)) > 2 * len(self.obj.data.vertices)

    def test_every_kind_of_wrinkles(self) -> None:
        for method in METHODS:
            with self.subTest(method):
                add_wrinkles(self.obj, method)
                for frame in (11, 3, 7):
                    self.check(frame)
                self.assertTrue(self.fine())
                self.assertIn("rumple_offset", sleeve.evaluated(self.obj).data.attributes)
                bpy.ops.object.rumple_remove()
                self.check(5)
                self.assertFalse(self.fine())

    def test_wrinkles_first(self) -> None:
        self.obj, self.rig = face.scene(maps=False)
        add_wrinkles(self.obj, "MESH")
        bpy.ops.rumple.maps_add()
        face.two_poses(self.obj, self.rig)
        face.animate(self.rig)
        self.check(6)
        self.assertTrue(self.fine())

    def test_switched_off_and_on(self) -> None:
        add_wrinkles(self.obj, "MESH")
        wrinkles = modifier.find(self.obj)
        self.check(6)
        wrinkles.show_viewport = False
        self.check(8)
        self.assertFalse(self.fine())
        wrinkles.show_viewport = True
        self.check(4)
        self.assertTrue(self.fine())

    def test_a_denser_mesh(self) -> None:
        add_wrinkles(self.obj, "MESH")
        self.check(6)
        before = len(sleeve.shown(self.obj))
        self.obj.rumple.mesh.level = 2
        scheduler.sync_all()
        self.check(7)
        self.assertGreater(len(sleeve.shown(self.obj)), 2 * before)

    def test_as_many_points_as_the_coarse_mesh_has_but_others(self) -> None:
        """An own fine mesh may have the coarse one's number of points: numbers alone do not tell which one is shown."""
        mesh = self.obj.data.copy()
        points = compat.positions(mesh)[::-1] + np.float32(0.0007)
        compat.set_positions(mesh, points)
        own = bpy.data.objects.new("Own", mesh)
        bpy.context.scene.collection.objects.link(own)
        self.obj.rumple.mesh.source, self.obj.rumple.own_mesh = "OBJECT", own
        add_wrinkles(self.obj, "MESH")
        scheduler.sync_all()
        self.check(6)
        self.assertEqual(len(sleeve.shown(self.obj)), len(self.obj.data.vertices))
        modifier.find(self.obj).show_viewport = False
        self.check(9)

    def test_baked_clips_and_no_handlers(self) -> None:
        add_wrinkles(self.obj, "MESH")
        bpy.context.scene.frame_end = 11
        with tempfile.TemporaryDirectory() as folder:
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "face.blend"))
            self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
            handlers.unregister()
            try:
                for frame in (11, 2, 6):
                    self.check(frame)
            finally:
                handlers.register()
        self.assertTrue(self.fine())

    def test_a_machine_without_rumple_sees_the_same_masks(self) -> None:
        add_wrinkles(self.obj, "MESH")
        for wrinkles in (True, False):
            modifier.find(self.obj).show_viewport = wrinkles
            with tempfile.TemporaryDirectory() as folder:
                bpy.context.scene.frame_set(1)
                bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, vanilla_blender.FILE))
                seen = vanilla_blender.look(Path(folder), "Face", (11, 4), attributes=("rumple_pose_Surprise",))
            for frame in (4, 11):
                self.check(frame)
                np.testing.assert_allclose(seen[frame]["rumple_pose_Surprise"][:, 0],
                                           face.mask(self.obj, "Surprise"), atol=1e-6)

    def test_in_the_wrong_order_it_is_said_and_mended_by_moving(self) -> None:
        add_wrinkles(self.obj, "MESH")
        stack = list(self.obj.modifiers)
        compat.move_modifier(self.obj, stack.index(maps_modifier.find(self.obj)), stack.index(modifier.find(self.obj)))
        maps_changes.rig_changed(self.obj)
        bpy.context.scene.frame_set(6)
        bpy.context.scene.frame_set(7)
        self.assertIn("Wrinkle Mesh is below Wrinkle Maps in the stack, so the masks are lost", face.notes(self.obj))
        compat.move_modifier(self.obj, stack.index(maps_modifier.find(self.obj)), stack.index(modifier.find(self.obj)))
        bpy.context.scene.frame_set(5)
        self.check(6)
        self.assertEqual(face.notes(self.obj), "")

    def test_what_is_refused_beside_wrinkles_is_refused_once(self) -> None:
        """A refused modifier that forgot the wrinkles in front of it was prepared anew at every frame.

        And a mesh that the Wrinkle Mesh had removed was looked for in the list of updates after that: in 3.4 a write
        into freed memory, and a crash at the next file or never.
        """
        add_wrinkles(self.obj, "MESH")
        self.check(6)
        self.obj.rumple_maps.root = "nobody"
        for frame in (7, 8, 9):
            bpy.context.scene.frame_set(frame)
        self.assertIn("no bone \"nobody\" to be the root", self.obj.rumple_maps.message)
        self.assertFalse(face.mask(self.obj, "Surprise").any())
        self.assertEqual(maps_modifier.wrinkles(maps_modifier.find(self.obj)), sleeve.output_object(self.obj))
        bpy.context.scene.frame_set(10)
        self.assertFalse(maps_runtimes.of(self.obj).stale)
        self.obj.rumple_maps.root = "head"
        bpy.context.scene.frame_set(2)
        self.check(6)

    def test_a_new_skin_at_the_address_of_the_former_one_gets_its_weights(self) -> None:
        """In 3.4 keys are addresses: the weights of a new skin were taken to be written, and every mask was 0."""
        self.check(6)
        runtime, make = maps_runtimes.of(self.obj), maps_meshes.new_skin

        def at_the_same_address(*arguments: Any) -> Any:
            skin = make(*arguments)
            runtime.output_key = compat.session_key(skin.data)
            return skin

        self.obj.rumple_maps.root = "nobody"
        bpy.context.scene.frame_set(7)
        self.obj.rumple_maps.root = "head"
        with mock.patch.object(maps_meshes, "new_skin", at_the_same_address):
            bpy.context.scene.frame_set(2)
        self.check(6)

    def settle(self) -> None:
        """As the timer of a window."""
        bpy.context.view_layer.update()
        if scheduler.work_is_due():
            scheduler.sync_all()

    def test_nothing_stays_of_what_is_removed_in_any_way_and_order(self) -> None:
        """Removed by Blender's X the Wrinkle Mesh left its output object behind, for Wrinkle Maps still read it."""
        def ours() -> list[str]:
            return [item.name for items in (bpy.data.objects, bpy.data.meshes, bpy.data.node_groups) for item in items
                    if item.name != "Face" and item not in (self.rig, self.rig.data)]

        def crossed(find: Any) -> Any:
            return lambda: self.obj.modifiers.remove(find(self.obj))

        maps = (bpy.ops.rumple.maps_remove, crossed(maps_modifier.find))
        others = (bpy.ops.object.rumple_remove, crossed(modifier.find))
        ways = [(first, then) for one in maps for other in others for first, then in ((one, other), (other, one))]
        for number, (first, then) in enumerate(ways):
            for frame_between in (True, False):
                with self.subTest(f"{number} {frame_between}"):
                    self.setUp()
                    add_wrinkles(self.obj, "MESH")
                    self.check(6)
                    self.assertIn("Face.wrinkles", ours())
                    first()
                    if first in others and frame_between:
                        scheduler.sync_all()
                        self.assertNotIn("Face.wrinkles", ours())
                    then()
                    self.settle()
                    self.assertEqual(ours(), [])
                    self.assertEqual(self.obj.rumple.method, "NONE")

    def test_our_buttons_leave_nothing_at_once(self) -> None:
        """Scripts have no window whose timer works."""
        add_wrinkles(self.obj, "MESH")
        self.check(6)
        with scheduler.suspended():
            bpy.ops.object.rumple_remove()
            bpy.ops.rumple.maps_remove()
        self.assertEqual([obj.name for obj in bpy.data.objects], ["Face", "Rig"])

    def test_subdivision_in_front_shows_no_mask_and_is_named(self) -> None:
        subdivision = self.obj.modifiers.new("Smooth", "SUBSURF")
        compat.move_modifier(self.obj, len(self.obj.modifiers) - 1, 1)
        maps_changes.rig_changed(self.obj)
        bpy.context.scene.frame_set(10)
        bpy.context.scene.frame_set(11)
        self.assertFalse(face.mask(self.obj, "Surprise").any())
        self.assertIn('"Smooth" above Wrinkle Maps changes the number of vertices', face.notes(self.obj))
        self.obj.modifiers.remove(subdivision)
        self.check(6)


class RendersBeside(Renders):
    """The same pictures, of a Wrinkle Mesh that carries the masks."""

    def setUp(self) -> None:
        super().setUp()
        add_wrinkles(self.obj, "MESH")
        self.obj.rumple.mesh.radius = 0.05  # so low that every point keeps its pixel

    def test_pixel_by_pixel_as_without_wrinkles(self) -> None:
        bpy.context.scene.frame_set(9)
        wrinkled = self.pixels()
        modifier.find(self.obj).show_render = False
        bare = self.pixels()
        self.assertGreater(bare.max(), 0.5)
        self.assertLess(np.abs(wrinkled - bare).max(), 0.05)
        self.assertLess(np.abs(wrinkled - bare).mean(), 0.002)


del Renders  # it runs where it belongs
