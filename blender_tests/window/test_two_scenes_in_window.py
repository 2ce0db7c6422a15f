# SPDX-License-Identifier: GPL-3.0-or-later
"""One garment in two scenes, each in a window of its own: they share the mesh that shows it."""
from __future__ import annotations

import unittest
from typing import Any, Iterator
from unittest import mock

import bpy
from rumple.blender.frame import solve
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
                self.assertEqual((runtimes.of(obj).unplayed, obj.rumple.message), (solve.TWO_SCENES, ""))
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

    def close_second(self) -> None:
        windows = bpy.context.window_manager.windows
        if len(windows) > 1:
            with sleeve.context(window=windows[1]):
                bpy.ops.wm.window_close()


if __name__ == "__main__":
    unittest.main()
