# SPDX-License-Identifier: GPL-3.0-or-later
"""A hem that is tucked into other clothes is pinned by the first click: a shirt in trousers, a leg in a boot."""
from __future__ import annotations

import math
import unittest

import bmesh
import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.objects import mesh_reader
from support import sleeve

GROUP = "Rumple Follow"


class Tucked(unittest.TestCase):
    """A sleeve over an arm that points down, its end in a glove: the upper end is pinned in any case."""

    def setUp(self) -> None:
        self.obj = sleeve.to_be_cloth()

    def wear(self, radius: float, length: float = 0.4) -> None:
        """A glove around the end of the sleeve, of that many of its radii and lengths."""
        mesh = sleeve.tube("Glove")
        for vertex in mesh.vertices:
            vertex.co.x = 0.85 * sleeve.LENGTH + length * vertex.co.x
            vertex.co.yz *= radius
        sleeve.skinned(mesh, bpy.data.objects["Arm"], "Glove")

    def click(self, method: str = "MESH") -> np.ndarray:
        """(n,) weights of the map; empty without one."""
        for obj in bpy.data.objects:
            obj.rotation_euler.y = math.pi / 2.0  # X points down
        sleeve.make_active(self.obj)
        bpy.ops.object.rumple_add(method=method)
        if GROUP not in self.obj.vertex_groups:
            return np.zeros(0, np.float32)
        return mesh_reader.group_weights(self.obj, self.obj.data, [GROUP])[:, 0]

    def test_it_is_pinned_at_the_hem_that_is_covered_and_only_there(self) -> None:
        """A shirt came out of its waistband, and below it there was nothing: the body is deleted there."""
        self.wear(1.15)
        along = compat.positions(self.obj.data)[:, 0]
        for method in ("MESH", "FIELD", "PATHS"):
            with self.subTest(method):
                weights = self.click(method)
                self.assertEqual(weights[along == along.max()].min(), 1.0)
                self.assertEqual(weights[np.abs(along - 0.5 * sleeve.LENGTH) < 0.1].max(), 0.0)
                self.assertEqual(weights[along == along.min()].min(), 1.0)
                bpy.ops.object.rumple_remove()
                self.obj.vertex_groups.remove(self.obj.vertex_groups[GROUP])

    def test_the_edge_of_a_cap_is_a_hem(self) -> None:
        """It is none of the mesh with its caps, so that a map of its pins left collar and cuffs free."""
        bpy.data.objects.remove(bpy.data.objects["Human"])
        bpy.data.objects.remove(self.obj)
        mesh = sleeve.tube()
        parts = bmesh.new()
        for first, length, radius in ((0.0, 1.0, 1.0), (0.8, 0.5, 0.85), (-0.3, 0.5, 0.85)):  # a hand, an elbow in it
            parts.from_mesh(mesh)
            parts.verts.ensure_lookup_table()
            own = parts.verts[-len(mesh.vertices):]
            for vertex in own:
                vertex.co.x = sleeve.LENGTH * first + length * vertex.co.x
                vertex.co.yz *= radius
            if first >= 0.0:
                parts.faces.new(own[-sleeve.AROUND:])
        parts.to_mesh(mesh)
        self.obj = sleeve.skinned(mesh, bpy.data.objects["Arm"])
        self.obj.rumple.mesh.property_unset("base_cloth")
        self.wear(1.15, 0.8)
        at_cap = np.abs(compat.positions(mesh)[:sleeve.AROUND * sleeve.ALONG, 0] - sleeve.LENGTH) < 1e-4
        self.assertEqual(self.click()[:len(at_cap)][at_cap].min(), 1.0)

    def test_with_a_modifier_in_front(self) -> None:
        self.wear(1.15)
        along = compat.positions(self.obj.data)[:, 0]
        for kind in ("MIRROR", "SUBSURF", "SOLIDIFY"):
            with self.subTest(kind):
                self.obj.modifiers.new("Front", kind)
                compat.move_modifier(self.obj, len(self.obj.modifiers) - 1, 0)
                self.assertEqual(self.click()[along == along.max()].min(), 1.0)
                bpy.ops.object.rumple_remove()
                self.obj.vertex_groups.remove(self.obj.vertex_groups[GROUP])
                self.obj.modifiers.remove(self.obj.modifiers["Front"])

    def test_what_is_far_or_below_covers_nothing(self) -> None:
        for radius in (2.5, 0.9):
            with self.subTest(radius):
                self.wear(radius)
                self.assertEqual(len(self.click()), 0)
                bpy.ops.object.rumple_remove()
                bpy.data.objects.remove(bpy.data.objects["Glove"])

    def test_a_mask_of_weight_paint_leaves_nothing_out(self) -> None:
        """With nothing selected all of the map was 0, and the garment pinned nowhere."""
        self.wear(1.15)
        self.obj.data.use_paint_mask_vertex = True
        self.obj.data.vertices.foreach_set("select", np.zeros(len(self.obj.data.vertices), bool))
        along = compat.positions(self.obj.data)[:, 0]
        weights = self.click()
        self.assertEqual(weights[(along == along.max()) | (along == along.min())].min(), 1.0)

    def test_a_click_that_is_refused_leaves_no_map(self) -> None:
        self.wear(1.15)
        self.obj.rumple.mesh.source = "OBJECT"
        with self.assertRaises(RuntimeError):
            self.click()
        self.assertNotIn(GROUP, self.obj.vertex_groups)

    def test_what_was_painted_stays(self) -> None:
        self.wear(1.15)
        self.obj.vertex_groups.new(name=GROUP).add([3], 0.25, "REPLACE")
        weights = self.click()
        self.assertEqual(weights[3], 0.25)
        self.assertEqual(np.count_nonzero(weights), 1)


if __name__ == "__main__":
    unittest.main()
