# SPDX-License-Identifier: GPL-3.0-or-later
"""The random walk with a viewport that draws, timers that rebuild, and real undo."""
from __future__ import annotations

import os
from typing import Iterator

import bpy
from rumple.blender.viewport import preview
from support import garment_walk
from support.window_case import WindowCase


class RandomWalk(WindowCase):

    def test_many_steps(self) -> Iterator[float]:
        areas = bpy.context.window_manager.windows[0].screen.areas
        max(areas, key=lambda a: a.width * a.height).type = "VIEW_3D"
        drawn = 0
        for seed in (14, 15):
            for _ in garment_walk.Walk(seed, os.environ["RUMPLE_OUT"]).steps(45):
                yield 0.05
                drawn += len(preview._on_gpu)
                self.assertFalse([held for held in preview._on_gpu.values() if held.refusal])
        self.assertGreater(drawn, 10)
