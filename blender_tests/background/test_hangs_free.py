# SPDX-License-Identifier: GPL-3.0-or-later
"""The first click paints where a garment hangs free of the body."""
from __future__ import annotations

import unittest

import bmesh
import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.objects import mesh_reader, painted_maps
from rumple.core.hangs_free import FREE
from support import sleeve

WIDE = 0.16  # metres that the middle of the sleeve is wider
GROUP = mesh_reader.MESH_GROUPS[FREE]


class HangsFree(unittest.TestCase):
    def setUp(self) -> None:
        self.obj = sleeve.scene(wrinkles=False)
        for settings in (self.obj.rumple.mesh, self.obj.rumple.field, self.obj.rumple.paths):  # the click says
            settings.property_unset("base_cloth")
        sleeve.under(self.obj, "Human")

    def widen(self) -> np.ndarray:
        """A balloon sleeve. (n,) bool: the vertices in its middle."""
        rest = compat.positions(self.obj.data)
        bulge = np.sin(np.pi * np.clip(rest[:, 0] / sleeve.LENGTH, 0.0, 1.0)) ** 2
        rest[:, 1:] *= 1.0 + WIDE / sleeve.RADIUS * bulge[:, None]
        self.obj.data.vertices.foreach_set("co", rest.ravel())
        self.obj.data.update()
        return bulge > 0.9

    def click(self, method: str = "MESH") -> np.ndarray:
        """(n,) weights of the map; empty without one."""
        sleeve.make_active(self.obj)
        bpy.ops.object.rumple_add(method=method)
        if GROUP not in self.obj.vertex_groups:
            return np.zeros(0, np.float32)
        return mesh_reader.group_weights(self.obj, self.obj.data, [GROUP])[:, 0]

    def test_a_balloon_sleeve_hangs_free_in_its_middle_and_is_worn_at_its_cuffs(self) -> None:
        middle = self.widen()
        for method in ("MESH", "FIELD", "PATHS"):
            with self.subTest(method):
                weights = self.click(method)
                self.assertGreater(weights[middle].min(), 0.9)
                self.assertLess(weights[[0, -1]].max(), 0.25)  # a ring of vertices is far from the next
                settings = getattr(self.obj.rumple, method.lower())
                self.assertAlmostEqual(settings.free_room, 0.25, places=2)
                sleeve.at(4)
                bpy.ops.object.rumple_remove()
                self.obj.vertex_groups.remove(self.obj.vertex_groups[GROUP])

    def test_it_is_found_where_faces_look_inwards_and_in_centimetres(self) -> None:
        middle = self.widen()
        self.obj.data.flip_normals()
        scene = bpy.context.scene
        scene.unit_settings.scale_length = 0.01
        for obj in (self.obj, bpy.data.objects["Human"], bpy.data.objects["Arm"]):
            if obj.parent is None:
                obj.scale = (100.0, 100.0, 100.0)
        bpy.context.view_layer.update()
        weights = self.click()
        self.assertGreater(weights[middle].min(), 0.9)

    def test_a_plain_sleeve_has_no_map(self) -> None:
        self.assertEqual(len(self.click()), 0)

    def test_without_a_body_nothing_is_known(self) -> None:
        self.widen()
        bpy.data.objects.remove(bpy.data.objects["Human"])
        self.assertEqual(len(self.click()), 0)

    def test_where_the_body_was_deleted_nothing_is_known(self) -> None:
        # The edge of a hole was the nearest: the front of a sweater hung free of the waistband of the trousers.
        self.widen()
        body = bmesh.new()
        body.from_mesh(bpy.data.objects["Human"].data)
        bmesh.ops.delete(body, geom=[v for v in body.verts if 0.1 < v.co.x < sleeve.LENGTH - 0.1], context="VERTS")
        body.to_mesh(bpy.data.objects["Human"].data)
        self.assertEqual(len(self.click()), 0)

    def test_what_was_painted_stays(self) -> None:
        self.widen()
        self.obj.vertex_groups.new(name=GROUP).add([3], 0.25, "REPLACE")
        weights = self.click()
        self.assertEqual((weights[3], np.count_nonzero(weights)), (0.25, 1))

    def test_the_map_is_among_those_that_are_painted(self) -> None:
        self.widen()
        self.click()
        found = {one.key: one for one in painted_maps.of(self.obj)}
        self.assertTrue(found[FREE].exists)
        self.assertEqual((found[FREE].label, found[FREE].rest), ("Hangs Free", 0.0))
