# SPDX-License-Identifier: GPL-3.0-or-later
"""Keep Smooth, painted on a garment in Blender."""
from __future__ import annotations

import unittest

import bpy
import numpy as np
from rumple.blender.frame import clip_status
from rumple.blender.objects import mesh_reader
from support import sleeve

GROUP = "Rumple Keep Smooth"


def folded(method: str) -> bpy.types.Object:
    """The sleeve, bent, with one of the systems as geometry."""
    obj = sleeve.scene(wrinkles=False)
    obj.rumple.field.output = "GEOMETRY"
    obj.rumple.mesh.density, obj.rumple.mesh.level = "LEVEL", 1
    bpy.ops.object.rumple_add(method=method)
    sleeve.play()
    return obj


class KeepSmooth(unittest.TestCase):
    def test_the_brush_begins_with_all_folds_and_takes_them_away(self) -> None:
        for method in ("MESH", "FIELD", "PATHS"):
            with self.subTest(method):
                obj = folded(method)
                before = sleeve.shown(obj).copy()
                self.assertGreater(np.linalg.norm(sleeve.attribute(obj, "rumple_offset"), axis=1).max(), 1e-4)
                self.assertEqual(bpy.ops.object.rumple_paint(group="smooth"), {"FINISHED"})
                weights = mesh_reader.group_weights(obj, obj.data, [GROUP])
                self.assertEqual(weights.max(), 0.0)
                self.assertTrue(all(vertex.groups for vertex in obj.data.vertices))
                sleeve.play()
                np.testing.assert_allclose(sleeve.shown(obj), before, atol=1e-6)
                obj.vertex_groups[GROUP].add(range(len(obj.data.vertices)), 1.0, "REPLACE")
                obj.update_tag()
                sleeve.play()
                self.assertLess(np.linalg.norm(sleeve.attribute(obj, "rumple_offset"), axis=1).max(), 1e-6)

    def test_a_bake_knows_when_it_changes(self) -> None:
        obj = folded("MESH")
        bpy.ops.object.rumple_paint(group="smooth")
        before = clip_status.inputs_fingerprint(obj, bpy.context.scene)
        obj.vertex_groups[GROUP].add(range(len(obj.data.vertices)), 1.0, "REPLACE")
        self.assertNotEqual(clip_status.inputs_fingerprint(obj, bpy.context.scene), before)


if __name__ == "__main__":
    unittest.main()
