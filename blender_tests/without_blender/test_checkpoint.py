# SPDX-License-Identifier: GPL-3.0-or-later
"""The law of checkpoints: what goes on from one has the bits of what was never ended, whatever the system, its cloth
and its rest shape. What is not whole, or of something else, is refused."""
from __future__ import annotations

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from rumple.core.cloth.surroundings import Field, Surroundings
from rumple.core.files.checkpoint import CannotGoOn, Checkpoint, carry_frames
from rumple.core.frame.engine import FrameResult, Wrinkles
from rumple.core.mesh.body import Body
from rumple.core.settings.system_settings import FieldSettings, MeshSettings, PathsSettings
from rumple.core.systems.all_systems import SYSTEMS
from support.frames import solve_frame
from support.meshes import tube

FRAMES, KEPT = range(1, 9), 4
# A vortex about the mesh, and a wind that differs from frame to frame.
BLOWS = (Field("VORTEX", (0.1, 0.0, 0.0), (0.0, 0.0, 1.0), strength=4.0, flow=1.0),
         Field("WIND", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), strength=3.0, noise=2.0, seed=5))
ONE = MeshSettings(density="LEVEL", level=1, layers="ONE")
LAYERED = replace(ONE, layers="CLOTH")
FIELD = FieldSettings(output="GEOMETRY", wavelength=0.05, detail=4)
PATHS = PathsSettings(width=0.02, detail=2, threshold=1.1)
HANG = dict(base_cloth="HANG", room=0.02, thickness=0.002)
SWING = {**HANG, "base_cloth": "SWING"}
KINDS: dict[str, tuple[str, Any]] = {
    "one mesh": ("MESH", ONE), "adaptive": ("MESH", replace(ONE, rest_shape="ADAPTIVE")),
    "layers": ("MESH", LAYERED), "layers that hang": ("MESH", replace(LAYERED, **HANG)),
    "layers that swing": ("MESH", replace(LAYERED, **SWING)),
    "on a dense mesh": ("MESH", replace(MeshSettings(), layers="CLOTH", **HANG)),
    "field on a dense mesh": ("FIELD", replace(FIELD, detail=1, **SWING)),
    "paths on a dense mesh": ("PATHS", replace(PATHS, drape=1.0, detail=1, **HANG)),
    "field": ("FIELD", FIELD), "adaptive field": ("FIELD", replace(FIELD, rest_shape="ADAPTIVE")),
    "draped field": ("FIELD", replace(FIELD, drape=1.0, **HANG)), "paths": ("PATHS", PATHS),
    "draped paths": ("PATHS", replace(PATHS, drape=1.0, **SWING))}


class Played:
    """One garment, its frames, and what it is worn over."""

    def __init__(self, kind: str) -> None:
        self.method, self.settings = KINDS[kind]
        self.base = tube(40, 60) if "dense" in kind else tube(14, 10)
        self.body = tube(10, 8)

    def build(self) -> Wrinkles:
        return SYSTEMS[self.method].wrinkles.build(self.base, self.settings)

    def solve(self, fine: Wrinkles, frame: int, settings: Any = None) -> FrameResult:
        squeeze = 1.0 - 0.05 * min(frame, 7 - frame)
        positions = np.ascontiguousarray(self.base.positions * (1.0, 1.0, squeeze), np.float32)
        inside = np.ascontiguousarray(self.body.positions * (0.8, 0.8, squeeze), np.float32)
        worn = Body(inside, self.body.corner_vertex[self.body.triangle_corner])
        cloth = self.settings.base_cloth != "OFF"
        found = solve_frame(fine, float(frame), positions, settings or self.settings, {}, start=1,
                            world_from_object=np.eye(3, dtype=np.float32), body=worn if cloth else None,
                            surroundings=Surroundings((0.01 * frame, 0.0, 0.0), fields=BLOWS, frame=frame))
        assert isinstance(found, FrameResult)
        return found

    def kept(self) -> tuple[Checkpoint, list[np.ndarray]]:
        """Of one frame, and what those after it look like."""
        fine = self.build()
        for frame in range(1, KEPT + 1):
            self.solve(fine, frame)
        cached = fine.frame_cache.get(float(KEPT))
        assert cached is not None
        checkpoint = Checkpoint.of(KEPT - 1, cached)
        return checkpoint, [self.solve(fine, frame).positions.copy() for frame in FRAMES[KEPT - 1:]]

    def go_on(self, checkpoint: Checkpoint) -> Wrinkles:
        """Another process: it comes to the frame by a jump, and takes the state in place of that."""
        fine = self.build()
        self.solve(fine, KEPT)
        fine.frame_cache.put(float(KEPT), checkpoint.restored(fine))
        return fine


