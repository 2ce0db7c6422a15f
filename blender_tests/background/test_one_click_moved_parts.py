# SPDX-License-Identifier: GPL-3.0-or-later
"""The first click paints things in the mesh of a garment that one bone moves: books, plates, buckles, belts."""
from __future__ import annotations

import unittest
from typing import Callable

import bmesh
import bpy
import numpy as np
from mathutils import Matrix
from rumple.blender import compat
from rumple.blender.objects import painted_maps, runtimes
from support import figure, sleeve


class Things(unittest.TestCase):
    """A dress with a plate at its side."""

    def setUp(self) -> None:
        self.obj = figure.dressed()
        self.own = len(self.obj.data.vertices)
        self.add(lambda work: bmesh.ops.create_cube(
            work, size=1.0, matrix=Matrix.Translation((0.16, 0.0, 0.95)) @ Matrix.Diagonal((0.01, 0.12, 0.12, 1.0))),
            "hips")

    def add(self, make: Callable[[bmesh.types.BMesh], object], bone: str) -> None:
        work, mesh = bmesh.new(), self.obj.data
        work.from_mesh(mesh)
        before = len(work.verts)
        make(work)
        count = len(work.verts)
        work.to_mesh(mesh)
        work.free()
        self.obj.vertex_groups[bone].add(list(range(before, count)), 1.0, "REPLACE")

    def painted(self, key: str) -> np.ndarray:
        return painted_maps.weights(self.obj, painted_maps.find(self.obj, key))

    def test_it_is_painted_and_keeps_its_shape(self) -> None:
        for method in ("MESH", "FIELD", "PATHS"):
            with self.subTest(method):
                sleeve.click(self.obj, method)
                rigid = self.painted("rigid")
                self.assertEqual((rigid[:self.own].max(), rigid[self.own:].min()), (0.0, 1.0))
                self.assertEqual(runtimes.of(self.obj).evaluator.base.rigid.count, 1)
                bpy.ops.object.rumple_remove()
                self.obj.vertex_groups.remove(self.obj.vertex_groups["Rumple Rigid"])

    def test_what_bends_is_cloth(self) -> None:
        top = [vertex.index for vertex in self.obj.data.vertices if vertex.index >= self.own and vertex.co.z > 0.95]
        self.obj.vertex_groups["hips"].remove(top)
        self.obj.vertex_groups["chest"].add(top, 1.0, "REPLACE")
        sleeve.click(self.obj)
        self.assertNotIn("Rumple Rigid", self.obj.vertex_groups)

    def test_what_the_artist_painted_or_set_stays(self) -> None:
        self.obj.rumple.mesh.rigid_parts = False
        sleeve.click(self.obj)
        self.assertNotIn("Rumple Rigid", self.obj.vertex_groups)
        bpy.ops.object.rumple_remove()
        self.obj.rumple.mesh.rigid_parts = True
        self.obj.vertex_groups.new(name="Rumple Rigid").add([0], 0.5, "REPLACE")
        sleeve.click(self.obj)
        self.assertEqual(self.painted("rigid").max(), 0.5)

    def test_a_hand_follows_the_animation(self) -> None:
        rig = bpy.data.objects["Figure"]
        sleeve.make_active(rig)
        bpy.ops.object.mode_set(mode="EDIT")
        fingers = [f"finger{number}" for number in range(4)]
        for number, name in enumerate(fingers):
            figure.add_bone(rig, name, "hand.L", (0.8, 0.02 * number, 1.45))
        bpy.ops.object.mode_set(mode="OBJECT")
        for name in ("hand.L", *fingers):
            self.obj.vertex_groups.new(name=name)
        before = len(self.obj.data.vertices)
        self.add(lambda work: bmesh.ops.create_uvsphere(
            work, u_segments=12, v_segments=12, radius=0.09,
            matrix=Matrix.Translation((0.8, 0.0, 1.45)) @ Matrix.Diagonal((1.0, 0.1, 0.6, 1.0))), "hand.L")
        places = compat.positions(self.obj.data)
        for name, angle in zip(fingers, np.linspace(0.0, 1.5, 4)):
            far = [index for index in range(before, len(places)) if places[index, 0] > 0.8 + 0.02 * angle]
            self.obj.vertex_groups[name].add(far, 0.5, "REPLACE")
        sleeve.click(self.obj)
        for key in ("follow", "smooth"):
            painted = self.painted(key)
            self.assertEqual(painted[before:].min(), 1.0, key)
            self.assertLess(painted[:self.own].mean(), 0.5, key)
        self.assertEqual(self.painted("rigid")[before:].max(), 0.0)


if __name__ == "__main__":
    unittest.main()
