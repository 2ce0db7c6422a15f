# SPDX-License-Identifier: GPL-3.0-or-later
"""The base class of tests that need a window.

A test method that yields is a generator: each `yield` lets Blender handle events and redraw once, `yield 0.5`
lets it run for half a second.

    class Panel(WindowCase):
        def test_panel_draws(self):
            with self.area("PROPERTIES"):
                bpy.ops.object.rumple_add(method="MESH")
            yield
            self.screenshot("panel")
"""
from __future__ import annotations

import os
import struct
import time
import unittest
import zlib
from pathlib import Path
from typing import Any, Callable, Iterator

import bpy
import numpy as np
from support import sleeve


class WindowCase(unittest.TestCase):

    def area(self, kind: str = "VIEW_3D") -> Any:
        """A context override with the first area of this kind."""
        areas = bpy.context.window_manager.windows[0].screen.areas
        area = next(area for area in areas if area.type == kind)
        return sleeve.context(area=area, region=next(region for region in area.regions if region.type == "WINDOW"))

    def render_job(self, just_before: Callable[[], object] = lambda: None, **how: object) -> Iterator[float]:
        """A render as F12 starts it, with the properties of render.render, and its end: `yield from`.
        just_before: what is done then, with no timer in between.

        Two faults of Blender 3.4 are kept away. By a key, not from Python: bpy.ops lets go of Python's lock while the
        operator looks into the override of the context, and the handlers run in the thread of the job by then; that
        broke Python's memory. And with the viewport alone in the window: Blender forbids Python to write while it draws
        a panel, and while an engine renders, by one flag that each puts back as it found it; where the engine ends
        within a panel, it stays forbidden for good.
        """
        ended, over = [], (bpy.app.handlers.render_complete, bpy.app.handlers.render_cancel)
        for handlers in over:
            handlers.append(ended_by := lambda *_arguments: ended.append(1))
            self.addCleanup(handlers.remove, ended_by)
        self._viewport_alone_or_not()
        yield from self.press_for("render.render", just_before, **how)
        yield from self.until(lambda: ended and not bpy.app.is_job_running("RENDER"), 240.0)
        self._viewport_alone_or_not()
        self.assertEqual(len(ended), 1)

    def _viewport_alone_or_not(self) -> None:
        """Without headers and panels."""
        with self.area():
            bpy.ops.screen.screen_full_area(use_hide_panels=True)

    def press_for(self, operator: str, just_before: Callable[[], object], **how: object) -> Iterator[float]:
        """A key that runs an operator with these properties: `yield from`."""
        keymap = bpy.context.window_manager.keyconfigs.addon.keymaps.new("Window")
        item = keymap.keymap_items.new(operator, "F19", "PRESS")
        for name, value in how.items():
            setattr(item.properties, name, value)
        yield
        just_before()
        window = bpy.context.window_manager.windows[0]
        for value in ("PRESS", "RELEASE"):
            window.event_simulate("F19", value, x=window.width // 2, y=window.height // 2)
        yield
        keymap.keymap_items.remove(item)

    def clear_view(self, space: bpy.types.SpaceView3D) -> None:
        """A 3D viewport with nothing but the objects."""
        space.show_gizmo = False
        for name in ("show_floor", "show_axis_x", "show_axis_y", "show_cursor", "show_text", "show_object_origins",
                     "show_outline_selected", "show_bones", "show_relationship_lines"):
            setattr(space.overlay, name, False)

    def until(self, condition: Callable[[], object], seconds: float = 30.0) -> Iterator[float]:
        """Yields until it holds: a busy machine takes its time. `yield from self.until(lambda: ...)`."""
        ends = time.monotonic() + seconds
        while not condition() and time.monotonic() < ends:
            yield 0.1

    def pixels(self) -> np.ndarray:
        """What the screen shows at the last redraw (yield once before), (height, width, 3) uint8, the top row first."""
        data = Path(os.environ["RUMPLE_FRAMEBUFFER"]).read_bytes()     # an XWD file
        header = struct.unpack(">25I", data[:100])
        header_size, width, height, row_bytes, colors = header[0], header[4], header[5], header[12], header[19]
        rows = np.frombuffer(data, np.uint8, row_bytes * height, header_size + 12 * colors).reshape(height, row_bytes)
        return rows[:, :4 * width].reshape(height, width, 4)[:, :, 2::-1]

    def screenshot(self, name: str) -> str:
        """Saves it as RUMPLE_OUT/name.png and returns the path."""
        path = Path(os.environ["RUMPLE_OUT"]) / f"{name}.png"
        path.write_bytes(png(self.pixels()))
        return path


def png(pixels: np.ndarray) -> bytes:
    """(height, width, 3) uint8 as a PNG file."""
    height, width, _ = pixels.shape
    rows = np.zeros((height, 1 + 3 * width), np.uint8)      # each row begins with its filter: 0, none
    rows[:, 1:] = pixels.reshape(height, -1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows.tobytes())) + chunk(b"IEND", b""))
