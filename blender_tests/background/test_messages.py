# SPDX-License-Identifier: GPL-3.0-or-later
"""What was silent is said, and what is said names the object, the element and what to do, in an artist's words."""
from __future__ import annotations

import contextlib
import io
import unittest
from typing import Callable
from unittest import mock

import bpy
from rumple.blender import compat, scheduler
from rumple.blender.frame import clip_status
from rumple.blender.maps import overlay
from rumple.blender.objects import modifier, runtimes, stack_notes
from rumple.blender.viewport.draw_handler import DrawHandler
from rumple.core.frame import engine
from rumple.core.systems.all_systems import SYSTEMS
from support import sleeve


def place(obj: bpy.types.Object) -> int:
    return list(obj.modifiers).index(modifier.find(obj))


class Stack(unittest.TestCase):

    def test_wrinkles_in_front_of_what_poses_are_told_to_move(self) -> None:
        obj = sleeve.scene()
        self.assertEqual(stack_notes.of(obj), [])
        compat.move_modifier(obj, place(obj), 0)
        self.assertEqual(stack_notes.of(obj), [
            'Sleeve: the modifier "Armature" is below Wrinkle Mesh in the stack, so the wrinkles do not see what it '
            "moves: move Wrinkle Mesh below it"])
        obj.modifiers["Armature"].show_viewport = obj.modifiers["Armature"].show_render = False
        self.assertIn("nothing above Wrinkle Mesh", stack_notes.of(obj)[0])

    def test_a_step_that_skips_frames_is_said(self) -> None:
        """Of cloth that hangs nothing was said: each rendered frame is solved as after a jump."""
        obj, scene = sleeve.scene(), bpy.context.scene
        obj.rumple.mesh.base_cloth = "HANG"
        sleeve.at(2)
        for step, notes in ((1, 0), (2, 1)):
            scene.frame_step = step
            self.assertEqual(len(stack_notes.of(obj)), notes)
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                clip_status.check_before_render()
            self.assertEqual(printed.getvalue().count("Sleeve: Step of the scene is 2"), notes)
        sleeve.play()  # its advice: no frame of the render is a jump then
        self.assertEqual(stack_notes.of(obj), [])
        bpy.ops.object.rumple_clear_frames()
        self.assertEqual(len(stack_notes.of(obj)), 1)
        obj.rumple.mesh.base_cloth = "SWING"  # its frames say so themselves
        self.assertEqual(stack_notes.of(obj), [])

    def test_what_may_stand_behind_is_left_in_peace(self) -> None:
        obj = sleeve.scene()
        for kind in ("SMOOTH", "SHRINKWRAP", "SUBSURF", "SOLIDIFY", "MASK", "DISPLACE"):
            obj.modifiers.new(kind, kind)
        self.assertEqual(stack_notes.of(obj), [])

    def test_an_armature_without_weights_is_named(self) -> None:
        """As after a parenting that failed: the garment stands while the body walks away."""
        obj = sleeve.scene()
        obj.vertex_groups["upper"].name = "Upper"
        self.assertEqual(stack_notes.of(obj), [])
        obj.vertex_groups["lower"].name = "Lower"
        self.assertEqual(stack_notes.of(obj), [
            'Sleeve: the modifier "Armature" moves no vertex: no vertex group has the name of one of its bones. Parent '
            "the mesh to the armature with automatic weights, or paint weights"])
        obj.modifiers["Armature"].use_bone_envelopes = True
        self.assertEqual(stack_notes.of(obj), [])

    def test_a_mesh_that_nothing_deforms_is_told_why_it_has_no_folds(self) -> None:
        obj = sleeve.scene()
        armature = obj.modifiers["Armature"].object
        obj.modifiers.remove(obj.modifiers["Armature"])
        text = "Sleeve: nothing above Wrinkle Mesh in the stack deforms the mesh"
        self.assertTrue(stack_notes.of(obj)[0].startswith(text))
        obj.parent, obj.parent_type = armature, "ARMATURE"
        self.assertEqual(stack_notes.of(obj), [])
        obj.parent_type = "OBJECT"
        obj.shape_key_add(name="Basis")
        self.assertEqual(len(stack_notes.of(obj)), 1)
        obj.shape_key_add(name="Bent")
        self.assertEqual(stack_notes.of(obj), [])
        obj.shape_key_clear()
        obj.rumple.mesh.base_cloth = "HANG"
        self.assertEqual(stack_notes.of(obj), [])
        obj.rumple.mesh.base_cloth = "OFF"
        self.assertEqual(len(stack_notes.of(obj)), 1)


