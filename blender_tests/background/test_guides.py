# SPDX-License-Identifier: GPL-3.0-or-later
"""Guides in Blender: curves on a garment, and its seams, become folds; in the viewport, in bakes and in new files."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path

import bpy
import numpy as np
from rumple.blender import scheduler
from rumple.blender.frame import clip_status
from rumple.blender.objects import guide_curves, modifier
from support import sleeve


def folded(method: str = "MESH") -> bpy.types.Object:
    """The sleeve with one of the systems as geometry, at rest."""
    obj = sleeve.scene(wrinkles=False)
    obj.rumple.field.output = "GEOMETRY"
    obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 2, 0
    bpy.ops.object.rumple_add(method=method)
    sleeve.at(1)
    return obj


def line(*points: tuple[float, float, float]) -> bpy.types.Object:
    """A selected curve in the scene."""
    data = bpy.data.curves.new("Line", "CURVE")
    data.dimensions = "3D"
    spline = data.splines.new("POLY")
    spline.points.add(len(points) - 1)
    for point, place in zip(spline.points, points):
        point.co = (*place, 1.0)
    obj = bpy.data.objects.new("Line", data)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    obj.select_set(True)
    return obj


def guided(obj: bpy.types.Object) -> bpy.types.Object:
    curve = line((0.1, 0.0, sleeve.RADIUS), (0.5, 0.0, sleeve.RADIUS))
    bpy.ops.object.rumple_guide_add()
    curve.rumple_guide.count, curve.rumple_guide.spacing, curve.rumple_guide.depth = 2, 0.05, 0.01
    update()
    return curve


def update() -> None:
    sleeve.at(2)
    sleeve.at(1)


def settle(obj: bpy.types.Object) -> None:
    """What is painted was read."""
    obj.data.update_tag()
    scheduler.sync_all()
    update()


class Guides(unittest.TestCase):
    def test_a_selected_curve_becomes_a_guide_in_every_system(self) -> None:
        for method in ("MESH", "FIELD", "PATHS"):
            with self.subTest(method):
                obj = folded(method)
                bare = sleeve.shown(obj).copy()
                curve = guided(obj)
                self.assertEqual(curve.parent, obj)
                moved = np.linalg.norm(sleeve.shown(obj) - bare, axis=1)
                self.assertAlmostEqual(moved.max(), 0.01, delta=0.001)
                self.assertLess(np.percentile(moved[bare[:, 2] < -0.02], 99), 1e-4)

    def test_a_direction_turns_the_folds_of_motion_in_every_system(self) -> None:
        """Also waves in shading, which have no shape."""
        for method, output in (("MESH", "GEOMETRY"), ("FIELD", "GEOMETRY"), ("FIELD", "SHADING"),
                               ("PATHS", "GEOMETRY")):
            with self.subTest(f"{method} {output}"):
                obj = folded(method)
                obj.rumple.field.output = output
                obj.rumple.paths.width, obj.rumple.paths.threshold = 0.04, 1.05
                scheduler.sync_all()
                name = {"MESH": "rumple_offset", "FIELD": "rumple_direction", "PATHS": "rumple_height"}[method]

                def played() -> np.ndarray:
                    for frame in range(1, 9):
                        sleeve.at(frame)
                    return sleeve.attribute(obj, name).copy()

                bare = played()
                curve = line((0.1, 0.0, sleeve.RADIUS), (0.5, 0.03, sleeve.RADIUS))
                bpy.ops.object.rumple_guide_add()
                curve.rumple_guide.reach, curve.rumple_guide.kind = 0.3, "DIRECTION"
                self.assertGreater(np.abs(played() - bare).max(), 1e-3)
                curve.rumple_guide.others = 1.0
                np.testing.assert_array_equal(played(), bare)

    def test_widths_that_are_painted_make_a_finer_mesh_once(self) -> None:
        for method, group in (("MESH", "mesh"), ("PATHS", "paths")):
            with self.subTest(method):
                obj = sleeve.scene(wrinkles=False)
                obj.rumple.mesh.layers = "CLOTH"
                bpy.ops.object.rumple_add(method=method)
                getattr(obj.rumple, group).base_cloth = "OFF"
                sleeve.at(1)
                before = len(sleeve.shown(obj))
                painted = obj.vertex_groups.new(name="Rumple Wavelength")
                painted.add(range(len(obj.data.vertices)), 1.0, "REPLACE")
                settle(obj)
                self.assertEqual(len(sleeve.shown(obj)), before)
                painted.add(range(20), 0.8, "REPLACE")
                settle(obj)
                finer = len(sleeve.shown(obj))
                self.assertGreater(finer, 2 * before)
                painted.add(range(20), 0.3, "REPLACE")
                settle(obj)
                self.assertEqual(len(sleeve.shown(obj)), finer)
                obj.vertex_groups.remove(painted)
                settle(obj)
                self.assertEqual(len(sleeve.shown(obj)), before)

    def test_edits_of_the_curve_count_and_removing_it_takes_the_folds_back(self) -> None:
        obj = folded()
        bare = sleeve.shown(obj).copy()
        curve = guided(obj)
        before = sleeve.shown(obj).copy()
        for point in curve.data.splines[0].points:
            point.co.x += 0.02
        curve.data.update_tag()
        update()
        self.assertGreater(np.abs(sleeve.shown(obj) - before).max(), 0.002)
        before = sleeve.shown(obj).copy()
        curve.location.x += 0.02
        update()
        self.assertGreater(np.abs(sleeve.shown(obj) - before).max(), 0.002)
        self.assertEqual(bpy.ops.object.rumple_guide_remove(name=curve.name), {"FINISHED"})
        update()
        np.testing.assert_allclose(sleeve.shown(obj), bare, atol=1e-6)

    def test_a_guide_that_was_deleted_is_gone(self) -> None:
        obj = folded()
        bare = sleeve.shown(obj).copy()
        bpy.data.objects.remove(guided(obj))
        bpy.context.view_layer.update()
        update()
        np.testing.assert_allclose(sleeve.shown(obj), bare, atol=1e-6)

    def test_where_the_garment_stands_does_not_count(self) -> None:
        obj = folded()
        guided(obj)
        before = sleeve.shown(obj).copy()
        obj.location, obj.rotation_euler = (3.0, -2.0, 1.0), (0.0, 0.0, 1.0)
        update()
        np.testing.assert_allclose(sleeve.shown(obj), before, atol=1e-6)

    def test_they_are_scaled_with_the_skeleton(self) -> None:
        """They lay at the size at rest, beside the garment."""
        shown = []
        for by_bone in (False, True):
            obj = folded()
            guided(obj)
            rig = bpy.data.objects["Arm"]
            for scaled in (rig.pose.bones["upper"],) if by_bone else (rig, obj):
                scaled.scale = (2.0, 2.0, 2.0)
            for _ in range(2):
                bpy.context.view_layer.update()
            settle(obj)
            shown.append(sleeve.shown(obj) * obj.scale.x)
        self.assertGreater(np.abs(np.linalg.norm(shown[0][:, 1:], axis=1) - 2.0 * sleeve.RADIUS).max(), 0.005)
        np.testing.assert_allclose(*shown, atol=1e-5)

    def test_seams_pucker(self) -> None:
        obj = folded()
        bare = sleeve.shown(obj).copy()
        for edge in obj.data.edges:
            edge.use_seam = all(vertex // sleeve.AROUND == 5 for vertex in edge.vertices)
        obj.data.update_tag()
        obj.rumple_guide.seam_depth, obj.rumple_guide.seam_spacing = 0.004, 0.05
        scheduler.sync_all()
        update()
        moved = np.linalg.norm(sleeve.shown(obj) - bare, axis=1)
        self.assertAlmostEqual(moved.max(), 0.004, delta=0.0006)
        middle = sleeve.LENGTH * 5 / (sleeve.ALONG - 1)
        self.assertLess(np.percentile(moved[np.abs(bare[:, 0] - middle) > 0.06], 99), 1e-5)

    def test_seams_are_found_as_lines_and_rings(self) -> None:
        mesh = sleeve.tube()
        for edge in mesh.edges:
            ring = all(vertex // sleeve.AROUND == 5 for vertex in edge.vertices)
            edge.use_seam = ring or all(vertex % sleeve.AROUND == 0 and vertex // sleeve.AROUND < 4
                                        for vertex in edge.vertices)
        chains = sorted(guide_curves._seams(mesh), key=len)  # pylint: disable=protected-access
        self.assertEqual([len(chain) for chain in chains], [4, sleeve.AROUND + 1])
        self.assertEqual(chains[1][0], chains[1][-1])

    def test_a_new_curve_lies_on_the_garment(self) -> None:
        obj = folded()
        bpy.context.scene.cursor.location = (0.3, 0.0, 0.2)
        self.assertEqual(bpy.ops.object.rumple_guide_add(), {"FINISHED"})
        curve, = guide_curves.of(obj)
        for point in curve.data.splines[0].bezier_points:
            self.assertLess(abs(np.hypot(point.co.y, point.co.z) - sleeve.RADIUS), 0.005)

    def test_without_a_rest_shape_none_is_made_and_it_is_said(self) -> None:
        obj = folded()
        obj.rumple.mesh.rest_shape = "FRAME"
        with self.assertRaises(RuntimeError) as caught:  # how bpy.ops hands on a refusal
            bpy.ops.object.rumple_guide_add()
        self.assertIn("no rest shape is captured yet", str(caught.exception))
        self.assertNotIn("Traceback", str(caught.exception))

    def test_where_there_are_no_faces_none_is_made_and_it_is_said(self) -> None:
        """A new curve lies on the garment: of none there was an exception that nobody caught."""
        obj = folded()
        obj.data.clear_geometry()
        bpy.context.view_layer.update()
        with self.assertRaisesRegex(RuntimeError, "Error: Sleeve: its mesh has no faces: add some"):
            bpy.ops.object.rumple_guide_add()
        self.assertEqual(guide_curves.of(obj), [])

    def test_they_come_back_with_the_file(self) -> None:
        obj = folded()
        guided(obj)
        shown = sleeve.shown(obj).copy()
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "guides.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
            update()
            np.testing.assert_allclose(sleeve.shown(bpy.data.objects["Sleeve"]), shown, atol=1e-6)

    def test_a_bake_has_them_and_knows_when_they_change(self) -> None:
        obj = folded()
        curve = guided(obj)
        live = sleeve.shown(obj).copy()
        scene = bpy.context.scene
        before = clip_status.inputs_fingerprint(obj, scene)
        with tempfile.TemporaryDirectory() as folder:
            obj.rumple.bake_folder = folder
            obj.rumple.bake_start, obj.rumple.bake_end = 1, 3
            bpy.ops.object.rumple_bake()
            self.assertTrue(modifier.is_baked(modifier.find(obj)))
            sleeve.at(2)
            sleeve.at(1)
            np.testing.assert_allclose(sleeve.shown(obj), live, atol=1e-5)
            curve.rumple_guide.depth = 0.02
            self.assertNotEqual(clip_status.inputs_fingerprint(obj, scene), before)


if __name__ == "__main__":
    unittest.main()
