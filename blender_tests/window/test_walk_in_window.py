# SPDX-License-Identifier: GPL-3.0-or-later
"""The random walk with a viewport that draws, timers that rebuild, and real undo."""
from __future__ import annotations

import os
from typing import Iterator

import bpy
from rumple.blender.viewport import preview
from support import garment_walk, random_walk, window_walk
from support.window_case import WindowCase


class RandomWalk(WindowCase):

    def setUp(self) -> None:
        areas = bpy.context.window_manager.windows[0].screen.areas
        max(areas, key=lambda a: a.width * a.height).type = "VIEW_3D"

    def test_many_steps(self) -> Iterator[float]:
        drawn = 0
        for seed in random_walk.seeds(2):
            for _ in garment_walk.Walk(14 + seed, os.environ["RUMPLE_OUT"]).steps(45):
                yield 0.05
                drawn += len(preview._on_gpu)
                self.assertFalse([held for held in preview._on_gpu.values() if held.refusal])
        self.assertGreater(drawn, 10)

    def test_painted_while_it_plays_and_in_two_windows(self) -> Iterator[float]:
        strokes = strokes_in_play = painted = windows = 0
        for seed in random_walk.seeds(1):
            walk = window_walk.Walk(seed, os.environ["RUMPLE_OUT"])
            for step in walk.steps(60):
                yield step or 0.05
            strokes, strokes_in_play = strokes + walk.strokes, strokes_in_play + walk.strokes_in_play
            painted, windows = painted + walk.painted, windows + walk.windows
        print(f"{strokes} strokes, {strokes_in_play} of them in play, {painted} changed paint; {windows} more windows")
        self.assertGreater(min(strokes_in_play, windows), 0)
        if bpy.app.version[:2] != (4, 3):  # Debian's has no brushes
            self.assertGreater(painted, 0)
