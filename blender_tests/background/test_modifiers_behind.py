# SPDX-License-Identifier: GPL-3.0-or-later
"""Modifiers behind the wrinkles that remove, merge or reorder points: the wrinkles under them are those without them,
and no other garment notices."""
from __future__ import annotations

import contextlib
import functools
import io
import os
import tempfile
import unittest
from typing import Any, Callable
from unittest import mock

import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.objects import bodies, evaluator, modifier, runtimes, stack_notes, subdivision_behind
from support import reference_solve, render_cases, sleeve, small_renders

SETTINGS = {
    "MASK": dict(vertex_group="lower", threshold=0.5),
    "DECIMATE": dict(ratio=0.3),
    "WELD": dict(merge_threshold=0.01),
    "BUILD": dict(frame_start=1, frame_duration=200),
    "REMESH": dict(mode="VOXEL", voxel_size=0.02),
    "BEVEL": dict(width=0.001),
    "WIREFRAME": {},
    "SKIN": {},
}


def nodes_behind(obj: bpy.types.Object, *kinds: str) -> Any:
    """A modifier with nodes of these kinds in a row."""
    group = bpy.data.node_groups.new("Behind", "GeometryNodeTree")
    for side in ("INPUT", "OUTPUT"):
        compat.new_group_socket(group, "Geometry", side, "NodeSocketGeometry")
    row = [group.nodes.new(kind) for kind in ("NodeGroupInput", *kinds, "NodeGroupOutput")]
    for before, after in zip(row, row[1:]):
        group.links.new(before.outputs[0], after.inputs[0])
    behind = obj.modifiers.new("Behind", "NODES")
    behind.node_group = group
    return behind


def delete_first_points(obj: bpy.types.Object) -> None:
    """Nodes that delete the points that the wrinkles are read from."""
    group = nodes_behind(obj, "GeometryNodeDeleteGeometry").node_group
    index, limit = group.nodes.new("GeometryNodeInputIndex"), group.nodes.new("FunctionNodeCompare")
    limit.data_type, limit.operation = "INT", "LESS_THAN"
    group.links.new(index.outputs[0], compat.socket(limit.inputs, "A"))
    compat.socket(limit.inputs, "B").default_value = 50
    group.links.new(limit.outputs[0], compat.socket(group.nodes["Delete Geometry"].inputs, "Selection"))


def put_behind(obj: bpy.types.Object, kind: str) -> Any:
    behind = obj.modifiers.new("Behind", kind)
    for name, value in SETTINGS[kind].items():
        setattr(behind, name, value)
    return behind


