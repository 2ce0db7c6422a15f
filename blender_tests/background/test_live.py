# SPDX-License-Identifier: GPL-3.0-or-later
"""The live solve: any frame in any order, paint, settings, duplicates, edits, undo, files."""
from __future__ import annotations

import os
import tempfile
import unittest
from dataclasses import fields, replace
from unittest import mock
from typing import Any

import bmesh
import bpy
import numpy as np
from rumple.blender import handlers, scheduler
from rumple.blender.frame import solve
from rumple.blender.maps import changes as maps_changes, solve as maps_solve
from rumple.blender.nodes import wrinkle_tree
from rumple.blender.objects import changes, modifier, output_mesh, runtimes
from rumple.blender.objects.kept_lists import ModifiedObjects
from support import sleeve


class Frames(unittest.TestCase):

    def test_played_frames_look_the_same_in_any_order(self) -> None:
        obj = sleeve.scene()
        sleeve.play()
        pictures = {}
        for frame in (20, 4, 13, 7):
            sleeve.at(frame)
            pictures[frame] = sleeve.shown(obj)
        for frame in (7, 20, 13, 4):
            sleeve.at(frame)
            np.testing.assert_array_equal(sleeve.shown(obj), pictures[frame])

    def test_every_input_counts_but_the_start(self) -> None:
        obj = sleeve.scene()
        sleeve.at(5)
        inputs = runtimes.of(obj).inputs
        self.assertTrue(inputs.same_as(replace(inputs, positions=inputs.positions.copy(), paint=dict(inputs.paint))))
        for one in fields(inputs):
            other = replace(inputs, **{one.name: {"room": np.ones(3)} if one.name == "paint" else "another"})
            self.assertEqual(inputs.same_as(other), one.name == "start", one.name)

    def test_the_folds_show(self) -> None:
        obj = sleeve.scene()
        sleeve.play()
        self.assertGreater(np.linalg.norm(sleeve.attribute(obj, "rumple_offset"), axis=1).max(), 1e-3)

    def test_subframes_stand_between_frames(self) -> None:
        obj = sleeve.scene()
        sleeve.play()
        sleeve.at(12)
        before = sleeve.shown(obj)
        sleeve.at(12, 0.5)
        self.assertEqual(runtimes.of(obj).inputs.frame, 12.5)
        between = sleeve.shown(obj)
        np.testing.assert_allclose(between, sleeve.picture(obj).positions, atol=1e-6)
        self.assertGreater(np.abs(between - before).max(), 1e-4)

    def test_a_held_pose_stays_to_the_bit(self) -> None:
        obj = sleeve.scene()
        bpy.data.objects["Arm"].animation_data_clear()
        bpy.data.objects["Arm"].pose.bones["lower"].rotation_euler.z = 1.2
        sleeve.play(1, 12)
        still = sleeve.shown(obj)
        sleeve.play(13, 20)
        np.testing.assert_array_equal(sleeve.shown(obj), still)

    def test_nothing_is_written_when_nothing_changed(self) -> None:
        obj = sleeve.scene()
        sleeve.at(9)
        written = []
        original = output_mesh.write_result
        output_mesh.write_result = lambda *arguments: written.append(1) or original(*arguments)
        try:
            bpy.data.objects.new("Empty", None)
            for _ in range(3):
                obj.update_tag()
                bpy.context.view_layer.update()
        finally:
            output_mesh.write_result = original
        self.assertEqual(written, [])

    def test_updates_are_read_before_anything_is_made_anew(self) -> None:
        """The list of updates still names a mesh that a rebuild removed: in 3.4 to ask for its original then wrote into
        freed memory, and crashed at the next file."""
        sleeve.scene()
        calls = mock.Mock()
        with mock.patch.object(changes, "note_updates", calls.note), mock.patch.object(solve, "process", calls.work), \
                mock.patch.object(maps_changes, "note_updates", calls.note), \
                mock.patch.object(maps_solve, "process", calls.work):
            for handler in (handlers._on_frame, handlers._on_update):
                calls.reset_mock()
                handler(bpy.context.scene, bpy.context.evaluated_depsgraph_get())
                self.assertEqual([call[0] for call in calls.mock_calls], ["note", "note", "work", "work"])

    def test_a_handler_searches_the_file_once_for_each_kind(self) -> None:
        sleeve.scene()
        sleeve.at(2)
        searched = []
        original = ModifiedObjects._searched

        def counted(kept: Any) -> Any:
            searched.append(kept)
            return original(kept)
        with mock.patch.object(ModifiedObjects, "_searched", counted):
            for handler in (handlers._on_frame, handlers._on_update):
                searched.clear()
                handler(bpy.context.scene, bpy.context.evaluated_depsgraph_get())
                self.assertIn(modifier._WRINKLED, searched)
                self.assertEqual(len(searched), len(set(searched)))

    def test_the_kept_list_follows_what_scripts_do(self) -> None:
        obj = sleeve.scene()
        sleeve.at(2)

        def names() -> list[str]:
            return [found.name for found, _ in modifier.wrinkled_objects()]
        self.assertEqual(names(), ["Sleeve"])
        obj.name = "Cuff"
        self.assertEqual(names(), ["Cuff"])
        copy = obj.copy()
        bpy.context.collection.objects.link(copy)
        bpy.context.view_layer.update()
        self.assertEqual(names(), ["Cuff", "Cuff.001"])
        bpy.data.objects.remove(obj)
        self.assertEqual(names(), ["Cuff.001"])
        copy.modifiers.remove(modifier.find(copy))
        self.assertEqual(names(), [])

    def test_stretch_attributes_are_sane(self) -> None:
        obj = sleeve.scene()
        sleeve.at(20)
        low, high = sleeve.attribute(obj, "rumple_stretch_min"), sleeve.attribute(obj, "rumple_stretch_max")
        self.assertTrue((low <= high + 1e-6).all())
        self.assertLess(low.min(), 0.9)
        self.assertEqual(sleeve.attribute(obj, "rumple_stretch_direction").shape, (len(low), 3))

    def test_internal_attributes_do_not_reach_later_modifiers(self) -> None:
        names = {a.name for a in sleeve.evaluated(sleeve.scene()).data.attributes}
        self.assertEqual(names & set(wrinkle_tree.OUTPUT_ONLY), set())


