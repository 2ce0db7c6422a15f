# SPDX-License-Identifier: GPL-3.0-or-later
"""The scale of an object, and of the skeleton that it follows, say how long its lengths in metres are."""
from __future__ import annotations

import unittest
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix
from rumple.blender import compat, scheduler
from rumple.blender.nodes import wrinkle_tree
from rumple.blender.objects import bodies, incoming_mesh, mesh_reader, rig_scale, runtimes, stack_notes, units
from support import cloth_scenes, sleeve


class Scale(unittest.TestCase):

    def setUp(self) -> None:
        self.obj = sleeve.scene()
        sleeve.at(1)

    def scale_built(self) -> float:
        return runtimes.of(self.obj).evaluator.unit_scale

    def keyed(self, first: float, last: float) -> None:
        for frame, size in ((1, first), (sleeve.LAST, last)):
            self.obj.scale = (size,) * 3
            self.obj.keyframe_insert("scale", frame=frame)

    def test_scaling_makes_the_folds_anew(self) -> None:
        """It edits no mesh: the former folds stayed until something else was changed, or the file was opened again."""
        self.assertAlmostEqual(self.scale_built(), 1.0, 5)
        self.obj.scale *= 2.0
        for _ in range(2):
            bpy.context.view_layer.update()
        sleeve.at(2)
        self.assertAlmostEqual(self.scale_built(), 2.0, 5)
        bpy.data.objects["Arm"].scale = (3.0,) * 3
        self.obj.parent = bpy.data.objects["Arm"]
        for _ in range(2):
            bpy.context.view_layer.update()
        sleeve.at(3)
        self.assertAlmostEqual(self.scale_built(), 6.0, 4)
        self.assertEqual(self.obj.rumple.message, "")

    def test_a_keyed_scale_is_that_of_the_first_frame(self) -> None:
        """It was that of the frame in which the fine mesh was made: a farm's chunk had other folds."""
        self.keyed(1.0, 3.0)
        shapes = []
        for frame in (1, 20, 7):
            sleeve.at(frame)
            runtimes.of(self.obj).stale = True
            scheduler.sync_all()
            shapes.append((runtimes.of(self.obj).build.shape, self.scale_built()))
        self.assertEqual(shapes, [(shapes[0][0], 1.0)] * 3)
        sleeve.play()
        self.assertFalse(runtimes.of(self.obj).stale)
        self.assertAlmostEqual(units.metres_per_unit(self.obj, bpy.context.scene), 1.0)

    def test_a_driven_scale_makes_nothing_anew_in_each_frame(self) -> None:
        for axis in range(3):
            self.obj.driver_add("scale", axis).driver.expression = "1 + frame / 10"
        sleeve.at(2)
        evaluator = runtimes.of(self.obj).evaluator
        sleeve.play()
        self.assertIs(runtimes.of(self.obj).evaluator, evaluator)

    def test_what_pops_up_has_the_scale_of_the_next_key(self) -> None:
        """Of a scale that is keyed from zero, lengths in metres had no meaning: there were no wrinkles in any frame."""
        self.keyed(0.0, 2.0)
        sleeve.play()
        self.assertEqual(self.obj.rumple.message, "")
        self.assertAlmostEqual(self.scale_built(), 2.0)
        self.assertTrue(sleeve.is_fine(self.obj))
        self.obj.animation_data_clear()
        rig = bpy.data.objects["Arm"]
        self.obj.parent, self.obj.scale, self.obj = rig, (1.0,) * 3, rig
        self.keyed(0.0, 3.0)
        self.assertAlmostEqual(units.metres_per_unit(bpy.data.objects["Sleeve"], bpy.context.scene), 3.0)

    def test_what_a_driver_hides_by_zero_is_made_when_it_is_seen(self) -> None:
        """Its fine mesh was refused at a scale of zero, and nothing tried again: a driver is no edit."""
        for axis in range(3):
            self.obj.driver_add("scale", axis).driver.expression = "0 if frame < 4 else 1"
        self.obj.rumple.mesh.level = 2
        for frame in (2, 3):
            sleeve.at(frame)
        self.assertIn("its scale is zero", self.obj.rumple.message)
        for frame in (4, 5):
            sleeve.at(frame)
        self.assertEqual(self.obj.rumple.message, "")
        self.assertEqual(len(sleeve.shown(self.obj)), 2880)


