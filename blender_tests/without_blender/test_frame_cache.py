# SPDX-License-Identifier: GPL-3.0-or-later
"""The frame cache alone, and what clears it."""
from __future__ import annotations

import unittest
from dataclasses import replace
from types import SimpleNamespace
from unittest import mock

import numpy as np
from rumple.core.frame.frame_cache import CachedFrame, FrameCache
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from test_engine import FRAMES, SETTINGS, clip
from support.frames import solve_frame
from support.meshes import tube


class Removing(float):
    """The number of a frame that is removed while somebody sorts, as by a render that stores frames at the limit of
    memory meanwhile."""

    cache: FrameCache

    def __lt__(self, other: float) -> bool:
        self.cache._entries.pop(float(self), None)
        return float.__lt__(self, other)


class ReadMeanwhile(unittest.TestCase):

    def test_a_frame_that_is_removed_while_a_panel_lists_them(self) -> None:
        """The numbers were sorted, and then each was looked up: that one was gone, and the panel broke off with a
        KeyError."""
        cache = FrameCache()
        Removing.cache = cache
        for frame in (3, 1, 2):
            cache.put(Removing(frame), CachedFrame.of(SimpleNamespace(nbytes=1), b"", b"", True, None))
        self.assertEqual(cache.frames(), [(1.0, True), (2.0, True), (3.0, True)])
        self.assertLess(len(cache.frames()), 3)  # so some were removed


class Replaced(unittest.TestCase):

    def played(self) -> FrameCache:
        cache = FrameCache()
        for frame in (1.0, 2.0, 2.5, 3.0, 4.0):
            cache.put(frame, self.frame())
        return cache

    def frame(self) -> CachedFrame:
        return CachedFrame.of(mock.Mock(nbytes=10), b"", b"", True, None)

    def test_frames_behind_a_whole_one_go_on_from_it(self) -> None:
        cache = self.played()
        cache.put(2.0, self.frame())
        self.assertEqual([final for _, final in cache.frames()], [True, True, False, False, False])

    def test_none_goes_on_from_a_subframe(self) -> None:
        """Motion blur replaces it: all that was played behind it was solved again."""
        cache = self.played()
        cache.put(2.5, self.frame())
        self.assertTrue(all(final for _, final in cache.frames()))


class Cleared(unittest.TestCase):

    def test_a_setting_that_changes_together_with_the_frame_starts_anew(self) -> None:
        """The new frame went on from the one before under the former setting, and was called final."""
        base = tube(12, 12)
        poses, other = clip(base), replace(SETTINGS, radius=0.6)
        mesh, fresh = (WrinkleMesh.build(base, SETTINGS) for _ in range(2))
        for frame in FRAMES:
            solve_frame(mesh, float(frame), poses[frame], SETTINGS, {}, start=1)
        mesh.settings_are_keyed = False
        jumped, alone = (solve_frame(one, 5.0, poses[5], other, {}, start=1) for one in (mesh, fresh))
        self.assertEqual(mesh.frame_cache.frames(), [(5.0, False)])
        np.testing.assert_array_equal(jumped.positions, alone.positions)
        mesh.settings_are_keyed = True
        solve_frame(mesh, 6.0, poses[6], SETTINGS, {}, start=1)
        self.assertEqual([frame for frame, _ in mesh.frame_cache.frames()], [5.0, 6.0])


if __name__ == "__main__":
    unittest.main()
