# SPDX-License-Identifier: GPL-3.0-or-later
"""Played for long, every system gives the same bits and needs no more memory. scripts/soak plays 100,000 frames."""
from __future__ import annotations

import os
import resource
import time
import unittest
from pathlib import Path
from typing import Callable

import bpy
import numpy as np
from support import face, sleeve

FRAMES = int(os.environ.get("RUMPLE_SOAK_FRAMES", "400"))  # of each system
WARM = 0.2  # of the frames: what Blender and Python take once, they take in these
MOST_GROWTH = 24.0  # MB after that, however many frames: a byte lost in each vertex of a frame is 30 MB in 100,000


def memory() -> float:
    """MB that this process has; where the system does not say it (a chroot) the most that it has had."""
    try:
        return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * resource.getpagesize() / 2.0**20
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


class Soak(unittest.TestCase):
    def soak(self, name: str, shown: Callable[[], np.ndarray]) -> None:
        """The clip again and again, each time solved anew. shown: what is looked at in its last frame."""
        clips = max(FRAMES // sleeve.LAST, 5)
        first, seconds, warm = np.empty(0), [], 0.0
        for clip in range(clips):
            if bpy.ops.object.rumple_clear_frames.poll():
                bpy.ops.object.rumple_clear_frames()
            began = time.perf_counter()
            sleeve.play()
            seconds.append((time.perf_counter() - began) / sleeve.LAST)
            found = shown()
            first = found if clip == 0 else first
            np.testing.assert_array_equal(found, first, f"clip {clip + 1} of {clips}")
            warm = memory() if clip < WARM * clips else warm
        growth = memory() - warm
        self.report(name, clips * sleeve.LAST, seconds, growth)
        self.assertLess(growth, MOST_GROWTH)

    def report(self, name: str, frames: int, seconds: list[float], growth: float) -> None:
        """A line of the table."""
        tenth = max(len(seconds) // 10, 1)
        early, late = (1000.0 * float(np.median(part)) for part in (seconds[:tenth], seconds[-tenth:]))
        with (Path(os.environ["RUMPLE_OUT"]) / "soak.txt").open("a", encoding="utf-8") as table:
            table.write(f"{name}: {frames} frames, {early:.2f} ms a frame in the first tenth, {late:.2f} in the last, "
                        f"{growth:.1f} MB more memory\n")

    def wrinkled(self, method: str, base_cloth: str) -> None:
        obj = sleeve.scene(wrinkles=False)
        for settings in (obj.rumple.mesh, obj.rumple.field, obj.rumple.paths):
            settings.base_cloth = base_cloth
        bpy.ops.object.rumple_add(method=method)
        if method == "FIELD":
            obj.rumple.field.output = "GEOMETRY"

    def positions(self) -> np.ndarray:
        return sleeve.shown(bpy.context.object)

    def test_wrinkle_mesh(self) -> None:
        self.wrinkled("MESH", "OFF")
        self.soak("Wrinkle Mesh", self.positions)

    def test_cloth_over_a_body(self) -> None:
        """What the first click makes of a garment."""
        obj = sleeve.scene(wrinkles=False)
        obj.rumple.mesh.property_unset("base_cloth")
        sleeve.under(obj)
        bpy.ops.object.rumple_add(method="MESH")
        settings = obj.rumple.mesh
        self.assertEqual((settings.base_cloth, settings.layers, obj.rumple.body.name), ("HANG", "CLOTH", "Human"))
        self.soak("Wrinkle Mesh, Hang, over a body", self.positions)

    def test_cloth_that_swings(self) -> None:
        self.wrinkled("MESH", "SWING")
        self.soak("Wrinkle Mesh, Swing", self.positions)

    def test_wrinkle_field(self) -> None:
        self.wrinkled("FIELD", "HANG")
        self.soak("Wrinkle Field, Hang", self.positions)

    def test_wrinkle_paths(self) -> None:
        self.wrinkled("PATHS", "OFF")
        self.soak("Wrinkle Paths", self.positions)

    def test_wrinkle_maps(self) -> None:
        obj, rig = face.scene()
        face.two_poses(obj, rig)
        face.animate(rig)
        self.soak("Wrinkle Maps", lambda: face.mask(obj, "Surprise"))
