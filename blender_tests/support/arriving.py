# SPDX-License-Identifier: GPL-3.0-or-later
"""What arrives at the wrinkles of a garment, and that they are solved over it."""
from __future__ import annotations

import bpy
import numpy as np
from rumple.blender import scheduler
from rumple.blender.objects import modifier, runtimes
from support import sleeve


class Arriving:
    """Mix it into a TestCase."""

    def bare(self, obj: bpy.types.Object) -> np.ndarray:
        """What arrives at the wrinkles in this frame."""
        nodes_mod = modifier.find(obj)
        with scheduler.suspended():
            nodes_mod.show_viewport = False
            bpy.context.view_layer.update()
            positions = sleeve.shown(obj)
            nodes_mod.show_viewport = True
            bpy.context.view_layer.update()
        return positions

    def check(self, obj: bpy.types.Object) -> None:
        """It plays on what arrives, and is solved over it."""
        self.assertEqual(obj.rumple.message, "")
        fine = runtimes.of(obj).evaluator
        arriving = self.bare(obj)
        self.assertEqual(fine.coarse_count, len(arriving))
        sleeve.play(1, 8)
        self.assertEqual(obj.rumple.message, "")
        np.testing.assert_array_equal(runtimes.of(obj).inputs.positions[:len(arriving)], self.bare(obj))
        shown = sleeve.shown(obj)
        self.assertEqual(len(shown), fine.vertex_count)
        self.assertTrue(np.isfinite(shown).all())
        self.assertGreater(np.abs(runtimes.of(obj).result.offset).max(), 1e-4)
