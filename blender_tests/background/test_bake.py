# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked clips: shown without handlers, whole or not at all, and stale ones are said."""
from __future__ import annotations

import json
import os
import struct
import tempfile
import unittest
from functools import partial
from pathlib import Path, PureWindowsPath
from time import perf_counter
from typing import Any
from unittest import mock

import bpy
import numpy as np
from rumple.blender import handlers, scheduler
from rumple.blender.bake import clip, operators, playback
from rumple.blender.frame import baking, clip_status
from rumple.blender.objects import modifier, runtimes
from rumple.core.files import clip_folder, clip_lock
from rumple.core.mesh.frame_result import COMMON_ATTRIBUTES
from support import sleeve, vanilla_blender

ATTRIBUTES = tuple(attribute.name for attribute in COMMON_ATTRIBUTES)


class Baked(unittest.TestCase):

    def setUp(self) -> None:
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.obj = sleeve.scene()
        self.blend = os.path.join(self.folder.name, vanilla_blender.FILE)
        bpy.ops.wm.save_as_mainfile(filepath=self.blend)

    def clip(self) -> Path:
        return clip_status.clip_path(self.obj)

    def cache_object(self) -> bpy.types.Object:
        return modifier.cache_object(modifier.find(self.obj))

    def test_a_clip_that_a_worker_bakes_is_left_to_it(self) -> None:
        """The lock is that of `rumple bake`; who holds it and what to do is said, and nothing is changed."""
        self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
        path = self.clip()
        before, lock = path.read_bytes(), path.with_name(f".{path.name}.lock")
        self.assertEqual([file.name for file in path.parent.iterdir()], [path.name])  # it was given back
        lock.write_text(json.dumps(dict(host="node_7", process=4711, started="", task="slurm 12_3")))
        self.obj.rumple.mesh.bending = 0.5
        with self.assertRaisesRegex(RuntimeError, "is being baked by process 4711 on node_7 .* ago: wait for it"):
            bpy.ops.object.rumple_bake()
        self.assertEqual(path.read_bytes(), before)
        self.assertTrue(lock.is_file())
        lock.write_text(json.dumps(dict(host=clip_folder.HOST, process=1 << 29, started="", task="")))
        self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})  # of a Blender that is gone
        self.assertNotEqual(path.read_bytes(), before)
        self.assertEqual([file.name for file in path.parent.iterdir()], [path.name])

    def test_a_bake_that_is_refused_leaves_no_folder(self) -> None:
        """The lock made it, before anything else of the bake was looked at."""
        folder = clip.new_clip_path(self.obj).parent
        self.assertFalse(folder.exists())
        self.obj.rumple.bake_start, self.obj.rumple.bake_end = 5, 2
        with self.assertRaisesRegex(RuntimeError, "is before the first"):
            bpy.ops.object.rumple_bake()
        self.assertFalse(folder.exists())

    def test_in_sculpt_mode_it_says_to_leave_it(self) -> None:
        """It asked to see whether the modifier was on, which it was."""
        bpy.ops.object.mode_set(mode="SCULPT")
        with self.assertRaisesRegex(RuntimeError, "Sleeve: nothing is solved while its mesh is edited: leave Sculpt"):
            bpy.ops.object.rumple_bake()
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})

    def test_frames_that_blender_does_not_have_are_refused_before_any_is_solved(self) -> None:
        """From 2147483645 on: the frames in front of it were made a list of 80 GB, then played for ever."""
        first, last = self.obj.rumple.bake_start, self.obj.rumple.bake_end
        largest, beyond = 2**31 - 1, playback.MOST_FRAME + 1
        for start, end, named in ((largest - 2, largest, largest - 2), (-2**31, last, -2**31),
                                  (first, largest, largest), (first, beyond, beyond)):
            self.obj.rumple.bake_start, self.obj.rumple.bake_end = start, end
            with self.assertRaisesRegex(RuntimeError, f"Sleeve: Blender has no frame {named}: change the first or"):
                bpy.ops.object.rumple_bake()
        # Nor does Blender go there: a bake would wait at the same frame.
        bpy.context.scene.frame_set(beyond)
        self.assertEqual(bpy.context.scene.frame_current, playback.MOST_FRAME)

    def test_a_worker_leaves_a_clip_to_a_window_that_bakes_it(self) -> None:
        for end in ("cancel", "finish"):
            running = clip.ClipBake(bpy.context, self.obj)
            running.step()
            with self.assertRaisesRegex(clip_lock.Held, f"is being baked by process {os.getpid()} on "):
                clip_lock.Lock(running.writer.clip)
            while end == "finish" and running.step():
                pass
            getattr(running, end)()
            clip_lock.Lock(running.writer.clip).release()
        with mock.patch.object(clip.ClipBake, "_begin", side_effect=ValueError("no room")):
            self.assertRaises(RuntimeError, bpy.ops.object.rumple_bake)
        clip_lock.Lock(self.clip()).release()

    def test_a_window_that_lost_its_lock_leaves_the_clip_alone(self) -> None:
        """A computer that slept for long, say."""
        for behind in (2, 20):
            running = clip.ClipBake(bpy.context, self.obj)
            path = running.writer.clip
            for _ in range(behind):
                running.step()
            lock = running.lock.path
            lock.write_text(json.dumps(dict(host="node_7", process=1, started="", task="")))
            with mock.patch.object(clip_lock, "_TOUCHED", -1.0), self.assertRaisesRegex(
                    playback.BakeError, "was taken over by process 1 on node_7: wait for it"):
                running.step() if behind == 2 else running.finish()
            running.cancel()
            self.assertEqual([file.name for file in path.parent.iterdir()], [lock.name])
            lock.unlink()

    def test_a_window_waits_until_the_clip_can_be_put_in_place(self) -> None:
        """Another program has the former one open: what was solved was thrown away."""
        window = mock.Mock(spec=operators.OBJECT_OT_rumple_bake, every=False, report=mock.Mock(), _baked=0, _waiting=[],
                           _again_at=0.0, _running=clip.ClipBake(bpy.context, self.obj))
        for name in ("_wait", "_finish", "_next"):
            function = getattr(operators.OBJECT_OT_rumple_bake, name)
            getattr(window, name).side_effect = partial(function, window)

        def step() -> None:
            operators.OBJECT_OT_rumple_bake._step_until(window, bpy.context, perf_counter() + 1e6)
        with mock.patch("os.replace", side_effect=PermissionError(13, "in use")):
            for _ in range(2):
                step()
                self.assertIsNotNone(window._running)
        self.assertEqual([call.args[0] for call in window.report.mock_calls], [{"WARNING"}])  # said once
        self.assertRegex(window.report.mock_calls[0].args[1], "Esc gives it up: Sleeve: nothing can be written to")
        step()
        self.assertIsNone(window._running)
        self.assertEqual([file.name for file in self.clip().parent.iterdir()], [self.clip().name])
        sleeve.at(5)
        self.assertEqual(self.obj.rumple.message, "")

    def test_two_windows_do_not_bake_at_once(self) -> None:
        """Each would have the other's garments stand still."""
        running = clip.ClipBake(bpy.context, self.obj)
        window = mock.Mock(spec=operators.OBJECT_OT_rumple_bake, every=False, report=mock.Mock())
        with mock.patch.object(operators, "bpy", mock.Mock(app=mock.Mock(background=False))):
            found = operators.OBJECT_OT_rumple_bake.invoke(window, bpy.context, None)
        self.assertEqual(found, {"CANCELLED"})
        self.assertRegex(window.report.mock_calls[0].args[1], "Another bake is under way")
        running.cancel()
        self.assertFalse(baking.is_running())

    def test_is_the_played_through_clip_and_needs_no_handlers(self) -> None:
        sleeve.play()
        live = {}
        for frame in (1, 9, 20):
            sleeve.at(frame)
            live[frame] = sleeve.shown(self.obj)
        self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
        handlers.unregister()
        try:
            for frame in (20, 1, 9):
                sleeve.at(frame)
                np.testing.assert_allclose(sleeve.shown(self.obj), live[frame], atol=1e-6)
        finally:
            handlers.register()

    def test_a_bake_that_starts_late_is_played_through_too(self) -> None:
        sleeve.play()
        sleeve.at(15)
        live = sleeve.shown(self.obj)
        bpy.ops.object.rumple_clear_frames()
        self.obj.rumple.bake_start = 12
        bpy.ops.object.rumple_bake()
        sleeve.at(15)
        np.testing.assert_allclose(sleeve.shown(self.obj), live, atol=1e-6)

    def test_subframes(self) -> None:
        self.obj.rumple.bake_samples = 2
        sleeve.play()
        sleeve.at(13, 0.5)
        live = sleeve.shown(self.obj)
        bpy.ops.object.rumple_bake()
        sleeve.at(13, 0.5)
        np.testing.assert_allclose(sleeve.shown(self.obj), live, atol=1e-6)

    def attributes(self, time: float) -> dict[str, np.ndarray]:
        sleeve.at(int(time), time - int(time))
        return {name: sleeve.attribute(self.obj, name) for name in ATTRIBUTES}

    def test_attributes_play_too_without_the_add_on_and_at_subframes(self) -> None:
        # They stayed as they were in the last live frame: the cache had positions only.
        times = (20.0, 1.0, 13.5, 9.0)
        self.obj.rumple.bake_samples = 2
        sleeve.play()
        live = {time: self.attributes(time) for time in times}
        bpy.ops.object.rumple_bake()
        bpy.ops.wm.save_mainfile()
        seen = vanilla_blender.look(Path(self.folder.name), "Sleeve", times, attributes=ATTRIBUTES)
        for time in times:
            here = self.attributes(time)
            for name, value in live[time].items():
                np.testing.assert_allclose(here[name], value, atol=1e-6, err_msg=f"{name}, {time}")
                np.testing.assert_allclose(seen[time][name], value, atol=1e-6, err_msg=f"{name}, {time}")
        for name in ATTRIBUTES:
            self.assertGreater(np.abs(live[20.0][name] - live[1.0][name]).max(), 1e-3, name)

    def test_attributes_between_two_samples(self) -> None:
        bpy.ops.object.rumple_bake()
        before, between, after = self.attributes(13), self.attributes(13.25), self.attributes(14)
        for name in ("rumple_stretch_min", "rumple_stretch_max", "rumple_offset"):
            np.testing.assert_allclose(between[name], 0.75 * before[name] + 0.25 * after[name], atol=1e-6)
        direction = between["rumple_stretch_direction"]
        mean = 0.75 * before["rumple_stretch_direction"] + 0.25 * after["rumple_stretch_direction"]
        length = np.linalg.norm(direction, axis=1)
        self.assertTrue(np.all((np.abs(length - 1.0) < 1e-5) | (length == 0.0)))
        np.testing.assert_allclose(direction * np.linalg.norm(mean, axis=1, keepdims=True), mean, atol=1e-5)

    def test_with_its_clip_lost_and_no_handlers_it_is_at_rest_attributes_too(self) -> None:
        bpy.ops.object.rumple_bake()
        sleeve.at(20)
        self.clip().unlink()
        handlers.unregister()
        try:
            seen = self.attributes(19)
        finally:
            handlers.register()
        for attribute in COMMON_ATTRIBUTES:
            np.testing.assert_array_equal(seen[attribute.name], attribute.rest)

    def test_a_clip_of_another_fine_mesh_is_not_shown(self) -> None:
        sleeve.play()
        bpy.ops.object.rumple_bake()
        self.cache_object().data = bpy.data.meshes.new("Other")
        self.obj.update_tag()
        sleeve.at(20)
        self.assertEqual(len(sleeve.shown(self.obj)), len(sleeve.output_object(self.obj).data.vertices))
        self.assertGreater(np.ptp(sleeve.shown(self.obj)[:, 0]), 0.25)

    def test_a_duplicate_plays_the_clip_until_it_is_baked_itself(self) -> None:
        bpy.ops.object.rumple_bake()
        bpy.ops.object.duplicate()
        copy = bpy.context.object
        scheduler.sync_all()
        sleeve.at(17)
        np.testing.assert_array_equal(sleeve.shown(copy), sleeve.shown(self.obj))
        first = self.cache_object()
        copy.rumple.mesh.radius = 0.1
        bpy.ops.object.rumple_bake()
        sleeve.at(17)
        self.assertEqual(self.cache_object(), first)
        self.assertEqual([name.rsplit("-", 1)[0] for name in sleeve.names(self.entries())],
                         ["scene-Sleeve", "scene-Sleeve_001"])
        self.assertGreater(np.abs(sleeve.shown(copy) - sleeve.shown(self.obj)).max(), 1e-3)

    def test_baked_again_and_freed_nothing_is_left_behind(self) -> None:
        for _ in range(2):
            bpy.ops.object.rumple_bake()
        self.assertEqual(sleeve.names(bpy.data.objects), ["Arm", "Sleeve", "Sleeve.clip.001", "Sleeve.wrinkles"])
        bpy.ops.object.rumple_bake_free()
        self.assertEqual(sleeve.names(bpy.data.objects), ["Arm", "Sleeve", "Sleeve.wrinkles"])
        bpy.ops.object.rumple_bake()
        bpy.ops.object.rumple_remove()
        self.assertEqual(sleeve.names(bpy.data.objects), ["Arm", "Sleeve"])
        self.assertEqual(sleeve.names(bpy.data.meshes), ["Sleeve"])

    def test_a_share_of_windows_is_not_taken_for_a_folder_beside_the_file(self) -> None:
        """Its backslashes became slashes, and Blender reads // as the folder of the blend file."""
        share, drive = PureWindowsPath(r"\\server\share\a.pc2"), PureWindowsPath(r"D:\clips\a.pc2")
        with mock.patch.object(bpy.path, "relpath", side_effect=ValueError):  # as where the blend file is on a drive
            self.assertEqual(clip.stored_path(share), str(share))
            self.assertEqual(clip.stored_path(drive), "D:/clips/a.pc2")
        self.assertEqual(bpy.path.abspath(str(share)), str(share))
        sleeve.empty_file()
        self.assertEqual(clip.stored_path(share), str(share))

    def test_the_path_is_relative_and_the_file_is_a_whole_pc2(self) -> None:
        bpy.ops.object.rumple_bake()
        self.assertRegex(modifier.mesh_cache(self.cache_object()).filepath, r"^//rumple/scene-Sleeve-[0-9a-f]{8}\.pc2$")
        data = self.clip().read_bytes()
        signature, version, points, start, step, samples = struct.unpack("<12siiffi", data[:32])
        self.assertEqual((signature, version, start, step, samples), (b"POINTCACHE2\0", 1, 1.0, 1.0, 20))
        self.assertEqual(points, 4 * len(sleeve.output_object(self.obj).data.vertices))  # a float pair, three vectors
        self.assertGreater(len(data), 32 + 12 * points * samples)  # and the manifest
        self.assertEqual(sleeve.names(self.entries()), [self.clip().name])

    def entries(self) -> Any:
        return os.scandir(self.clip().parent)

    def test_a_failed_bake_leaves_the_former_clip(self) -> None:
        bpy.ops.object.rumple_bake()
        before = self.clip().read_bytes()
        modifier.find(self.obj).show_viewport = False
        with self.assertRaises(RuntimeError):
            bpy.ops.object.rumple_bake()
        self.assertEqual(self.clip().read_bytes(), before)
        self.assertTrue(modifier.is_baked(modifier.find(self.obj)))
        self.assertEqual(len(list(self.entries())), 1)

    def test_an_unsaved_file_is_baked_to_a_folder_that_goes_and_it_is_said(self) -> None:
        self.obj = sleeve.scene()
        with mock.patch.object(operators, "said", side_effect=operators.said) as said, \
                mock.patch.object(Path, "resolve", side_effect=OSError):  # as on some drives of Windows
            self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
        self.assertEqual(self.clip().parents[1], Path(bpy.app.tempdir))
        self.assertRegex(said.call_args.args[0], f"samples to {self.clip()}: this folder goes when Blender quits")
        sleeve.at(10)
        self.assertEqual(self.obj.rumple.message, "")
        bpy.ops.wm.save_as_mainfile(filepath=str(Path(self.folder.name, "late.blend")))
        sleeve.at(11)  # it was said only when something else was edited: not before Blender quit
        self.assertIn("baked before the file was saved", self.obj.rumple.message)
        bpy.ops.object.rumple_bake()
        sleeve.at(12)
        self.assertEqual(self.obj.rumple.message, "")
        self.assertEqual(self.clip().parents[1], Path(self.folder.name))

    def test_all_of_the_scene(self) -> None:
        """Each with its own range; one that cannot be baked keeps no other from it."""
        other, broken = sleeve.another("Other", 1.5), sleeve.another("Broken", 2.0)
        other.rumple.bake_end, broken.rumple.bake_end = 8, 0
        sleeve.make_active(self.obj)
        with self.assertRaisesRegex(RuntimeError, "Broken: the last frame"):
            bpy.ops.object.rumple_bake(every=True)
        self.assertEqual([modifier.is_baked(modifier.find(obj)) for obj in (self.obj, other, broken)],
                         [True, True, False])
        self.assertEqual([clip_status.manifest(clip_status.clip_path(obj)).end for obj in (self.obj, other)], [20, 8])

    def test_the_frame_stays(self) -> None:
        sleeve.at(7)
        bpy.ops.object.rumple_bake()
        self.assertEqual(bpy.context.scene.frame_current, 7)

    def test_changed_settings_missing_files_and_other_poses_are_said(self) -> None:
        bpy.ops.object.rumple_bake()
        sleeve.at(9)
        self.assertEqual(self.obj.rumple.message, "")
        self.obj.rumple.mesh.bending = 0.1
        sleeve.at(10)
        self.assertIn("since the bake", self.obj.rumple.message)
        bpy.ops.object.rumple_bake()
        self.assertEqual(self.obj.rumple.message, "")
        sleeve.at(25)
        self.assertIn("outside the bake", self.obj.rumple.message)
        bend = bpy.data.objects["Arm"].pose.bones["lower"]
        bend.rotation_euler.z = -1.0
        bend.keyframe_insert("rotation_euler", frame=10)
        sleeve.at(9)
        self.assertIn("not the baked one", self.obj.rumple.message)
        self.clip().unlink()
        self.assertIn("missing", clip_status.check(self.obj, sleeve.output_object(self.obj)))

    def test_freed_it_is_live_again(self) -> None:
        bpy.ops.object.rumple_bake()
        clip = self.clip()
        bpy.ops.object.rumple_bake_free()
        sleeve.at(20)
        np.testing.assert_allclose(sleeve.shown(self.obj), sleeve.picture(self.obj).positions, atol=1e-6)
        self.assertTrue(clip.is_file())
        self.assertFalse(bpy.ops.object.rumple_bake_free.poll())

    def test_opened_again_it_shows_the_clip(self) -> None:
        bpy.ops.object.rumple_bake()
        sleeve.at(20)
        seen = sleeve.shown(self.obj)
        bpy.ops.wm.save_mainfile()
        bpy.ops.wm.open_mainfile(filepath=self.blend)
        self.obj = bpy.data.objects["Sleeve"]
        sleeve.at(20)
        np.testing.assert_allclose(sleeve.shown(self.obj), seen, atol=1e-6)
        self.assertEqual(self.obj.rumple.message, "")
        self.assertIsNone(runtimes.of(self.obj).evaluator)

    def test_shape_keys_show_every_frame(self) -> None:
        sleeve.play()
        bpy.ops.object.rumple_bake_shape_keys(start=4, end=9)
        copy = bpy.data.objects["Sleeve shape keys"]
        for frame in (4, 7, 9):
            sleeve.at(frame)
            np.testing.assert_allclose(sleeve.shown(copy), sleeve.shown(self.obj), atol=1e-5)
        self.assertEqual(len(copy.modifiers), 0)
        self.assertEqual(copy.rumple.method, "NONE")
