# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigid, painted on a garment in Blender: live, in renders' meshes, baked, in every system."""
from __future__ import annotations

import os
import tempfile
import unittest

import bpy
import numpy as np
from rumple.blender.frame import clip_status
from rumple.blender.objects import mesh_reader, runtimes
from support import sleeve

GROUP = "Rumple Rigid"
RINGS = (5, 6, 7)  # of the tube, over the elbow


def folded(method: str, cloth: bool = False) -> bpy.types.Object:
    """The sleeve, bent, with one of the systems as geometry."""
    obj = sleeve.scene(wrinkles=False)
    obj.rumple.field.output = "GEOMETRY"
    obj.rumple.mesh.density, obj.rumple.mesh.level = "LEVEL", 1
    for settings in (obj.rumple.mesh, obj.rumple.field, obj.rumple.paths):
        settings.base_cloth = "HANG" if cloth else "OFF"
    bpy.ops.object.rumple_add(method=method)
    return obj


def paint(obj: bpy.types.Object, *rings: int) -> None:
    """Weight 1 on the upper half of these rings."""
    if GROUP not in obj.vertex_groups:
        assert bpy.ops.object.rumple_paint(group="rigid") == {"FINISHED"}
    vertices = [vertex.index for vertex in obj.data.vertices
                if vertex.index // sleeve.AROUND in rings and vertex.index % sleeve.AROUND < sleeve.AROUND // 2]
    obj.vertex_groups[GROUP].add(vertices, 1.0, "REPLACE")
    obj.update_tag()


def flat(obj: bpy.types.Object, animated: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of the shown points those on faces that are painted all over: bool, and the places of all on the coarse mesh."""
    held = sleeve.output_object(obj)
    weights = mesh_reader.group_weights(obj, obj.data, [GROUP])[:, 0]
    mesh = runtimes.of(obj).evaluator.in_viewport or runtimes.of(obj).evaluator
    share = np.column_stack([1.0 - mesh.barycentric.sum(1), mesh.barycentric])
    assert held is not None
    return (weights[mesh.triangle_vertex] == 1.0).all(1), (share[:, :, None] * animated[mesh.triangle_vertex]).sum(1)


def animated(obj: bpy.types.Object) -> np.ndarray:
    """As the armature alone has it."""
    obj.modifiers[-1].show_viewport = False
    bpy.context.view_layer.update()
    found = sleeve.shown(obj)
    obj.modifiers[-1].show_viewport = True
    bpy.context.view_layer.update()
    return found


class PaintedRigid(unittest.TestCase):
    def test_the_brush_begins_with_cloth_and_makes_it_rigid(self) -> None:
        for method in ("MESH", "FIELD", "PATHS"):
            with self.subTest(method):
                obj = folded(method)
                sleeve.play(1, 15)
                before = sleeve.shown(obj)
                self.assertEqual(bpy.ops.object.rumple_paint(group="rigid"), {"FINISHED"})
                self.assertEqual(mesh_reader.group_weights(obj, obj.data, [GROUP]).max(), 0.0)
                sleeve.play(1, 15)
                np.testing.assert_allclose(sleeve.shown(obj), before, atol=1e-6)
                paint(obj, *RINGS)
                sleeve.play(1, 15)
                found = sleeve.shown(obj)
                inside, places = flat(obj, animated(obj))
                self.assertGreater(int(inside.sum()), 20)
                self.assertLess(np.abs(found - places)[inside].max(), 2e-6)
                self.assertGreater(np.abs(found - before).max(), 1e-4)
                self.assertEqual(obj.rumple.message, "")

    def test_on_cloth_it_moves_as_one(self) -> None:
        for method in ("MESH", "FIELD", "PATHS"):
            with self.subTest(method):
                obj = folded(method, cloth=True)
                paint(obj, *RINGS)
                sleeve.play(1, 15)
                found = sleeve.shown(obj)
                inside, places = flat(obj, animated(obj))
                x, y = found[inside].astype(np.float64), places[inside].astype(np.float64)
                np.testing.assert_allclose(np.linalg.norm(x[:, None] - x, axis=2),
                                           np.linalg.norm(y[:, None] - y, axis=2), atol=5e-6)
                self.assertGreater(np.abs(x - y).max(), 1e-4)

    def test_a_frame_is_the_same_whatever_was_looked_at(self) -> None:
        obj = folded("MESH", cloth=True)
        paint(obj, *RINGS)
        sleeve.play(1, 12)
        played = sleeve.shown(obj)
        for frame in (3, 12, 7, 12):
            sleeve.at(frame)
        np.testing.assert_array_equal(sleeve.shown(obj), played)

    def test_a_bake_plays_it_and_knows_when_it_changes(self) -> None:
        obj = folded("MESH", cloth=True)
        paint(obj, *RINGS)
        sleeve.play(1, 8)
        live = sleeve.shown(obj)
        before = clip_status.inputs_fingerprint(obj, bpy.context.scene)
        with tempfile.TemporaryDirectory() as folder:
            bpy.context.scene.frame_end = 8
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "sleeve.blend"))
            obj = bpy.data.objects["Sleeve"]
            sleeve.make_active(obj)
            self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
            sleeve.at(8)
            baked = sleeve.shown(obj)
            if len(baked) == len(live):
                np.testing.assert_allclose(baked, live, atol=2e-6)
        paint(obj, 9)
        self.assertNotEqual(clip_status.inputs_fingerprint(obj, bpy.context.scene), before)

    def test_a_loose_part_that_is_painted_all_over_is_as_it_was_modelled(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        mesh = obj.data
        count = len(mesh.vertices)
        quads = [tuple(polygon.vertices) for polygon in mesh.polygons]
        points = [tuple(vertex.co) for vertex in mesh.vertices]
        belt = [index for index in range(count) if index // sleeve.AROUND in (2, 3)]
        points += [(mesh.vertices[i].co.x, 1.3 * mesh.vertices[i].co.y, 1.3 * mesh.vertices[i].co.z) for i in belt]
        around = sleeve.AROUND
        quads += [(count + i, count + (i + 1) % around, count + around + (i + 1) % around, count + around + i)
                  for i in range(around)]
        bpy.data.objects.remove(obj)
        mesh.clear_geometry()
        mesh.from_pydata(points, [], quads)
        obj = sleeve.skinned(mesh, bpy.data.objects["Arm"])
        sleeve.make_active(obj)
        obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 1, 0
        bpy.ops.object.rumple_add(method="MESH")
        sleeve.at(1)
        cloth = len(sleeve.shown(obj))
        self.assertEqual(bpy.ops.object.rumple_paint(group="rigid"), {"FINISHED"})
        obj.vertex_groups[GROUP].add(range(count, len(points)), 1.0, "REPLACE")
        obj.update_tag()
        obj.data.update_tag()
        bpy.context.view_layer.update()
        sleeve.at(2)
        sleeve.at(1)
        self.assertEqual(obj.rumple.message, "")
        found = sleeve.shown(obj)
        self.assertLess(len(found), cloth)
        np.testing.assert_allclose(found[-2 * around:], np.array(points[count:], np.float32), atol=1e-5)


if __name__ == "__main__":
    unittest.main()
