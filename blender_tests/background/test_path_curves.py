# SPDX-License-Identifier: GPL-3.0-or-later
"""The paths as curves: what they show, and what becomes of them when their garment is copied, saved, baked, removed."""
from __future__ import annotations

import os
import tempfile
import unittest
from unittest import mock

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree
from rumple.blender import compat, handlers, scheduler
from rumple.blender.bake import clip as clip_bake
from rumple.blender.frame import clip_status, path_curves
from rumple.blender.nodes import path_curves_tree
from rumple.blender.objects import modifier, runtimes
from rumple.core.files import clip_file
from rumple.core.files.clip_manifest import ClipFault
from rumple.core.systems import curve_rows
from support import curve_edges, sleeve, small_renders, vanilla_blender


def curved() -> tuple[bpy.types.Object, bpy.types.Object]:
    """The sleeve with Wrinkle Paths, and its curves."""
    obj = sleeve.scene(wrinkles=False)
    with sleeve.context():
        bpy.ops.object.rumple_add(method="PATHS")
        bpy.ops.object.rumple_curves_add()
    return obj, curve_edges.child_of(obj)


class Curves(unittest.TestCase):
    def test_follow_playback_scrubbing_and_subframes(self) -> None:
        obj, child = curved()
        sleeve.at(1)
        self.assertEqual(curve_edges.same(self, obj, child), 0, "nothing folds at rest")
        sleeve.play()
        self.assertGreater(curve_edges.same(self, obj, child), 3)
        for frame, subframe in ((3, 0.0), (20, 0.0), (11, 0.5), (15, 0.25), (1, 0.0)):
            sleeve.at(frame, subframe)
            curve_edges.same(self, obj, child)
        self.assertEqual(obj.rumple.message, "")

    def test_they_move_with_the_garment_and_stand_at_its_crests(self) -> None:
        obj, child = curved()
        rig = bpy.data.objects["Arm"]
        obj.parent, rig.location, rig.rotation_euler = rig, (1.0, 2.0, 3.0), (0.4, 0.5, 0.6)
        sleeve.play()
        _, positions, values = curve_edges.seen(child)
        np.testing.assert_allclose(np.array(child.matrix_world), np.array(obj.matrix_world), atol=1e-6)
        shown, heights = sleeve.shown(obj), sleeve.attribute(obj, "rumple_height")[:, 0]
        width, away = obj.rumple.paths.width, []
        surface = BVHTree.FromObject(obj, bpy.context.evaluated_depsgraph_get())
        for p, height in zip(positions, values["rumple_path_height"]):
            nearest = np.linalg.norm(shown - p, axis=1).argmin()
            if heights[nearest] < 1.2 * height:  # else it runs below a higher fold there
                away.append(surface.find_nearest(p)[3])
        self.assertGreater(len(away), 0.5 * len(positions))
        self.assertLess(max(away), 0.2 * width)

    def test_nothing_is_written_when_nothing_changed(self) -> None:
        obj, child = curved()
        sleeve.at(15)
        with mock.patch.object(compat, "set_positions", side_effect=AssertionError("written")):
            runtimes.of(obj).invalidate_output()
            sleeve.at(15)
        self.assertEqual(obj.rumple.message, "")
        sleeve.at(14)
        curve_edges.same(self, obj, child)

    def test_a_modifier_behind_that_shuffles_the_points_hides_them_and_the_wrinkles_off_too(self) -> None:
        obj, child = curved()
        sleeve.play()
        modifier.find(obj).show_viewport = False
        bpy.context.view_layer.update()
        self.assertEqual(len(curve_edges.seen(child)[0]), 0, "they shrank to the origin")
        modifier.find(obj).show_viewport = True
        sleeve.at(20)
        obj.modifiers.new("Subdivision", "SUBSURF")
        sleeve.at(19)
        self.assertGreater(curve_edges.same(self, obj, child), 0)

    def test_a_tube_has_the_radius_that_is_set(self) -> None:
        obj, child = curved()
        sleeve.play()
        curves, positions, _ = curve_edges.seen(child)
        child.modifiers.remove(child.modifiers[curve_edges.NAME])
        nodes_mod = path_curves.find(child)
        compat.set_modifier_input(nodes_mod, compat.group_sockets(nodes_mod.node_group, "INPUT")["Radius"], 0.002)
        child.update_tag()
        sleeve.at(20)
        mesh = sleeve.evaluated(child).data
        self.assertGreater(len(mesh.polygons), 6 * len(positions))
        away = [np.linalg.norm(positions - p, axis=1).min() for p in compat.positions(mesh)]
        self.assertAlmostEqual(max(away), 0.002, places=4)

    def test_refusals_in_words(self) -> None:
        obj, child = curved()
        sleeve.make_active(child)
        self.assertFalse(bpy.ops.object.rumple_add.poll(), "curves have no folds")
        sleeve.make_active(obj)
        self.assertTrue(bpy.ops.object.rumple_curves_remove.poll())
        bpy.ops.object.rumple_curves_remove()
        self.assertFalse(bpy.ops.object.rumple_curves_remove.poll())
        bpy.ops.object.rumple_remove()
        self.assertFalse(bpy.ops.object.rumple_curves_add.poll())

    def test_in_edit_mode_they_wait(self) -> None:
        obj, child = curved()
        sleeve.make_active(child)
        bpy.ops.object.mode_set(mode="EDIT")
        sleeve.play()
        bpy.ops.object.mode_set(mode="OBJECT")
        sleeve.at(19)
        self.assertGreater(curve_edges.same(self, obj, child), 0)


