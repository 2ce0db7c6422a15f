# SPDX-License-Identifier: GPL-3.0-or-later
"""Rest shapes that adapt, on the sleeve: every system, in any order, baked, saved and opened again."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path

import bpy
import numpy as np
import sleeve
from rumple.blender import properties, structure

METHODS = ("MESH", "FIELD")


def adapting(method: str, start: int = 1, **settings: object) -> bpy.types.Object:
    """The sleeve with wrinkles measured against what lasts."""
    obj = sleeve.scene(wrinkles=False)
    bpy.context.scene.frame_start = start
    if method == "MESH":
        obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 1, 0
    else:
        obj.rumple.field.output = "GEOMETRY"
    with sleeve.context():
        bpy.ops.object.rumple_add(method=method)
    for name, value in {"rest_shape": "ADAPTIVE", **settings}.items():
        setattr(properties.group_of(obj), name, value)
    structure.settle_all()
    return obj


def folds(obj: bpy.types.Object) -> float:
    return float(np.sqrt((sleeve.attribute(obj, "rumple_offset")**2).sum(1)).max())


def mean_fold(obj: bpy.types.Object) -> float:
    return float(np.sqrt((sleeve.attribute(obj, "rumple_offset")**2).sum(1)).mean())


class Adaptive(unittest.TestCase):
    def test_played_frames_come_back_to_the_bit(self) -> None:
        for method in METHODS:
            with self.subTest(method):
                obj = adapting(method)
                played = {}
                for frame in range(1, sleeve.LAST + 1):
                    sleeve.at(frame)
                    played[frame] = sleeve.shown(obj)
                self.assertEqual(obj.rumple.message, "")
                for frame in (7, 2, 20, 11):
                    sleeve.at(frame)
                    np.testing.assert_array_equal(sleeve.shown(obj), played[frame])

    def test_the_first_frame_is_unwrinkled_however_it_is_bent(self) -> None:
        for method in METHODS:
            with self.subTest(method):
                obj = adapting(method, start=sleeve.LAST)
                sleeve.at(sleeve.LAST)
                from_rest = folds(obj)
                properties.group_of(obj).reference = "FIRST_FRAME"
                sleeve.at(sleeve.LAST)
                self.assertLess(folds(obj), 1e-3 * from_rest)
                self.assertEqual(obj.rumple.message, "")

    def test_what_lasts_is_given_in_to(self) -> None:
        for method in METHODS:
            with self.subTest(method):
                obj = adapting(method, relaxation=0.2)
                sleeve.play()
                given_in = mean_fold(obj)
                properties.group_of(obj).rest_shape = "REST_POSE"
                structure.settle_all()
                sleeve.play()
                self.assertLess(given_in, 0.9 * mean_fold(obj))

    def test_independent_frames_are_those_of_the_rest_pose(self) -> None:
        for method in METHODS:
            with self.subTest(method):
                obj = adapting(method, reference="FIRST_FRAME", stateless=True)
                sleeve.at(20)
                alone = sleeve.shown(obj)
                properties.group_of(obj).rest_shape = "REST_POSE"
                structure.settle_all()
                sleeve.at(20)
                np.testing.assert_array_equal(sleeve.shown(obj), alone)

    def test_a_bake_shows_the_played_through_clip(self) -> None:
        for method in METHODS:
            with self.subTest(method), tempfile.TemporaryDirectory() as folder:
                obj = adapting(method, reference="FIRST_FRAME")
                obj.rumple.bake_end, obj.rumple.bake_samples = sleeve.LAST, 2
                sleeve.play()
                sleeve.at(13, 0.5)
                live = sleeve.shown(obj)
                bpy.ops.wm.save_as_mainfile(filepath=str(Path(folder) / "adaptive.blend"))
                self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
                sleeve.at(13, 0.5)
                np.testing.assert_allclose(sleeve.shown(obj), live, atol=1e-6)
                obj.rumple.mesh.relaxation = obj.rumple.field.relaxation = 0.5
                structure.settle_all()
                self.assertIn("changed since the bake", obj.rumple.message)

    def test_an_opened_file_plays_to_the_same_folds(self) -> None:
        for method in METHODS:
            with self.subTest(method), tempfile.TemporaryDirectory() as folder:
                obj = adapting(method)
                sleeve.play()
                played, path = sleeve.shown(obj), str(Path(folder) / "adaptive.blend")
                bpy.ops.wm.save_as_mainfile(filepath=path)
                bpy.ops.wm.open_mainfile(filepath=path)
                obj = bpy.data.objects["Sleeve"]
                self.assertEqual(properties.group_of(obj).rest_shape, "ADAPTIVE")
                sleeve.play()
                np.testing.assert_array_equal(sleeve.shown(obj), played)

    def test_presets_keep_it(self) -> None:
        obj = adapting("MESH", reference="FIRST_FRAME", relaxation=0.03)
        bpy.ops.object.rumple_preset(preset="SILK")
        self.assertEqual((obj.rumple.mesh.rest_shape, obj.rumple.mesh.reference), ("ADAPTIVE", "FIRST_FRAME"))
        self.assertAlmostEqual(obj.rumple.mesh.relaxation, 0.03)
