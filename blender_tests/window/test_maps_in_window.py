# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Maps with a window: EEVEE, panels, undo, the modal bake."""
from __future__ import annotations

from pathlib import Path
from typing import ClassVar, Iterator
from unittest import mock

import bpy
import numpy as np
from mathutils import Euler
from rumple.blender.maps import bake, modifier as maps_modifier
from support import face, keyed_face, maps_renders, sleeve
from support.window_case import WindowCase


class RUMPLE_OT_test_hears(bpy.types.Operator):
    """Notes the key that it was run by"""

    bl_idname, bl_label = "rumple.test_hears", "Hears"
    heard: ClassVar[list[str]] = []

    def invoke(self, _context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self.heard.append(event.type)
        return {"FINISHED"}


def biggest_area() -> bpy.types.Area:
    return max(bpy.context.window_manager.windows[0].screen.areas, key=lambda a: a.width * a.height)


class KeysInWindow(WindowCase):

    def test_panels_sliders_sculpting_and_undo_of_shape_keys(self) -> Iterator[float]:
        obj = keyed_face.scene()
        settings = keyed_face.two_poses(obj)
        area = biggest_area()
        area.type = "PROPERTIES"
        yield
        area.spaces.active.context = "MODIFIER"
        keyed_face.set_keys(obj, brow_L=1.0, jaw=0.25)
        yield 0.5
        self.screenshot("maps_keys_panel")
        self.assertAlmostEqual(settings.poses["Surprise"].present, 0.5, 4)
        keyed_face.set_keys(obj, frown=1.0)
        block = obj.data.shape_keys.key_blocks["frown"]
        block.data.foreach_set("co", np.array([v.co for v in obj.data.vertices], np.float32).ravel())
        block.data[0].co.z += 0.01
        obj.data.update_tag()
        yield from self.until(lambda: face.mask(obj, "Anger")[1:].max() == 0.0)
        self.assertEqual(face.mask(obj, "Anger")[0], 1.0)
        area.type = "VIEW_3D"
        yield 0.2
        with self.area("VIEW_3D"):
            bpy.ops.ed.undo_push(message="two poses")
            sleeve.make_active(obj)
            bpy.ops.rumple.pose_remove()
            bpy.ops.ed.undo_push(message="one pose")
            bpy.ops.ed.undo()
        yield 0.5
        obj = bpy.data.objects["Face"]
        keyed_face.set_keys(obj, brow_R=0.5)
        np.testing.assert_allclose(face.mask(obj, "Surprise"), 0.5 * keyed_face.weights("brow.R"), atol=1e-4)
        self.assertEqual(obj.rumple_maps.message, "")


class MapsInEevee(WindowCase):

    def test_eevee_shows_the_native_blend(self) -> None:
        maps_renders.check(self, "EEVEE")


class MapsInWindow(WindowCase):

    def make(self) -> None:
        self.obj, self.rig = face.scene()
        self.settings = face.two_poses(self.obj, self.rig)
        face.pose(self.rig, brow_L=0.0075, brow_R=0.01)
        with sleeve.context():
            bpy.ops.rumple.maps_show()

    def test_panels_draw_in_the_modifier_tab(self) -> Iterator[float]:
        self.make()
        area = biggest_area()
        area.type = "PROPERTIES"
        yield
        area.spaces.active.context = "MODIFIER"
        yield 0.5
        self.screenshot("maps_panel")
        self.obj.vertex_groups.remove(self.obj.vertex_groups["jaw"])
        self.rig.data.bones["head"].name = "skull"
        self.obj.rumple_maps.bones[0].tracked = "HEAD"
        yield from self.until(lambda: "no bone" in self.settings.message)
        self.assertIn("Rig has no bone", self.settings.message)
        yield 0.2
        self.screenshot("maps_panel_refusal")

    def test_the_sidebar_is_there_while_posing(self) -> Iterator[float]:
        self.make()
        area = biggest_area()
        area.type = "VIEW_3D"
        yield 0.2
        area.spaces.active.show_region_ui = True
        with sleeve.context():
            sleeve.make_active(self.rig)
        with self.area("VIEW_3D"):
            bpy.ops.object.mode_set(mode="POSE")
        yield 0.3
        region = next(region for region in area.regions if region.type == "UI")
        if hasattr(region, "active_panel_category"):    # 4.2 on; it is read-only before the first redraw
            region.active_panel_category = "Rumple"
        yield 0.5
        self.screenshot("maps_sidebar")
        with self.area("VIEW_3D"):
            bpy.ops.rumple.pose_go()
            bpy.ops.object.mode_set(mode="OBJECT")
        self.assertEqual(self.settings.poses[1].present, 1.0)

    def test_influences_show_as_colours(self) -> Iterator[float]:
        self.make()
        face.pose(self.rig, brow_L=0.01)
        area = biggest_area()
        area.type = "VIEW_3D"
        yield 0.2
        region = area.spaces.active.region_3d
        region.view_perspective, region.view_rotation = "ORTHO", Euler((np.pi / 2, 0.0, 0.0)).to_quaternion()
        region.view_location, region.view_distance = (0.0, 0.0, 0.0), 0.3
        area.spaces.active.overlay.show_overlays = True
        counts = []
        for shown in (False, True):
            self.settings.show_influences = shown
            area.tag_redraw()
            yield 0.5
            pixels = self.pixels()[:, :area.width].astype(int)
            counts.append(int((pixels[:, :, 0] - pixels[:, :, 1:].max(2) > 60).sum()))
        self.screenshot("maps_influences")
        self.assertGreater(counts[1], counts[0] + 500)

    def test_undo_and_redo(self) -> Iterator[float]:
        self.make()
        with self.area("VIEW_3D"):
            bpy.ops.ed.undo_push(message="two poses")
            sleeve.make_active(self.obj)
            bpy.ops.rumple.pose_remove()
            bpy.ops.ed.undo_push(message="one pose")
            bpy.ops.ed.undo()
        yield 0.5
        obj, rig = bpy.data.objects["Face"], bpy.data.objects["Rig"]
        self.assertEqual([pose.name for pose in obj.rumple_maps.poses], ["Surprise", "Anger"])
        face.pose(rig, brow_L=-0.008, brow_R=-0.008, jaw=0.005)
        yield from self.until(lambda: "Anger" in maps_modifier.find(obj).node_group[maps_modifier.KEY])
        self.assertGreater(face.mask(obj, "Anger").max(), 0.9)
        with self.area("VIEW_3D"):
            bpy.ops.ed.redo()
        yield 0.5
        self.assertEqual([pose.name for pose in bpy.data.objects["Face"].rumple_maps.poses], ["Surprise"])

    def test_until_a_new_list_of_poses_is_built_the_former_masks_stay(self) -> Iterator[float]:
        """The strengths of the new list were written over the former poses: NumPy refused their number, and with one
        pose left its strength was that of both."""
        self.make()
        tree = maps_modifier.find(self.obj).node_group
        yield from self.until(lambda: "Surprise" in tree[maps_modifier.KEY])
        self.settings.poses["Anger"].strength, self.settings.poses["Surprise"].strength = 0.5, 0.25
        face.pose(self.rig, brow_L=0.01, jaw=0.01)
        for change, kept in ((lambda: bpy.ops.rumple.pose_add(name="Open"), ["Surprise", "Anger", "Open"]),
                             (bpy.ops.rumple.pose_remove, ["Surprise", "Anger"]),
                             (lambda: bpy.ops.rumple.pose_move(direction="UP"), ["Anger", "Surprise"]),
                             (lambda: self.settings.poses.remove(0), ["Surprise"])):  # as scripts do
            with sleeve.context():
                bpy.context.view_layer.update()
                before = {pose.name: face.mask(self.obj, pose.name) for pose in self.settings.poses}
                self.assertGreater(before["Surprise"].max(), 0.2)
                change()
                bpy.context.view_layer.update()
                self.assertEqual([pose.name for pose in self.settings.poses], kept)
                for name, mask in before.items():
                    np.testing.assert_array_equal(face.mask(self.obj, name), mask, err_msg=name)
                self.assertEqual(self.settings.message, "")
            yield from self.until(lambda: repr(tuple(kept)) in tree[maps_modifier.KEY])
            self.assertEqual(self.settings.message, "")
            self.assertAlmostEqual(face.mask(self.obj, "Surprise").max(), before["Surprise"].max(), 6)

    def texels(self) -> list[np.ndarray]:
        """Of the maps of all poses."""
        return [np.array(pose.image.pixels[:], np.float32) for pose in self.settings.poses]

    def test_the_bake_runs_modal_and_can_be_cancelled(self) -> Iterator[float]:
        """In a second Blender, whose maps are those that a script gets in this one."""
        self.make()
        self.settings.bake_size = 64
        window = bpy.context.window_manager.windows[0]
        with self.area("VIEW_3D"):
            bpy.ops.rumple.maps_bake(every=True)
        by_script = self.texels()
        for pose in self.settings.poses:
            pose.image = None
        before = bpy.context.scene.frame_current
        with self.area("VIEW_3D"), mock.patch.object(bake.MapBake, "steps", side_effect=AssertionError):
            self.assertEqual(bpy.ops.rumple.maps_bake("INVOKE_DEFAULT", every=True), {"RUNNING_MODAL"})
        yield from self.until(lambda: all(pose.image for pose in self.settings.poses), 90.0)
        yield 0.3
        former = [pose.image for pose in self.settings.poses]
        self.assertNotIn(None, former)
        self.assertGreater(by_script[0].std(), 0.0)
        for ours, theirs in zip(self.texels(), by_script):
            np.testing.assert_array_equal(ours, theirs)
        self.assertEqual(bpy.context.scene.frame_current, before)
        objects = sorted(obj.name for obj in bpy.data.objects)
        with self.area("VIEW_3D"):
            bpy.ops.rumple.maps_bake("INVOKE_DEFAULT", every=True)
        yield 0.06
        window.event_simulate("ESC", "PRESS", x=400, y=400)
        window.event_simulate("ESC", "RELEASE", x=400, y=400)
        yield 1.0
        self.assertEqual(list(Path(bpy.app.tempdir).glob("rumple_maps_*")), [])
        self.assertIs(self.settings.poses[1].image, former[1])
        self.assertEqual(sorted(obj.name for obj in bpy.data.objects), objects)
        self.assertEqual(len(list(maps_modifier.mapped_objects())), 1)

    def begin_bake(self) -> Iterator[float]:
        """Until the second Blender runs: `yield from`."""
        self.settings.bake_size = 64
        with self.area("VIEW_3D"):
            self.assertEqual(bpy.ops.rumple.maps_bake("INVOKE_DEFAULT", every=True), {"RUNNING_MODAL"})
        yield from self.until(self.bakes)
        self.assertEqual(len(self.bakes()), 1)

    @staticmethod
    def bakes() -> list[Path]:
        return list(Path(bpy.app.tempdir).glob("rumple_maps_*/log"))

    def test_keys_and_mouse_reach_the_window_while_a_second_blender_bakes(self) -> Iterator[float]:
        """It swallowed all of them, until the bake was over."""
        self.make()
        bpy.utils.register_class(RUMPLE_OT_test_hears)
        self.addCleanup(bpy.utils.unregister_class, RUMPLE_OT_test_hears)
        yield from self.begin_bake()
        heard: list[str] = []
        with mock.patch.object(RUMPLE_OT_test_hears, "heard", heard):
            yield from self.press_for("rumple.test_hears", lambda: None)
        self.assertEqual(heard, ["F19"])
        window, area = bpy.context.window_manager.windows[0], biggest_area()
        x, y = area.x + area.width // 2, area.y + area.height // 2
        distance = area.spaces.active.region_3d.view_distance
        window.event_simulate("MOUSEMOVE", "NOTHING", x=x, y=y)
        window.event_simulate("WHEELUPMOUSE", "PRESS", x=x, y=y)
        yield from self.until(lambda: area.spaces.active.region_3d.view_distance < distance, 5.0)
        self.assertLess(area.spaces.active.region_3d.view_distance, distance)
        self.assertEqual(len(self.bakes()), 1, "not while it bakes")
        window.event_simulate("ESC", "PRESS", x=x, y=y)
        window.event_simulate("ESC", "RELEASE", x=x, y=y)
        yield from self.until(lambda: not self.bakes(), 5.0)
        self.assertEqual(self.bakes(), [])
        self.assertEqual([pose.image for pose in self.settings.poses], [None, None])

    def test_the_artist_goes_on_and_the_maps_find_their_poses(self) -> Iterator[float]:
        """With other work, undo, and a click on the button again."""
        self.make()
        with self.area("VIEW_3D"):
            bpy.ops.ed.undo_push(message="two poses")
        yield from self.begin_bake()
        with self.area("VIEW_3D"):
            self.assertEqual(bpy.ops.rumple.maps_bake("INVOKE_DEFAULT"), {"CANCELLED"})
            bpy.context.scene.frame_end = 7
            bpy.ops.ed.undo_push(message="a frame range")
            bpy.ops.ed.undo()
        yield
        settings = bpy.data.objects["Face"].rumple_maps
        settings.bake_size = 32
        settings.poses.move(0, 1)
        self.assertEqual((len(self.bakes()), [pose.image for pose in settings.poses]), (1, [None, None]))
        yield from self.until(lambda: not self.bakes(), 90.0)
        self.assertEqual([pose.image and (pose.image.name, *pose.image.size) for pose in settings.poses],
                         [("Face Anger", 64, 64), ("Face Surprise", 64, 64)])
        yield 0.3

    def test_another_file_ends_the_bake(self) -> Iterator[float]:
        self.make()
        yield from self.begin_bake()
        sleeve.empty_file()
        yield 0.5
        self.assertEqual((self.bakes(), len(bpy.data.images)), ([], 0))
        self.make()
        yield from self.begin_bake()  # none is under way any more
        sleeve.empty_file()
        yield 0.2

    def test_a_bake_whose_window_is_closed_ends(self) -> Iterator[float]:
        """The second Blender went on, and its folder stayed."""
        self.make()
        with sleeve.context():
            bpy.ops.wm.window_new()
        yield 0.5
        second = bpy.context.window_manager.windows[-1]
        with sleeve.context(window=second, area=second.screen.areas[0]):
            bpy.ops.rumple.maps_bake("INVOKE_DEFAULT", every=True)
        folders = Path(bpy.app.tempdir)
        yield from self.until(lambda: list(folders.glob("rumple_maps_*/log")))
        self.assertEqual(len(list(folders.glob("rumple_maps_*/log"))), 1)
        with sleeve.context(window=second):
            bpy.ops.wm.window_close()
        yield 0.5
        self.assertEqual(list(folders.glob("rumple_maps_*")), [])
