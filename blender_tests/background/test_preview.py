# SPDX-License-Identifier: GPL-3.0-or-later
"""The GPU preview in background mode: off, without an error, whatever the switch says."""
from __future__ import annotations

import unittest

import bpy
from rumple.blender.objects import runtimes
from rumple.blender.viewport import gpu_arrays, preview
from support import sleeve


class Background(unittest.TestCase):

    def test_it_is_off(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        obj.rumple.field.gpu_preview = True
        bpy.ops.object.rumple_add(method="FIELD")
        sleeve.play(1, 5)
        self.assertEqual(obj.rumple.message, "")
        self.assertFalse(preview.handler.added)
        self.assertEqual((gpu_arrays._kept, len(preview._on_gpu)), ({}, 0))

    def test_unregister_and_register(self) -> None:
        preview.unregister()
        preview.register()
        self.assertFalse(preview.handler.added)

    def test_the_switch_is_not_part_of_what_is_solved(self) -> None:
        """Turning it on keeps the stored frames."""
        obj = sleeve.scene(wrinkles=False)
        bpy.ops.object.rumple_add(method="FIELD")
        sleeve.play(1, 5)
        stored = runtimes.of(obj).evaluator.frame_cache.frames()
        obj.rumple.field.gpu_preview = True
        sleeve.at(5)
        self.assertEqual(runtimes.of(obj).evaluator.frame_cache.frames(), stored)
        self.assertGreaterEqual(len(stored), 5)
