# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's own operators take the modifier from has no wrinkles any more: Convert to Mesh, Apply, Delete."""
from __future__ import annotations

import unittest
from unittest import mock

import bpy
from rumple.blender import handlers, scheduler, ui_base
from rumple.blender.nodes import wrinkle_tree
from rumple.blender.objects import modifier, runtimes
from support import curve_edges, sleeve


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


class WithCurves(unittest.TestCase):
    """The curves of Wrinkle Paths are a child of their garment."""

    def curved(self) -> tuple[bpy.types.Object, bpy.types.Object]:
        obj = sleeve.scene(wrinkles=False)
        bpy.ops.object.rumple_add(method="PATHS")
        bpy.ops.object.rumple_curves_add()
        return obj, curve_edges.child_of(obj)

    def test_they_are_deleted_with_their_garment(self) -> None:
        """Blender's Delete left them in the scene, with folds of a garment that was gone."""
        obj, _child = self.curved()
        sleeve.make_active(obj)
        bpy.ops.object.delete()
        requests: list[float] = []
        with mock.patch.object(scheduler, "request", lambda *wait: requests.append(0.0)):
            bpy.context.view_layer.update()
            sleeve.at(5)
            handlers._on_update(bpy.context.scene, bpy.context.evaluated_depsgraph_get())
        self.assertTrue(requests, "in a window a timer would have nothing to do")
        scheduler.sync_all()
        self.assertEqual([o.name for o in bpy.context.scene.objects], ["Arm"])

    def test_a_garment_that_is_only_hidden_keeps_them(self) -> None:
        """It is in a collection of no scene."""
        obj, child = self.curved()
        aside = bpy.data.collections.new("Aside")
        aside.objects.link(obj)
        bpy.context.scene.collection.objects.unlink(obj)
        scheduler.sync_all()
        self.assertIn(child, list(bpy.context.scene.objects))


if __name__ == "__main__":
    unittest.main()
