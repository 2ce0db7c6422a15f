# SPDX-License-Identifier: GPL-3.0-or-later
"""The first of Blender's two evaluations of a frame hands on the coarse mesh, and nobody ever sees it."""
from __future__ import annotations

import contextlib
import unittest
from unittest import mock
from typing import Iterator

import bpy
import numpy as np
from rumple.blender import compat, handlers
from rumple.blender.frame import first_pass
from rumple.blender.frame.garment_reader import GarmentReader
from rumple.blender.nodes.output_flags import Flag, change_flag, is_set
from rumple.blender.objects import modifier, runtimes
from rumple.core.base.wording import UserError
from support import sleeve


@contextlib.contextmanager
def first_passes(obj: bpy.types.Object) -> Iterator[list[int]]:
    """Numbers of points that an object has when the first pass of each frame is over."""
    counts = []

    def look(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        counts.append(len(obj.evaluated_get(depsgraph).data.vertices))

    bpy.app.handlers.frame_change_post.insert(0, look)  # before ours, which writes
    try:
        yield counts
    finally:
        bpy.app.handlers.frame_change_post.remove(look)


def coarse_count(obj: bpy.types.Object) -> int:
    return len(obj.data.vertices)


def is_coarse(obj: bpy.types.Object) -> bool:
    return is_set(modifier.output_object(modifier.find(obj)), Flag.COARSE_ONLY)


class Flags(unittest.TestCase):
    def test_no_two_of_an_object_share_an_axis(self) -> None:
        """They were four numbers in four files."""
        self.assertEqual(len(Flag.__members__), len(set(Flag)))  # equal values are one member with two names
        self.assertEqual({flag.axis for flag in Flag} - {0, 1, 2}, set())

    def test_each_is_set_and_cleared_by_itself(self) -> None:
        obj = bpy.data.objects.new("Flags", None)
        for flag in Flag:
            others = {other for other in Flag if other.axis != flag.axis}
            self.assertTrue(change_flag(obj, flag, True))
            self.assertFalse(change_flag(obj, flag, True))
            self.assertTrue(is_set(obj, flag))
            self.assertFalse(any(is_set(obj, other) for other in others))
            self.assertTrue(change_flag(obj, flag, False))
            self.assertFalse(is_set(obj, flag))


class FirstPass(unittest.TestCase):

    def played(self, obj: bpy.types.Object, first: int = 4, last: int = 8) -> set[int]:
        sleeve.play(1, first - 1)
        with first_passes(obj) as counts:
            sleeve.play(first, last)
        return set(counts)

    def test_a_garment_that_moves_costs_one_fine_mesh_a_frame(self) -> None:
        obj = sleeve.scene()
        self.assertEqual(self.played(obj), {coarse_count(obj)})
        self.assertGreater(len(sleeve.shown(obj)), coarse_count(obj))
        self.assertFalse(is_coarse(obj))

    def test_what_is_shown_is_what_two_fine_passes_showed(self) -> None:
        """Also where a modifier behind the wrinkles makes more points of the mesh."""
        shown, seen = [], []
        for prepare in (first_pass.hand_on_coarse, lambda scene: None):
            with mock.patch.object(first_pass, "hand_on_coarse", prepare):
                obj = sleeve.scene()
                obj.modifiers.new("Lining", "SOLIDIFY")
                sleeve.play()
                frames = []
                with first_passes(obj) as counts:
                    for frame in (6, 7, 8, 15):
                        sleeve.at(frame)
                        frames.append(sleeve.shown(obj))
                shown.append(np.array(frames))
                seen.append(set(counts))
        np.testing.assert_array_equal(*shown)
        self.assertLess(max(seen[0]), min(seen[1]))

    def test_a_garment_that_stands_still_is_left_alone(self) -> None:
        """Blender does not evaluate it at all: to switch it would cost what it saves elsewhere."""
        obj = sleeve.scene()
        bpy.data.objects["Arm"].animation_data_clear()
        self.assertNotIn(coarse_count(obj), self.played(obj))
        self.assertEqual(runtimes.of(obj).moved_in, 0)

    def test_it_is_shown_whole_again_when_the_solve_fails(self) -> None:
        obj = sleeve.scene()
        sleeve.play(1, 4)
        with mock.patch.object(GarmentReader, "_read", side_effect=UserError("on purpose")):
            sleeve.at(5)
        self.assertEqual(runtimes.message(obj), "on purpose")
        self.assertFalse(is_coarse(obj))
        self.assertGreater(len(sleeve.shown(obj)), coarse_count(obj))

    def test_it_is_shown_whole_again_when_the_handler_breaks(self) -> None:
        obj, scene = sleeve.scene(), bpy.context.scene
        sleeve.play(1, 4)
        first_pass.hand_on_coarse(scene)
        self.assertTrue(is_coarse(obj))
        depsgraph = bpy.context.evaluated_depsgraph_get()
        with mock.patch.object(handlers, "_follow", side_effect=RuntimeError):
            handlers._on_frame(scene, depsgraph)
        self.assertFalse(is_coarse(obj))

    def test_modifiers_behind_that_keep_a_mesh_see_the_fine_one_only(self) -> None:
        obj = sleeve.scene()
        obj.modifiers.new("Collision", "COLLISION")
        self.assertNotIn(coarse_count(obj), self.played(obj))

    def test_what_is_bound_to_a_garment_sees_the_fine_one_only(self) -> None:
        obj = sleeve.scene()
        patch = bpy.data.objects.new("Patch", bpy.data.meshes.new("Patch"))
        bpy.context.scene.collection.objects.link(patch)
        patch.modifiers.new("Bound", "SURFACE_DEFORM").target = obj
        self.assertNotIn(coarse_count(obj), self.played(obj))

    def test_simulation_zones_see_the_fine_one_only(self) -> None:
        obj = sleeve.scene()
        group = bpy.data.node_groups.new("Hair", "GeometryNodeTree")
        try:
            group.nodes.new("GeometryNodeSimulationOutput")
        except RuntimeError:
            self.skipTest("this Blender has no simulation zones")
        obj.modifiers.new("Hair", "NODES").node_group = group
        self.assertNotIn(coarse_count(obj), self.played(obj))

    def test_a_garment_of_another_scene_is_left_alone(self) -> None:
        obj = sleeve.scene()
        sleeve.play(1, 4)
        other = bpy.data.scenes.new("Other")
        other.frame_set(4)
        self.assertFalse(is_coarse(obj))
        self.assertEqual(runtimes.of(obj).moved_in, compat.session_key(bpy.context.scene))


if __name__ == "__main__":
    unittest.main()
