# SPDX-License-Identifier: GPL-3.0-or-later
"""One garment of a real scene, wrinkled by one click and played through once, for the real suite."""
from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from rumple.blender.objects import runtimes

DATA = Path(os.environ.get("RUMPLE_DATA", ""))
OUT = Path(os.environ.get("RUMPLE_OUT", ""))


class EveryFrame:
    """A test of what was measured in the frames of a clip, `seen`: mix it into a TestCase."""

    def for_every_frame(self, law: Any) -> None:
        """The law holds, or the first frames where it does not are named."""
        broken = [s for s in self.seen if not law(s)]
        self.assertEqual(broken[:3], [], f"{len(broken)} of {len(self.seen)} frames")


class PlayedOnce:
    """Laws of any system on a whole clip. A system adds method, look() and summary()."""

    file: str
    name: str
    method: str
    variant = ""  # in the name of the file of what was measured
    settings: dict = {"base_cloth": "OFF"}  # set before the click: the system alone, over the animated mesh

    @classmethod
    def setUpClass(cls) -> None:
        bpy.ops.wm.open_mainfile(filepath=str(DATA / f"{cls.file}.blend"))
        cls.scene, cls.garment = bpy.context.scene, bpy.data.objects[cls.name]
        for other in bpy.data.objects:  # bodies do not matter here, and cost time
            if other.type == "MESH" and other != cls.garment:
                other.hide_viewport = True
        bpy.context.view_layer.objects.active = cls.garment
        cls.frames = range(cls.scene.frame_start, cls.scene.frame_end + 1)
        cls.scene.frame_set(cls.frames[0])
        for name, value in cls.settings.items():
            setattr(getattr(cls.garment.rumple, cls.method.lower()), name, value)
        if cls.settings.get("base_cloth") == "OFF":
            cls.garment.rumple.body = None  # set: none is looked for
        cls.garment.rumple.viewport_steps = cls.garment.rumple.mesh.display_steps  # the mesh of renders is measured
        assert bpy.ops.object.rumple_add(method=cls.method) == {"FINISHED"}, cls.garment.rumple.message
        cls.fine = runtimes.of(cls.garment).evaluator
        cls.seen = [cls.look(frame) for frame in cls.frames]
        OUT.mkdir(parents=True, exist_ok=True)
        common = dict(file=cls.file, garment=cls.name, blender=bpy.app.version_string, frames=len(cls.seen))
        path = OUT / f"{cls.method.lower()}{cls.variant}_{cls.file}_{cls.name}.json"
        path.write_text(json.dumps({**common, **cls.summary()}, indent=1))

    @classmethod
    def look(cls, frame: int) -> dict:
        """Show a frame and measure it: frame, message, finite, digest (of all that is shown, all bits) and more."""
        raise NotImplementedError

    @classmethod
    def summary(cls) -> dict:
        """What goes to RUMPLE_OUT."""
        raise NotImplementedError

    def test_every_frame_is_there_and_finite(self) -> None:
        self.assertGreaterEqual(len(self.seen), 100)
        for seen in self.seen:
            self.assertEqual((seen["message"], seen["finite"]), ("", True), seen["frame"])

    def test_replayed_in_any_order_to_the_bit(self) -> None:
        for index in (len(self.seen) - 1, 0, *np.random.default_rng(1).permutation(len(self.seen))[:16]):
            self.assertEqual(self.look(self.seen[index]["frame"])["digest"], self.seen[index]["digest"])
