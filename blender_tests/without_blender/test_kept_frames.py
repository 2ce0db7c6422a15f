# SPDX-License-Identifier: GPL-3.0-or-later
"""Stored frames on disk: a jump gives the bits that were played, and nothing else is ever taken for them."""
from __future__ import annotations

import os
import shutil
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from rumple.core.cloth.surroundings import Field, Surroundings
from rumple.core.files import clip_folder, kept_frames
from rumple.core.files.kept_frames import SUFFIX, KeptFrames
from rumple.core.frame.engine import FrameResult, Wrinkles
from rumple.core.frame.frame_input import FrameInput
from rumple.core.settings.system_settings import FieldSettings, MeshSettings, PathsSettings
from rumple.core.systems.all_systems import SYSTEMS
from support.frames import solve_frame
from support.meshes import tube

HANG = dict(base_cloth="HANG", room=0.02, thickness=0.002)
LAYERED = MeshSettings(density="LEVEL", level=1, layers="CLOTH")
KINDS: dict[str, tuple[str, Any]] = {
    "one mesh": ("MESH", replace(LAYERED, layers="ONE")),
    "adaptive": ("MESH", replace(LAYERED, layers="ONE", rest_shape="ADAPTIVE")),
    "layers that swing": ("MESH", replace(LAYERED, **{**HANG, "base_cloth": "SWING"})),
    "waves on drapes": ("FIELD", FieldSettings(output="GEOMETRY", wavelength=0.05, detail=4, drape=1.0, **HANG)),
    "paths": ("PATHS", PathsSettings(width=0.02, detail=2, threshold=1.1))}
LAST, LARGE = 8, 1 << 30
# A vortex about the mesh, and a wind that differs from frame to frame.
BLOWS = (Field("VORTEX", (0.1, 0.0, 0.0), (0.0, 0.0, 1.0), strength=4.0, flow=1.0),
         Field("WIND", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), strength=3.0, noise=2.0, seed=5))


