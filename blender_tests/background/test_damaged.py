# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo's garments, broken in ways in which garments of other makers arrive: one click in each system, played,
rendered. blender_tests/real has eleven ways, on garments of S1 to S3."""
from __future__ import annotations

import sys
import unittest
from pathlib import Path
from unittest import mock

import bpy
from rumple.blender.objects import modifier
from support import damage, sleeve
from support.damaged_case import Damaged

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"


class DemoDamaged(Damaged):
    name: str
    frames = range(40, 47)

    @classmethod
    def opened(cls) -> bpy.types.Object:
        if str(SCRIPTS) not in sys.path:
            sys.path.insert(0, str(SCRIPTS))
        import demo_scene
        build = demo_scene.demo_body.build_body
        sleeve.empty_file()
        with mock.patch.object(demo_scene.demo_body, "build_body", lambda _spacing: build(0.02)):
            demo_scene.build_demo_scene()
        return bpy.data.objects[cls.name]


class TornTrousers(DemoDamaged, unittest.TestCase):
    name, way = "Trousers", damage.everything


class ShirtOfNgons(DemoDamaged, unittest.TestCase):
    name, way, method = "Shirt", damage.ngons, "FIELD"


class TurnedTrousers(DemoDamaged, unittest.TestCase):
    name, way, method = "Trousers", damage.turned, "PATHS"


class NotFinite(unittest.TestCase):
    def test_points_that_are_nowhere_are_named_and_what_was_mended_is_a_garment(self) -> None:
        TornTrousers.opened()
        obj = bpy.data.objects["Trousers"]
        bpy.context.view_layer.objects.active = obj
        places = {vertex: obj.data.vertices[vertex].co.y for vertex in (7, 300)}
        for vertex in places:
            obj.data.vertices[vertex].co.y = float("nan")
        with self.assertRaisesRegex(RuntimeError, r"Trousers: .*vertex 7\b"):
            bpy.ops.object.rumple_add(method="MESH")
        self.assertIsNone(modifier.find(obj))
        for vertex, place in places.items():
            obj.data.vertices[vertex].co.y = place
        obj.data.update()
        self.assertEqual(bpy.ops.object.rumple_add(method="MESH"), {"FINISHED"})
        self.assertEqual(obj.rumple.message, "")


if __name__ == "__main__":
    unittest.main()
