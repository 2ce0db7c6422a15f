# SPDX-License-Identifier: GPL-3.0-or-later
"""Rest shapes that adapt, on the sleeve: every system, in any order, baked, saved and opened again."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path
from unittest import mock

import bpy
import numpy as np
from rumple.blender import scheduler
from rumple.blender.bake import clip
from rumple.blender.frame import clip_status
from rumple.blender.objects import evaluator, modifier, properties, runtimes
from rumple.blender.ui import paths_panel, rest_panel
from support import sleeve
from support.frames import solve_frame

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
    scheduler.sync_all()
    return obj


class Panels(unittest.TestCase):

    def drawn(self, panel: type) -> list[str]:
        """The settings that a panel draws."""
        layout = mock.Mock()
        layout.column.return_value = layout
        panel.draw(mock.Mock(layout=layout), bpy.context)
        return [call.args[1] for call in layout.prop.call_args_list]

    def test_both_draw_what_has_an_effect_and_nothing_else(self) -> None:
        """Persistence drew all four, whatever was set."""
        expected = {("REST", False): ["reference", "relaxation", "growth", "window"],
                    ("FIRST_FRAME", False): ["reference", "relaxation", "window"],
                    ("STATIC_REST", False): ["reference", "window"], ("REST", True): []}
        for method, panel in (("MESH", rest_panel.DATA_PT_rumple_rest),
                              ("PATHS", paths_panel.DATA_PT_rumple_persistence)):
            obj = sleeve.scene(wrinkles=False)
            bpy.ops.object.rumple_add(method=method)
            settings = properties.group_of(obj)
            if method == "MESH":
                settings.rest_shape = "ADAPTIVE"
            for (reference, stateless), names in expected.items():
                if method == "PATHS" or reference != "STATIC_REST":
                    settings.reference, settings.stateless = reference, stateless
                    found = [name for name in self.drawn(panel) if name in expected["REST", False]]
                    self.assertEqual(found, names, (method, reference, stateless))


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
                scheduler.sync_all()
                sleeve.play()
                self.assertLess(given_in, 0.9 * mean_fold(obj))

    def test_independent_frames_are_those_of_the_rest_pose(self) -> None:
        for method in METHODS:
            with self.subTest(method):
                obj = adapting(method, reference="FIRST_FRAME", stateless=True)
                sleeve.at(20)
                alone = sleeve.shown(obj)
                properties.group_of(obj).rest_shape = "REST_POSE"
                scheduler.sync_all()
                sleeve.at(20)
                np.testing.assert_array_equal(sleeve.shown(obj), alone)

    def test_a_bake_as_in_playback_shows_the_played_through_clip(self) -> None:
        for method in METHODS:
            with self.subTest(method), tempfile.TemporaryDirectory() as folder:
                obj = adapting(method, reference="FIRST_FRAME")
                obj.rumple.bake_end, obj.rumple.bake_samples, obj.rumple.bake_whole_clip = sleeve.LAST, 2, False
                sleeve.play()
                sleeve.at(13, 0.5)
                live = sleeve.shown(obj)
                bpy.ops.wm.save_as_mainfile(filepath=str(Path(folder) / "adaptive.blend"))
                self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
                sleeve.at(13, 0.5)
                np.testing.assert_allclose(sleeve.shown(obj), live, atol=1e-6)
                obj.rumple.mesh.relaxation = obj.rumple.field.relaxation = 0.5
                scheduler.sync_all()
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


class WholeClip(unittest.TestCase):
    """A bake looks at the clip before it solves it."""

    METHODS = (*METHODS, "PATHS")

    def setUp(self) -> None:
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def made(self, method: str) -> bpy.types.Object:
        if method == "PATHS":
            obj = sleeve.scene(wrinkles=False)
            obj.rumple.paths.threshold = 1.1
            bpy.ops.object.rumple_add(method="PATHS")
        else:
            obj = adapting(method, relaxation=0.1)
        sleeve.bend_until(8)  # and then it stands: live labels are late
        obj.rumple.bake_end = sleeve.LAST
        bpy.ops.wm.save_as_mainfile(filepath=str(Path(self.folder.name) / f"{method}.blend"))
        return obj

    def played(self, obj: bpy.types.Object) -> dict[int, np.ndarray]:
        shapes = {}
        for frame in range(1, sleeve.LAST + 1):
            sleeve.at(frame)
            shapes[frame] = sleeve.shown(obj)
        return shapes

    def by_hand(self, obj: bpy.types.Object) -> dict[int, np.ndarray]:
        """All frames with the labels of the whole clip, by the engine alone."""
        scene, runtime = bpy.context.scene, runtimes.of(obj)
        now = evaluator.sources(obj)
        fine = modifier.system(modifier.find(obj)).wrinkles.build(now.base, now.settings, unit_scale=now.unit_scale)
        poses = {}
        for frame in range(1, sleeve.LAST + 1):
            sleeve.at(frame)
            poses[float(frame)] = runtime.inputs.positions
        rate = scene.render.fps / scene.render.fps_base
        fine.analyze_clip(poses, now.settings, frame_rate=rate)
        return {int(frame): solve_frame(fine, frame, pose, now.settings, {}, start=1, frame_rate=rate).positions
                for frame, pose in poses.items()}

    def test_baked_frames_are_those_solved_with_the_labels_of_the_whole_clip(self) -> None:
        for method in self.METHODS:
            with self.subTest(method):
                obj = self.made(method)
                live, expected = self.played(obj), self.by_hand(obj)
                for samples in (1, 2):
                    obj.rumple.bake_samples = samples
                    self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
                    for frame, shape in self.played(obj).items():
                        np.testing.assert_allclose(shape, expected[frame], atol=1e-6, err_msg=f"frame {frame}")
                    bpy.ops.object.rumple_bake_free()
                self.assertGreater(max(np.abs(expected[f] - live[f]).max() for f in live), 1e-5)
                again = self.played(obj)  # and live is as it was
                for frame in live:
                    np.testing.assert_array_equal(again[frame], live[frame])
                obj.rumple.bake_whole_clip = False
                bpy.ops.object.rumple_bake()
                for frame, shape in self.played(obj).items():
                    np.testing.assert_allclose(shape, live[frame], atol=1e-6)

    def test_over_a_body_nothing_is_seen_ahead(self) -> None:
        # Frames are solved over the mesh that is put out of the body: labels of the animated one do not fit them.
        for method in self.METHODS:
            with self.subTest(method):
                obj = self.made(method)
                obj.rumple.body = sleeve.under(obj, radius=1.04)
                live = self.played(obj)
                self.assertTrue(obj.rumple.bake_whole_clip)
                self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
                for frame, shape in self.played(obj).items():
                    np.testing.assert_allclose(shape, live[frame], atol=1e-6, err_msg=f"frame {frame}")

    def test_shape_keys_are_baked_so_too(self) -> None:
        for method in self.METHODS:
            with self.subTest(method):
                obj = self.made(method)
                expected = self.by_hand(obj)
                self.assertEqual(bpy.ops.object.rumple_bake_shape_keys(), {"FINISHED"})
                keys = bpy.data.objects[f"{obj.name} shape keys"].data.shape_keys.key_blocks
                for frame in (3, 9, sleeve.LAST):
                    flat = np.empty(3 * len(keys[0].data), np.float32)
                    keys[f"Frame {frame}"].data.foreach_get("co", flat)
                    np.testing.assert_allclose(flat.reshape(-1, 3), expected[frame], atol=1e-6)

    def test_a_bake_that_starts_late_looks_at_its_run_up(self) -> None:
        obj = self.made("MESH")
        expected = self.by_hand(obj)
        obj.rumple.bake_start = 12
        bpy.ops.object.rumple_bake()
        sleeve.at(15)
        np.testing.assert_allclose(sleeve.shown(obj), expected[15], atol=1e-6)

    def test_an_object_that_follows_another_wrinkled_one(self) -> None:
        other = self.made("MESH")
        cuff = sleeve.cuff(other, "SHRINKWRAP", "Cuff")
        cuff.rumple.mesh.rest_shape, cuff.rumple.bake_end = "ADAPTIVE", sleeve.LAST
        scheduler.sync_all()
        bake = clip.ClipBake(bpy.context, cuff)
        while bake.step():
            pass
        bake.finish()
        self.assertTrue(bake.playback.analyzes)
        self.assertEqual(bake.note, "")  # it came as it was looked at, in the second pass of every frame

    def test_a_cancelled_look_leaves_nothing(self) -> None:
        obj = self.made("MESH")
        live = self.played(obj)
        for steps in (0, 3, sleeve.LAST, sleeve.LAST + 3):
            bake = clip.ClipBake(bpy.context, obj)
            self.assertEqual(bake.playback.count, 2 * sleeve.LAST)
            for _ in range(steps):
                self.assertTrue(bake.step())
            bake.cancel()
            runtime = runtimes.of(obj)
            self.assertFalse(runtime.analyzing)
            self.assertIsNone(clip_status.clip_path(obj))
            sleeve.at(14)
            sleeve.at(sleeve.LAST)
        again = self.played(obj)
        for frame in live:
            np.testing.assert_array_equal(again[frame], live[frame])

    def test_how_it_was_baked_is_part_of_the_clip(self) -> None:
        obj = self.made("MESH")
        bpy.ops.object.rumple_bake()
        self.assertEqual(obj.rumple.message, "")
        obj.rumple.bake_whole_clip = False
        scheduler.sync_all()
        self.assertIn("changed since the bake", obj.rumple.message)

    def test_a_clip_of_one_frame(self) -> None:
        obj = self.made("PATHS")
        obj.rumple.bake_end = 1
        sleeve.at(1)
        self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})

    def test_a_modifier_that_is_off_is_said_before_anything_is_solved(self) -> None:
        obj = self.made("MESH")
        modifier.find(obj).show_viewport = False
        with self.assertRaisesRegex(RuntimeError, "nothing is seen at frame 1"):
            bpy.ops.object.rumple_bake()
        self.assertFalse(runtimes.of(obj).analyzing)
