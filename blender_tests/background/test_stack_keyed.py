# SPDX-License-Identifier: GPL-3.0-or-later
"""Modifiers in front of the wrinkles that make points, and whose settings change from frame to frame."""
from __future__ import annotations

import contextlib
import io
import os
import tempfile
import unittest

import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.objects import incoming_mesh, modifier, runtimes
from support import sleeve


def in_front(obj: bpy.types.Object, name: str, kind: str) -> bpy.types.Modifier:
    made = obj.modifiers.new(name, kind)
    compat.move_modifier(obj, len(obj.modifiers) - 1, 0)
    return obj.modifiers[made.name]


def moving_nodes(obj: bpy.types.Object) -> tuple[bpy.types.Modifier, str]:
    """Nodes that subdivide, and move all points up by their input Amount. Returns the identifier of the input, too."""
    group = bpy.data.node_groups.new("Nodes", "GeometryNodeTree")
    for name, way, kind in (("Geometry", "INPUT", "NodeSocketGeometry"), ("Amount", "INPUT", "NodeSocketFloat"),
                            ("Geometry", "OUTPUT", "NodeSocketGeometry")):
        compat.new_group_socket(group, name, way, kind)
    row = [group.nodes.new(kind) for kind in ("NodeGroupInput", "GeometryNodeSubdivideMesh", "GeometryNodeSetPosition",
                                              "NodeGroupOutput")]
    for before, after in zip(row, row[1:]):
        group.links.new(before.outputs[0], after.inputs[0])
    upwards = group.nodes.new("ShaderNodeCombineXYZ")
    group.links.new(row[0].outputs["Amount"], upwards.inputs["Z"])
    group.links.new(upwards.outputs[0], row[2].inputs["Offset"])
    made = in_front(obj, 'The "wind"', "NODES")
    made.node_group = group
    return made, compat.group_sockets(group, "INPUT")["Amount"]


def garment() -> bpy.types.Object:
    obj = sleeve.scene(wrinkles=False)
    obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 1, 0
    return obj


class Edited(unittest.TestCase):
    """The mesh under modifiers in front. The modifier was blamed for what the artist had edited; a baked garment showed
    the bare mesh, and nothing was said."""

    def edited(self, obj: bpy.types.Object, ring: int = sleeve.AROUND) -> None:
        mesh = obj.data
        faces = [tuple(face.vertices) for face in mesh.polygons][:-ring]
        places = [vertex.co.copy() for vertex in mesh.vertices][:-ring]
        mesh.clear_geometry()
        mesh.from_pydata(places, [], faces)

    def setUp(self) -> None:
        self.obj = garment()
        in_front(self.obj, "Above", "SUBSURF")
        bpy.ops.object.rumple_add(method="MESH")
        self.assertFalse(incoming_mesh.is_own(self.obj))
        sleeve.play(1, 3)

    def test_no_modifier_is_blamed(self) -> None:
        self.edited(self.obj)
        sleeve.play(4, 6)
        self.assertEqual((self.obj.rumple.message, runtimes.of(self.obj).notes), ("", []))
        self.assertGreater(len(sleeve.shown(self.obj)), len(incoming_mesh.of(self.obj).vertices))

    def test_a_baked_one_shows_live_folds(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "stack.blend"))
            bpy.ops.object.rumple_bake()
            for opened in (False, True):
                if opened:
                    bpy.ops.wm.open_mainfile(filepath=os.path.join(folder, "stack.blend"))
                    self.obj = bpy.data.objects["Sleeve"]
                else:
                    bpy.ops.wm.save_mainfile()
                sleeve.play(4, 5)
                self.assertTrue(modifier.plays_clip(modifier.find(self.obj)))
                self.edited(self.obj)
                sleeve.play(6, 7)
                self.assertRegex(self.obj.rumple.message, "were baked, so live folds are shown")
                self.assertFalse(modifier.plays_clip(modifier.find(self.obj)))
                self.assertGreater(len(sleeve.shown(self.obj)), len(incoming_mesh.of(self.obj).vertices))