class Rows(unittest.TestCase):
    def test_curves_without_room_are_left_out_whole(self) -> None:
        obj, _ = curved()
        sleeve.play()
        curves = curve_edges.solved(obj)
        room = int(curves.start[2]) + 1  # two curves and a point
        rows, left_out = curve_rows.rows_of(curves, room)
        self.assertEqual(left_out, len(curves.id) - 2)
        self.assertEqual(rows.reshape(4, room, 3)[3, :, 2].sum(), curves.start[2] - 2, "edges within curves")

    def test_the_capacity_grows_where_it_may_and_is_said_where_not(self) -> None:
        obj, child = curved()
        sleeve.at(1)
        path_curves._set_capacity(child.data, 16)
        with mock.patch.object(scheduler, "allowed_now", return_value=False):  # as while it renders
            sleeve.play()
            self.assertRegex(obj.rumple.message, "Sleeve.curves has no room for [0-9]+ of [0-9]+ paths")
            self.assertEqual(path_curves.capacity(child.data), 16, "topology changed while it renders")
            self.assertEqual(runtimes.of(obj).message, "", "to what is worn over it, it would be an unsolved garment")
        scheduler.sync_all()
        sleeve.at(20)
        self.assertGreater(curve_edges.same(self, obj, child), 3)
        self.assertEqual(obj.rumple.message, "")


class Lives(unittest.TestCase):
    def test_removing_the_wrinkles_removes_them(self) -> None:
        for remove in (bpy.ops.object.rumple_remove,
                       lambda: bpy.context.object.modifiers.remove(modifier.find(bpy.context.object)),
                       lambda: bpy.data.objects.remove(bpy.data.objects["Sleeve"])):
            obj, _ = curved()
            sleeve.at(5)
            remove()
            scheduler.sync_all()
            self.assertEqual([o for o in sleeve.names(bpy.data.objects) if o != "Sleeve"], ["Arm"])
            self.assertFalse(any(path_curves_tree.is_ours(group) for group in bpy.data.node_groups))
            self.assertLessEqual(sleeve.names(bpy.data.meshes), ["Sleeve"])

    def test_an_emptied_input_removes_nothing(self) -> None:
        _, child = curved()
        nodes_mod = path_curves.find(child)
        compat.set_modifier_input(nodes_mod, compat.group_sockets(nodes_mod.node_group, "INPUT")["Garment"], None)
        scheduler.sync_all()
        self.assertIn(child.name, bpy.data.objects)

    def test_copies_of_both_have_curves_of_their_own(self) -> None:
        for linked in (False, True):
            obj, child = curved()
            child.select_set(True)
            bpy.ops.object.duplicate(linked=linked)
            scheduler.sync_all()
            copy = next(o for o, _ in modifier.wrinkled_objects() if o != obj)
            self.assertNotEqual(curve_edges.child_of(copy).data, child.data)
            copy.rumple.paths.seed = 7
            sleeve.play()
            for garment in (obj, copy):
                self.assertGreater(curve_edges.same(self, garment, curve_edges.child_of(garment)), 3)

    def test_a_copy_of_the_garment_alone_has_none(self) -> None:
        obj, child = curved()
        bpy.ops.object.duplicate()
        scheduler.sync_all()
        self.assertEqual(path_curves.of(obj), [child])
        self.assertEqual(len(list(path_curves.all_curves())), 1)

    def test_saved_and_opened_they_go_on(self) -> None:
        curved()
        sleeve.play()
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "curves.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
            obj = bpy.data.objects["Sleeve"]
            sleeve.play()
            self.assertGreater(curve_edges.same(self, obj, curve_edges.child_of(obj)), 3)


