# SPDX-License-Identifier: GPL-3.0-or-later
"""The walk between scenes and files with what needs a window: playback that goes on through all other steps, strokes of
the mouse in Weight Paint, and a second window, on another scene or the same."""
from __future__ import annotations

from typing import Any, Iterator

import bpy
from support import file_walk, sleeve


class Walk(file_walk.Walk):

    FIRST = ("do_play", "do_stroke", "do_window")  # so that every walk has them
    OFTEN: tuple[str, ...] = (*file_walk.Walk.OFTEN, *("do_play", "do_stroke", "do_window") * 3)

    def __init__(self, seed: int, folder: str) -> None:
        super().__init__(seed, folder)
        self.places: list[tuple[int, int]] = []  # of a stroke that is to come, pixels of the window
        self.strokes = self.strokes_in_play = self.windows = 0

    def choose(self, names: list[str]) -> str:
        return self.FIRST[len(self.done)] if len(self.done) < len(self.FIRST) else super().choose(names)

    def between(self) -> Iterator[float]:
        yield from super().between()
        if self.places:
            self.strokes += 1
            self.strokes_in_play += bpy.context.window_manager.windows[0].screen.is_animation_playing
            yield from self.stroke()

    def stroke(self) -> Iterator[float]:
        places, self.places = self.places, []
        for kind, value, (x, y) in (("MOUSEMOVE", "NOTHING", places[0]), ("LEFTMOUSE", "PRESS", places[0]),
                                    *(("MOUSEMOVE", "NOTHING", place) for place in places[1:]),
                                    ("LEFTMOUSE", "RELEASE", places[-1])):
            bpy.context.window_manager.windows[0].event_simulate(kind, value, x=x, y=y)
            yield 0.02  # a frame of playback may come in between

    # --- the steps
    def do_play(self) -> None:
        """Starts or stops."""
        bpy.ops.screen.animation_play()

    def do_stroke(self) -> None:
        """Takes paint away, or puts it back, where the mouse goes."""
        obj = self.pick()
        if obj is None:
            return
        area = next((area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D"),
                    None)
        if area is None:
            return
        region = next(region for region in area.regions if region.type == "WINDOW")
        with sleeve.context(area=area, region=region):
            bpy.ops.view3d.view_selected()
        self.do_paint()
        middle = region.x + region.width // 2, region.y + region.height // 2
        wide = region.width // 6
        self.places = [(middle[0] + self.random.randint(-wide, wide), middle[1] + self.random.randint(-wide, wide))
                       for _ in range(6)]

    def do_window(self) -> Any:
        """Opens a second one, shows a scene there, or closes it."""
        windows = bpy.context.window_manager.windows
        if len(windows) < 2:
            self.windows += 1
            return bpy.ops.wm.window_new_main() if self.random.random() < 0.5 else bpy.ops.wm.window_new()
        if self.random.random() < 0.5:
            windows[1].scene = self.random.choice(list(bpy.data.scenes))
            return None
        with bpy.context.temp_override(window=windows[1]):
            return bpy.ops.wm.window_close()