def through_a_file(checkpoint: Checkpoint) -> Checkpoint:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.state"
        path.write_bytes(checkpoint.to_bytes("bake"))
        found = Checkpoint.read(path, "bake")
    assert found is not None
    return found


class Checkpoints(unittest.TestCase):

    def test_what_goes_on_from_one_has_the_same_bits(self) -> None:
        for kind in KINDS:
            with self.subTest(kind):
                played = Played(kind)
                checkpoint, after = played.kept()
                fine = played.go_on(through_a_file(checkpoint))
                first = played.solve(fine, KEPT)
                self.assertTrue(first.replayed)
                np.testing.assert_array_equal(first.positions, after[0])
                for frame, positions in zip(FRAMES[KEPT:], after[1:]):
                    np.testing.assert_array_equal(played.solve(fine, frame).positions, positions)
                self.assertTrue(fine.frame_cache.get(float(FRAMES[-1])).final)
                # A case where it could fail: the state counts.
                jumped = played.build()
                played.solve(jumped, KEPT)
                self.assertFalse(np.array_equal(played.solve(jumped, KEPT + 1).positions, after[1]))

    def test_stored_frames_go_on_in_what_shows_them_otherwise(self) -> None:
        """As where the smoothing of viewports is changed: all is replayed, and what follows has the same bits."""
        for kind in KINDS:
            with self.subTest(kind):
                played = Played(kind)
                former, fine, through = played.build(), played.build(), played.build()
                expected = [played.solve(through, frame).positions.copy() for frame in FRAMES]
                for frame in range(1, KEPT + 1):
                    played.solve(former, frame)
                reports = [played.solve(former, frame).report for frame in range(1, KEPT + 1)]
                stored = former.frame_cache.frames()
                carry_frames(former, fine)
                self.assertEqual((fine.frame_cache.frames(), former.frame_cache.frames()), (stored, []))
                for frame, positions in zip(FRAMES, expected):
                    found = played.solve(fine, frame)
                    self.assertEqual(found.replayed, frame <= KEPT)
                    np.testing.assert_array_equal(found.positions, positions)
                    if frame <= KEPT:
                        self.assertIs(found.report, reports[frame - 1])
                self.assertTrue(all(final for _, final in fine.frame_cache.frames()))

    def test_frames_that_went_on_are_forgotten_with_the_settings_they_were_solved_with(self) -> None:
        played = Played("layers")
        former, fine = played.build(), played.build()
        for frame in range(1, KEPT + 1):
            played.solve(former, frame)
        fine.settings_are_keyed = False
        carry_frames(former, fine)
        self.assertFalse(played.solve(fine, 2, replace(played.settings, bending=0.3)).replayed)
        self.assertEqual([frame for frame, _ in fine.frame_cache.frames()], [2.0])

    def test_other_settings_behind_it_are_those_of_playback(self) -> None:
        """Settings that are animated: what is held under the former ones is let go of, as in playback."""
        for kind in ("one mesh", "layers that swing", "field"):
            played = Played(kind)
            checkpoint, _ = played.kept()
            other = replace(played.settings, **({"wavelength": 0.06} if kind == "field" else {"bending": 0.3}))
            through = played.build()
            for frame in range(1, KEPT + 1):
                played.solve(through, frame)
            expected = played.solve(through, KEPT + 1, other).positions
            np.testing.assert_array_equal(played.solve(played.go_on(checkpoint), KEPT + 1, other).positions, expected)

    def test_whole_numbers_have_64_bits_on_every_system(self) -> None:
        """With NumPy 1 a whole number has 32 bits on Windows where nobody says how many: the bytes were others."""
        real = np.asarray

        def on_windows(values: Any, dtype: Any = None) -> np.ndarray:
            return real(values, np.int32 if dtype is None and isinstance(values, int) else dtype)
        for system in (real, on_windows):
            with mock.patch.object(np, "asarray", system):
                checkpoint, _ = Played("paths").kept()
            self.assertEqual(checkpoint.arrays["wrinkles/next_id"].dtype, np.int64)

    def test_what_is_not_whole_is_not_read(self) -> None:
        checkpoint, _ = Played("draped field").kept()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "a.state"
            data = checkpoint.to_bytes("bake")
            path.write_bytes(data)
            self.assertIsNone(Checkpoint.read(path, "another bake"))
            self.assertIsNone(Checkpoint.read(path.with_name("none"), "bake"))
            for place in range(60, len(data), 501):  # beyond the bits of an archive that no reader looks at
                harmed = bytearray(data)
                harmed[place] ^= 0xff
                path.write_bytes(harmed)
                found = Checkpoint.read(path, "bake")
                self.assertTrue(found is None or all(np.array_equal(found.arrays.get(name), values)
                                                     for name, values in checkpoint.arrays.items()), place)
            encrypted = bytearray(data)
            for header, flags in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
                encrypted[data.index(header) + flags] ^= 1
            path.write_bytes(encrypted)
            self.assertIsNone(Checkpoint.read(path, "bake"))
            for size in (0, 1, 100, len(data) // 2, len(data) - 1):
                path.write_bytes(data[:size])
                self.assertIsNone(Checkpoint.read(path, "bake"), size)

    def test_the_library_looks_at_all_of_a_state(self) -> None:
        """Arrays that are whole, of a mesh that is another one now, or made up: nothing is taken of them."""
        for kind in KINDS:
            played = Played(kind)
            checkpoint, _ = played.kept()
            fine = played.build()
            for name, values in checkpoint.arrays.items():
                if name.partition("/")[0] not in ("wrinkles", "cloth", "drape", "base", "swing"):
                    continue
                left_out = {other: array for other, array in checkpoint.arrays.items() if other != name}
                if not name.endswith("/time"):
                    with self.assertRaises(CannotGoOn, msg=f"{kind}: {name}"):
                        Checkpoint(0, left_out).restored(fine)
                if values.dtype.kind == "f" and values.size:
                    wrong = np.array(values)
                    wrong.reshape(-1)[-1] = np.nan
                    with self.assertRaises(CannotGoOn, msg=f"{kind}: {name}"):
                        Checkpoint(0, {**checkpoint.arrays, name: wrong}).restored(fine)
                if values.ndim and len(values):
                    with self.assertRaises(CannotGoOn, msg=f"{kind}: {name}"):
                        Checkpoint(0, {**checkpoint.arrays, name: np.ascontiguousarray(values[:-1])}).restored(fine)

    def test_where_cloth_swung_is_checked_as_well(self) -> None:
        """The library does not see these three arrays of a frame before. They were taken as they came, so the state was
        restored, and every later frame failed, or was not finite."""
        played = Played("layers that swing")
        checkpoint, _ = played.kept()
        fine = played.build()
        for name in ("seconds", "world_from_object", "location"):
            good = checkpoint.arrays[f"swing/{name}"]
            for what, wrong in (("another shape", good.reshape(1, *good.shape)), ("not finite", good * np.nan),
                                ("infinite", good + np.inf), ("another type", good.astype(np.float32)),
                                ("text", np.array("text")), ("one number less", good.reshape(-1)[:-1])):
                with self.subTest(name, wrong=what), self.assertRaisesRegex(CannotGoOn, name):
                    Checkpoint(0, {**checkpoint.arrays, f"swing/{name}": wrong}).restored(fine)
            left_out = {other: array for other, array in checkpoint.arrays.items() if other != f"swing/{name}"}
            with self.assertRaises(CannotGoOn):
                Checkpoint(0, left_out).restored(fine)

    def test_cloth_that_was_carried_is_only_of_a_garment_as_dense(self) -> None:
        played, other = Played("field on a dense mesh"), Played("draped field")
        checkpoint, _ = played.kept()
        good = checkpoint.arrays["coarse/solved"]
        for what, wrong in (("another mesh", good[:-1]), ("not finite", good * np.nan), ("text", np.array("text"))):
            with self.subTest(what), self.assertRaisesRegex(CannotGoOn, "solved"):
                Checkpoint(0, {**checkpoint.arrays, "coarse/solved": np.ascontiguousarray(wrong)}).restored(
                    played.build())
        for fine, arrays in ((other.build(), checkpoint.arrays),
                             (played.build(), {name: array for name, array in checkpoint.arrays.items()
                                               if name != "coarse/solved"})):
            with self.assertRaises(CannotGoOn):
                Checkpoint(0, arrays).restored(fine)

    def test_hints_of_another_mesh_are_refused(self) -> None:
        wrong = Played("layers that hang").kept()[0]
        wrong.arrays["cloth/contact_hint"] = np.full_like(wrong.arrays["cloth/contact_hint"], 100000)
        with self.assertRaisesRegex(CannotGoOn, "contact_hint: expected -1 to"):
            wrong.restored(Played("layers that hang").build())


if __name__ == "__main__":
    unittest.main()