class Nodes(unittest.TestCase):
    """In 5.2 an input of nodes has another path for keys and drivers: each frame counted as an edit of the stack, so
    the fine mesh was built anew in each frame, and folds never went on from the frame before."""

    def check(self, obj: bpy.types.Object) -> None:
        bpy.ops.object.rumple_add(method="MESH")
        self.assertFalse(incoming_mesh.is_own(obj))
        sleeve.at(1)
        evaluator, stack = runtimes.of(obj).evaluator, incoming_mesh.stack_fingerprint(obj)
        for frame in range(2, 6):
            sleeve.at(frame)
            bpy.context.view_layer.update()
            self.assertEqual(incoming_mesh.stack_fingerprint(obj), stack)
            self.assertIs(runtimes.of(obj).evaluator, evaluator)
            self.assertTrue(evaluator.frame_cache.get(float(frame)).final)
        self.assertGreater(runtimes.of(obj).inputs.positions[:, 2].mean(), 0.04)

    def test_a_keyed_input(self) -> None:
        obj = garment()
        made, identifier = moving_nodes(obj)
        path = compat.modifier_input_path(made, identifier)
        for frame, amount in ((1, 0.0), (6, 0.1)):
            compat.set_modifier_input(made, identifier, amount)
            obj.keyframe_insert(path, frame=frame)
        self.assertEqual(compat.animated_paths(obj), {path})
        self.check(obj)

    def test_a_driven_input(self) -> None:
        obj = garment()
        driver = obj.driver_add(compat.modifier_input_path(*moving_nodes(obj))).driver
        driver.type, driver.expression = "SCRIPTED", "(frame - 1) * 0.02"
        self.check(obj)

    def test_an_edited_input_is_an_edit(self) -> None:
        obj = garment()
        made, identifier = moving_nodes(obj)
        bpy.ops.object.rumple_add(method="MESH")
        before = incoming_mesh.stack_fingerprint(obj)
        compat.set_modifier_input(made, identifier, 0.5)
        self.assertNotEqual(incoming_mesh.stack_fingerprint(obj), before)


class OtherPoints(unittest.TestCase):
    """Without a window nothing works between two frames: the frame in which other points arrived showed no folds, and
    those after it were solved as after a jump."""

    def test_a_frame_after_other_levels_are_set_is_solved(self) -> None:
        def played(before: int) -> list[np.ndarray]:
            obj = garment()
            made = in_front(obj, "Subdivision", "SUBSURF")
            made.levels = made.render_levels = before
            bpy.ops.object.rumple_add(method="MESH")
            made.levels = made.render_levels = 0
            return [sleeve.shown(obj) for frame in (1, 2, 3) if sleeve.at(frame) is None]

        for changed, same in zip(played(1), played(0)):
            np.testing.assert_array_equal(changed, same)

    def test_a_keyed_number_of_points(self) -> None:
        obj = garment()
        made = in_front(obj, "Fewer", "DECIMATE")
        for frame, ratio in ((4, 1.0), (5, 0.5)):
            made.ratio = ratio
            obj.keyframe_insert(f'{made.path_from_id()}.ratio', frame=frame)
        for curve in compat.keyed_curves(obj.animation_data):
            for key in curve.keyframe_points:
                key.interpolation = "CONSTANT"
        sleeve.at(1)
        bpy.ops.object.rumple_add(method="MESH")
        for frame in (4, 5, 6, 4):
            sleeve.at(frame)
            self.assertEqual(len(sleeve.shown(obj)), runtimes.of(obj).evaluator.vertex_count, frame)
            self.assertTrue(sleeve.is_fine(obj))
            self.assertIsNotNone(runtimes.of(obj).evaluator.frame_cache.get(float(frame)))


class Nothing(unittest.TestCase):

    def test_what_has_no_faces_at_first_has_wrinkles_as_soon_as_it_has(self) -> None:
        """A Build has none in its first frame. That mesh was refused, and what came later was not looked at: there were
        no wrinkles in any frame, and the mesh, which has faces, was said to have none."""
        obj = garment()
        made = in_front(obj, "Grow", "BUILD")
        made.frame_start, made.frame_duration, made.show_viewport = 1, 4, False
        bpy.ops.object.rumple_add(method="MESH")
        whole = len(sleeve.shown(obj))
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            made.show_viewport = True
            bpy.context.view_layer.update()
            sleeve.at(1)
            bpy.context.view_layer.update()
        self.assertIn('the modifier "Grow" above the wrinkles leaves no faces: move it below', obj.rumple.message)
        sleeve.play(2, 8)
        self.assertEqual(len(sleeve.shown(obj)), whole)
        self.assertEqual(obj.rumple.message, "")
        self.assertEqual(modifier.coarse_vertices(modifier.find(obj)), len(obj.data.vertices))
        self.assertGreater(np.abs(runtimes.of(obj).result.offset).max(), 1e-4)