class ByAxes(unittest.TestCase):
    """It counted as strain, in silence: a sleeve that only turned was pressed together by a third."""

    def setUp(self) -> None:
        self.obj, self.rig = sleeve.scene(), bpy.data.objects["Arm"]
        self.above = bpy.data.objects.new("Above", None)
        bpy.context.scene.collection.objects.link(self.above)

    def said(self) -> list[str]:
        return [note for note in stack_notes.of(self.obj) if "differs by axes" in note]

    def stretch(self) -> float:
        """Of the forearm, which only turns."""
        sleeve.at(sleeve.LAST)
        scheduler.sync_all()
        sleeve.at(sleeve.LAST)
        return float(sleeve.attribute(self.obj, "rumple_stretch_min")[9 * sleeve.AROUND:11 * sleeve.AROUND].mean())

    def apply(self, obj: bpy.types.Object) -> None:
        sleeve.make_active(obj)
        bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)

    def test_what_is_to_be_applied_is_named(self) -> None:
        self.obj.parent = self.above
        self.assertEqual(self.said(), [])
        for uneven in (self.obj, self.above):
            uneven.scale = (1.0, 2.0, 1.0)
            self.assertEqual(self.said(), [
                f'Sleeve: the scale of "{uneven.name}" differs by axes, so folds come where cloth only turns: apply it '
                "(Object > Apply > Scale)"])
            self.assertLess(self.stretch(), 0.7)
            for one in (uneven, self.obj):  # of what hangs from an empty Blender makes it that one's own
                self.apply(one)
            self.assertEqual(self.said(), [])
            self.assertGreater(self.stretch(), 0.95)

    def test_where_its_armature_is_scaled_alike_it_is_not_strained(self) -> None:
        self.rig.scale = (1.0, 2.0, 1.0)
        self.obj.parent = self.rig
        self.assertGreater(self.stretch(), 0.95)
        self.assertEqual(self.said(), [])
        self.obj.scale = (1.0, 0.5, 1.0)
        self.assertEqual(self.said(), [])  # it is shown as it counts
        self.obj.scale = (1.0, 1.0, 0.5)
        self.assertIn('the scale of "Sleeve"', self.said()[0])

    def test_what_cancels_is_none(self) -> None:
        self.obj.scale = (2.0, -2.0, 2.03)
        self.assertEqual(self.said(), [])
        self.above.scale = (1.0, 1.0, 3.0)
        self.obj.parent = self.above
        self.assertIn('the scale of "Above"', self.said()[0])
        self.obj.matrix_parent_inverse = Matrix.Diagonal((1.0, 1.0, 1.0 / 3.0, 1.0))
        self.assertEqual(self.said(), [])

    def test_one_that_begins_even_is_squash_and_stretch(self) -> None:
        for frame, size in ((1, 1.0), (sleeve.LAST, 2.0)):
            self.obj.scale.z = size
            self.obj.keyframe_insert("scale", frame=frame)
        sleeve.at(sleeve.LAST)
        self.assertEqual(self.said(), [])


