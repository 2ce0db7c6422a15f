# SPDX-License-Identifier: GPL-3.0-or-later
"""A figure that is cut into objects, as kits of characters and exports by material are, stays closed at the cuts."""
from __future__ import annotations

import math
import unittest

import bmesh
import bpy
import numpy as np
from mathutils import Matrix
from rumple.blender import compat
from rumple.blender.first_click import body_search
from rumple.blender.objects import mesh_reader
from support import sleeve

GROUP = "Rumple Follow"
AT_CUT = slice(-sleeve.AROUND, None)  # the last ring of the sleeve


def close_ends(mesh: bpy.types.Mesh) -> None:
    work = bmesh.new()
    work.from_mesh(mesh)
    bmesh.ops.holes_fill(work, edges=work.edges)
    work.to_mesh(mesh)
    work.free()


def lowest_place(obj: bpy.types.Object) -> float:
    """The largest coordinate along the sleeve, which points down, of what is shown."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return float(compat.positions(evaluated.data)[:, 0].max())


class Cut(unittest.TestCase):
    """A sleeve that points down, and the cuff that goes on where it ends, an object of its own."""

    def setUp(self) -> None:
        self.obj = sleeve.to_be_cloth()
        bpy.data.objects.remove(bpy.data.objects["Human"])
        self.cuff = self.go_on()

    def go_on(self, apart: float = 0.0) -> bpy.types.Object:
        """The cuff, that far below the sleeve."""
        mesh = sleeve.tube("Cuff")
        rest = compat.positions(mesh)
        rest[:, 0] = np.float32(0.3) * rest[:, 0] + compat.positions(self.obj.data)[-1, 0] + apart
        mesh.vertices.foreach_set("co", rest.ravel())
        mesh.update()
        cuff = sleeve.skinned(mesh, bpy.data.objects["Arm"], "Cuff")
        cuff.rumple.mesh.property_unset("base_cloth")
        return cuff

    def click(self, method: str = "MESH") -> np.ndarray:
        """(n,) what is painted as pinned; empty without a map."""
        for obj in bpy.data.objects:
            obj.rotation_euler.y = math.pi / 2.0  # X points down
        sleeve.click(self.obj, method)
        if GROUP not in self.obj.vertex_groups:
            return np.zeros(0, np.float32)
        return mesh_reader.group_weights(self.obj, self.obj.data, [GROUP])[:, 0]

    def test_both_sides_are_pinned_at_the_cut(self) -> None:
        """The bodice of a dress hung from its collar and left the skirt, which is an object of its own, by 4 cm."""
        for method in ("MESH", "FIELD", "PATHS"):
            with self.subTest(method):
                weights = self.click(method)
                self.assertEqual(weights[AT_CUT].min(), 1.0)
                along = compat.positions(self.obj.data)[:, 0]
                self.assertEqual(weights[np.abs(along - 0.5 * sleeve.LENGTH) < 0.1].max(), 0.0)
                bpy.ops.object.rumple_remove()
                self.obj.vertex_groups.remove(self.obj.vertex_groups[GROUP])
        self.obj = self.cuff
        weights = self.click()
        self.assertTrue(not len(weights) or weights[:sleeve.AROUND].min() == 1.0, "the highest border is held anyway")

    def test_a_closed_end_is_not_rounded_away_from_the_cut(self) -> None:
        """Both rims were rounded, and a slit of 1 cm was open around the waist in the rest pose already."""
        close_ends(self.obj.data)
        rest = compat.positions(self.cuff.data)
        head = sleeve.skinned(sleeve.tube("Head"), bpy.data.objects["Arm"], "Above")
        head.data.transform(Matrix.Translation((-sleeve.LENGTH, 0.0, 0.0)))
        bpy.context.scene.frame_set(1)
        self.click()
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "HANG")
        self.assertAlmostEqual(lowest_place(self.obj), float(rest[0, 0]), delta=2e-3)

    def test_neither_side_is_worn_over_the_other(self) -> None:
        """At a cut the distance is nought, and its sign was noise: with one Blender a skirt was worn over its bodice,
        and was pushed out of it at the hip."""
        for vertex in self.cuff.data.vertices:
            vertex.co.x = sleeve.LENGTH + (vertex.co.x - sleeve.LENGTH) / 6.0
            vertex.co.yz *= 1.0 + (vertex.co.x - sleeve.LENGTH)  # it is flared
        for degrees in (10.0, 33.0, 57.0, 81.0):
            for obj in bpy.data.objects:
                obj.rotation_euler = (0.1, math.radians(degrees), math.radians(2.0 * degrees))
            bpy.context.view_layer.update()
            for obj in (self.obj, self.cuff):
                found = body_search.find(obj, bpy.context.scene)
                self.assertEqual((found.body, found.garments, found.clothes), (None, [], []), degrees)

    def test_creases_of_the_artist_stay(self) -> None:
        creases = np.zeros(len(self.obj.data.edges), np.float32)
        creases[0] = 0.5
        compat.set_edge_marks(self.obj.data, {"crease": creases})
        self.click()
        found = compat.edge_creases(self.obj.data)
        ring = compat.edge_vertices(self.obj.data) >= len(self.obj.data.vertices) - sleeve.AROUND
        np.testing.assert_array_equal(found == 1.0, ring.all(axis=1))
        self.assertEqual(found[0], 0.5)

    def test_what_only_lies_near_is_no_cut(self) -> None:
        bpy.data.objects.remove(self.cuff)
        self.go_on(0.002)
        self.click()
        self.assertFalse(compat.edge_creases(self.obj.data).any())

    def test_a_copy_of_the_garment_is_no_cut(self) -> None:
        """A level of detail at the same place pinned all of it: it had no folds."""
        bpy.data.objects.remove(self.cuff)
        sleeve.skinned(self.obj.data.copy(), bpy.data.objects["Arm"], "Detail")
        self.assertEqual(len(self.click()), 0)

    def test_skin_by_name_leaves_no_cut_open(self) -> None:
        """The map that the click had made for the skin counted as the artist's, so no hem was pinned."""
        slots = compat.indices(self.obj.data.polygons, "material_index")
        slots[:] = np.arange(len(slots)) < 3 * sleeve.AROUND
        self.obj.data.polygons.foreach_set("material_index", slots)
        self.obj.material_slots[1].material.name = "Skin"
        weights = self.click()
        self.assertIn("Rumple Keep Smooth", self.obj.vertex_groups)
        self.assertEqual(weights[AT_CUT].min(), 1.0)
        self.assertEqual(weights[:sleeve.AROUND].min(), 1.0, "skin")

    def test_what_was_painted_stays(self) -> None:
        self.obj.vertex_groups.new(name=GROUP).add([3], 0.25, "REPLACE")
        weights = self.click()
        self.assertEqual((weights[3], np.count_nonzero(weights)), (0.25, 1))


if __name__ == "__main__":
    unittest.main()
