# SPDX-License-Identifier: GPL-3.0-or-later
"""A wrinkled garment that is linked from another file, and undo: what is linked stays in memory as it is, and must name
nothing that is read anew."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path

import bpy
import numpy as np
from rumple.blender import scheduler
from rumple.blender.objects import modifier
from support import sleeve


class LinkedGarment(unittest.TestCase):

    def setUp(self) -> None:
        library = str(Path(self.enterContext(tempfile.TemporaryDirectory())) / "library.blend")
        sleeve.scene()
        bpy.ops.wm.save_as_mainfile(filepath=library, copy=True)
        sleeve.empty_file()
        bpy.ops.ed.undo_push(message="before")
        with bpy.data.libraries.load(library, link=True) as (_, wanted):
            wanted.objects = ["Sleeve"]
        bpy.context.scene.collection.objects.link(wanted.objects[0])
        self.play()
        for message in ("linked", "something else"):
            bpy.ops.ed.undo_push(message=message)

    def garment(self) -> bpy.types.Object:
        return next(obj for obj in bpy.data.objects if obj.library is not None and modifier.find(obj) is not None)

    def play(self) -> None:
        sleeve.at(19)
        scheduler.sync_all()
        sleeve.at(20)

    def folds(self) -> float:
        return float(np.abs(sleeve.attribute(self.garment(), "rumple_offset")).max())

    def hidden(self) -> list[str]:
        return sorted(obj.name for obj in bpy.data.objects if obj.library is None and obj.name.startswith("Sleeve."))

    def test_while_it_is_undone_it_names_nothing_local_and_afterwards_the_same(self) -> None:
        """Blender 5.2 ended."""
        named, before = [], self.hidden()

        def look(*_arguments: object) -> None:
            named.append(modifier.outputs(modifier.find(self.garment())))

        for handlers in (bpy.app.handlers.undo_pre, bpy.app.handlers.redo_pre):
            handlers.append(look)
            self.addCleanup(handlers.remove, look)
        self.assertEqual(len(modifier.outputs(modifier.find(self.garment()))), len(before))
        for step in (bpy.ops.ed.undo, bpy.ops.ed.redo, bpy.ops.ed.undo):
            step()
            self.assertEqual({output.name for output in modifier.outputs(modifier.find(self.garment()))}, set(before))
            self.play()
            self.assertEqual((self.garment().rumple.message, self.hidden()), ("", before))
            self.assertGreater(self.folds(), 1e-3)
        self.assertEqual(named, [[], [], []])

    def test_linking_is_undone_and_done_again(self) -> None:
        bpy.ops.ed.undo()
        bpy.ops.ed.undo()
        self.play()
        bpy.ops.ed.redo()
        self.play()
        self.assertEqual(self.garment().rumple.message, "")
        self.assertGreater(self.folds(), 1e-3)


if __name__ == "__main__":
    unittest.main()