class ScaledByABone(unittest.TestCase):
    """As an object that is scaled: it counted as stretched, and no fold was left."""

    def dressed(self, bone: float, size: float, **values: Any) -> bpy.types.Object:
        """A sleeve over a body, both of that size, or both scaled by the bone that the other one hangs from."""
        obj, body = cloth_scenes.dressed(**values)
        self.rig = bpy.data.objects["Arm"]
        self.rig.pose.bones["upper"].scale = (bone,) * 3
        self.rig.scale = obj.scale = body.scale = (size,) * 3
        return obj

    def in_the_world(self, obj: bpy.types.Object) -> np.ndarray:
        for _ in range(2):
            bpy.context.view_layer.update()
        scheduler.sync_all()
        sleeve.play(last=8)  # the more the sleeve is bent, the more folds multiply roundings
        return sleeve.shown(obj) * obj.scale.x

    def test_cloth_is_that_of_a_scaled_object(self) -> None:
        by_object = self.in_the_world(self.dressed(1.0, 2.0))
        obj = self.dressed(2.0, 1.0)
        by_bone = self.in_the_world(obj)
        apart = np.linalg.norm(by_bone - by_object, axis=1)
        self.assertLess(apart.mean(), 2e-4)  # metres: what is scaled is rounded elsewhere
        self.assertLess(apart.max(), 5e-3)
        moved = sleeve.shown(obj) - sleeve.shown(cloth_scenes.bared(obj))
        self.assertGreater(np.linalg.norm(moved, axis=1).mean(), 5e-3)

    def test_scaling_the_bone_makes_the_folds_anew(self) -> None:
        expected = self.in_the_world(self.dressed(2.0, 1.0))
        obj = self.dressed(1.0, 1.0)
        self.in_the_world(obj)
        self.rig.pose.bones["upper"].scale = (2.0, 2.0, 2.0)
        np.testing.assert_array_equal(self.in_the_world(obj), expected)

    def test_a_part_that_is_scaled_is_stretched(self) -> None:
        obj = self.dressed(1.0, 1.0)
        self.rig.pose.bones["lower"].scale = (2.0, 2.0, 2.0)
        self.assertEqual(rig_scale.of(obj, bpy.context.scene), 1.0)
        self.rig.data.bones["upper"].use_deform = False  # now the other one alone deforms it
        self.assertEqual(rig_scale.of(obj, bpy.context.scene), 2.0)

    def test_a_bone_that_does_not_inherit_scale_begins_at_1(self) -> None:
        obj = self.dressed(3.0, 1.0)
        obj.vertex_groups.remove(obj.vertex_groups["upper"])  # now both bones are above all that deforms it
        self.rig.pose.bones["lower"].scale = (2.0, 2.0, 2.0)
        self.assertAlmostEqual(rig_scale.of(obj, bpy.context.scene), 6.0)
        self.rig.data.bones["lower"].inherit_scale = "NONE"
        self.assertAlmostEqual(rig_scale.of(obj, bpy.context.scene), 2.0)

    def test_a_keyed_scale_is_that_of_the_first_frame_and_makes_nothing_anew(self) -> None:
        obj = self.dressed(1.0, 1.0)
        bone = self.rig.pose.bones["upper"]
        for frame, size in ((1, 2.0), (sleeve.LAST, 3.0)):
            bone.scale = (size,) * 3
            bone.keyframe_insert("scale", frame=frame)
        sleeve.at(20)
        scheduler.sync_all()
        self.assertEqual(rig_scale.of(obj, bpy.context.scene), 2.0)
        evaluator = runtimes.of(obj).evaluator
        sleeve.play()
        self.assertIs(runtimes.of(obj).evaluator, evaluator)

    def test_a_driven_scale_and_one_of_zero_do_not_count(self) -> None:
        obj = self.dressed(0.0, 1.0)
        self.assertEqual(rig_scale.of(obj, bpy.context.scene), 1.0)
        for axis in range(3):
            self.rig.pose.bones["upper"].driver_add("scale", axis).driver.expression = "1 + frame / 10"
        sleeve.at(2)
        evaluator = runtimes.of(obj).evaluator
        sleeve.play()
        self.assertEqual(rig_scale.of(obj, bpy.context.scene), 1.0)
        self.assertIs(runtimes.of(obj).evaluator, evaluator)

    def test_a_captured_shape_has_the_size_that_it_was_shown_in(self) -> None:
        obj = self.dressed(2.0, 1.0)
        bpy.ops.object.rumple_capture_rest(frame=1)
        scheduler.sync_all()
        sleeve.at(1)
        base = runtimes.of(obj).evaluator.base
        np.testing.assert_allclose(base.positions, runtimes.of(obj).inputs.positions, atol=1e-5)


class Slots(unittest.TestCase):

    @unittest.skipUnless("action_slot" in bpy.types.AnimData.bl_rna.properties, "actions have no slots in this Blender")
    def test_keys_of_another_slot_do_not_count(self) -> None:
        """An action may animate several objects: the scale that it keys for the rig is not that of the garment."""
        obj, rig = sleeve.scene(), bpy.data.objects["Arm"]
        action = rig.animation_data.action
        for frame, size in ((1, 1.0), (sleeve.LAST, 3.0)):
            rig.scale = (size,) * 3
            rig.keyframe_insert("scale", frame=frame)
        self.assertIn("scale", compat.animated_paths(rig))
        self.assertIsNotNone(compat.find_curve(rig.animation_data, "scale", 2))
        about = obj.animation_data_create()
        about.action = action
        about.action_slot = None
        self.assertEqual(compat.animated_paths(obj), set())
        about.action_slot = slot = action.slots.new("OBJECT", "Sleeve")
        self.assertEqual((compat.animated_paths(obj), list(compat.keyed_curves(about))), (set(), []))
        bag = action.layers[0].strips[0].channelbag(slot, ensure=True)
        bag.fcurves.new("hide_render").keyframe_points.insert(1, 0.0)
        self.assertEqual(compat.animated_paths(obj), {"hide_render"})
        self.assertIsNone(compat.find_curve(about, "scale", 2))
        sleeve.at(sleeve.LAST)
        self.assertEqual((tuple(obj.scale), tuple(rig.scale)), ((1.0,) * 3, (3.0,) * 3))
        self.assertEqual(units.metres_per_unit(obj, bpy.context.scene), 1.0)


