# SPDX-License-Identifier: GPL-3.0-or-later
"""The frame cache alone."""
from __future__ import annotations

import unittest
from types import SimpleNamespace

from rumple.core.frame_cache import CachedFrame, FrameCache


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


if __name__ == "__main__":
    unittest.main()
