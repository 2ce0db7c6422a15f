# SPDX-License-Identifier: GPL-3.0-or-later
"""The modifier in the stack: added, removed, applied, embedded."""
from __future__ import annotations

import contextlib
import io
import math
import os
import tempfile
import unittest
from typing import Any, Callable
from unittest import mock

import bpy
import numpy as np
from rumple.blender import compat, handlers, scheduler
from rumple.blender.maps import modifier as maps_modifier
from rumple.blender.nodes import wrinkle_tree
from rumple.blender.objects import modifier, properties, runtimes
from rumple.blender.ui import operators
from support import sleeve

LAST = 6  # frame


class Stack(unittest.TestCase):

    def test_stands_behind_the_last_deformer_and_before_subdivision(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        obj.modifiers.new("Subdivision", "SUBSURF")
        obj.modifiers.new("Solidify", "SOLIDIFY")
        self.assertEqual(bpy.ops.object.rumple_add(method="MESH"), {"FINISHED"})
        self.assertEqual([m.name for m in obj.modifiers], ["Armature", "Wrinkle Mesh", "Subdivision", "Solidify"])
        self.assertEqual(obj.rumple.method, "MESH")
        self.assertEqual(obj.rumple.message, "")

    @unittest.skipUnless("use_pin_to_last" in bpy.types.Modifier.bl_rna.properties, "this Blender pins no modifier")
    def test_stands_there_too_where_the_last_one_is_pinned(self) -> None:
        """Shade Auto Smooth pins its modifier to the end, and Blender adds others in front of it. Rumple took the last
        one for its own, and moved that: the wrinkles stayed below the Subdivision, and renders had none."""
        for add, name in ((lambda obj: modifier.add(obj, "MESH"), "Wrinkle Mesh"),
                          (maps_modifier.add, maps_modifier.NAME)):
            obj = sleeve.scene(wrinkles=False)
            obj.modifiers.new("Subdivision", "SUBSURF")
            obj.modifiers.new("Smooth by Angle", "WEIGHTED_NORMAL").use_pin_to_last = True
            self.assertEqual(add(obj), obj.modifiers[name])
            self.assertEqual([m.name for m in obj.modifiers], ["Armature", name, "Subdivision", "Smooth by Angle"])

    def test_adding_twice_is_refused(self) -> None:
        sleeve.scene()
        self.assertFalse(bpy.ops.object.rumple_add.poll())

    def test_shows_more_points_than_the_coarse_mesh(self) -> None:
        obj = sleeve.scene()
        self.assertGreater(len(sleeve.shown(obj)), 3 * len(obj.data.vertices))

    def test_off_shows_the_coarse_mesh(self) -> None:
        obj = sleeve.scene()
        modifier.find(obj).show_viewport = False
        self.assertEqual(len(sleeve.shown(obj)), len(obj.data.vertices))

    def test_removing_leaves_nothing(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        before = [sleeve.names(getattr(bpy.data, kind)) for kind in ("objects", "meshes", "node_groups", "materials")]
        bpy.ops.object.rumple_add(method="MESH")
        sleeve.at(9)
        bpy.ops.object.rumple_capture_rest(frame=1)
        bpy.ops.object.rumple_remove()
        after = [sleeve.names(getattr(bpy.data, kind)) for kind in ("objects", "meshes", "node_groups", "materials")]
        self.assertEqual(after, before)
        self.assertEqual([m.name for m in obj.modifiers], ["Armature"])
        self.assertEqual([a.name for a in obj.data.attributes if a.name.startswith("rumple")], [])
        self.assertEqual(obj.rumple.method, "NONE")

    def test_applying_keeps_what_is_seen(self) -> None:
        obj = sleeve.scene()
        obj.modifiers.new("Subdivision", "SUBSURF").show_viewport = False
        sleeve.at(15)
        seen = sleeve.shown(obj)
        bpy.ops.object.rumple_apply()
        np.testing.assert_array_equal(compat.positions(obj.data), seen)
        self.assertEqual([m.name for m in obj.modifiers], ["Subdivision"])
        self.assertEqual(sleeve.names(bpy.data.objects), ["Arm", "Sleeve"])
        self.assertEqual(sleeve.names(obj.vertex_groups), ["lower", "upper"])
        self.assertEqual([m.name for m in obj.data.materials], ["Outside", "Cuff"])

    def test_applying_under_an_armature_that_is_the_parent(self) -> None:
        """It was deformed twice, and stood two metres away."""
        obj = sleeve.scene(wrinkles=False)
        obj.modifiers.remove(obj.modifiers["Armature"])
        obj.parent, obj.parent_type = bpy.data.objects["Arm"], "ARMATURE"
        bpy.context.view_layer.update()
        obj.rumple.mesh.display_steps = 0
        bpy.ops.object.rumple_add(method="MESH")
        sleeve.at(15)
        seen = sleeve.shown(obj)
        bpy.ops.object.rumple_apply()
        sleeve.at(15)
        np.testing.assert_array_equal(sleeve.shown(obj), seen)
        self.assertEqual(obj.parent.name, "Arm")

    def test_applying_with_shape_keys(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        obj.shape_key_add(name="Basis")
        obj.shape_key_add(name="Wide").value = 1.0
        obj.rumple.mesh.display_steps = 0
        bpy.ops.object.rumple_add(method="MESH")
        sleeve.at(15)
        seen = sleeve.shown(obj)
        bpy.ops.object.rumple_apply()
        self.assertIsNone(obj.data.shape_keys)
        np.testing.assert_array_equal(compat.positions(obj.data), seen)

    def test_blenders_own_apply_is_tidied(self) -> None:
        obj = sleeve.scene()
        sleeve.at(15)
        bpy.ops.object.modifier_apply(modifier="Wrinkle Mesh")
        bpy.context.view_layer.update()
        scheduler.sync_all()
        self.assertEqual(obj.rumple.method, "NONE")
        self.assertEqual(sleeve.names(bpy.data.objects), ["Arm", "Sleeve"])
        left = [a.name for a in obj.data.attributes if a.name.startswith("rumple_base")]
        self.assertEqual(left, [])

    def test_copied_to_another_object(self) -> None:
        """Blender's Copy Modifiers: the object's settings were read as those of another system, "unexpected"."""
        for method in ("FIELD", "PATHS"):
            obj = sleeve.scene(wrinkles=False)
            sleeve.click(obj, method)
            other = sleeve.skinned(sleeve.tube("Other"), bpy.data.objects["Arm"], "Other")
            other.select_set(True)
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                bpy.ops.object.make_links_data(type="MODIFIERS")
                sleeve.at(10)
            self.assertEqual((printed.getvalue(), other.rumple.method, other.rumple.message), ("", method, ""))
            self.assertIsNotNone(runtimes.of(other).result)


class Embedding(unittest.TestCase):

    def test_shows_exactly_what_was_solved(self) -> None:
        obj = sleeve.scene()
        for frame in (20, 3, 11):
            sleeve.at(frame)
            np.testing.assert_allclose(sleeve.shown(obj), sleeve.picture(obj).positions, atol=1e-6)

    def test_coarse_positions_come_back_to_the_bit(self) -> None:
        obj = sleeve.scene()
        twin = sleeve.skinned(obj.data, bpy.data.objects["Arm"], "Twin")
        modifier.find(obj).show_viewport = True
        for later in (False, True):
            if later:
                obj.modifiers.new("Subdivision", "SUBSURF")
                obj.modifiers.new("Solidify", "SOLIDIFY").thickness = 0.01
            sleeve.at(14)
            count = len(obj.data.vertices)
            np.testing.assert_array_equal(sleeve.attribute(obj, wrinkle_tree.BASE_POSITION)[:count], sleeve.shown(twin))

    def test_a_rigid_turn_of_the_armature_turns_the_folds(self) -> None:
        obj = sleeve.scene()
        sleeve.at(20)
        before, folds = sleeve.shown(obj), sleeve.picture(obj).local_offset.copy()
        root = bpy.data.objects["Arm"].pose.bones["upper"]
        root.rotation_mode = "AXIS_ANGLE"
        root.rotation_axis_angle = (math.radians(140.0), 1.0, 2.0, 3.0)
        bpy.context.view_layer.update()
        turn = np.array(root.matrix @ root.bone.matrix_local.inverted(), np.float32)
        expected = before @ turn[:3, :3].T + turn[:3, 3]
        np.testing.assert_allclose(sleeve.shown(obj), expected, atol=2e-3)
        self.assertGreater(np.abs(folds).max(), 1e-3)

    def test_without_handlers_the_mesh_follows_the_pose(self) -> None:
        obj = sleeve.scene()
        sleeve.at(10)
        tree_only = self.without_handlers()
        try:
            sleeve.at(11)
            shown = sleeve.shown(obj)
        finally:
            tree_only()
        sleeve.at(10)
        sleeve.at(11)
        self.assertLess(np.abs(shown - sleeve.shown(obj)).max(), 0.02)

    def without_handlers(self) -> Any:
        handlers.unregister()
        return handlers.register

    def test_collapsed_triangles_stay_finite(self) -> None:
        obj = sleeve.scene()
        key = obj.shape_key_add(name="Basis")
        flat = obj.shape_key_add(name="Flat")
        for point in flat.data:
            point.co = (0.1, 0.0, 0.0)
        flat.value = 1.0
        bpy.context.view_layer.update()
        self.assertEqual(len(key.data), len(obj.data.vertices))
        self.assertTrue(np.isfinite(sleeve.shown(obj)).all())


class Tree(unittest.TestCase):

    def test_an_older_tree_is_rebuilt_in_place(self) -> None:
        obj = sleeve.scene()
        sleeve.at(12)
        seen = sleeve.shown(obj)
        group = modifier.find(obj).node_group
        group[wrinkle_tree.VERSION_KEY] = 0
        group.nodes.clear()
        self.assertTrue(wrinkle_tree.upgrade(group))
        self.assertIsNotNone(sleeve.output_object(obj))
        bpy.context.view_layer.update()
        np.testing.assert_allclose(sleeve.shown(obj), seen, atol=1e-6)

    def test_one_tree_serves_all_objects(self) -> None:
        obj = sleeve.scene()
        other = sleeve.skinned(sleeve.tube("Other"), bpy.data.objects["Arm"], "Other")
        sleeve.make_active(other)
        bpy.ops.object.rumple_add(method="MESH")
        self.assertEqual(modifier.find(obj).node_group, modifier.find(other).node_group)


class AddedInTheMiddle(unittest.TestCase):

    def changes(self, cloth: str, frames: range) -> list[float]:
        """The largest change of a fold from one of the frames to the next, after a click in frame 10."""
        obj = sleeve.scene(wrinkles=False)
        obj.rumple.mesh.base_cloth = cloth
        obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 1, 0
        sleeve.at(10)
        bpy.ops.object.rumple_add(method="MESH")
        offsets = []
        for frame in frames:
            sleeve.at(frame)
            offsets.append(sleeve.attribute(obj, "rumple_offset"))
        return [np.linalg.norm(b - a, axis=1).max() for a, b in zip(offsets, offsets[1:])]

    def test_the_frame_it_was_added_on_does_not_pop(self) -> None:
        for cloth in ("OFF", "HANG", "SWING"):
            first, *others = self.changes(cloth, range(10, 15))
            self.assertLess(first, 2.0 * max(others), cloth)

    def test_nor_where_play_begins_before_it(self) -> None:
        """It was replayed as it was solved first, from nothing."""
        for cloth in ("OFF", "HANG", "SWING"):
            changes = self.changes(cloth, range(6, 15))
            there = changes.pop(3), changes.pop(3)  # to frame 10, and from it
            self.assertLess(max(there), 2.0 * max(changes[1:]), cloth)


class AddedAgain(unittest.TestCase):
    """What was kept from a removal cannot be changed without wrinkles, as the panel is not there."""

    def add(self, change: Callable[[bpy.types.Object, Any], object], method: str, by_hand: bool) -> bpy.types.Object:
        """Add, change what is kept, remove, and add again."""
        obj = sleeve.scene(wrinkles=False)
        bpy.ops.object.rumple_add(method=method)
        change(obj, properties.group_of(obj))
        scheduler.sync_all()
        bpy.ops.object.rumple_remove()
        with mock.patch.object(operators.OBJECT_OT_rumple_add, "_may_wait", by_hand):
            bpy.ops.object.rumple_add(method=method)
        self.assertEqual(runtimes.message(obj), "")
        sleeve.at(4)
        self.assertTrue(sleeve.is_fine(obj))
        return obj

    def test_a_captured_rest_shape_went_with_the_wrinkles(self) -> None:
        """Without wrinkles there is no button that captures another, and the click was refused for it."""
        for method in ("MESH", "PATHS"):
            obj = self.add(lambda *_: bpy.ops.object.rumple_capture_rest(frame=5), method, by_hand=False)
            self.assertEqual(properties.group_of(obj).rest_shape, "REST_POSE")

    def test_what_refuses_for_another_reason_keeps_them(self) -> None:
        """The scale is wrong, and the settings were gone for good: a click that is refused is no step of undo."""
        obj = sleeve.scene(wrinkles=False)
        bpy.ops.object.rumple_add(method="MESH")
        obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.most_vertices = "LEVEL", 2, 400_000
        bpy.ops.object.rumple_remove()
        obj.scale = (0.0, 0.0, 0.0)
        bpy.context.view_layer.update()
        with mock.patch.object(operators.OBJECT_OT_rumple_add, "_may_wait", True):
            with self.assertRaises(RuntimeError):
                bpy.ops.object.rumple_add(method="MESH")
        kept = obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.most_vertices
        self.assertEqual(kept, ("LEVEL", 2, 400_000))

    def test_folds_are_as_wide_as_on_the_first_click(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        obj.rumple.mesh.property_unset("base_cloth")
        sleeve.under(obj, "Human")
        found = []
        for _ in range(2):
            with mock.patch.object(operators.OBJECT_OT_rumple_add, "_may_wait", bool(found)):
                bpy.ops.object.rumple_add(method="MESH")
            found.append((obj.rumple.mesh.wavelength, obj.rumple.mesh.density, obj.rumple.mesh.base_cloth))
            obj.rumple.most_vertices, obj.rumple.mesh.density, obj.rumple.mesh.level = 1000, "LEVEL", 3
            bpy.ops.object.rumple_remove()
        self.assertEqual(found[0], found[1])

    def test_settings_that_refuse_the_fine_mesh_are_let_go(self) -> None:
        """Each click was refused, for ever."""
        def most(obj: bpy.types.Object, settings: Any) -> None:
            obj.rumple.most_vertices, settings.density, settings.level = 1000, "LEVEL", 3

        def key(obj: bpy.types.Object, settings: Any) -> None:
            obj.rumple.rest_key, settings.rest_shape = "Gone", "SHAPE_KEY"

        def own(_obj: bpy.types.Object, settings: Any) -> None:
            settings.source = "OBJECT"

        for change in (most, key, own):
            with self.subTest(change.__name__):
                obj = self.add(change, "MESH", by_hand=True)
                self.assertEqual(obj.rumple.most_vertices, 250_000)
                with self.assertRaisesRegex(RuntimeError, "Error: Sleeve: "):  # a script is told
                    self.add(change, "MESH", by_hand=False)


class SimulatedAbove(unittest.TestCase):
    """A Cloth above the wrinkles that was played and not baked: a tag of the garment empties its cache."""

    def setUp(self) -> None:
        self.obj = sleeve.scene(wrinkles=False)
        self.obj.modifiers.new("Cloth", "CLOTH").point_cache.frame_end = LAST
        self.obj.rumple.mesh.density, self.obj.rumple.mesh.level = "LEVEL", 1
        bpy.ops.object.rumple_add(method="MESH")
        sleeve.play(1, LAST)
        self.fallen = sleeve.shown(self.obj)[:, 2].min()

    def check_kept(self) -> None:
        obj = bpy.data.objects["Sleeve"]
        bpy.context.view_layer.update()
        self.assertFalse(obj.modifiers["Cloth"].point_cache.is_outdated)
        sleeve.at(1)
        sleeve.at(LAST)
        self.assertAlmostEqual(sleeve.shown(obj)[:, 2].min(), self.fallen, places=5)

    def test_opening_the_file_keeps_its_cache(self) -> None:
        """It was rendered hanging still."""
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "simulated.blend")
            bpy.ops.wm.save_as_mainfile(filepath=file, copy=True)
            bpy.ops.wm.open_mainfile(filepath=file)
        self.check_kept()

    def test_a_still_render_keeps_it(self) -> None:
        """The animation that was rendered after it was lost."""
        handlers._on_render_start()
        handlers._on_render_end()
        self.assertNotEqual(scheduler._due, set())
        scheduler._look()  # the timer of a window calls it
        self.check_kept()