class Applied(unittest.TestCase):
    """Blender moves no vector of an attribute when scale and rotation are applied."""

    def setUp(self) -> None:
        self.obj = sleeve.scene(wrinkles=False)
        self.obj.scale, self.obj.rotation_euler = (2.0, 2.0, 2.0), (0.3, 0.2, 1.1)
        bpy.context.view_layer.update()
        self.map = np.array(self.obj.matrix_world)

    def apply(self, obj: bpy.types.Object | None = None) -> None:
        sleeve.make_active(obj or self.obj)
        bpy.ops.object.transform_apply(location=True, rotation=True, scale=True)
        for _ in range(2):
            bpy.context.view_layer.update()
            scheduler.sync_all()

    def vectors(self, name: str) -> np.ndarray:
        return compat.read_attribute(incoming_mesh.of(self.obj).attributes[name])

    def test_a_captured_rest_shape_goes_along(self) -> None:
        """It was half as large as the cloth, and everything was taut."""
        for behind in ("nothing", "a modifier that makes points"):
            with self.subTest(behind):
                self.setUp()
                if behind != "nothing":
                    self.obj.modifiers.new("Subdivision", "SUBSURF").levels = 1
                    compat.move_modifier(self.obj, 1, 0)
                sleeve.make_active(self.obj)
                bpy.ops.object.rumple_add(method="MESH")
                bpy.ops.object.rumple_capture_rest(frame=8)
                before = self.vectors(wrinkle_tree.REST_POSITION)
                self.apply()
                after = before @ self.map[:3, :3].T + self.map[:3, 3]
                np.testing.assert_allclose(self.vectors(wrinkle_tree.REST_POSITION), after, atol=2e-4)
                self.apply()
                np.testing.assert_allclose(self.vectors(wrinkle_tree.REST_POSITION), after, atol=2e-4)
                bpy.ops.object.rumple_remove()
                self.assertNotIn(wrinkle_tree.REST_BASIS, self.obj.data.attributes)

    def test_up_at_rest_goes_along(self) -> None:
        """The waist of trousers that lay on their back was no longer the highest opening, and the hems were pinned."""
        self.obj.rotation_euler, self.obj.scale = (0.0, -1.5, 0.4), (2.0, 1.0, 1.5)
        sleeve.make_active(self.obj)
        bpy.ops.object.rumple_add(method="MESH")
        mesh = self.obj.rumple.mesh
        mesh.up = "X"  # along the sleeve: up in the world, nearly
        self.obj.rumple.field.up = "-Y"
        scheduler.sync_all()
        bpy.ops.ed.undo_push(message="Before")
        for again in range(2):
            self.apply()
            self.assertEqual((mesh.up, self.obj.rumple.field.up, self.obj.rumple.paths.up), ("Z", "-Y", "Z"), again)
        mesh.up = "-X"  # chosen anew, it stays
        self.obj.data.vertices[3].co.x += 0.2
        self.apply()
        self.assertEqual(mesh.up, "-X")

    def test_a_mirrored_body_is_outside_where_it_was(self) -> None:
        """Blender 3.4 and 4.3 leave it inside out. Cloth took the inside for the outside until the file was opened."""
        obj = self.obj = sleeve.scene(wrinkles=False)
        obj.rumple.mesh.property_unset("base_cloth")
        body = sleeve.under(obj)
        body.modifiers.clear()
        body.data.transform(Matrix.Diagonal((1.0, -1.0, 1.0, 1.0)))
        body.scale.y = -1.0
        sleeve.make_active(obj)
        bpy.ops.object.rumple_add(method="MESH")
        obj.rumple.body = body
        shown = []
        for change in (lambda: None, lambda: self.apply(body), lambda: (bodies.forget_all(), runtimes.forget(obj))):
            change()
            scheduler.sync_all()
            sleeve.play(1, 8)
            shown.append(sleeve.shown(obj))
        np.testing.assert_array_equal(shown[1], shown[2])

    def test_painted_waves_go_along(self) -> None:
        bpy.ops.object.rumple_add(method="FIELD")
        bpy.ops.object.rumple_scatter(seed=3)
        scheduler.sync_all()
        before = self.vectors(mesh_reader.REST_WRINKLE)
        self.assertGreater(np.abs(before).max(), 0.1)
        self.apply()
        turn = self.map[:3, :3] / 2.0
        np.testing.assert_allclose(self.vectors(mesh_reader.REST_WRINKLE), before @ turn.T, atol=2e-4)
        bpy.ops.object.rumple_clear_rest_wrinkles()
        scheduler.sync_all()
        self.assertNotIn(wrinkle_tree.REST_BASIS, self.obj.data.attributes)


if __name__ == "__main__":
    unittest.main()
