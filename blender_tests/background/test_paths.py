# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Paths on the sleeve: one click, replay, frame rate, paint."""
from __future__ import annotations

import unittest

import bpy
import numpy as np
import sleeve
from rumple.blender import modifier, registry, structure


def folding(**settings: object) -> bpy.types.Object:
    """The sleeve with Wrinkle Paths."""
    obj = sleeve.scene(wrinkles=False)
    for name, value in settings.items():
        setattr(obj.rumple.paths, name, value)
    with sleeve.context():
        bpy.ops.object.rumple_add(method="PATHS")
    return obj


class Paths(unittest.TestCase):
    def test_folds_rise_where_it_bends_and_nowhere_else(self) -> None:
        obj = folding()
        sleeve.play()
        offset = np.sqrt((sleeve.attribute(obj, "rumple_offset")**2).sum(1))
        x = registry.runtime(obj).fine.positions_rest[:, 0]
        self.assertGreater(registry.runtime(obj).picture.report.paths, 0)
        self.assertGreater(offset.max(), 0.1 * obj.rumple.paths.width)
        self.assertEqual(offset[x < 0.1].max(), 0.0)
        self.assertEqual(obj.rumple.message, "")

    def test_at_rest_nothing_folds(self) -> None:
        obj = folding()
        sleeve.at(1)
        self.assertEqual(registry.runtime(obj).picture.report.paths, 0)
        self.assertEqual(np.abs(sleeve.attribute(obj, "rumple_height")).max(), 0.0)

    def test_played_frames_come_back_to_the_bit(self) -> None:
        obj = folding()
        played = {}
        for frame in range(1, sleeve.LAST + 1):
            sleeve.at(frame)
            played[frame] = sleeve.shown(obj)
        for frame in (7, 2, 20, 11):
            sleeve.at(frame)
            np.testing.assert_array_equal(sleeve.shown(obj), played[frame])

    def test_another_frame_rate_solves_anew(self) -> None:
        obj = folding()
        sleeve.play()
        before = sleeve.attribute(obj, "rumple_height")
        bpy.context.scene.render.fps = 60  # the same frames pass faster
        sleeve.play()
        self.assertGreater(np.abs(sleeve.attribute(obj, "rumple_height") - before).max(), 1e-4)
        self.assertEqual(obj.rumple.message, "")

    def test_no_folds_where_the_mask_is_zero(self) -> None:
        obj = folding()
        with sleeve.context():
            bpy.ops.object.rumple_paint(group="mask")
            bpy.ops.object.mode_set(mode="OBJECT")
        obj.vertex_groups["Rumple Mask"].add(range(len(obj.data.vertices)), 0.0, "REPLACE")
        obj.update_tag()
        structure.settle_all()
        sleeve.play()
        self.assertEqual(np.abs(sleeve.attribute(obj, "rumple_height")).max(), 0.0)

    def test_presets_differ_and_the_way_back_is_exact(self) -> None:
        obj = folding(threshold=1.05)
        chosen = {name: getattr(obj.rumple.paths, name) for name in obj.rumple.paths.__annotations__}
        seen = {}
        for preset in ("SILK", "WOOL", "LEATHER", "COTTON"):
            bpy.ops.object.rumple_preset(preset=preset)
            structure.settle_all()
            sleeve.play()
            self.assertEqual(obj.rumple.message, "", preset)
            seen[preset] = registry.runtime(obj).picture.report.paths
        self.assertGreater(seen["SILK"], seen["COTTON"])
        self.assertLess(seen["LEATHER"], seen["COTTON"])
        back = {name: getattr(obj.rumple.paths, name) for name in chosen}
        self.assertAlmostEqual(back.pop("width"), chosen.pop("width"), places=7)
        self.assertEqual(back.pop("threshold"), 1.25, "a preset sets what any of its sisters sets")
        chosen.pop("threshold")
        self.assertEqual(back, chosen)

    def test_a_preset_leaves_alone_what_no_cloth_is_about(self) -> None:
        obj = folding()
        obj.rumple.paths.seed, obj.rumple.paths.direction = 5, "BOTH"
        bpy.ops.object.rumple_preset(preset="WOOL")
        self.assertEqual((obj.rumple.paths.seed, obj.rumple.paths.direction), (5, "BOTH"))
        self.assertEqual(obj.rumple.mesh.preset, "COTTON", "each system has its own")

    def test_the_field_has_no_presets(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        with sleeve.context():
            bpy.ops.object.rumple_add(method="FIELD")
            self.assertFalse(bpy.ops.object.rumple_preset.poll())
        self.assertEqual(obj.rumple.method, "FIELD")

    def test_removing_leaves_nothing(self) -> None:
        obj = folding()
        sleeve.at(5)
        bpy.ops.object.rumple_remove()
        self.assertEqual(sleeve.names(bpy.data.objects), ["Arm", "Sleeve"])
        self.assertIsNone(modifier.find(obj))
