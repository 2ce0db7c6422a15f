# SPDX-License-Identifier: GPL-3.0-or-later
"""The frame rendered is the frame solved, in each engine: the same tests in -b and in a window."""
from __future__ import annotations

import os
import tempfile
import unittest

import bpy
import numpy as np
from support import reference_solve, sleeve, small_renders

# Pixels by which two renders of the same thing may differ. Positions are equal to a rounding (1.2e-7 m), which may move
# an edge past a sample; EEVEE of 5.2 spreads a sample over four pixels.
STRAY = 4
OTHER = 20  # pixels by which a render of something else differs at least


class Engines:
    """Each: a still after a jump, an animation, motion blur (Workbench has none), and that folds show at all."""

    def stage(self, engine: str) -> bpy.types.Object:
        if engine != "CYCLES" and not small_renders.can_draw():
            raise unittest.SkipTest(f"{engine} needs a screen in this Blender: the window suite does it")
        return small_renders.stage(engine)

    def check_still(self, engine: str) -> None:
        obj = self.stage(engine)
        found = {frame: small_renders.still(frame) for frame in (14, 9)}
        for frame, picture in found.items():
            right, = reference_solve.expected(obj, [frame])
            self.assertLessEqual(reference_solve.unlike(picture, right), STRAY, f"frame {frame}")
            for wrong in (*reference_solve.expected(obj, [frame - 1]), reference_solve.unfolded(obj, frame)):
                self.assertGreater(reference_solve.unlike(picture, wrong), OTHER, f"frame {frame}")
        self.assertEqual(obj.rumple.message, "")

    def check_animation(self, engine: str) -> None:
        obj = self.stage(engine)
        found = small_renders.clip(1, 6)
        right = dict(zip(found, reference_solve.expected(obj, range(1, 7))))
        for frame in found:
            self.assertLessEqual(reference_solve.unlike(found[frame], right[frame]), STRAY, f"frame {frame}")
        for frame in range(3, 7):
            self.assertGreater(reference_solve.unlike(found[frame], right[frame - 1]), OTHER, f"frame {frame}")
        self.assertEqual(obj.rumple.message, "")

    def check_motion_blur(self, engine: str, baked: bool = False) -> None:
        """A blurred frame of an animation covers the mean of the moments while the shutter is open.

        Of what it covers: the colours of a half covered pixel are stored without their weight. The arm bends so fast
        that the grain of edges is small beside the blur.
        """
        obj = self.stage(engine)
        sleeve.bend_until(5)
        right = np.mean(reference_solve.expected(obj, [1, 2, *(3.0 + (np.arange(8) - 3.5) / 8.0)])[2:], axis=0)
        if baked:
            self.bake(obj)
        sharp = small_renders.clip(1, 3)[3]
        small_renders.blur(1.0)
        blurred = small_renders.clip(1, 3)[3]
        self.assertGreater(reference_solve.unlike(sharp, blurred), OTHER)
        self.assertLess(reference_solve.uncovered(blurred, right), 0.5 * reference_solve.uncovered(blurred, sharp))
        self.assertLess(reference_solve.uncovered(blurred, right), 0.5 * reference_solve.uncovered(sharp, right))
        self.assertEqual(obj.rumple.message, "")

    def bake(self, obj: bpy.types.Object) -> None:
        """With a sample between two frames: the shutter opens and closes there."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder.name, "scene.blend"))
        obj.rumple.bake_samples = 2
        with sleeve.context():
            sleeve.make_active(obj)
            self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})

    def test_workbench_still_after_a_jump(self) -> None:
        self.check_still("BLENDER_WORKBENCH")

    def test_workbench_animation(self) -> None:
        self.check_animation("BLENDER_WORKBENCH")

    def test_cycles_still_after_a_jump(self) -> None:
        self.check_still("CYCLES")

    def test_cycles_animation(self) -> None:
        self.check_animation("CYCLES")

    def test_eevee_still_after_a_jump(self) -> None:
        self.check_still("EEVEE")

    def test_eevee_animation(self) -> None:
        self.check_animation("EEVEE")

    def test_cycles_motion_blur(self) -> None:
        self.check_motion_blur("CYCLES")

    def test_cycles_motion_blur_of_a_baked_clip(self) -> None:
        self.check_motion_blur("CYCLES", baked=True)

    def test_eevee_motion_blur(self) -> None:
        self.check_motion_blur("EEVEE")
