# SPDX-License-Identifier: GPL-3.0-or-later
"""Linked duplicates share one mesh, with its paint and its captured rest shape: whoever changes them is told where."""
from __future__ import annotations

import contextlib
import io
import unittest
from typing import Callable

import bpy
from support import sleeve

TOLD = "Sleeve.001: its mesh is also that of Sleeve, so this changes there too"


def said(act: Callable[[], object]) -> str:
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        act()
    return printed.getvalue()


def capture() -> None:
    bpy.ops.object.rumple_capture_rest(frame=15)


class Told(unittest.TestCase):
    def duplicated(self, linked: bool = True) -> None:
        bpy.ops.object.duplicate(linked=linked)
        sleeve.make_active(bpy.data.objects["Sleeve.001"])

    def test_capture(self) -> None:
        obj = sleeve.scene()
        bpy.ops.object.rumple_capture_rest(frame=5)
        sleeve.at(10)
        self.duplicated()
        before = sleeve.shown(obj)
        self.assertIn(TOLD, said(capture))
        sleeve.at(11)
        sleeve.at(10)
        self.assertGreater(abs(sleeve.shown(obj) - before).max(), 1e-3, "else there was nothing to be told")

    def test_nothing_is_told_where_nothing_else_changes(self) -> None:
        sleeve.scene()
        self.assertNotIn("its mesh is also", said(capture))
        self.duplicated(linked=False)
        self.assertNotIn("its mesh is also", said(capture))
        obj = sleeve.scene()     # of whose linked duplicate the rest shape is no captured one
        self.duplicated()
        obj.rumple.mesh.rest_shape = "REST_POSE"
        self.assertNotIn("its mesh is also", said(capture))

    def test_paint(self) -> None:
        sleeve.scene()
        self.duplicated()
        ops = bpy.ops.object
        for act in (lambda: ops.rumple_paint(group="radius"), lambda: ops.rumple_paint_invert(group="radius"),
                    lambda: ops.rumple_paint_clear(group="radius")):
            self.assertIn(TOLD, said(act))
        ops.make_single_user(object=True, obdata=True)
        self.assertNotIn("its mesh is also", said(lambda: ops.rumple_paint(group="radius")))

    def test_rest_wrinkles(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        sleeve.click(obj, "FIELD")
        self.duplicated()
        self.assertIn(TOLD, said(lambda: bpy.ops.object.rumple_scatter()))
        self.assertIn(TOLD, said(lambda: bpy.ops.object.rumple_clear_rest_wrinkles()))


if __name__ == "__main__":
    unittest.main()
