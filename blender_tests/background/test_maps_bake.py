# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps baked from the object's own wrinkles, and what goes to a game engine."""
from __future__ import annotations

import functools
import json
import math
import os
import tempfile
import time
import unittest
from pathlib import Path
from typing import Callable, Iterator
from unittest import mock

import bpy
import numpy as np
from rumple.blender.maps import bake, bake_apart, export as maps_export
from rumple.blender.objects import made_collections, modifier
from rumple.core.base.wording import UserError
from rumple.core.systems import poses_json
from support import face, maps_renders, sleeve


def texels(image: bpy.types.Image) -> np.ndarray:
    """(height, width, 3), the lowest row first."""
    flat = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(flat)
    return flat.reshape(image.size[1], image.size[0], 4)[:, :, :3]


def everything() -> set[tuple[str, str]]:
    """(kind, name) of all data-blocks but the images, which a bake makes."""
    lists = (getattr(bpy.data, name) for name in dir(bpy.data))
    return {(block.bl_rna.identifier, block.name_full)
            for blocks in lists if isinstance(blocks, bpy.types.bpy_prop_collection)
            for block in blocks if not isinstance(block, bpy.types.Image)}


class Bake(unittest.TestCase):

    def setUp(self) -> None:
        self.obj, self.rig = face.scene()
        face.pose(self.rig, brow_L=-0.012)
        bpy.ops.rumple.pose_add(name="Left")
        face.pose(self.rig, brow_R=-0.012)
        bpy.ops.rumple.pose_add(name="Right")
        face.pose(self.rig, jaw=0.003)
        self.settings = self.obj.rumple_maps
        self.settings.bake_size = 128

    def slopes(self, pose: str) -> tuple[np.ndarray, np.ndarray]:
        """How far each texel leans, 0..1, and the column of its centre: 0 left, 1 right of the face."""
        lean = np.abs(texels(self.settings.poses[pose].image)[:, :, :2] - 0.5).max(2)
        return lean, (np.arange(128) + 0.5) / 128

    def test_wrinkles_come_where_the_pose_compresses_the_skin(self) -> None:
        before = everything()
        self.assertEqual(bpy.ops.rumple.maps_bake(every=True), {"FINISHED"})
        self.assertEqual(everything(), before)
        for pose, centre in (("Left", 0.75), ("Right", 0.25)):     # x of 0.03 and -0.03 on a face of 0.12 m
            lean, place = self.slopes(pose)
            near, far = np.abs(place - centre) < 0.25, np.abs(place - centre) > 0.35
            self.assertGreater(lean[:, near].max(), 0.1, pose)
            self.assertLess((lean[:, far] ** 2).mean(), 0.05 * (lean[:, near] ** 2).mean(), pose)
        image = self.settings.poses["Left"].image
        self.assertTrue(image.packed_file is not None and image.colorspace_settings.is_data)

    def test_the_map_is_the_same_in_any_unit(self) -> None:
        """Blender's baker was given metres for the units of its scene: in centimetres every texel was flat."""
        self.settings.active = 0
        for cage in (0.0, 0.004):
            maps = []
            for unit in (1.0, 1 / 128):  # powers of two: else folds go another way by rounding alone
                self.obj.scale = self.rig.scale = (1 / unit,) * 3
                bpy.context.scene.unit_settings.scale_length = unit
                self.settings.bake_cage = cage / unit
                bpy.context.view_layer.update()
                bpy.ops.rumple.maps_bake()
                maps.append(texels(self.settings.poses["Left"].image))
            self.assertGreater(np.abs(maps[0][:, :, :2] - 0.5).max(), 0.1)
            np.testing.assert_allclose(maps[1], maps[0], atol=0.01)

    def test_a_second_blender_runs_the_scripts_of_a_trusted_file(self) -> None:
        """Drivers that call functions stood still there, so it baked another pose, and said nothing."""
        text = bpy.data.texts.new("rig.py")
        text.from_string("import bpy\nbpy.app.driver_namespace['rumple_lift'] = lambda: -0.012\n")
        text.use_module = True
        jaw = self.rig.pose.bones["jaw"].driver_add("location", 2)
        jaw.driver.expression = "rumple_lift()"
        self.settings.bake_size = 64
        for trusted in (True, False):
            with tempfile.TemporaryDirectory() as folder:
                path = os.path.join(folder, "face.blend")
                bpy.ops.wm.save_as_mainfile(filepath=path)
                bpy.ops.wm.open_mainfile(filepath=path, use_scripts=trusted)
                self.addCleanup(bpy.app.driver_namespace.pop, "rumple_lift", None)
                obj = bpy.data.objects["Face"]
                bpy.context.view_layer.objects.active = obj
                self.assertEqual(bpy.app.autoexec_fail, not trusted)
                jaw = bpy.data.objects["Rig"].pose.bones["jaw"]
                self.assertAlmostEqual(jaw.matrix_basis.translation.z, -0.012 if trusted else 0.0, 5)
                bpy.ops.rumple.maps_bake()
                here = texels(obj.rumple_maps.poses[obj.rumple_maps.active].image)
                apart = bake_apart.ApartBake(bake.MapBake(bpy.context, obj, [obj.rumple_maps.active]))
                try:
                    for _ in apart.steps():
                        time.sleep(0.1)
                finally:
                    apart.close()
                np.testing.assert_array_equal(texels(obj.rumple_maps.poses[obj.rumple_maps.active].image), here)

    def test_the_artists_scene_and_pose_stay(self) -> None:
        basis = {bone.name: bone.matrix_basis.copy() for bone in self.rig.pose.bones}
        scene = bpy.context.scene
        engine, active, frame = scene.render.engine, bpy.context.view_layer.objects.active, scene.frame_current
        bpy.ops.rumple.maps_bake()
        self.assertEqual({bone.name: bone.matrix_basis for bone in self.rig.pose.bones}, basis)
        self.assertEqual((scene.render.engine, bpy.context.view_layer.objects.active, scene.frame_current),
                         (engine, active, frame))
        self.assertEqual([m.type for m in self.obj.modifiers], ["ARMATURE", "NODES"])

    def test_the_channels_of_the_bones_keep_every_bit(self) -> None:
        """Set by a matrix, two turns became none, and scales were not quite 1."""
        for number, bone in enumerate(self.rig.pose.bones):
            bone.rotation_mode = ("QUATERNION", "XYZ", "AXIS_ANGLE")[number % 3]
            bone.rotation_euler, bone.rotation_axis_angle = (13.0, 0.1, -7.0), (9.0, 0.6, 0.0, 0.8)
            bone.rotation_quaternion = (-2.0, 0.1, 0.0, 0.3)

        def channels() -> list[tuple[float, ...]]:
            return [tuple(getattr(bone, name)) for bone in self.rig.pose.bones for name in bake.BONE_CHANNELS]
        before = channels()
        bpy.ops.rumple.maps_bake()
        self.assertEqual(channels(), before)

    def test_without_compression_the_map_is_flat(self) -> None:
        face.pose(self.rig, brow_L=1e-4, brow_R=1e-4, jaw=1e-4)
        bpy.ops.rumple.pose_add(name="Hardly")
        bpy.ops.rumple.maps_bake()
        self.assertLess(self.slopes("Hardly")[0].max(), 0.02)

    def test_sixteen_bits_have_more_than_256_steps(self) -> None:
        self.settings.bake_deep = True
        bpy.ops.rumple.maps_bake()
        image = self.settings.poses[self.settings.active].image
        self.assertTrue(image.is_float)
        self.assertGreater(np.abs(255 * texels(image) - np.rint(255 * texels(image))).max(), 0.1)

    def test_a_wrinkle_mesh_can_be_baked_too(self) -> None:
        self.settings.bake_source, self.obj.rumple.mesh.hem_rings = "MESH", 0
        bpy.ops.rumple.maps_bake(every=True)
        self.assertGreater(self.slopes("Left")[0].max(), 0.05)

    def test_wrinkle_paths_can_be_baked_too(self) -> None:
        self.settings.bake_source = "PATHS"
        bpy.ops.rumple.maps_bake(every=True)
        self.assertGreater(self.slopes("Left")[0].max(), 0.05)

    def test_saved_to_a_folder_the_values_stay(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            for deep in (False, True):
                self.settings.bake_deep, self.settings.bake_folder = deep, ""
                bpy.ops.rumple.maps_bake()
                image = self.settings.poses[self.settings.active].image
                before = texels(image).copy()
                path = maps_export.save_image(image, Path(folder) / "maps", deep)
                self.assertTrue(path.is_file())
                np.testing.assert_allclose(texels(image), before, atol=1 / 65535 if deep else 1 / 255)
                self.assertTrue(image.packed_file is None and image.colorspace_settings.is_data)

    def test_no_two_maps_are_one_file(self) -> None:
        """Of poses whose names differ by a dot or by case alone, and of two blend files: one was written over another.
        """
        with tempfile.TemporaryDirectory() as folder:
            written = []
            for file in ("one", "two"):
                bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, f"{file}.blend"))
                images = [bpy.data.images.new(name, 4, 4) for name in ("Face Joy", "Face.Joy", "Face_Joy", "face joy")]
                written += [maps_export.save_image(image, Path(folder), False) for image in images]
                for image in images:
                    bpy.data.images.remove(image)
            self.assertEqual(len({str(path).casefold() for path in written}), 8)
            self.assertEqual(len(list(Path(folder).glob("*.png"))), 8)

    def test_a_folder_on_another_drive_is_named_as_a_whole(self) -> None:
        """On Windows there is no relative path to it: the bake broke off, and the map was gone with the file."""
        with tempfile.TemporaryDirectory() as folder:
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "face.blend"))
            self.settings.bake_folder = os.path.join(folder, "maps")
            with mock.patch.object(bpy.path, "relpath", side_effect=ValueError):
                self.assertEqual(bpy.ops.rumple.maps_bake(every=True), {"FINISHED"})
            for pose in self.settings.poses:
                self.assertEqual(Path(pose.image.filepath).parent, Path(folder, "maps"))
                self.assertTrue(Path(pose.image.filepath).is_file() and pose.image.has_data)
            bpy.ops.rumple.maps_bake()
            self.assertTrue(self.settings.poses[self.settings.active].image.filepath.startswith("//maps"))

    def test_in_a_window_it_ends_whatever_goes_wrong(self) -> None:
        """Its timer, its words in the status bar and the copy of the file stayed."""
        for error, words in ((KeyError("a"), "Face: unexpected KeyError in test_maps_bake.py"), (UserError("b"), "b")):
            def steps(error: Exception = error) -> Iterator[str]:
                yield "begun"
                raise error
            cls, context, event = bake.RUMPLE_OT_maps_bake, mock.Mock(), mock.Mock(type="TIMER")
            running = mock.Mock(done=0, count=3)
            running.plan.name = "Face"
            operator = mock.Mock(_steps=steps(), _running=running)
            operator._stop = functools.partial(cls._stop, operator)
            operator.end_modal = functools.partial(cls.end_modal, operator)
            self.assertEqual(cls.modal(operator, context, event), {"PASS_THROUGH"})
            self.assertFalse(running.close.called)
            with mock.patch.object(bpy.types.WorkSpace, "status_text_set") as status:
                self.assertEqual(cls.modal(operator, context, event), {"CANCELLED"})
            self.assertEqual(status.call_args_list, [mock.call(None)] * len(bpy.data.workspaces))
            running.close.assert_called_once_with()
            context.window_manager.event_timer_remove.assert_called_once_with(operator._timer)
            self.assertTrue(operator.report.call_args.args[1].startswith(words), operator.report.call_args)

    def test_whatever_goes_wrong_nothing_stays(self) -> None:
        """Copies of the face stayed in the artist's scene, and the map that nothing was baked to."""
        before, images, wrong = everything(), len(bpy.data.images), mock.Mock(side_effect=KeyError)
        frozen, placed = bake.MapBake._frozen, modifier.place_behind_deforming
        faults = ((modifier, "place_behind_deforming", [placed, wrong]),
                  (bake.MapBake, "_frozen", [frozen, wrong]), (bake, "_flatten_strays", [wrong]))
        for place, name, answers in faults:
            with self.subTest(name):
                running, left = bake.MapBake(bpy.context, self.obj, [0]), iter(answers)

                def answer(*given: object, left: Iterator[Callable] = left) -> object:
                    return next(left)(*given)
                with mock.patch.object(place, name, answer), self.assertRaises(KeyError):
                    list(running.steps())
                running.close()
                self.assertEqual((everything(), len(bpy.data.images)), (before, images))

    def test_without_uv_map_it_is_refused(self) -> None:
        self.obj.data.uv_layers.remove(self.obj.data.uv_layers[0])
        with self.assertRaisesRegex(RuntimeError, "Face: it has no UV map"):
            bpy.ops.rumple.maps_bake()
        self.assertIsNone(self.settings.poses[0].image)

    def test_what_the_first_click_refuses_is_said_of_the_object(self) -> None:
        """It was an exception that nobody caught, about a copy that the artist has never seen."""
        self.obj.data.uv_layers[0].data[0].uv = (math.nan, 0.0)
        with self.assertRaises(RuntimeError) as raised:
            bpy.ops.rumple.maps_bake()
        self.assertEqual(str(raised.exception).strip(),
                         "Error: Face: the UV map has no valid place at corner 0: unwrap the mesh there again")
        self.assertIsNone(self.settings.poses[0].image)