class KeptOnDisk(unittest.TestCase):
    def setUp(self) -> None:
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = Path(place.name) / "Sleeve.frames"
        self.base = tube(14, 10)
        self.solves = 0

    def opened(self, kind: str, identity: str = "model", limit: int = LARGE) -> tuple[Wrinkles, KeptFrames]:
        """The garment as in a file that was just opened."""
        method, settings = KINDS[kind]
        fine = SYSTEMS[method].wrinkles.build(self.base, settings)
        kept = KeptFrames(fine, self.folder, identity, limit)
        fine.frame_cache.on_disk = kept
        return fine, kept

    def solve(self, fine: Wrinkles, kind: str, frame: int, other: bool = False, **more: Any) -> FrameResult:
        """other: frame 3 has another pose. more: settings, paint, start or frame_rate."""
        squeeze = 1.0 - 0.05 * min(frame, 7 - frame) - (0.02 if other and frame == 3 else 0.0)
        positions = np.ascontiguousarray(self.base.positions * (1.0, 1.0, squeeze), np.float32)
        about: dict[str, Any] = dict(settings=KINDS[kind][1], paint={}, start=1)
        about.update(more)
        found = solve_frame(fine, float(frame), positions, about.pop("settings"), about.pop("paint"),
                            world_from_object=np.eye(3, dtype=np.float32),
                            surroundings=Surroundings((0.01 * frame, 0.0, 0.0), fields=BLOWS), **about)
        assert isinstance(found, FrameResult)
        return found

    def played(self, kind: str, last: int = LAST, **more: Any) -> tuple[Wrinkles, KeptFrames, dict[int, np.ndarray]]:
        fine, kept = self.opened(kind)
        return fine, kept, {frame: self.solve(fine, kind, frame, **more).positions.copy()
                            for frame in range(1, last + 1)}

    def session(self, kind: str, **more: Any) -> dict[int, np.ndarray]:
        """Played, and stored."""
        _, kept, played = self.played(kind, **more)
        kept.write()
        return played

    def files(self) -> list[Path]:
        return sorted(self.folder.glob("*" + SUFFIX))

    def expect_solved_anew(self, result: FrameResult) -> None:
        self.assertFalse(result.replayed)

    # --- the law
    def test_a_jump_gives_the_bits_that_were_played(self) -> None:
        for kind in KINDS:
            with self.subTest(kind):
                shutil.rmtree(self.folder, ignore_errors=True)
                _, kept, played = self.played(kind)
                self.assertFalse(kept.write())
                self.assertEqual(len(self.files()), LAST)
                fine, kept = self.opened(kind)
                for frame in (6, 2, 8, 3):
                    found = self.solve(fine, kind, frame)
                    self.assertTrue(found.replayed)
                    self.assertFalse(found.unplayed)
                    np.testing.assert_array_equal(found.positions, played[frame])
                self.assertEqual(kept.note, "")
                self.assertEqual(fine.status(found), [])

    def test_play_goes_on_from_a_jump_with_the_same_bits(self) -> None:
        for kind in ("adaptive", "layers that swing", "paths"):
            with self.subTest(kind):
                shutil.rmtree(self.folder, ignore_errors=True)
                _, kept, played = self.played(kind)
                kept.write()
                fifth = kept._name(kept.evaluator.frame_cache.timeline, 5.0)  # pylint: disable=protected-access
                for path in self.files():  # so that the frames behind the jump are solved
                    if path.name != fifth:
                        path.unlink()
                fine, _ = self.opened(kind)
                for frame in (5, 6, 7, 8):
                    np.testing.assert_array_equal(self.solve(fine, kind, frame).positions, played[frame])

    # --- what is never shown
    def test_frames_of_other_settings_paint_models_starts_and_rates(self) -> None:
        kind = "layers that swing"
        self.session(kind)
        settings = KINDS[kind][1]
        other = dict(settings=replace(settings, drape=0.5)), dict(start=2), dict(frame_rate=30.0), \
            dict(paint={"room": np.full(len(self.base.positions), 0.5, np.float32)})
        for more in other:
            with self.subTest(**more):
                fine, _ = self.opened(kind)
                self.expect_solved_anew(self.solve(fine, kind, 5, **more))
        fine, _ = self.opened(kind, identity="another")
        self.expect_solved_anew(self.solve(fine, kind, 5))
        fine, _ = self.opened(kind)
        self.expect_solved_anew(self.solve(fine, kind, 3, other=True))
        self.assertTrue(self.solve(fine, kind, 5).replayed)

    def test_frames_behind_one_that_has_changed(self) -> None:
        """Their own inputs are as before; what they went on from is not."""
        kind = "one mesh"
        self.session(kind)
        _, _, expected = self.played(kind, other=True)  # reads none behind frame 2
        shutil.rmtree(self.folder)
        _, _, alone = self.played(kind, other=True)
        for frame in expected:
            np.testing.assert_array_equal(expected[frame], alone[frame])

    def test_nor_after_a_jump_behind_it(self) -> None:
        kind = "one mesh"
        old = self.session(kind)
        fine, _ = self.opened(kind)
        np.testing.assert_array_equal(self.solve(fine, kind, 6).positions, old[6])  # nothing is known of frame 3 yet
        found = {frame: self.solve(fine, kind, frame, other=True).positions.copy() for frame in range(1, LAST + 1)}
        shutil.rmtree(self.folder)
        _, _, alone = self.played(kind, other=True)
        np.testing.assert_array_equal(found[6], alone[6])
        np.testing.assert_array_equal(found[LAST], alone[LAST])

    # --- a changed pose: frame 3 has another one, all others have the same inputs as before
    def both(self, kind: str) -> dict[int, np.ndarray]:
        """What is played after the change, in a second session."""
        old, new = self.session(kind), self.session(kind, other=True)
        self.assertFalse(any(np.array_equal(old[frame], new[frame]) for frame in range(3, LAST + 1)))
        return new

    def test_after_a_change_a_jump_gives_what_was_played_last(self) -> None:
        """Files behind the changed frame were never replaced, because their own inputs were the same: a jump gave the
        old frame, and called it final."""
        for kind in ("one mesh", "layers that swing"):
            with self.subTest(kind):
                shutil.rmtree(self.folder, ignore_errors=True)
                new = self.both(kind)
                self.assertEqual(len(self.files()), LAST)
                for jump in range(1, LAST + 1):
                    fine, kept = self.opened(kind)
                    found = self.solve(fine, kind, jump, other=True)
                    self.assertTrue(found.replayed)
                    self.assertFalse(found.unplayed)
                    np.testing.assert_array_equal(found.positions, new[jump])
                times = {path: path.stat().st_mtime_ns for path in self.files()}
                self.assertFalse(kept.write())
                self.assertEqual({path: path.stat().st_mtime_ns for path in self.files()}, times)

    def test_a_jump_behind_a_change_that_was_not_played_to_its_end(self) -> None:
        """A newer frame that is stored before them tells that they are old: they are not final any more."""
        kind = "layers that swing"
        for last in (3, 4, 7):
            with self.subTest(last=last):
                shutil.rmtree(self.folder, ignore_errors=True)
                new = self.both(kind)
                self.session(kind)
                self.session(kind, last=last, other=True)
                fine, _ = self.opened(kind)
                found = self.solve(fine, kind, 8, other=True)
                self.expect_solved_anew(found)
                self.assertTrue(found.unplayed)
                found = self.solve(fine, kind, 2, other=True)
                self.assertTrue(found.replayed and not found.unplayed)
                for frame in range(1, LAST + 1):
                    np.testing.assert_array_equal(self.solve(fine, kind, frame, other=True).positions, new[frame])

    def test_a_jump_is_compared_with_what_was_played_since(self) -> None:
        """It was read before the change, and nothing of the change is on disk yet."""
        kind = "layers that swing"
        self.both(kind)
        for jump in (6, 7):
            with self.subTest(jump=jump):
                fine, _ = self.opened(kind)
                self.assertTrue(self.solve(fine, kind, 6, other=True).replayed)
                for frame in range(1, 5):
                    self.solve(fine, kind, frame)
                found = self.solve(fine, kind, jump)
                self.assertFalse(found.replayed and not found.unplayed)

    def test_what_no_memory_was_left_for_does_not_speak_against_later_frames(self) -> None:
        """Of a long clip the first frames are forgotten before they are written, and their files are older ones."""
        kind = "layers that swing"
        new = self.both(kind)
        self.session(kind)
        fine, kept = self.opened(kind)
        fine.frame_cache.limit_bytes = 1
        for frame in range(1, LAST + 1):
            self.solve(fine, kind, frame, other=True)
        self.assertLess(len(fine.frame_cache.frames()), 4)
        kept.write()
        fine, _ = self.opened(kind)
        found = self.solve(fine, kind, LAST, other=True)
        self.assertTrue(found.replayed and not found.unplayed)
        np.testing.assert_array_equal(found.positions, new[LAST])

    def test_two_frame_rates_and_two_starts_are_kept_side_by_side(self) -> None:
        kind = "layers that swing"
        fine, kept, played = self.played(kind)
        slow = {frame: self.solve(fine, kind, frame, frame_rate=12.0).positions.copy() for frame in range(1, LAST + 1)}
        kept.write()
        self.assertEqual(len(self.files()), 2 * LAST)
        fine, _ = self.opened(kind)
        for frame, expected, rate in ((5, played, 24.0), (5, slow, 12.0), (7, played, 24.0), (7, slow, 12.0)):
            found = self.solve(fine, kind, frame, frame_rate=rate)
            self.assertTrue(found.replayed)
            np.testing.assert_array_equal(found.positions, expected[frame])

    def test_provisional_frames_are_not_kept(self) -> None:
        fine, kept = self.opened("layers that swing")
        self.solve(fine, "layers that swing", 5)
        kept.write()
        self.assertEqual(self.files(), [])

    # --- faults
    def test_what_is_damaged_is_said_solved_and_written_anew(self) -> None:
        kind = "one mesh"
        _, kept, played = self.played(kind)
        kept.write()
        whole = {path: path.read_bytes() for path in self.files()}
        damages = {"empty": lambda data: b"", "cut": lambda data: data[:-9], "text": lambda data: b"hello",
                   "bit": lambda data: data[:400] + bytes([data[400] ^ 1]) + data[401:],
                   "foreign": lambda data: data[:len(data) // 2] + os.urandom(len(data) // 2)}
        for name, damage in damages.items():
            with self.subTest(name):
                for path, data in whole.items():
                    path.write_bytes(damage(data))
                fine, kept = self.opened(kind)
                found = self.solve(fine, kind, 1)
                self.expect_solved_anew(found)
                np.testing.assert_array_equal(found.positions, played[1])
                self.assertEqual(kept.note, "Tube: a stored frame on disk is damaged, or of something else: it is "
                                            "solved anew")
                kept.write()
                self.assertEqual(sum(path.read_bytes() == whole[path] for path in whole), 1)

    def test_a_state_of_another_model_under_its_name(self) -> None:
        """Bytes that are whole, of the right identity, and do not fit: the library looks at them as a whole."""
        with mock.patch.object(FrameInput, "digest", lambda *_: bytes(16)):
            _, kept, _ = self.played("one mesh", last=1)
            kept.write()
            self.base = tube(16, 10)
            fine, kept = self.opened("one mesh")
            self.expect_solved_anew(self.solve(fine, "one mesh", 1))
        self.assertIn("damaged", kept.note)

    def test_a_full_disk_is_said_and_loses_nothing(self) -> None:
        fine, kept, played = self.played("one mesh")
        kept.write()
        before = {path: path.read_bytes() for path in self.files()}
        self.solve(fine, "one mesh", 9)

        def full(path: Path, data: bytes) -> int:
            with open(path, "wb") as file:
                file.write(data[:10])
            raise OSError(28, "No space left on device")
        with mock.patch.object(Path, "write_bytes", full):
            self.assertFalse(kept.write())
        self.assertIn("Tube: its stored frames are not kept: the disk of", kept.note)
        self.assertEqual({path: path.read_bytes() for path in self.folder.iterdir()}, before)
        np.testing.assert_array_equal(self.solve(fine, "one mesh", 3).positions, played[3])

    def test_a_folder_that_cannot_be_written_is_said(self) -> None:
        self.folder.parent.joinpath("Sleeve.frames").write_text("a file")
        _, kept, _ = self.played("one mesh", last=2)
        self.assertFalse(kept.write())
        self.assertIn("its stored frames are not kept", kept.note)
        self.assertEqual(self.folder.read_text(), "a file")

    def test_a_rename_that_is_refused_is_tried_again(self) -> None:
        """Windows refuses it while a virus scanner looks at the new file."""
        _, kept, _ = self.played("one mesh")
        replace, refused = os.replace, [True, False, True]

        def scanned(source: Path, target: Path) -> None:
            if refused and refused.pop():
                raise PermissionError(13, "Permission denied")
            replace(source, target)
        with mock.patch("os.replace", scanned):
            while kept.write(0.0):
                pass
        self.assertEqual((len(self.files()), len(os.listdir(self.folder)), kept.note), (LAST, LAST, ""))

    def test_renames_that_are_always_refused_are_said(self) -> None:
        _, kept, _ = self.played("one mesh")
        tries = 0
        with mock.patch("os.replace", side_effect=PermissionError(13, "Permission denied")):
            while kept.write(0.0):
                tries += 1
        self.assertIn(tries, range(2, 10))
        self.assertIn("Tube: its stored frames are not kept: nothing can be written", kept.note)
        self.assertEqual(os.listdir(self.folder), [])

    # --- the limit
    def test_the_oldest_go_first(self) -> None:
        fine, kept, _ = self.played("one mesh")
        kept.write()
        size = self.files()[0].stat().st_size
        for age, path in enumerate(self.files()):
            os.utime(path, (1000.0 + age, 1000.0 + age))
        oldest = self.files()[:4]
        kept.limit_bytes = 5 * size + 100
        self.solve(fine, "one mesh", 9)
        kept.write()
        self.assertLessEqual(sum(path.stat().st_size for path in self.files()), kept.limit_bytes)
        self.assertFalse(any(path.exists() for path in oldest))
        self.assertFalse(kept.write())  # what was swept is not written again

    def test_one_frame_that_is_larger_than_the_limit_is_not_written(self) -> None:
        _, kept, _ = self.played("one mesh")
        kept.limit_bytes = 100
        self.assertFalse(kept.write())
        self.assertEqual(self.files(), [])

    def test_it_stops_when_its_time_is_over_and_goes_on(self) -> None:
        _, kept, _ = self.played("one mesh")
        self.assertTrue(kept.write(0.0))
        self.assertEqual(len(self.files()), 1)
        while kept.write(0.0):
            pass
        self.assertEqual(len(self.files()), LAST)

    # --- two at once
    def test_two_that_write_and_sweep_the_same_folder(self) -> None:
        _, one, _ = self.played("one mesh")
        _, other, _ = self.played("one mesh")
        one.write(0.0)
        other.write()
        one.write()
        self.assertEqual(len(self.files()), LAST)
        other.limit_bytes = 1
        glob = Path.glob

        def gone(folder: Path, pattern: str) -> Any:
            found = list(glob(folder, pattern))
            for path in found:
                path.unlink()  # by another Blender, after the folder was listed
            return found
        with mock.patch.object(Path, "glob", gone):
            other._sweep()  # pylint: disable=protected-access
        fine, kept = self.opened("one mesh")
        self.expect_solved_anew(self.solve(fine, "one mesh", 1))
        self.assertEqual(kept.note, "")

    def test_what_a_killed_blender_left_is_swept(self) -> None:
        self.folder.mkdir()
        left = self.folder / f".x.frame.{clip_folder.HOST}.999999999-1.part"
        left.write_text("half")
        _, kept, _ = self.played("one mesh", last=1)
        kept.write()
        self.assertFalse(left.exists())

    def test_clear_removes_all_of_them(self) -> None:
        _, kept, _ = self.played("one mesh")
        kept.write()
        kept.clear()
        self.assertEqual(self.files(), [])
        self.assertFalse(kept.write())
        self.assertEqual(len(self.files()), LAST)

    def test_frames_of_another_format_are_not_found(self) -> None:
        _, kept, _ = self.played("one mesh")
        kept.write()
        with mock.patch.object(kept_frames, "FORMAT", 0):
            fine, kept = self.opened("one mesh")
        self.expect_solved_anew(self.solve(fine, "one mesh", 1))
        self.assertEqual(kept.note, "")


if __name__ == "__main__":
    unittest.main()