class Behind(unittest.TestCase):

    def played(self, frames: Any, prepare: Callable[..., object]) -> Any:
        """What is solved in the last of the frames, of both garments; prepare: called before the third of them."""
        one = sleeve.scene()
        other = sleeve.skinned(sleeve.tube("Other"), bpy.data.objects["Arm"], "Other")
        other.rumple.mesh.density, other.rumple.mesh.level, other.rumple.mesh.display_steps = "LEVEL", 1, 0
        sleeve.make_active(other)
        bpy.ops.object.rumple_add(method="MESH")
        for number, frame in enumerate(frames):
            if number == 2:
                prepare(one)
            sleeve.at(frame)
        self.one, self.other = one, other
        return [(runtimes.of(obj).inputs.frame, runtimes.of(obj).result.positions, obj.rumple.message)
                for obj in (one, other)]

    def test_the_wrinkles_are_those_without_it_and_others_go_on(self) -> None:
        # In background scripts one Mask stopped every garment of the file: Reordered escaped the handler.
        frames = range(1, 10)
        without = self.played(frames, lambda _obj: None)
        self.assertGreater(np.abs(without[0][1] - runtimes.of(self.one).evaluator.positions_rest).max(), 0.01)
        for kind in SETTINGS:
            with self.subTest(kind):
                behind = self.played(frames, lambda obj, kind=kind: put_behind(obj, kind))
                for (frame, positions, message), (_, expected, _) in zip(behind, without):
                    self.assertEqual((frame, message), (9.0, ""))
                    np.testing.assert_array_equal(positions, expected)

    def test_a_mask_shows_a_part_of_the_wrinkled_mesh(self) -> None:
        self.played(range(1, 10), lambda obj: put_behind(obj, "MASK"))
        shown, solved = sleeve.shown(self.one), runtimes.of(self.one).result.positions
        self.assertLess(len(shown), 0.7 * len(solved))
        self.assertGreater(len(shown), 0.3 * len(solved))
        distance = np.abs(shown[:, None] - solved[None]).max(axis=2).min(axis=1)
        self.assertLess(distance.max(), 1e-5)

    def test_node_groups_that_remove_points_neither(self) -> None:
        # It stopped its own garment: what it removed could not be read.
        def nothing(obj: bpy.types.Object) -> None:
            nodes_behind(obj).node_group.links.clear()

        frames = range(1, 10)
        without = self.played(frames, lambda _obj: None)
        for prepare in (delete_first_points, nothing):
            with self.subTest(prepare.__name__):
                for (frame, positions, message), (_, expected, _) in zip(self.played(frames, prepare), without):
                    self.assertEqual((frame, message), (9.0, ""))
                    np.testing.assert_array_equal(positions, expected)

    def test_what_is_above_is_evaluated_as_it_is_set(self) -> None:
        """The modifiers that were off while the mesh was read are on again, those that are off stay off."""
        self.played(range(1, 10), delete_first_points)
        self.one.modifiers["Behind"].show_render = False
        sleeve.at(10)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        self.assertEqual([(m.show_viewport, m.show_render) for m in self.one.evaluated_get(depsgraph).modifiers],
                         [(True, True), (True, True), (True, False)])

    def test_a_garment_over_one_that_loses_points_is_worn_over_all_of_it(self) -> None:
        self.played(range(1, 4), delete_first_points)
        self.other.rumple.body = self.one
        for frame in (4, 5, 6):
            sleeve.at(frame)
        self.assertEqual(self.other.rumple.message, "")
        depsgraph = bpy.context.evaluated_depsgraph_get()
        worn = bodies.read(self.other, self.other.evaluated_get(depsgraph), depsgraph)
        self.assertGreaterEqual(len(worn.positions), len(self.one.data.vertices))

    def test_nothing_is_shown_beside_the_mesh(self) -> None:
        self.played(range(1, 10), lambda obj: put_behind(obj, "MASK"))
        self.assertEqual([i.object.name for i in bpy.context.evaluated_depsgraph_get().object_instances
                          if i.is_instance], [])

    def test_baked_and_applied_it_is_what_was_seen(self) -> None:
        obj = sleeve.scene()
        put_behind(obj, "MASK")
        sleeve.at(9)
        sleeve.at(10)
        count = len(sleeve.output_object(obj).data.vertices)
        seen = runtimes.of(obj).result.positions.copy()
        bpy.ops.object.rumple_apply()
        self.assertEqual(len(obj.data.vertices), count)
        np.testing.assert_allclose(compat.positions(obj.data), seen, atol=1e-5)

    def test_a_file_opened_anew_renders_it(self) -> None:
        obj = small_renders.stage("CYCLES")
        sleeve.play(1, 9)
        expected = runtimes.of(obj).result.positions.copy()
        put_behind(obj, "MASK")
        name = obj.name
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "masked.blend")
            bpy.ops.wm.save_as_mainfile(filepath=file)
            bpy.ops.wm.open_mainfile(filepath=file)
            small_renders.clip(1, 9)
        runtime = runtimes.of(bpy.data.objects[name])
        self.assertEqual((runtime.inputs.frame, runtimes.message(bpy.data.objects[name])), (9.0, ""))
        np.testing.assert_array_equal(runtime.result.positions, expected)

    def test_a_hidden_object_goes_on(self) -> None:
        """Hidden in the viewport, as what is baked or worn under others is: it was told to be shown."""
        without = self.played(range(1, 10), lambda _obj: None)[0][1]
        for kind in ("MASK", "DECIMATE"):
            one, _other = self.played(range(1, 10), lambda obj, kind=kind: (put_behind(obj, kind), obj.hide_set(True)))
            self.assertEqual((one[0], one[2]), (9.0, ""))
            np.testing.assert_array_equal(one[1], without)


