# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's own operators take the modifier from has no wrinkles any more: Convert to Mesh, and Apply."""
from __future__ import annotations

import unittest

import bpy
from rumple.blender import ui_base
from rumple.blender.nodes import wrinkle_tree
from rumple.blender.objects import modifier, runtimes
from support import sleeve


class Converted(unittest.TestCase):
    def is_as_without(self, obj: bpy.types.Object, method: str) -> None:
        """No trace, no panel, no message; and the next click works."""
        sleeve.at(13)
        self.assertEqual(obj.rumple.method, "NONE")
        self.assertIsNone(runtimes.known(obj))
        self.assertEqual(obj.rumple.message, "")
        self.assertNotIn(wrinkle_tree.BASE_POSITION, obj.data.attributes)
        self.assertFalse(ui_base.Panel.poll(bpy.context))
        self.assertEqual(ui_base.refusal(obj, wrinkled=False), "")
        self.clicked(obj, method)

    def clicked(self, obj: bpy.types.Object, method: str) -> None:
        count = len(obj.data.vertices)
        sleeve.click(obj, method)
        self.assertEqual(obj.rumple.method, method)
        sleeve.at(14)
        self.assertGreater(len(sleeve.evaluated(obj).data.vertices), count)
        self.assertEqual(obj.rumple.message, "")

    def made(self) -> bpy.types.Object:
        obj = sleeve.scene()
        sleeve.at(12)
        return obj

    def test_it_is_as_without_wrinkles(self) -> None:
        for method in ("MESH", "PATHS"):
            obj = self.made()
            bpy.ops.object.convert(target="MESH")
            self.is_as_without(obj, method)

    def test_the_original_is_kept(self) -> None:
        original = self.made()
        bpy.ops.object.convert(target="MESH", keep_original=True)
        self.assertNotEqual(bpy.context.object, original)
        self.is_as_without(bpy.context.object, "MESH")
        self.assertEqual(original.rumple.method, "MESH")
        self.assertIsNotNone(modifier.find(original))

    def test_applied_by_blender(self) -> None:
        obj = self.made()
        bpy.ops.object.modifier_apply(modifier=modifier.find(obj).name)
        self.is_as_without(obj, "MESH")

    def test_the_next_click_comes_at_once(self) -> None:
        obj = self.made()
        bpy.ops.object.convert(target="MESH")
        self.clicked(obj, "PATHS")


if __name__ == "__main__":
    unittest.main()
