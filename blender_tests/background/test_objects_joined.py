# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects with wrinkles that are joined (Ctrl J), cut and separated keep their rest shapes and paint."""
from __future__ import annotations

import math
import os
import tempfile
import unittest

import bpy
import numpy as np
from rumple.blender.objects import mesh_reader, modifier, runtimes
from support import sleeve

HIGHER = 0.5    # the second sleeve, in metres
FRAME = 10


def sides(positions: np.ndarray, mesh: bpy.types.Mesh) -> np.ndarray:
    """Lengths of edges: what folds go by."""
    pairs = np.array([edge.vertices for edge in mesh.edges])
    return np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1)


class Joined(unittest.TestCase):
    def setUp(self) -> None:
        self.obj = sleeve.scene()
        self.other = sleeve.another("Other")
        self.other.location.z = HIGHER
        self.count = len(self.obj.data.vertices)

    def capture(self, *objects: bpy.types.Object) -> None:
        for obj in objects:
            sleeve.make_active(obj)
            bpy.ops.object.rumple_capture_rest(frame=FRAME)
            sleeve.at(FRAME)

    def join(self) -> None:
        sleeve.make_active(self.obj)
        self.other.select_set(True)
        bpy.ops.object.join()
        sleeve.at(FRAME + 1)
        sleeve.at(FRAME)

    def rest(self) -> np.ndarray:
        return mesh_reader.rest_positions(self.obj, self.obj.rumple.mesh.rest_shape, "")

    def test_what_was_not_captured_rests_as_it_is_modelled(self) -> None:
        """Its rest shape was a single point: it had no folds, and the panel named edges of zero length."""
        expected = mesh_reader.basis_positions(self.other.data) + (0.0, 0.0, HIGHER)
        self.capture(self.obj)
        before = self.rest()
        self.join()
        np.testing.assert_array_equal(self.rest()[:self.count], before)
        np.testing.assert_allclose(self.rest()[self.count:], expected, atol=1e-6)
        self.assertEqual(runtimes.of(self.obj).notes, [])
        self.assertLess(sleeve.attribute(self.obj, "rumple_stretch_min").min(), 0.8)
        self.assertGreater(sleeve.attribute(self.obj, "rumple_stretch_min").min(), 0.5)

    def test_both_keep_what_was_captured(self) -> None:
        for turn, scale in ((0.0, 1.0), (1.0, 1.0), (0.0, 2.0)):
            with self.subTest(turn=turn, scale=scale):
                self.setUp()
                self.other.rotation_euler.x, self.other.scale = turn, (scale, scale, scale)
                self.capture(self.obj, self.other)
                before = self.rest()
                other = scale * sides(mesh_reader.rest_positions(self.other, "FRAME", ""), self.other.data)
                self.join()
                np.testing.assert_array_equal(self.rest()[:self.count], before)
                after = sides(self.rest(), self.obj.data)
                np.testing.assert_allclose(np.sort(after[len(after) // 2:]), np.sort(other), rtol=1e-4)
                self.assertAlmostEqual(sleeve.attribute(self.obj, "rumple_stretch_min").min(), 1.0, places=3)

    def test_what_was_baked_shows_live_folds(self) -> None:
        """It showed the bare mesh until it was baked again."""
        with tempfile.TemporaryDirectory() as folder:
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "joined.blend"))
            sleeve.make_active(self.obj)
            self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
            self.join()
            self.assertRegex(self.obj.rumple.message, "384 vertices, 192 were baked, so live folds are shown")
            found = sleeve.shown(self.obj)
            self.assertGreater(len(found), len(self.obj.data.vertices))
            bpy.ops.object.rumple_bake_free()
            sleeve.at(FRAME + 1)
            sleeve.at(FRAME)
            np.testing.assert_array_equal(sleeve.shown(self.obj), found)

    def test_a_larger_one_that_is_joined_moves_no_rest_shape(self) -> None:
        """One map had moved most vertices, and was taken for all."""
        self.other.data = self.obj.data.copy()
        sleeve.make_active(self.other)
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.mesh.subdivide()
        bpy.ops.object.mode_set(mode="OBJECT")
        self.other.scale = 2.0, 2.0, 2.0
        sleeve.at(FRAME)
        self.capture(self.obj, self.other)
        before = self.rest()
        self.join()
        np.testing.assert_array_equal(self.rest()[:self.count], before)

    def test_a_part_that_is_added_in_edit_mode(self) -> None:
        self.capture(self.obj)
        sleeve.make_active(self.obj)
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.primitive_cylinder_add(radius=0.05, depth=0.5, location=(0.0, 0.0, 0.5), end_fill_type="NOTHING")
        bpy.ops.object.mode_set(mode="OBJECT")
        sleeve.at(FRAME)
        np.testing.assert_array_equal(self.rest()[self.count:],
                                      mesh_reader.basis_positions(self.obj.data)[self.count:])
        self.assertEqual(runtimes.of(self.obj).notes, [])

    def test_a_rotation_is_applied_to_both_parts_alike(self) -> None:
        self.capture(self.obj, self.other)
        self.join()
        before = self.rest()
        self.obj.rotation_euler.x = math.pi / 2.0
        bpy.ops.object.transform_apply(location=False, rotation=True, scale=False)
        sleeve.at(FRAME)
        np.testing.assert_allclose(self.rest(), before[:, [0, 2, 1]] * (1.0, -1.0, 1.0), atol=1e-5)

    def test_paint_goes_along_and_each_half_keeps_it(self) -> None:
        self.other.vertex_groups.new(name="Rumple Radius").add(range(self.count), 0.25, "REPLACE")
        self.join()
        painted = runtimes.of(self.obj).paint.values["radius"]
        np.testing.assert_allclose(painted, np.repeat((0.0, 0.25), self.count))
        bpy.ops.mesh.separate(type="LOOSE")
        sleeve.at(FRAME)
        halves = [obj for obj in bpy.context.scene.objects if modifier.find(obj) is not None]
        self.assertEqual(sorted(float(runtimes.of(half).paint.values["radius"].mean()) for half in halves), [0.0, 0.25])
        self.assertEqual(len({modifier.output_object(modifier.find(half)) for half in halves}), 2)


if __name__ == "__main__":
    unittest.main()
