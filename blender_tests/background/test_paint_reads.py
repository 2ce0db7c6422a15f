# SPDX-License-Identifier: GPL-3.0-or-later
"""When painted maps are read."""
from __future__ import annotations

import unittest
from unittest import mock

import bpy
import numpy as np
from rumple.blender import scheduler
from rumple.blender.objects import mesh_reader, properties, runtimes
from support import cloth_scenes, sleeve

RADIUS = "Rumple Radius"


class Remeshed(unittest.TestCase):
    """In 5.2 a Remesh keeps vertex groups, and some weights are above 1 then: 1.004 was refused as impossible,
    so the garment had no folds any more."""

    def test_paint_that_a_remesh_carries_is_taken(self) -> None:
        obj = cloth_scenes.garment()
        group = obj.vertex_groups.new(name="Rumple Follow")
        for vertex in obj.data.vertices:
            group.add([vertex.index], vertex.co.x / sleeve.LENGTH, "REPLACE")
        bpy.context.view_layer.update()
        obj.data.remesh_voxel_size, obj.data.use_remesh_fix_poles = 0.03, False
        for name in ("use_remesh_preserve_attributes", "use_remesh_preserve_volume"):
            if hasattr(obj.data, name):
                setattr(obj.data, name, True)
        bpy.ops.object.voxel_remesh()
        bpy.context.view_layer.update()
        sleeve.at(5)
        self.assertEqual(obj.rumple.message, "")
        self.assertTrue(sleeve.is_fine(obj))
        weights = mesh_reader.group_weights(obj, obj.data, ["Rumple Follow"])
        self.assertTrue(((weights >= 0.0) & (weights <= 1.0)).all())


class ReadAgain(unittest.TestCase):
    """Vertex groups are read after an edit, not in every frame: this takes 1 ms for 1000 vertices."""

    def painted(self) -> bpy.types.Object:
        obj = sleeve.scene()
        obj.vertex_groups.new(name=RADIUS).add(range(len(obj.data.vertices)), 0.5, "REPLACE")
        sleeve.play(1, 3)
        return obj

    def test_animation_alone_reads_nothing(self) -> None:
        self.painted()
        with mock.patch.object(mesh_reader, "weights_by_name", wraps=mesh_reader.weights_by_name) as read:
            for frame in (4, 5, 3, 12, 1):
                sleeve.at(frame)
        read.assert_not_called()

    def test_an_edit_by_a_script_counts_in_the_next_frame(self) -> None:
        """Nothing updates the scene between the edit and the frame."""
        def rename(obj: bpy.types.Object) -> None:
            obj.vertex_groups[RADIUS].name = "Put Away"

        edits = {
            "add": lambda obj: obj.vertex_groups[RADIUS].add([40], 0.125, "REPLACE"),
            "remove": lambda obj: obj.vertex_groups[RADIUS].remove([40]),
            "weight": lambda obj: setattr(obj.data.vertices[40].groups[-1], "weight", 0.125),
            "delete": lambda obj: obj.vertex_groups.remove(obj.vertex_groups[RADIUS]),
            "rename": rename,
            "another": lambda obj: obj.vertex_groups.new(name="Rumple Bending").add([40], 0.125, "REPLACE")}
        for name, edit in edits.items():
            with self.subTest(name):
                obj = self.painted()
                before = runtimes.of(obj).inputs.paint
                edit(obj)
                bpy.context.scene.frame_set(4)
                after, read = runtimes.of(obj).inputs.paint, mesh_reader.paint(obj, properties.settings_of(
                    obj, bpy.context.scene))
                self.assertEqual(after.keys(), read.keys())
                for key in read:
                    np.testing.assert_array_equal(after[key], read[key])
                self.assertFalse(before.keys() == after.keys() and all(
                    np.array_equal(before[key], after[key]) for key in before), "the edit changed nothing")

    def test_an_edit_while_updates_are_not_looked_at_counts_in_the_next_frame(self) -> None:
        obj = self.painted()
        with scheduler.suspended():
            obj.vertex_groups[RADIUS].add([40], 0.125, "REPLACE")
            bpy.context.view_layer.update()
        bpy.context.scene.frame_set(4)
        self.assertEqual(runtimes.of(obj).inputs.paint["radius"][40], 0.125)

    def test_an_attribute_that_a_script_fills_counts_in_the_next_frame(self) -> None:
        """Blender does not report this."""
        obj = self.painted()
        values = obj.data.attributes.new("Rumple Bending", "FLOAT", "POINT")
        values.data.foreach_set("value", np.ones(len(obj.data.vertices), np.float32))
        sleeve.play(1, 3)
        obj.data.attributes["Rumple Bending"].data[40].value = 0.25
        bpy.context.scene.frame_set(4)
        self.assertEqual(runtimes.of(obj).inputs.paint["bending"][40], 0.25)
