# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Paths on the sleeve: one click, replay, frame rate, paint."""
from __future__ import annotations

import unittest

import bpy
import numpy as np
from rumple.blender import scheduler
from rumple.blender.objects import modifier, properties, runtimes
from support import sleeve


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
        x = runtimes.of(obj).evaluator.positions_rest[:, 0]
        self.assertGreater(runtimes.of(obj).result.report.paths, 0)
        self.assertGreater(offset.max(), 0.1 * obj.rumple.paths.width)
        self.assertEqual(offset[x < 0.1].max(), 0.0)
        self.assertEqual(obj.rumple.message, "")

    def test_at_rest_nothing_folds(self) -> None:
        obj = folding()
        sleeve.at(1)
        self.assertEqual(runtimes.of(obj).result.report.paths, 0)
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
        scheduler.sync_all()
        sleeve.play()
        self.assertEqual(np.abs(sleeve.attribute(obj, "rumple_height")).max(), 0.0)

    def test_presets_differ_and_the_way_back_is_exact(self) -> None:
        obj = folding(threshold=1.05)
        chosen = {name: getattr(obj.rumple.paths, name) for name in obj.rumple.paths.__annotations__}
        seen = {}
        for preset in ("SILK", "WOOL", "LEATHER", "COTTON"):
            bpy.ops.object.rumple_preset(preset=preset)
            scheduler.sync_all()
            sleeve.play()
            self.assertEqual(obj.rumple.message, "", preset)
            seen[preset] = runtimes.of(obj).result.report.paths
        self.assertGreater(seen["SILK"], seen["COTTON"])
        self.assertLess(seen["LEATHER"], seen["COTTON"])
        back = {name: getattr(obj.rumple.paths, name) for name in chosen}
        self.assertAlmostEqual(back.pop("width"), chosen.pop("width"), places=7)
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

    def test_width_from_the_height_of_the_armature_in_any_unit(self) -> None:
        obj = folding()
        rig = bpy.data.objects["Arm"]
        rig.rotation_euler.y, rig.scale = -np.pi / 2, (3.0, 3.0, 3.0)  # it stands: 3 x 0.6 m, and bends anywhere
        bpy.context.view_layer.update()
        for frame, metres in ((1, 1.0), (20, 1.0), (20, 10.0)):
            sleeve.at(frame)
            bpy.context.scene.unit_settings.scale_length = metres
            self.assertEqual(bpy.ops.object.rumple_width_from_height(percent=0.5), {"FINISHED"})
            self.assertAlmostEqual(obj.rumple.paths.width, 0.005 * 1.8, places=6)
            self.assertAlmostEqual(properties.settings_of(obj, bpy.context.scene).width, 0.009 * metres, places=6)

    def test_without_armature_the_parent_and_then_the_mesh_itself_has_the_height(self) -> None:
        obj = folding()
        bpy.data.objects.remove(bpy.data.objects["Arm"])
        body = bpy.data.objects.new("Body", sleeve.tube("Body"))
        bpy.context.scene.collection.objects.link(body)
        body.scale.z = 10.0
        bpy.context.view_layer.update()
        for parent, height in ((body, 20.0 * sleeve.RADIUS), (None, 2.0 * sleeve.RADIUS)):
            obj.parent = parent
            obj.matrix_parent_inverse = body.matrix_world.inverted()
            if parent is None:
                obj.matrix_parent_inverse.identity()
            bpy.context.view_layer.update()
            bpy.ops.object.rumple_width_from_height()
            self.assertAlmostEqual(obj.rumple.paths.width, 0.01 * height, places=5)

    def test_what_is_flat_has_no_height(self) -> None:
        obj = folding()
        bpy.data.objects.remove(bpy.data.objects["Arm"])
        obj.scale.z = 0.0
        bpy.context.view_layer.update()
        before = obj.rumple.paths.width
        with self.assertRaisesRegex(RuntimeError, "Sleeve: no height to go by"):
            bpy.ops.object.rumple_width_from_height()
        self.assertEqual(obj.rumple.paths.width, before)

    def test_removing_leaves_nothing(self) -> None:
        obj = folding()
        sleeve.at(5)
        bpy.ops.object.rumple_remove()
        self.assertEqual(sleeve.names(bpy.data.objects), ["Arm", "Sleeve"])
        self.assertIsNone(modifier.find(obj))