class Words(unittest.TestCase):

    def said(self, change: Callable[..., object]) -> str:
        obj = sleeve.scene()
        sleeve.at(2)
        change(obj)
        scheduler.sync_all()
        sleeve.at(3)
        return obj.rumple.message

    def test_no_message_has_the_name_of_an_array(self) -> None:
        def torn(obj: bpy.types.Object) -> None:
            obj.shape_key_add(name="Basis")
            key = obj.shape_key_add(name="Torn")
            key.value = 1.0
            key.data[7].co.x = float("nan")

        def empty(obj: bpy.types.Object) -> None:
            obj.data.clear_geometry()

        def flat(obj: bpy.types.Object) -> None:
            for vertex in obj.data.vertices:
                vertex.co = (0.0, 0.0, 0.0)

        def too_fine(obj: bpy.types.Object) -> None:
            obj.rumple.mesh.source, obj.rumple.mesh.edge_length = "EDGE_LENGTH", 0.0001

        def wild(obj: bpy.types.Object) -> None:
            obj.shape_key_add(name="Basis")
            key = obj.shape_key_add(name="Wild")
            key.value = 1.0
            key.data[7].co.x = 1e14

        def too_many(obj: bpy.types.Object) -> None:
            obj.rumple.most_vertices, obj.rumple.mesh.level = 10_000, 5

        expected = ((wild, r"^Sleeve: vertex 7 is 1e\+14 away from the origin in this frame, .*the last good frame"),
                    (too_many, r"^Sleeve: the fine mesh would have about \d+ vertices, more than \d+: choose fewer"),
                    (torn, r"^Sleeve: vertex 7 has no valid position in this frame .*: look at the shape keys"),
                    (empty, r"^Sleeve: its mesh has no faces: add some, or choose another object"),
                    (flat, r"^Sleeve: all of its vertices stand at one place: give it a shape"),
                    (too_fine, r"^Sleeve: edges of 0.0001\d* need more than \d+ vertices: choose a greater Longest"))
        for change, words in expected:
            with self.subTest(change.__name__):
                self.assertRegex(self.said(change), words)

    def test_too_little_memory_is_said_with_what_to_do(self) -> None:
        """It was called unexpected, with the place in our sources."""
        for method in SYSTEMS:
            obj = sleeve.scene(wrinkles=False)
            settings = getattr(obj.rumple, method.lower())
            settings.density, settings.level = "LEVEL", 1
            bpy.ops.object.rumple_add(method=method)
            sleeve.at(2)
            shown = sleeve.shown(obj)
            with mock.patch.object(engine.Wrinkles, "finish_frame", side_effect=MemoryError("not enough")):
                sleeve.at(3)
                self.assertEqual(obj.rumple.message,
                                 "Sleeve: there is not enough memory: choose longer folds, or lower Memory Limit")
                self.assertEqual(len(sleeve.shown(obj)), len(shown))
            sleeve.at(4)
            self.assertEqual((obj.rumple.message, runtimes.of(obj).inputs.frame), ("", 4.0))

    def test_maps_without_an_armature_are_refused_in_a_sentence(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        obj.modifiers.remove(obj.modifiers["Armature"])
        bpy.context.view_layer.update()
        with self.assertRaises(RuntimeError) as caught:
            bpy.ops.object.rumple_add(method="MAPS")
        self.assertNotIn("Traceback", str(caught.exception))
        self.assertIn("armature", str(caught.exception).lower())

    def test_what_goes_wrong_while_a_viewport_is_drawn_is_said_once(self) -> None:
        """The influences of Wrinkle Maps had no guard: a traceback at every redraw. The GPU preview said it anew."""
        for handler, fails in ((overlay.handler, "rumple.blender.maps.modifier.mapped_objects"),
                               (DrawHandler("the cloth", lambda: [].pop()), "rumple.blender.scheduler.request")):
            said = io.StringIO()
            with contextlib.redirect_stdout(said), mock.patch(fails, side_effect=KeyError("gone")):
                handler.draw()
                handler.draw()
            self.assertEqual(said.getvalue().count("unexpected"), 1)


if __name__ == "__main__":
    unittest.main()
