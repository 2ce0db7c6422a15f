# SPDX-License-Identifier: GPL-3.0-or-later
"""Two scenes, each in a window of its own: with one garment, whose shown mesh they share, and with one each."""
from __future__ import annotations

import unittest
from typing import Any, Iterator
from unittest import mock

import bpy
import numpy as np
from rumple.blender.frame import garment_reader
from rumple.blender.objects import output_mesh, runtimes
from support import sleeve
from support.window_case import WindowCase


class TwoScenes(WindowCase):

    def second_window(self) -> Iterator[float]:
        """On a scene that shows the same objects."""
        first = bpy.context.window_manager.windows[0]
        with sleeve.context(window=first):
            bpy.ops.wm.window_new_main()
        yield 0.3
        other = bpy.data.scenes.new("Other")
        for obj in bpy.data.scenes["Scene"].collection.all_objects:
            other.collection.objects.link(obj)
        bpy.context.window_manager.windows[1].scene = other
        yield 0.5

    def test_they_come_to_rest(self) -> Iterator[float]:
        """Each wrote its own frame because the other had written: all of a processor, for ever."""
        obj = sleeve.scene()
        self.addCleanup(self.close_second)
        yield from self.second_window()
        obj = bpy.data.objects["Sleeve"]
        sleeve.at(3)
        yield 0.5
        bpy.data.scenes["Other"].frame_set(9)
        yield 0.5
        written: list[Any] = []
        write = output_mesh.write_result
        with mock.patch.object(output_mesh, "write_result", lambda *what: written.append(what) or write(*what)):
            for scene, frame in (("Other", 9), ("Scene", 4), ("Other", 3)):
                bpy.data.scenes[scene].frame_set(frame)
                yield 0.6
                self.assertEqual((runtimes.of(obj).inputs.frame, runtimes.of(obj).written_at[1]), (frame, frame))
                self.assertEqual((runtimes.of(obj).unplayed, obj.rumple.message), (garment_reader.TWO_SCENES, ""))
        self.assertLessEqual(len(written), 3)
        runtimes.of(obj).forget_inputs()  # as where another evaluator takes over: both scenes have to solve
        bpy.data.scenes["Scene"].frame_set(4)
        yield 0.5
        self.assertIsNotNone(runtimes.of(obj).inputs)

    def test_a_closed_window_leaves_the_other_as_it_was_before(self) -> Iterator[float]:
        obj = sleeve.scene()
        yield from self.second_window()
        obj = bpy.data.objects["Sleeve"]
        bpy.data.scenes["Scene"].frame_set(3)
        yield 0.3
        bpy.data.scenes["Other"].frame_set(9)
        yield 0.3
        self.close_second()
        yield 0.3
        bpy.data.scenes["Scene"].view_layers[0].update()
        obj.update_tag()
        yield 0.3
        self.assertEqual((runtimes.of(obj).inputs.frame, runtimes.of(obj).unplayed), (3.0, ""))

    def two_garments(self) -> Iterator[float]:
        """Each in a scene and a window of its own, the second one at half the frame rate."""
        sleeve.scene()
        self.addCleanup(self.close_second)
        first = bpy.context.window_manager.windows[0]
        with sleeve.context(window=first):
            bpy.ops.wm.window_new_main()
        yield 0.3
        second = bpy.context.window_manager.windows[1]
        with sleeve.context(window=second):
            bpy.ops.scene.new(type="FULL_COPY")
        second.scene.name, second.scene.render.fps = "Other", 12
        yield 0.5

    def garment(self, scene: str) -> bpy.types.Object:
        return next(obj for obj in bpy.data.scenes[scene].objects if obj.name.startswith("Sleeve"))

    def play(self, number: int, until: int) -> Iterator[float]:
        """In a window, from its first frame."""
        window = bpy.context.window_manager.windows[number]
        with sleeve.context(window=window, screen=window.screen):
            bpy.ops.screen.animation_play()
        window.scene.frame_set(1)
        yield from self.until(lambda: window.scene.frame_current >= until)
        with sleeve.context(window=window, screen=window.screen):
            bpy.ops.screen.animation_cancel(restore_frame=False)
        yield 0.2

    def test_each_garment_plays_in_its_own_window(self) -> Iterator[float]:
        """What one window plays leaves the other's garment, its frames and its picture as they are."""
        yield from self.two_garments()
        for scene in ("Scene", "Other"):
            bpy.data.scenes[scene].frame_set(1)
        yield 0.5
        for number, (scene, other) in enumerate((("Scene", "Other"), ("Other", "Scene"), ("Scene", "Other"))):
            still = runtimes.of(self.garment(other))
            before = still.inputs.frame, still.result.positions.copy(), set(still.evaluator.frame_cache.frames())
            yield from self.play(number % 2, 8)
            played = runtimes.of(self.garment(scene))
            self.assertGreaterEqual(played.inputs.frame, 8.0)
            self.assertEqual(played.inputs.frame_rate, 24.0 if scene == "Scene" else 12.0)
            still = runtimes.of(self.garment(other))
            self.assertEqual((still.inputs.frame, set(still.evaluator.frame_cache.frames())), (before[0], before[2]))
            np.testing.assert_array_equal(still.result.positions, before[1])
            for each in (scene, other):
                obj = self.garment(each)
                self.assertEqual((obj.rumple.message, runtimes.of(obj).unplayed), ("", ""))
        for scene in ("Scene", "Other"):
            bpy.data.scenes[scene].frame_set(5)
        yield 0.5
        one, two = (runtimes.of(self.garment(scene)) for scene in ("Scene", "Other"))
        self.assertIsNot(one.evaluator, two.evaluator)
        np.testing.assert_array_equal(one.result.positions, two.result.positions)  # the same pose, reached alike

    def close_second(self) -> None:
        windows = bpy.context.window_manager.windows
        if len(windows) > 1:
            with sleeve.context(window=windows[1]):
                bpy.ops.wm.window_close()


if __name__ == "__main__":
    unittest.main()