class Settings(unittest.TestCase):

    def test_radius_zero_means_no_folds(self) -> None:
        obj = sleeve.scene()
        obj.rumple.mesh.radius = 0.0
        sleeve.at(20)
        np.testing.assert_allclose(sleeve.attribute(obj, "rumple_offset"), 0.0, atol=1e-6)

    def test_density_rebuilds_the_mesh(self) -> None:
        obj = sleeve.scene(level=1)
        coarse = len(sleeve.shown(obj))
        obj.rumple.mesh.level = 2
        bpy.context.view_layer.update()
        self.assertGreater(len(sleeve.shown(obj)), 3 * coarse)
        np.testing.assert_allclose(sleeve.shown(obj), sleeve.picture(obj).positions, atol=1e-6)

    def test_animated_settings_count(self) -> None:
        obj = sleeve.scene()
        for frame, value in ((1, 0.0), (20, 1.0)):
            obj.rumple.mesh.radius = value
            obj.keyframe_insert("rumple.mesh.radius", frame=frame)
        sleeve.at(20)
        self.assertEqual(runtimes.of(obj).inputs.settings.radius, 1.0)
        sleeve.at(1)
        self.assertEqual(runtimes.of(obj).inputs.settings.radius, 0.0)

    def test_lengths_are_metres_whatever_the_unit(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        bpy.context.scene.unit_settings.scale_length = 0.01
        bpy.ops.object.rumple_add(method="MESH")
        self.assertAlmostEqual(obj.rumple.mesh.edge_length, 1.0, places=5)
        self.assertEqual(runtimes.of(obj).evaluator.level, 2, "the fold width suits a doll as well")

    def test_paint_keeps_folds_away(self) -> None:
        obj = sleeve.scene()
        bpy.ops.object.rumple_paint(group="radius")
        self.assertEqual(obj.vertex_groups.active.name, "Rumple Radius")
        sleeve.at(20)
        everywhere = np.abs(sleeve.attribute(obj, "rumple_offset")).max()
        obj.vertex_groups["Rumple Radius"].add(range(len(obj.data.vertices)), 0.0, "REPLACE")
        bpy.context.view_layer.update()
        self.assertGreater(everywhere, 1e-3)
        np.testing.assert_allclose(sleeve.attribute(obj, "rumple_offset"), 0.0, atol=1e-6)
        self.assertIn("Rumple Radius", sleeve.output_object(obj).vertex_groups)

    def test_rest_from_a_frame(self) -> None:
        obj = sleeve.scene()
        bpy.ops.object.rumple_capture_rest(frame=20)
        sleeve.at(20)
        self.assertEqual(obj.rumple.mesh.rest_shape, "FRAME")
        np.testing.assert_allclose(sleeve.attribute(obj, "rumple_stretch_min"), 1.0, atol=1e-3)

    def test_rest_from_a_shape_key_that_is_missing(self) -> None:
        obj = sleeve.scene()
        vertices = len(sleeve.shown(obj))
        obj.rumple.rest_key, obj.rumple.mesh.rest_shape = "Nowhere", "SHAPE_KEY"
        bpy.context.view_layer.update()
        self.assertIn("Nowhere", obj.rumple.message)
        self.assertEqual(len(sleeve.shown(obj)), vertices)


class Copies(unittest.TestCase):

    def test_duplicates_get_output_objects_of_their_own(self) -> None:
        for linked in (False, True):
            obj = sleeve.scene()
            bpy.ops.object.duplicate(linked=linked)
            copy = bpy.context.object
            sleeve.at(20)
            self.assertNotEqual(sleeve.output_object(copy), sleeve.output_object(obj))
            np.testing.assert_allclose(sleeve.shown(copy), sleeve.shown(obj), atol=1e-6)
            copy.rumple.mesh.radius = 0.0
            sleeve.at(19)
            self.assertGreater(np.abs(sleeve.attribute(obj, "rumple_offset")).max(), 1e-3)
            np.testing.assert_allclose(sleeve.attribute(copy, "rumple_offset"), 0.0, atol=1e-6)

    def test_deleting_one_leaves_the_other(self) -> None:
        obj = sleeve.scene()
        bpy.ops.object.duplicate()
        bpy.ops.object.delete()
        sleeve.at(20)
        self.assertEqual(obj.rumple.message, "")
        scheduler.sync_all()
        self.assertEqual(sleeve.names(bpy.data.objects), ["Arm", "Sleeve", "Sleeve.wrinkles"])

    def test_renaming(self) -> None:
        obj = sleeve.scene()
        sleeve.play(1, 5)
        stored = len(runtimes.of(obj).evaluator.frame_cache.frames())
        obj.name = "Shirt"
        sleeve.at(6)
        self.assertEqual(obj.rumple.message, "")
        self.assertEqual(len(runtimes.of(obj).evaluator.frame_cache.frames()), stored + 1)

    def test_removing_one_of_two_that_share_a_mesh(self) -> None:
        obj = sleeve.scene()
        bpy.ops.object.rumple_capture_rest(frame=1)
        bpy.ops.object.duplicate(linked=True)
        bpy.context.view_layer.update()
        bpy.ops.object.rumple_remove()
        sleeve.at(20)
        self.assertEqual(obj.rumple.message, "")
        self.assertIn(wrinkle_tree.REST_POSITION, obj.data.attributes)

    def test_copied_modifiers_are_bound_anew(self) -> None:
        obj = sleeve.scene()
        other = sleeve.skinned(sleeve.tube("Other"), bpy.data.objects["Arm"], "Other")
        source = modifier.find(obj)
        new = other.modifiers.new("Wrinkle Mesh", "NODES")
        new.node_group = source.node_group
        modifier.set_output_object(new, sleeve.output_object(obj), modifier.coarse_vertices(source))
        sleeve.at(10)
        sleeve.at(11)
        self.assertEqual(other.rumple.method, "MESH")
        self.assertNotEqual(sleeve.output_object(obj), sleeve.output_object(other))


class Edits(unittest.TestCase):

    def test_an_edited_topology_is_wrinkled_again(self) -> None:
        obj = sleeve.scene()
        sleeve.at(10)
        edit = bmesh.new()
        edit.from_mesh(obj.data)
        edit.faces.ensure_lookup_table()
        bmesh.ops.delete(edit, geom=edit.faces[:sleeve.AROUND], context="FACES")
        edit.to_mesh(obj.data)
        edit.free()
        obj.data.update()
        sleeve.at(11)
        sleeve.at(12)
        self.assertEqual(obj.rumple.message, "")
        self.assertEqual(modifier.coarse_vertices(modifier.find(obj)), len(obj.data.vertices))
        np.testing.assert_allclose(sleeve.shown(obj), sleeve.picture(obj).positions, atol=1e-6)

    def test_edit_mode_and_back(self) -> None:
        obj = sleeve.scene()
        sleeve.at(10)
        bpy.ops.object.mode_set(mode="EDIT")
        sleeve.at(11)
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.mesh.subdivide()
        bpy.ops.object.mode_set(mode="OBJECT")
        sleeve.at(12)
        sleeve.at(13)
        self.assertEqual(obj.rumple.message, "")
        np.testing.assert_allclose(sleeve.shown(obj), sleeve.picture(obj).positions, atol=1e-6)

    def test_an_empty_mesh_is_refused_in_words(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        obj.data.clear_geometry()
        with self.assertRaises(RuntimeError) as caught:
            bpy.ops.object.rumple_add(method="MESH")
        self.assertIn("Sleeve", str(caught.exception))
        self.assertIsNone(modifier.find(obj))

    def test_a_broken_edit_keeps_the_last_good_mesh(self) -> None:
        obj = sleeve.scene()
        sleeve.at(10)
        fine = runtimes.of(obj).evaluator
        obj.data.clear_geometry()
        sleeve.at(11)
        self.assertNotEqual(obj.rumple.message, "")
        self.assertIs(runtimes.of(obj).evaluator, fine)
        self.assertEqual(len(sleeve.output_object(obj).data.vertices), fine.vertex_count)

    def test_undo_and_redo_of_a_setting_and_of_removal(self) -> None:
        obj = sleeve.scene()
        bpy.ops.ed.undo_push(message="start")
        obj.rumple.mesh.radius = 0.0
        bpy.ops.ed.undo_push(message="radius")
        bpy.ops.object.rumple_remove()
        bpy.ops.ed.undo_push(message="remove")
        bpy.ops.ed.undo()
        self.assertEqual(self.folds(), 0.0)
        bpy.ops.ed.undo()
        self.assertGreater(self.folds(), 1e-3)
        bpy.ops.ed.redo()
        self.assertEqual(self.folds(), 0.0)
        bpy.ops.ed.redo()
        self.assertIsNone(modifier.find(bpy.data.objects["Sleeve"]))
        sleeve.at(5)

    def folds(self) -> float:
        sleeve.at(3)
        sleeve.at(20)
        obj = bpy.data.objects["Sleeve"]
        self.assertEqual(obj.rumple.message, "")
        return float(np.abs(sleeve.attribute(obj, "rumple_offset")).max())


class Files(unittest.TestCase):

    def setUp(self) -> None:
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name: str) -> str:
        return os.path.join(self.folder.name, name)

    def test_saved_and_opened_again(self) -> None:
        obj = sleeve.scene()
        sleeve.play()
        sleeve.at(15)
        seen = sleeve.shown(obj)
        bpy.ops.wm.save_as_mainfile(filepath=self.path("a.blend"))
        bpy.ops.wm.open_mainfile(filepath=self.path("a.blend"))
        obj = bpy.data.objects["Sleeve"]
        np.testing.assert_allclose(sleeve.shown(obj), seen, atol=1e-6)
        sleeve.play()
        sleeve.at(15)
        np.testing.assert_array_equal(sleeve.shown(obj), seen)

    def test_appended_twice(self) -> None:
        sleeve.scene()
        bpy.ops.wm.save_as_mainfile(filepath=self.path("library.blend"))
        sleeve.empty_file()
        for _ in range(2):
            bpy.ops.wm.append(directory=self.path("library.blend") + "/Object/", filename="Sleeve")
        sleeve.at(20)
        both = [o for o in bpy.data.objects if modifier.find(o)]
        self.assertEqual(len(both), 2)
        self.assertNotEqual(*[sleeve.output_object(o) for o in both])
        self.assertEqual([o.rumple.message for o in both], ["", ""])

    def test_linked_and_overridden(self) -> None:
        sleeve.scene()
        bpy.ops.wm.save_as_mainfile(filepath=self.path("library.blend"))
        sleeve.empty_file()
        with bpy.data.libraries.load(self.path("library.blend"), link=True) as (_, wanted):
            wanted.objects = ["Sleeve"]
        linked = wanted.objects[0]
        bpy.context.scene.collection.objects.link(linked)
        sleeve.at(19)
        sleeve.at(20)
        self.assertEqual(linked.rumple.message, "")
        self.assertGreater(np.abs(sleeve.attribute(linked, "rumple_offset")).max(), 1e-3)
        override = linked.override_create(remap_local_usages=True)
        sleeve.at(18)
        sleeve.at(20)
        self.assertEqual(override.rumple.message, "")
        self.assertGreater(np.abs(sleeve.attribute(override, "rumple_offset")).max(), 1e-3)
        override.rumple.mesh.radius = 0.0
        sleeve.at(19)
        np.testing.assert_allclose(sleeve.attribute(override, "rumple_offset"), 0.0, atol=1e-6)
        bpy.ops.wm.save_as_mainfile(filepath=self.path("shot.blend"))
        bpy.ops.wm.open_mainfile(filepath=self.path("shot.blend"))
        override = next(o for o in bpy.data.objects if o.override_library and modifier.find(o))
        self.assertEqual(override.rumple.mesh.radius, 0.0)
        sleeve.at(18)
        self.assertEqual(override.rumple.message, "")