class ElseWhere(vanilla_blender.InAFolder, unittest.TestCase):
    """Baked, rendered, and in a Blender without the add-on."""

    def test_without_the_add_on_they_ride_on_the_pose(self) -> None:
        obj, child = curved()
        sleeve.play()
        sleeve.at(12)
        curve_edges.to_edges(child)
        self.save()
        curves = curve_edges.solved(obj)
        there = vanilla_blender.look(self.folder, child.name, (12.0, 20.0), attributes=("rumple_path_height",))
        np.testing.assert_allclose(there[12.0]["position"], curves.positions, atol=2e-6)
        np.testing.assert_array_equal(there[20.0]["rumple_path_height"][:, 0], curves.height)
        sleeve.at(20)
        pose = runtimes.of(obj).inputs.positions
        p0, p1, p2 = (pose[curves.corners[:, k]] for k in range(3))
        on_triangle = p0 + curves.weights[:, :1] * (p1 - p0) + curves.weights[:, 1:] * (p2 - p0)
        np.testing.assert_allclose(np.linalg.norm(there[20.0]["position"] - on_triangle, axis=1),
                                   np.linalg.norm(curves.local_offset, axis=1), atol=2e-6)

    def test_baked_they_need_neither_handlers_nor_the_add_on(self) -> None:
        obj, child = curved()
        self.save()
        sleeve.play()
        live = {}
        for frame in (20, 9, 15):
            sleeve.at(frame)
            live[frame] = curve_edges.seen(child)
        obj.rumple.bake_whole_clip = False  # as in playback
        self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
        self.assertFalse(bpy.ops.object.rumple_curves_add.poll())
        handlers.unregister()
        try:
            for frame, (curves, positions, values) in live.items():
                sleeve.at(frame)
                baked = curve_edges.seen(child)
                np.testing.assert_array_equal(baked[0], curves)
                np.testing.assert_allclose(baked[1], positions, atol=2e-6)
                for name in curve_edges.ATTRIBUTES if len(curves) else ():
                    np.testing.assert_array_equal(baked[2][name], values[name])
            sleeve.at(15, 0.4)
            self.assertGreater(len(curve_edges.seen(child)[0]), 0)
        finally:
            handlers.register()
        self.save()
        there = vanilla_blender.look(self.folder, child.name, (20.0, 15.0), attributes=("rumple_path_width",))
        for frame in (20, 15):
            np.testing.assert_allclose(there[float(frame)]["position"], live[frame][1], atol=2e-6)

    def test_a_bake_prints_no_error_of_blender(self) -> None:
        """Its Mesh Cache stood behind the nodes, which leave no points, until it was moved above them."""
        obj, child = curved()
        move, on = compat.move_modifier, []

        def watched(moved: bpy.types.Object, source: int, target: int) -> None:
            on.append(moved.modifiers[source].show_viewport)
            move(moved, source, target)

        with mock.patch.object(compat, "move_modifier", watched):
            bpy.ops.object.rumple_bake()
        self.assertEqual(on, [False])
        self.assertTrue(modifier.mesh_cache(child).show_viewport)

    def test_between_baked_samples_they_ride_on_the_pose(self) -> None:
        obj, child = curved()
        self.save()
        bpy.ops.object.rumple_bake()
        sleeve.at(18)
        count = len(curve_edges.seen(child)[0])
        for subframe in (0.25, 0.4):
            sleeve.at(18, subframe)
            curves, positions, _ = curve_edges.seen(child)
            self.assertEqual(len(curves), count, "the curves of two samples were mixed")
            shown = sleeve.shown(obj)
            away = max(np.linalg.norm(shown - p, axis=1).min() for p in positions)
            self.assertLess(away, obj.rumple.paths.width)

    def test_a_freed_bake_is_live_again_and_its_file_goes_when_told(self) -> None:
        obj, child = curved()
        self.save()
        bpy.ops.object.rumple_bake()
        files = sorted(path.name for path in (self.folder / "rumple").iterdir())
        clip = clip_status.clip_path(obj)
        self.assertEqual(files, [clip.with_suffix(".curves.pc2").name, clip.name])
        bpy.ops.object.rumple_bake_free(delete_file=True)
        self.assertEqual(list((self.folder / "rumple").iterdir()), [])
        sleeve.play()
        self.assertGreater(curve_edges.same(self, obj, child), 3)

    def test_a_bake_that_breaks_off_leaves_the_former_clip(self) -> None:
        obj, child = curved()
        self.save()
        bpy.ops.object.rumple_bake()
        sleeve.at(18)
        before = curve_edges.seen(child)[1]
        with mock.patch.object(clip_file.ClipWriter, "add", side_effect=OSError("disk full")):
            with self.assertRaisesRegex(RuntimeError, "disk full"):
                bpy.ops.object.rumple_bake()
        sleeve.at(1)
        sleeve.at(18)
        np.testing.assert_array_equal(curve_edges.seen(child)[1], before)
        self.assertIsNotNone(modifier.mesh_cache(child))
        obj.rumple.paths.seed = 5
        self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
        sleeve.at(18)
        self.assertFalse(np.array_equal(curve_edges.seen(child)[1], before), "baked again")
        self.assertEqual([m.type for m in child.modifiers].count("MESH_CACHE"), 1)

    def test_where_the_clip_cannot_be_put_in_place_its_curves_are_not_and_both_are_later(self) -> None:
        """A file that another program has open: the curves of another bake were shown."""
        obj, child = curved()
        self.save()
        for former in (False, True):
            folder = self.folder / "rumple"
            before = {path.name: path.read_bytes() for path in folder.iterdir()} if former else {}
            obj.rumple.paths.seed += 1
            bake = clip_bake.ClipBake(bpy.context, obj)
            while bake.step():
                pass
            with mock.patch.object(clip_file.ClipWriter, "commit", side_effect=ClipFault("in use")):
                with self.assertRaisesRegex(clip_bake.NotInPlace, "in use"):
                    bake.finish()
            there = {path.name: path.read_bytes() for path in folder.iterdir() if not path.name.startswith(".")}
            self.assertTrue(there == before)
            self.assertEqual(modifier.mesh_cache(child) is not None, former)
            about = clip_file.read_manifest(bake.finish())
            self.assertEqual(clip_file.checksum(clip_file.read_manifest(bake.curves.clip)), about.curves)
            self.assertEqual(len(list(folder.iterdir())), 2)

    def test_a_bake_keeps_the_curves_of_its_samples_in_a_file(self) -> None:
        """They stayed in memory up to its end: gigabytes of a long clip."""
        obj, _child = curved()
        self.save()
        for end in ("finish", "cancel"):
            bake = clip_bake.ClipBake(bpy.context, obj)
            while bake.step():
                pass
            bake.curves.waiting.flush()
            waiting = [path for path in (self.folder / "rumple").iterdir() if ".curves.pc2." in path.name]
            self.assertEqual(len(waiting), 1)
            self.assertGreater(waiting[0].stat().st_size, 0)
            getattr(bake, end)()
            self.assertEqual(len(list((self.folder / "rumple").iterdir())), 2)  # the clip and its curves

    def test_a_bake_needs_no_room_in_the_mesh_that_shows_curves(self) -> None:
        """In a window, where handlers make no room, it broke off: play the clip through before you render it."""
        obj, child = curved()
        self.save()
        sleeve.play()
        expected = len(curve_edges.seen(child)[0])
        path_curves._set_capacity(child.data, 16)
        with (mock.patch.object(scheduler, "allowed_now", return_value=False),
              mock.patch.object(path_curves, "_wanted_capacity", return_value=16)):
            self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
        sleeve.at(sleeve.LAST)
        self.assertEqual(len(curve_edges.seen(child)[0]), expected)

    def test_curves_that_are_damaged_or_of_another_bake_are_said(self) -> None:
        obj, _child = curved()
        self.save()
        bpy.ops.object.rumple_bake()
        sleeve.at(18)
        self.assertEqual(obj.rumple.message, "")
        path = clip_status.clip_path(obj).with_suffix(".curves.pc2")
        good, other = path.read_bytes(), clip_status.clip_path(obj).read_bytes()
        torn = good[:32] + b"\x3f" * 1000 + good[1032:]
        for data, words in ((torn, "frame 1 of the baked clip .*curves.pc2 is damaged"), (None, "are not those"),
                            (other, "curves.pc2 are not those of the baked clip"), (good[:99], "are not those")):
            path.unlink() if data is None else path.write_bytes(data)
            sleeve.at(2)
            sleeve.at(1)
            self.assertRegex(obj.rumple.message, f"^Sleeve: .*{words}")
        path.write_bytes(good)
        sleeve.at(2)
        sleeve.at(3)
        self.assertEqual(obj.rumple.message, "")

    def test_rendered_stills_and_animations_show_the_same_curves(self) -> None:
        obj = small_renders.stage("CYCLES")
        bpy.ops.object.rumple_remove()
        bpy.ops.object.rumple_add(method="PATHS")
        bpy.ops.object.rumple_curves_add()
        child = curve_edges.child_of(obj)
        nodes_mod = path_curves.find(child)
        compat.set_modifier_input(nodes_mod, compat.group_sockets(nodes_mod.node_group, "INPUT")["Radius"], 0.006)
        obj.is_holdout = True  # only the curves are seen
        sleeve.play()
        stills = {frame: small_renders.still(frame) for frame in (14, 17, 20)}
        animation = small_renders.clip(1, 20)
        for frame, still in stills.items():
            self.assertGreater((still[..., 3] > 0.5).sum(), 15)
            np.testing.assert_allclose(animation[frame], still, atol=0.02)
        self.assertGreater(np.abs(stills[14] - stills[20]).max(), 0.3)