class SubdivisionOfTriangles(unittest.TestCase):
    """Blender crashed for want of memory: 0.1 MB for every triangle of the fine mesh."""

    def setUp(self) -> None:
        self.obj = sleeve.scene()
        self.behind = self.obj.modifiers.new("Subdivision", "SUBSURF")
        sleeve.at(2)

    def of_triangles(self) -> None:
        self.obj.rumple.mesh.source, self.obj.rumple.mesh.segments = "REGULAR", 1
        sleeve.at(3)
        sleeve.at(4)

    def test_quads_are_cheap(self) -> None:
        with mock.patch.multiple(subdivision_behind, NOTED=0.0, MOST=0.0):
            self.obj.rumple.mesh.level = 2
            sleeve.at(3)
            self.assertEqual((self.obj.rumple.message, stack_notes.of(self.obj)), ("", []))

    def test_much_is_said(self) -> None:
        with mock.patch.object(subdivision_behind, "NOTED", 10.0):
            self.of_triangles()
            self.assertEqual(self.obj.rumple.message, "")
            self.assertRegex(stack_notes.of(self.obj)[0], '^Sleeve: the modifier "Subdivision" below .* needs about')
            self.behind.levels = self.behind.render_levels = 0
            self.assertEqual(stack_notes.of(self.obj), [])

    def test_too_much_is_refused_before_it_is_spent_and_the_former_mesh_plays_on(self) -> None:
        before = len(sleeve.shown(self.obj))
        with mock.patch.object(subdivision_behind, "MOST", 10.0):
            self.of_triangles()
            self.assertRegex(self.obj.rumple.message, "switch off Use Limit Surface in it")
            self.assertEqual(len(sleeve.shown(self.obj)), before)
            runtimes.of(self.obj).evaluator = None  # as in a file that was just opened
            with mock.patch.object(evaluator, "_builder") as builder:  # it is not built again to be refused again
                sleeve.at(5)
                sleeve.at(4)
            builder.assert_not_called()
            self.assertRegex(self.obj.rumple.message, "switch off Use Limit Surface")
            self.behind.use_limit_surface = False
            sleeve.at(5)
            sleeve.at(6)
            self.assertEqual((self.obj.rumple.message, runtimes.of(self.obj).inputs.frame), ("", 6.0))
            self.assertNotEqual(len(sleeve.shown(self.obj)), before)

    def test_the_first_click_does_without_the_limit_surface_and_says_so(self) -> None:
        """A garment of triangles with a Subdivision, as pattern programs and artists leave it, was refused."""
        bpy.ops.object.rumple_remove()
        self.obj.rumple.mesh.source, self.obj.rumple.mesh.segments = "REGULAR", 1
        told, really = [], subdivision_behind.try_lighter
        with mock.patch.object(subdivision_behind, "MOST", 0.1), mock.patch.object(
                subdivision_behind, "try_lighter", side_effect=lambda *given: told.append(really(*given)) or told[0]):
            bpy.ops.object.rumple_add(method="MESH")
        self.assertRegex(told[0], 'Use Limit Surface .* is off now in the modifier "Subdivision"')
        self.assertFalse(self.behind.use_limit_surface)
        self.assertEqual(self.obj.rumple.message, "")

    def test_where_it_is_refused_for_something_else_nothing_is_switched_off(self) -> None:
        bpy.ops.object.rumple_remove()
        self.obj.rumple.most_vertices = 1
        self.obj.rumple.mesh.level = 5
        with self.assertRaisesRegex(RuntimeError, "vertices"):
            bpy.ops.object.rumple_add(method="MESH")
        self.assertTrue(self.behind.use_limit_surface)