class Worn(unittest.TestCase):
    """A garment: its copy is worn over a body and over another garment, too."""

    def check_nothing_else_changes(self, outer: bpy.types.Object) -> None:
        outer.rumple_maps.bake_size = 32
        scene = bpy.context.scene
        scene.render.use_lock_interface = False
        before = everything()
        self.assertEqual(bpy.ops.rumple.maps_bake(), {"FINISHED"})
        self.assertEqual(everything(), before)
        self.assertFalse(scene.render.use_lock_interface)
        self.assertEqual(bpy.data.objects["Inner"].rumple.message, "")

    def outer(self) -> bpy.types.Object:
        """The sleeve over Human and over a wrinkled sleeve, with a pose."""
        obj = sleeve.to_be_cloth()
        sleeve.another("Inner", 0.9)
        sleeve.make_active(obj)
        bpy.ops.rumple.maps_add()
        bpy.context.scene.frame_set(sleeve.LAST)
        bpy.ops.rumple.pose_add(name="Bent")
        return obj

    def test_no_collection_stays_and_the_scene_is_not_changed(self) -> None:
        """The first click on the copy makes a collection of what it is worn over, and sets the scene's lock."""
        made = []
        make = made_collections.make
        with mock.patch.object(made_collections, "make", lambda *given: made.append(make(*given)) or made[-1]):
            self.check_nothing_else_changes(self.outer())
        self.assertEqual(len(made), 1, "not a case of it")

    def test_a_collection_of_the_garment_itself_stays(self) -> None:
        obj = self.outer()
        sleeve.click(obj)
        worn_over = obj.rumple.body_collection
        self.check_nothing_else_changes(obj)
        self.assertEqual(obj.rumple.body_collection, worn_over)
        self.assertEqual([member.name for member in worn_over.objects], ["Inner"])


