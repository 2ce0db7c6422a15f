# SPDX-License-Identifier: GPL-3.0-or-later
"""A painted map that is renamed or deleted counts no more, and the panel says so."""
from __future__ import annotations

import unittest

import bpy
import numpy as np
from rumple.blender.objects import lost_maps, stack_notes
from support import sleeve

NAME = "Rumple Radius"
RENAMED = "Sleeve: the vertex group \"Rumple Radius\" is called \"Radius\" now"


def painted(obj: bpy.types.Object, name: str = NAME) -> bpy.types.VertexGroup:
    group = obj.vertex_groups.new(name=name)
    group.add(range(len(obj.data.vertices)), 0.1, "REPLACE")
    sleeve.at(10)
    return group


def renamed(obj: bpy.types.Object) -> str:
    return "".join(note for note in stack_notes.of(obj) if "is called" in note)


def deleted(obj: bpy.types.Object) -> str:
    return "".join(lost_maps.deleted(obj))


class Lost(unittest.TestCase):
    def setUp(self) -> None:
        self.obj = sleeve.scene()

    def nothing_is_said(self, obj: bpy.types.Object | None = None) -> None:
        sleeve.at(11)
        self.assertEqual((renamed(obj or self.obj), deleted(obj or self.obj)), ("", ""))

    def test_renamed(self) -> None:
        group = painted(self.obj)
        before = sleeve.shown(self.obj)
        self.nothing_is_said()
        group.name = "Radius"
        sleeve.at(10)
        self.assertGreater(np.abs(sleeve.shown(self.obj) - before).max(), 1e-3, "else it was of no use")
        self.assertIn(RENAMED, renamed(self.obj))
        sleeve.at(12)
        self.assertIn(RENAMED, renamed(self.obj), "until it has its name again")
        self.assertEqual(deleted(self.obj), "")
        group.name = NAME
        self.nothing_is_said()

    def test_deleted(self) -> None:
        self.obj.vertex_groups.remove(painted(self.obj))
        sleeve.at(10)
        self.assertIn("Sleeve: \"Rumple Radius\" is gone", deleted(self.obj))
        self.assertEqual(renamed(self.obj), "")
        painted(self.obj)
        self.nothing_is_said()

    def test_both_at_once(self) -> None:
        painted(self.obj, "Rumple Room").name = "Room"
        self.obj.vertex_groups.remove(painted(self.obj))
        sleeve.at(11)
        self.assertIn("\"Room\"", renamed(self.obj))
        self.assertIn("\"Rumple Radius\"", deleted(self.obj))

    def test_clear_is_no_loss(self) -> None:
        """Nor for a linked duplicate."""
        painted(self.obj)
        bpy.ops.object.duplicate(linked=True)
        other = bpy.context.object
        sleeve.at(11)
        bpy.ops.object.rumple_paint_clear(group="radius")
        self.nothing_is_said()
        self.nothing_is_said(other)

    def test_what_undo_takes_back_is_no_loss(self) -> None:
        bpy.ops.ed.undo_push(message="before")
        painted(self.obj)
        bpy.ops.ed.undo_push(message="painted")
        bpy.ops.ed.undo()
        self.obj = bpy.data.objects["Sleeve"]
        self.assertNotIn(NAME, self.obj.vertex_groups)
        self.nothing_is_said()

    def test_another_name_in_the_settings_is_no_loss(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        sleeve.click(obj, "FIELD")
        painted(obj, obj.rumple.field.mask)
        obj.rumple.field.mask = "upper"
        self.nothing_is_said(obj)
        obj.vertex_groups["upper"].name = "top"
        sleeve.at(12)
        self.assertIn("\"upper\" is called \"top\"", renamed(obj))

    def test_an_attribute(self) -> None:
        attribute = self.obj.data.attributes.new(NAME, "FLOAT", "POINT")
        attribute.data.foreach_set("value", np.full(len(self.obj.data.vertices), 0.1, np.float32))
        self.obj.data.update()
        sleeve.at(10)
        self.nothing_is_said()
        self.obj.data.attributes.remove(self.obj.data.attributes[NAME])
        self.obj.data.update()
        sleeve.at(10)
        self.assertIn("is gone", deleted(self.obj))


if __name__ == "__main__":
    unittest.main()