class Linked(unittest.TestCase):
    """A garment of another file, without a library override."""

    def setUp(self) -> None:
        folder = self.enterContext(tempfile.TemporaryDirectory())
        self.library, self.shot = (os.path.join(folder, name) for name in ("library.blend", "shot.blend"))

    def linked(self) -> bpy.types.Object:
        """What is in the file, in a new one."""
        sleeve.at(1)
        bpy.ops.wm.save_as_mainfile(filepath=self.library)
        sleeve.empty_file()
        with bpy.data.libraries.load(self.library, link=True) as (_, wanted):
            wanted.objects = ["Sleeve"]
        bpy.context.scene.collection.objects.link(wanted.objects[0])
        return wanted.objects[0]

    def seen(self, obj: bpy.types.Object) -> list[Any]:
        """Played, and reached by jumps."""
        found = []
        for frame in (*range(1, 8), 12, 3):
            sleeve.at(frame)
            found.append((runtimes.of(obj).result.positions.copy(), sleeve.shown(obj)))
        self.assertEqual(runtimes.message(obj), "")
        return found

    def test_it_is_solved_and_shown_as_in_its_own_file(self) -> None:
        for prepare in (*(functools.partial(put_behind, kind=kind) for kind in SETTINGS), delete_first_points):
            with self.subTest(prepare):
                obj = sleeve.scene()
                prepare(obj)
                expected = self.seen(obj)
                found = self.seen(self.linked())
                bpy.ops.wm.save_as_mainfile(filepath=self.shot)
                bpy.ops.wm.open_mainfile(filepath=self.shot)
                for again in (found, self.seen(bpy.data.objects["Sleeve"])):
                    for (solved, shown), (own_solved, own_shown) in zip(again, expected):
                        np.testing.assert_array_equal(solved, own_solved)
                        np.testing.assert_array_equal(shown, own_shown)

    def linked_in_place_of(self, obj: bpy.types.Object) -> bpy.types.Object:
        """The sleeve of a library that has this file as it is; the open file has it from there."""
        for path in (self.library, self.shot):
            bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.data.objects.remove(obj)
        with bpy.data.libraries.load(self.library, link=True) as (_, wanted):
            wanted.objects = ["Sleeve"]
        linked: bpy.types.Object = wanted.objects[0]
        bpy.context.scene.collection.objects.link(linked)
        return linked

    def test_it_renders_as_in_its_own_file(self) -> None:
        """It was rendered as it stood in the viewport: what is linked keeps the switches of its renders."""
        obj = small_renders.stage("CYCLES")
        sleeve.bend_until(4)
        put_behind(obj, "MASK")
        own = small_renders.clip(1, 4)
        bare = modifier.find(obj)
        bare.show_render = False
        without = small_renders.still(4)
        bare.show_render = True
        linked = self.linked_in_place_of(obj)
        found = small_renders.clip(1, 4)
        self.assertEqual(runtimes.message(linked), "")
        depsgraph = bpy.context.evaluated_depsgraph_get()
        for m in linked.evaluated_get(depsgraph).modifiers:
            self.assertEqual((m.show_viewport, m.show_render), (True, True))
        self.assertLessEqual(reference_solve.unlike(found[4], own[4]), render_cases.STRAY)
        self.assertGreater(reference_solve.unlike(without, own[4]), render_cases.OTHER)

    def test_what_asks_for_the_frame_is_said(self) -> None:
        obj = small_renders.stage("CYCLES")
        put_behind(obj, "MASK")
        obj.modifiers.new("Ripples", "WAVE")
        compat.move_modifier(obj, 3, 0)
        self.linked_in_place_of(obj)
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            small_renders.still(2)
        self.assertIn('Sleeve: it is linked, and a modifier below the wrinkles removes points, so renders do not see '
                      'what "Ripples" does: make a library override of it', printed.getvalue())


if __name__ == "__main__":
    unittest.main()
