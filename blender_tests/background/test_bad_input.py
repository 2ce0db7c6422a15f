# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as artists have them: what is wrong is said in words that name object and element, what can be handled is."""
from __future__ import annotations

import math
import unittest
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix
from rumple.blender import scheduler
from rumple.blender.objects import guide_curves, modifier, runtimes
from support import sleeve

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


class BadInput:
    """What every system answers."""

    method: str

    def add(self, vertices: Any, faces: Any, edges: Any = (), scale: float = 1.0) -> bpy.types.Object:
        """A mesh object of that name with wrinkles asked for; nothing raises."""
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        mesh = bpy.data.meshes.new("Rag")
        mesh.from_pydata(vertices, list(edges), faces)
        obj = bpy.data.objects.new("Rag", mesh)
        bpy.context.scene.collection.objects.link(obj)
        obj.scale = (scale, scale, scale)
        bpy.context.view_layer.objects.active = obj
        bpy.context.view_layer.update()
        try:
            self.answer = ""
            bpy.ops.object.rumple_add(method=self.method)
        except RuntimeError as error:  # how bpy.ops hands on an operator's error report
            self.answer = str(error)
        return obj

    def refused(self, words: str, *arguments: Any, **options: Any) -> None:
        obj = self.add(*arguments, **options)
        self.assertRegex(self.answer, words)
        self.assertIn("Rag", self.answer)
        self.assertIsNone(modifier.find(obj), "a refused mesh is left as it was")

    def handled(self, *arguments: Any, **options: Any) -> bpy.types.Object:
        obj = self.add(*arguments, **options)
        self.assertEqual(self.answer, "")
        self.assertEqual(obj.rumple.message, "")
        self.assertTrue(np.isfinite(sleeve.shown(obj)).all())
        self.assertGreaterEqual(len(sleeve.shown(obj)), len(obj.data.vertices))
        return obj

    def test_empty(self) -> None:
        self.refused("no faces|empty|no vert", [], [])

    def healed(self, words: str, *arguments: Any) -> None:
        obj = self.handled(*arguments)
        self.assertRegex("\n".join(runtimes.of(obj).evaluator.base.origin.notes("Rag")), words)

    def test_an_edge_with_three_faces_is_healed_and_named(self) -> None:
        vertices = SQUARE + [(0, 0, 1), (1, 0, 1), (0, -1, 1), (1, -1, 1)]
        self.healed("Rag: edge 0-1 has more faces than two", vertices, [(0, 1, 2, 3), (1, 0, 4, 5), (0, 1, 7, 6)])

    def test_duplicate_faces_are_healed_and_named(self) -> None:
        self.healed("^Rag: face 1 lies on another face", SQUARE, [(0, 1, 2, 3), (0, 1, 2, 3)])

    def test_a_face_that_is_turned_is_healed_and_named(self) -> None:
        self.healed("^Rag: face 1 faces the other way", SQUARE + [(1.5, 0, 0), (1.5, 1, 0)],
                    [(0, 1, 2, 3), (1, 2, 5, 4)])

    def test_a_coordinate_that_is_not_finite_is_named(self) -> None:
        self.refused(r"\b2\b", [(0, 0, 0), (1, 0, 0), (1, math.nan, 0), (0, 1, 0)], [(0, 1, 2, 3)])

    def test_a_scale_of_zero_is_refused(self) -> None:
        self.refused("scale is zero", SQUARE, [(0, 1, 2, 3)], scale=0.0)

    def test_a_negative_scale_is_handled(self) -> None:
        self.handled(SQUARE, [(0, 1, 2, 3)], scale=-1.0)

    def test_ngons_and_triangles_are_handled(self) -> None:
        around = [(math.cos(a), math.sin(a), 0) for a in np.linspace(0, 2 * math.pi, 7, endpoint=False)]
        self.handled(around + [(2, 0, 0)], [tuple(range(7)), (0, 7, 1)])

    def test_loose_vertices_and_edges_are_handled_and_noted(self) -> None:
        obj = self.handled(SQUARE + [(5, 5, 5), (6, 5, 5), (7, 7, 7)], [(0, 1, 2, 3)], edges=[(4, 5)])
        self.assertRegex(" ".join(runtimes.of(obj).notes), r"without a face: 3, the first is vertex 4")

    def test_zero_length_edges_and_flat_triangles_are_handled(self) -> None:
        self.handled([(0, 0, 0), (1, 0, 0), (1, 0, 0), (0, 1, 0), (2, 0, 0)], [(0, 1, 2, 3), (1, 4, 2)])

    def test_a_pose_that_is_not_finite_is_named_and_the_last_picture_stays(self) -> None:
        obj = self.handled(SQUARE, [(0, 1, 2, 3)])
        obj.shape_key_add(name="Basis")
        torn = obj.shape_key_add(name="Torn")
        torn.data[1].co.x = 0.5
        torn.value = 1.0
        sleeve.at(2)
        before = runtimes.of(obj).result
        torn.data[2].co.y = math.nan
        sleeve.at(3)
        self.assertRegex(obj.rumple.message, "^Rag: vertex 2 has no valid position in this frame .*: look at the shape")
        self.assertIs(runtimes.of(obj).result, before)
        torn.data[2].co.y = 1.0
        sleeve.at(4)
        self.assertEqual(obj.rumple.message, "")

    def hang(self) -> bpy.types.Object:
        """A sleeve of cloth."""
        obj = sleeve.scene(wrinkles=False)
        settings = getattr(obj.rumple, self.method.lower())
        settings.base_cloth = "HANG"
        sleeve.make_active(obj)
        bpy.ops.object.rumple_add(method=self.method)
        sleeve.at(2)
        return obj

    def told(self, obj: bpy.types.Object, words: str) -> None:
        bpy.context.view_layer.update()
        scheduler.sync_all()
        sleeve.at(3)
        self.assertRegex(obj.rumple.message, words)

    def test_painted_values_that_cannot_be_are_named(self) -> None:
        for value in (math.nan, -5.0):
            obj = self.hang()
            painted = obj.data.attributes.new("Rumple Follow", "FLOAT", "POINT")
            painted.data.foreach_set("value", np.full(len(obj.data.vertices), value, np.float32))
            obj.data.update()
            self.told(obj, f"^Sleeve: what is painted as follow holds {value:g}, where 0 to 1 is possible: paint it")

    def test_what_is_far_away_at_rest_is_named(self) -> None:
        obj = self.hang()
        obj.data.vertices[5].co.x = 1e12
        obj.data.update()
        self.told(obj, r"^Sleeve: vertex 5 is 1e\+12 away from the origin at rest: move the mesh to the origin")

    def test_lengths_that_a_scale_makes_extreme_are_named(self) -> None:
        obj = self.hang()
        obj.scale = (1e-12,) * 3
        bpy.data.objects["Arm"].scale = (1e-12,) * 3
        self.told(obj, r"^Sleeve: \w+ is \S+ in units of the object, where \S+ to \S+ is possible: look at the object")

    def test_a_garment_of_thousands_of_kilometres_is_refused_without_names_of_the_solver(self) -> None:
        """'stretch is 1.1e+15 in units of the object: look at that setting': the panel has no such setting."""
        obj = self.hang()
        obj.data.transform(Matrix.Scale(1e7, 4))
        obj.data.update()
        self.told(obj, "^Sleeve: its size in metres is too small or too large for cloth: look at the object's scale")

    def test_a_guide_with_a_point_that_is_nowhere_is_named(self) -> None:
        """It was told that NaN is no integer."""
        obj = self.hang()
        bpy.ops.object.rumple_guide_add()
        guide = guide_curves.of(obj)[0]
        guide.data.splines[0].bezier_points[0].co.x = math.nan
        self.told(obj, f'^Sleeve: the guide "{guide.name}" has a point without a valid place: delete that point')


class BadInputOfMesh(BadInput, unittest.TestCase):
    method = "MESH"

    def test_an_own_mesh_far_away_names_its_vertex_and_keeps_the_last_mesh(self) -> None:
        obj = self.handled(SQUARE, [(0, 1, 2, 3)])
        count = len(sleeve.shown(obj))
        far = bpy.data.objects.new("Far", obj.data.copy())
        far.location.x = 50.0
        bpy.context.scene.collection.objects.link(far)
        bpy.context.view_layer.update()
        obj.rumple.own_mesh = far
        obj.rumple.mesh.source = "OBJECT"
        sleeve.at(2)
        self.assertRegex(obj.rumple.message, r"^Rag: vertex \d+ of the own mesh")
        self.assertEqual(len(sleeve.shown(obj)), count)


class BadInputOfField(BadInput, unittest.TestCase):
    method = "FIELD"


class BadInputOfPaths(BadInput, unittest.TestCase):
    method = "PATHS"


if __name__ == "__main__":
    unittest.main()
