# SPDX-License-Identifier: GPL-3.0-or-later
"""The walk between scenes and files with what needs a window: playback that goes on through all other steps, strokes of
the mouse in Weight Paint, and a second window, on another scene or the same."""
from __future__ import annotations

from typing import Any, Iterator

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from rumple.blender.objects import mesh_reader
from support import file_walk, sleeve


class Walk(file_walk.Walk):

    FIRST = ("do_play", "do_stroke", "do_window")  # so that every walk has them
    OFTEN: tuple[str, ...] = (*file_walk.Walk.OFTEN, *("do_play", "do_stroke", "do_window") * 3)

    def __init__(self, seed: int, folder: str) -> None:
        super().__init__(seed, folder)
        self.area: bpy.types.Area | None = None  # where a stroke is to come
        self.strokes = self.strokes_in_play = self.painted = self.windows = 0

    def choose(self, names: list[str]) -> str:
        return self.FIRST[len(self.done)] if len(self.done) < len(self.FIRST) else super().choose(names)

    def between(self) -> Iterator[float]:
        yield from super().between()
        if self.area is None:
            return
        yield 0.3  # the view comes to rest
        places = self.places()
        self.area = None
        if places:
            self.strokes += 1
            self.strokes_in_play += bpy.context.window_manager.windows[0].screen.is_animation_playing
            before = self.paint()
            yield from self.stroke(places)
            self.painted += not np.array_equal(self.paint(), before)

    def places(self) -> list[tuple[int, int]]:
        """Some points of the garment, pixels of the window."""
        region = next(region for region in self.area.regions if region.type == "WINDOW")
        points = sleeve.shown(self.active())
        seen = (location_3d_to_region_2d(region, self.area.spaces.active.region_3d, points[row])
                for row in self.random.sample(range(len(points)), 6))
        return [(int(region.x + at.x), int(region.y + at.y)) for at in seen
                if at is not None and 0 < at.x < region.width and 0 < at.y < region.height]

    def active(self) -> bpy.types.Object:
        return bpy.context.window_manager.windows[0].view_layer.objects.active

    def paint(self) -> np.ndarray:
        """What is painted on."""
        obj = self.active()
        return mesh_reader.group_weights(obj, obj.data, [obj.vertex_groups.active.name])

    def stroke(self, places: list[tuple[int, int]]) -> Iterator[float]:
        for kind, value, (x, y) in (("MOUSEMOVE", "NOTHING", places[0]), ("LEFTMOUSE", "PRESS", places[0]),
                                    *(("MOUSEMOVE", "NOTHING", place) for place in places[1:]),
                                    ("LEFTMOUSE", "RELEASE", places[-1])):
            bpy.context.window_manager.windows[0].event_simulate(kind, value, x=x, y=y)
            yield 0.02  # a frame of playback may come in between
        yield 0.1

    # --- the steps
    def do_play(self) -> None:
        """Starts or stops."""
        bpy.ops.screen.animation_play()

    def do_stroke(self) -> None:
        """Takes paint away, or puts it back, where the mouse goes."""
        self.do_paint()
        area = next((area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D"),
                    None)
        if area is None or self.active() is None or self.active().mode != "WEIGHT_PAINT":
            return
        region = next(region for region in area.regions if region.type == "WINDOW")
        with sleeve.context(area=area, region=region):
            bpy.ops.view3d.view_selected()
        self.area = area

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