class Export(face.TwoPoses, unittest.TestCase):

    def test_json_images_and_influences(self) -> None:
        self.settings.poses[0].image = bpy.data.images.new("Lines", 8, 8, is_data=True)
        self.obj.material_slots[0].material = maps_renders.material("Pores", bpy.data.images.new("Pores", 8, 8))
        bpy.ops.rumple.maps_show()
        for frame, height in ((1, 0.0), (5, 0.01)):
            face.pose(self.rig, brow_L=height)
            self.rig.pose.bones["brow.L"].keyframe_insert("location", frame=frame)
        bpy.context.scene.frame_end = 5
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "face.json")
            self.assertEqual(bpy.ops.rumple.maps_export(filepath=path, frames=True), {"FINISHED"})
            self.assertEqual(sorted(os.listdir(folder)), ["face.frames.json", "face.json", "face_Surprise.png",
                                                          "face_neutral.png"])
            with open(path, encoding="utf-8") as file:
                rig = poses_json.from_json(file.read())
            with open(os.path.join(folder, "face.frames.json"), encoding="utf-8") as file:
                clip = json.load(file)
        self.assertEqual([(pose.name, pose.map) for pose in rig.poses],
                         [("Surprise", "face_Surprise.png"), ("Anger", "")])
        self.assertEqual(rig.neutral_map, "face_neutral.png")
        bone = clip["bones"].index("brow.L")
        self.assertEqual([row[bone][0] for row in clip["influence"]][::4], [0.0, 1.0])
        self.assertEqual((len(clip["influence"]), clip["fps"], clip["poses"]), (5, 24.0, ["Surprise", "Anger"]))
        self.assertEqual(bpy.context.scene.frame_current, 1)

    def test_a_copy_with_morph_weights_reaches_gltf(self) -> None:
        for frame, height in ((1, 0.0), (5, 0.01)):
            face.pose(self.rig, brow_L=height, brow_R=height)
            for bone in face.BROWS:
                self.rig.pose.bones[bone].keyframe_insert("location", frame=frame)
        bpy.context.scene.frame_end = 5
        self.assertEqual(bpy.ops.rumple.maps_weights(), {"FINISHED"})
        copy = bpy.data.objects["Face weights"]
        keys = copy.data.shape_keys
        bpy.context.scene.frame_set(5)
        self.assertEqual([key.name for key in keys.key_blocks], ["Basis", "rumple_pose_Surprise", "rumple_pose_Anger"])
        self.assertEqual([keys.key_blocks[n].value for n in (1, 2)], [1.0, 0.0])
        bpy.data.objects.remove(self.obj)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "face.gltf")
            bpy.ops.export_scene.gltf(filepath=path, export_format="GLTF_SEPARATE", export_morph_normal=False)
            with open(path, encoding="utf-8") as file:
                exported = json.load(file)
        paths = {channel["target"]["path"] for animation in exported["animations"] for channel in animation["channels"]}
        self.assertIn("weights", paths)
        self.assertEqual(exported["meshes"][0]["extras"]["targetNames"], ["rumple_pose_Surprise", "rumple_pose_Anger"])

    def test_where_nothing_can_be_written_it_is_said(self) -> None:
        with self.assertRaisesRegex(RuntimeError, "not_there"):
            bpy.ops.rumple.maps_export(filepath="/not_there/face.json")

    def test_a_map_of_tiles_is_refused_by_name(self) -> None:
        """Blender saves such an image as several files, and raised an exception that nobody caught."""
        tiles = bpy.data.images.new("Tiles", 8, 8, tiled=True)
        with tempfile.TemporaryDirectory() as folder:
            self.settings.poses[1].image = tiles
            with self.assertRaisesRegex(RuntimeError, "Face: the map Tiles has tiles") as raised:
                bpy.ops.rumple.maps_export(filepath=os.path.join(folder, "face.json"))
            self.assertNotIn("Traceback", str(raised.exception))
            self.settings.poses[1].image = None
            self.obj.material_slots[0].material = maps_renders.material("Pores", tiles)
            bpy.ops.rumple.maps_show()
            with self.assertRaisesRegex(RuntimeError, "Face: the map Tiles has tiles"):
                bpy.ops.rumple.maps_export(filepath=os.path.join(folder, "face.json"))
            self.assertEqual(os.listdir(folder), [])
            bpy.ops.rumple.maps_export(filepath=os.path.join(folder, "face.json"), images=False)
            self.assertEqual(os.listdir(folder), ["face.json"])

    def test_a_name_with_a_dot_keeps_all_of_it(self) -> None:
        """face.v2 was written as face.json, over that of the first version."""
        with tempfile.TemporaryDirectory() as folder:
            for name in ("face.v2", "face.v3.json"):
                bpy.ops.rumple.maps_export(filepath=os.path.join(folder, name), frames=True)
            self.assertEqual(sorted(os.listdir(folder)), ["face.v2.frames.json", "face.v2.json", "face.v3.frames.json",
                                                          "face.v3.json"])

    def test_two_maps_never_share_a_file(self) -> None:
        """Many disks do not tell "Smile" from "smile", and no file name has the dot of a pose's: one was written over
        the other."""
        for number in range(2):
            self.settings.poses[number].image = bpy.data.images.new(f"Lines {number}", 8, 8, is_data=True)
        for first, second in (("Surprise", "surprise"), ("A.B", "A B"), ("Anger", "Neutral")):
            self.settings.poses[0].name, self.settings.poses[1].name = first, second
            if second == "Neutral":
                self.obj.material_slots[0].material = maps_renders.material("Pores", bpy.data.images.new("Pores", 8, 8))
                bpy.ops.rumple.maps_show()
                first = "Pores"
            with tempfile.TemporaryDirectory() as folder:
                with self.assertRaisesRegex(RuntimeError, f"the maps of {first} and {second} would be one file"):
                    bpy.ops.rumple.maps_export(filepath=os.path.join(folder, "face.json"))
                self.assertEqual(os.listdir(folder), [])
