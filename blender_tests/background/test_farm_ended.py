# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that are ended or killed go on, to the bit: behind what is kept where it is right, else from the start."""
from __future__ import annotations

import signal
from contextlib import nullcontext
from pathlib import Path
from typing import Any
from unittest import mock

import bpy
from rumple.blender.farm import bake, command, commands, source
from rumple.core.files import clip_file, clip_lock
from rumple.core.files.checkpoint import Checkpoint
from rumple.core.files.clip_manifest import ClipFault
from support import farm_scene, sleeve
from support.farm_case import FRAMES, Case


class Ended(Case):
    """The law: what was ended and resumed is, byte for byte, what was never ended."""

    def end_after(self, name: str, samples: int, killed_behind: int | None = None) -> None:
        """A bake of one garment that is ended; or, with a state behind so many of its samples, killed."""
        commands.open_file(self.blend, False)
        obj = bpy.data.objects[name]
        files = source.of_files()
        bake.show_needed(obj, files)
        running = bake.FarmBake(bpy.context, obj, source.of_garment(obj, files), False)
        while running.partial.done < samples:
            running.step()
            if running.partial.done == killed_behind:
                running._keep_state()
        if killed_behind is not None:
            running._has_states = False
        running.stop()

    def check_resumed(self, name: str, passed: int, passed_harmed: int = 2) -> None:
        """Ends it after five samples, with bits gone wrong in the third in a second round."""
        self.assertEqual(self.run_command("bake"), 0)
        clip = self.clip(name)
        whole = clip.read_bytes()
        for harm in (False, True):
            clip.unlink()
            self.end_after(name, 5)
            partial = next(self.clips.glob(".*.partial"))
            if harm:
                data = bytearray(partial.read_bytes())
                data[len(data) // 2] ^= 1
                partial.write_bytes(data)
            self.assertFalse(clip.exists())
            found = self.data("bake", "--resume")["garments"][name]
            self.assertEqual((found["resumed"], found["passed"]), (2, passed_harmed) if harm else (5, passed))
            self.assertTrue(clip.read_bytes() == whole)
            self.assertEqual(len(list(self.clips.iterdir())), 3)

    def check_goes_on(self, name: str, samples: int, behind: int, passed: int) -> None:
        """The garment's bake, killed after some samples with a state behind others, goes on from that state."""
        for garment in (farm_scene.INNER, name):
            self.assertEqual(self.run_command("bake", "--resume", "--object", garment), 0)
        clip = self.clip(name)
        whole = clip.read_bytes()
        clip.unlink()
        self.end_after(name, samples, behind)
        found = self.data("bake", "--resume", "--object", name)["garments"][name]
        self.assertEqual((found["resumed"], found["passed"]), (samples, passed))
        self.assertTrue(clip.read_bytes() == whole)
        self.assertEqual(self.run_command("bake", "--verify", "--object", name), 0)
        self.assertEqual({path.suffix for path in self.clips.iterdir()}, {".pc2"})

    def edit(self, name: str, method: str = "MESH", **settings: object) -> None:
        """Another system, other settings, for the garment in the file."""
        obj = bpy.data.objects[name]
        if method != "MESH":
            sleeve.make_active(obj)
            bpy.ops.object.rumple_remove()
            bpy.ops.object.rumple_add(method=method)
        obj.rumple.bake_end = FRAMES
        for word, value in settings.items():
            setattr(getattr(obj.rumple, method.lower()), word, value)
        farm_scene.save(self.blend)

    def test_frames_that_depend_on_one_another(self) -> None:
        self.check_resumed(farm_scene.OUTER, 5, 0)  # the state is of a sample that is not whole

    def test_where_the_clip_cannot_be_put_in_place_what_is_solved_is_kept(self) -> None:
        """A file that another program has open. It was thrown away, and solved anew."""
        for name in (farm_scene.INNER, farm_scene.OUTER):
            self.assertEqual(self.run_command("bake", "--resume", "--object", name), 0)
        whole = self.clip(farm_scene.OUTER).read_bytes()
        self.clip(farm_scene.OUTER).unlink()
        with mock.patch.object(clip_file.ClipWriter, "commit", side_effect=ClipFault("in use")):
            self.assertEqual(self.run_command("bake", "--object", farm_scene.OUTER), 1)
        self.assertIn("in use", self.err)
        found = self.data("bake", "--resume", "--object", farm_scene.OUTER)["garments"][farm_scene.OUTER]
        self.assertEqual(found["resumed"], FRAMES)
        self.assertTrue(self.clip(farm_scene.OUTER).read_bytes() == whole)

    def test_where_the_lock_cannot_be_reached_for_long_what_is_solved_is_kept(self) -> None:
        """A share that is away. It was taken for the lock of another one."""
        opened = Path.open

        def away(path: Path, *arguments: Any, **named: Any) -> Any:
            if path.suffix == ".lock":
                raise OSError(5, "the share is away")
            return opened(path, *arguments, **named)
        with mock.patch.object(clip_lock, "_TOUCHED", -1.0), mock.patch.object(clip_lock, "_MOST_MISSED", 4), \
                mock.patch.object(Path, "open", away):
            self.assertEqual(self.run_command("bake", "--object", farm_scene.INNER), 1)
        self.assertIn("connect its disk", self.err)
        next(self.clips.glob(".*.lock")).unlink()
        found = self.data("bake", "--resume", "--object", farm_scene.INNER)["garments"][farm_scene.INNER]
        self.assertEqual(found["resumed"], 5)

    def test_after_a_kill_it_goes_on_behind_the_last_state(self) -> None:
        self.check_goes_on(farm_scene.OUTER, 6, 4, 4)
        self.check_goes_on(farm_scene.OUTER, 6, 6, 6)

    def test_cloth_that_swings_goes_on(self) -> None:
        self.edit(farm_scene.OUTER, base_cloth="SWING")
        self.check_goes_on(farm_scene.OUTER, 6, 4, 4)

    def test_of_subframes_it_goes_on_behind_the_last_whole_frame(self) -> None:
        bpy.data.objects[farm_scene.INNER].rumple.bake_samples = 3
        self.edit(farm_scene.INNER)
        self.check_goes_on(farm_scene.INNER, 10, 9, 7)

    def test_other_systems_go_on(self) -> None:
        for method in ("FIELD", "PATHS"):
            with self.subTest(method):
                self.edit(farm_scene.INNER, method)
                self.check_goes_on(farm_scene.INNER, 6, 5, 5)
                self.setUp()

    def test_a_rest_shape_that_looks_at_the_whole_clip_goes_on(self) -> None:
        bpy.data.objects[farm_scene.INNER].rumple.bake_whole_clip = True
        self.edit(farm_scene.INNER, rest_shape="ADAPTIVE")
        self.check_goes_on(farm_scene.INNER, 6, 5, 5)

    def test_a_state_that_is_not_whole_or_of_another_pose_is_not_used(self) -> None:
        """It is solved again, and the bits are the same."""
        self.run_command("bake")
        clip = self.clip(farm_scene.INNER)
        whole = clip.read_bytes()
        read = Checkpoint.read

        def of_another_pose(path: Path, identity: str) -> Checkpoint | None:
            found = read(path, identity)
            return found and Checkpoint(found.sample, {**found.arrays, "inputs": found.arrays["inputs"][::-1]})

        def half(path: Path, identity: str) -> Checkpoint | None:
            found = read(path, identity)
            assert found is not None
            name = next(name for name in found.arrays if name.endswith("offset"))
            return Checkpoint(found.sample, {**found.arrays, name: found.arrays[name][:-1].copy()})

        def too_late(path: Path, identity: str) -> Checkpoint | None:
            found = read(path, identity)
            return found and Checkpoint(found.sample + 4, found.arrays)

        for wrong, passed in ((read, 4), (of_another_pose, 0), (half, 0), (too_late, 0)):
            clip.unlink()
            self.end_after(farm_scene.INNER, 6, 4)
            with mock.patch.object(Checkpoint, "read", wrong):
                found = self.data("bake", "--resume", "--object", farm_scene.INNER)["garments"][farm_scene.INNER]
            self.assertEqual((found["resumed"], found["passed"]), (6, passed))
            self.assertTrue(clip.read_bytes() == whole)

    def test_what_rests_on_live_cloth_is_solved_again(self) -> None:
        """A state is of one garment: the other one, without a clip, would come by a jump."""
        for passed, inner in ((0, False), (5, True)):
            if inner:
                self.run_command("bake", "--object", farm_scene.INNER)
            self.run_command("bake", "--object", farm_scene.OUTER)
            whole = self.clip(farm_scene.OUTER).read_bytes()
            self.clip(farm_scene.OUTER).unlink()
            self.end_after(farm_scene.OUTER, 5)
            found = self.data("bake", "--resume", "--object", farm_scene.OUTER)["garments"][farm_scene.OUTER]
            self.assertEqual((found["resumed"], found["passed"]), (5, passed))
            self.assertTrue(self.clip(farm_scene.OUTER).read_bytes() == whole)

    def test_the_command_keeps_states(self) -> None:
        steps = iter(range(5))

        def end(clip: object) -> None:
            if next(steps, None) is None:
                raise KeyboardInterrupt  # not by a signal: nothing is written at the end
        with mock.patch("rumple.core.files.clip_lock.Lock.touch", end), \
                mock.patch.object(bake.FarmBake, "stop", lambda running: running.partial.keep()):
            self.assertRaises(KeyboardInterrupt, self.run_command, "bake", "--checkpoint", "0", "--object",
                              farm_scene.INNER)
        self.assertEqual({path.suffix for path in self.clips.iterdir()}, {".partial", ".journal", ".state"})
        found = self.data("bake", "--resume", "--object", farm_scene.INNER)["garments"][farm_scene.INNER]
        self.assertEqual((found["resumed"], found["passed"]), (6, 6))

    def test_windows_ends_a_bake_by_another_signal(self) -> None:
        """What its SIGTERM ends is ended at once."""
        for of_windows in (False, True):
            with mock.patch.object(signal, "SIGBREAK", signal.SIGUSR1, create=True) if of_windows else nullcontext():
                for number in (signal.SIGTERM, *([signal.SIGUSR1] if of_windows else [])):
                    former = signal.getsignal(number)
                    with command._ended_by_signal(), mock.patch.object(bake, "end_soon") as end_soon:
                        self.assertIsNot(signal.getsignal(number), former)
                        signal.raise_signal(number)
                        self.assertEqual(end_soon.call_count, 1)
                    self.assertIs(signal.getsignal(number), former)

    def test_independent_frames_are_not_solved_again(self) -> None:
        self.check_resumed(farm_scene.FREE, 5)

    def test_subframes_and_angles_go_on(self) -> None:
        obj = bpy.data.objects[farm_scene.FREE]
        bpy.ops.object.rumple_remove()
        obj.rumple.field.stateless, obj.rumple.bake_samples = True, 2
        sleeve.make_active(obj)
        bpy.ops.object.rumple_add(method="FIELD")
        obj.rumple.bake_end = FRAMES
        farm_scene.save(self.blend)
        self.check_resumed(farm_scene.FREE, 5)
        self.assertEqual(self.run_command("bake", "--verify", "3", "--object", farm_scene.FREE), 0)

    def test_of_another_file_nothing_is_used(self) -> None:
        self.run_command("bake")
        former = self.clip(farm_scene.FREE).read_bytes()
        self.clip(farm_scene.FREE).unlink()
        self.end_after(farm_scene.FREE, 5)
        bpy.data.objects[farm_scene.FREE].rumple.mesh.bending = 0.1
        farm_scene.save(self.blend)
        self.assertEqual(self.data("bake", "--resume")["garments"][farm_scene.FREE]["resumed"], 0)
        now = self.clip(farm_scene.FREE).read_bytes()
        self.assertFalse(now == former)
        self.clip(farm_scene.FREE).unlink()
        self.run_command("bake")
        self.assertTrue(self.clip(farm_scene.FREE).read_bytes() == now)

    def test_sigterm_keeps_what_is_solved(self) -> None:
        with mock.patch.object(bake, "_end_wanted", True):
            self.assertEqual(self.run_command("bake", "--object", farm_scene.FREE), 143)
        self.assertIn("kept for --resume", self.err)
        self.assertEqual({path.suffix for path in self.clips.iterdir()}, {".partial", ".journal"})
        self.assertEqual(self.data("bake", "--resume")["garments"][farm_scene.FREE]["resumed"], 1)
        self.assertEqual({path.suffix for path in self.clips.iterdir()}, {".pc2"})
