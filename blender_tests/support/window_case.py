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
import os
import struct
import time
import unittest
import zlib
from pathlib import Path

import bpy
import numpy as np
from support import sleeve


class WindowCase(unittest.TestCase):

    def area(self, kind="VIEW_3D"):
        """A context override with the first area of this kind."""
        areas = bpy.context.window_manager.windows[0].screen.areas
        area = next(area for area in areas if area.type == kind)
        return sleeve.context(area=area, region=next(region for region in area.regions if region.type == "WINDOW"))

    def viewport_alone(self):
        """The 3D viewport fills the window, without headers and panels, until the test ends. For render jobs beside a
        window that draws: Blender forbids Python to write while it draws a panel, and while an engine renders, by one
        flag that each puts back as it found it. Where the engine ends within a panel, it stays forbidden for good."""
        with self.area():
            bpy.ops.screen.screen_full_area(use_hide_panels=True)
        self.addCleanup(self._all_areas)

    def _all_areas(self):
        with self.area():
            bpy.ops.screen.screen_full_area(use_hide_panels=True)

    def clear_view(self, space):
        """A 3D viewport with nothing but the objects."""
        space.show_gizmo = False
        for name in ("show_floor", "show_axis_x", "show_axis_y", "show_cursor", "show_text", "show_object_origins",
                     "show_outline_selected", "show_bones", "show_relationship_lines"):
            setattr(space.overlay, name, False)

    def until(self, condition, seconds=30.0):
        """Yields until it holds: a busy machine takes its time. `yield from self.until(lambda: ...)`."""
        ends = time.monotonic() + seconds
        while not condition() and time.monotonic() < ends:
            yield 0.1

    def pixels(self):
        """What the screen shows at the last redraw (yield once before), (height, width, 3) uint8, the top row first."""
        data = Path(os.environ["RUMPLE_FRAMEBUFFER"]).read_bytes()     # an XWD file
        header = struct.unpack(">25I", data[:100])
        header_size, width, height, row_bytes, colors = header[0], header[4], header[5], header[12], header[19]
        rows = np.frombuffer(data, np.uint8, row_bytes * height, header_size + 12 * colors).reshape(height, row_bytes)
        return rows[:, :4 * width].reshape(height, width, 4)[:, :, 2::-1]

    def screenshot(self, name):
        """Saves it as RUMPLE_OUT/name.png and returns the path."""
        path = Path(os.environ["RUMPLE_OUT"]) / f"{name}.png"
        path.write_bytes(png(self.pixels()))
        return path


def png(pixels):
    """(height, width, 3) uint8 as a PNG file."""
    height, width, _ = pixels.shape
    rows = np.zeros((height, 1 + 3 * width), np.uint8)      # each row begins with its filter: 0, none
    rows[:, 1:] = pixels.reshape(height, -1)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows.tobytes())) + chunk(b"IEND", b""))
