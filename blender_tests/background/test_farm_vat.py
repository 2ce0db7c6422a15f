# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertex animation textures: what another reader finds in the files is the clip, within the error that is stated."""
from __future__ import annotations

import json
import re
import unittest
from pathlib import Path
from unittest import mock

import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.farm import commands, images
from rumple.core.files import clip_file, clip_folder, clip_partial, vat
from rumple.core.files.clip_manifest import ClipFault
from support import farm_case, farm_scene, textures

MOST = 2e-4  # metres


class Layouts(unittest.TestCase):

    def test_no_two_points_or_frames_share_a_texel_and_all_lie_inside(self) -> None:
        for points, frames in ((1, 1), (64, 7), (65, 7), (5000, 33), (300, 1000)):
            layout = vat.Layout.of(points, frames)
            for side in (layout.width, layout.height):
                self.assertEqual(side & (side - 1), 0)
                self.assertLessEqual(side, vat.LARGEST)
            numbers = np.arange(1, frames * points + 1, dtype=np.float32).reshape(frames, points, 1)
            picture = layout.picture(numbers.repeat(3, 2))
            self.assertEqual(np.count_nonzero(picture[..., 0]), points * frames)
            for frame in (0, frames - 1):
                np.testing.assert_array_equal(fetched(picture, layout.uv(), frame)[:, 0], numbers[frame, :, 0])

    def test_the_sides_are_those_of_openvat(self) -> None:
        """Worked out from the rule in the documentation: nearly square, powers of two, blocks of rows."""
        for points, frames, sides in ((49278, 150, (2048, 4096)), (810, 150, (512, 512)), (300, 8, (64, 64))):
            layout = vat.Layout.of(points, frames)
            self.assertEqual((layout.width, layout.height), sides)

    def test_what_fits_into_no_texture_is_refused(self) -> None:
        with self.assertRaisesRegex(ClipFault, "50000 points in 2000 frames need more than a texture of 8192 x 8192"):
            vat.Layout.of(50000, 2000)

    def test_an_object_that_moves_takes_its_motion_along(self) -> None:
        angle = np.deg2rad(90.0)
        turned = np.eye(4)
        turned[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        moved = turned.copy()
        moved[:3, 3] = 1.0, 2.0, 3.0
        one = np.array([[1.0, 0.0, 0.0]], np.float32)
        points, normals = vat.in_place_of(np.eye(4), moved, one, one)
        np.testing.assert_allclose(points, [[1.0, 3.0, 3.0]], atol=1e-6)
        np.testing.assert_allclose(normals, [[0.0, 1.0, 0.0]], atol=1e-6)
        self.assertIs(vat.in_place_of(moved, moved, one, one)[0], one)


def fetched(picture: np.ndarray, uv: np.ndarray, frame: int) -> np.ndarray:
    """As a shader addresses texels. uv: v upwards."""
    height, width = picture.shape[:2]
    u, v = uv.astype(float).T
    return picture[np.floor((1.0 - v + frame / height) * height).astype(int), np.floor(u * width).astype(int)]


class Textures(farm_case.Case):
    """Of the coat, which has a UV map with seams."""

    NAME, FRAMES = farm_scene.OUTER, range(1, 7)

    def export(self, *words: str) -> Path:
        self.assertEqual(self.run_command("bake", "--frames", "1-6"), 0, self.err)
        found = self.data("vat", "--object", self.NAME, *words)["garments"][self.NAME]
        self.assertEqual(found["code"], 0, self.err)
        self.stated = found["error"]
        return Path(found["file"])

    def test_the_error_is_said_in_millimetres_of_the_scene(self) -> None:
        """The object's scale was left out: what came from a program of centimetres was said to be a hundredfold off."""
        bpy.data.objects[self.NAME].scale = (0.5, 4.0, 0.5)
        farm_scene.save(self.blend)
        self.export()
        self.assertEqual(re.findall(r"at most (\S+) mm off", self.out), [f"{4e3 * self.stated:.2g}"])

    def baked(self) -> np.ndarray:
        """(frames, n, 3): of the clip itself."""
        clip = self.clip(self.NAME)
        manifest = clip_file.read_manifest(clip)
        return np.stack([clip_partial.points_in(clip, manifest, sample)[:manifest.vertices].astype(float)
                         for sample in range(manifest.sample_count)])

    @staticmethod
    def decoded(picture: np.ndarray, remap: dict) -> np.ndarray:
        least, most = np.array(remap["Min"]), np.array(remap["Max"])
        return least + picture * (most - least)

    def test_textures_and_mesh_together_are_the_clip(self) -> None:
        folder, baked = self.export("--image", "both"), self.baked()
        self.assertRegex(folder.name, r"^shot-Coat-[0-9a-f]{8}-1-6_vat$")
        self.assertEqual(sorted(file.name for file in folder.iterdir()), [
            "Coat-remap_info.json", "Coat.glb", "Coat_vat.exr", "Coat_vat.png", "Coat_vnrm.exr", "Coat_vnrm.png"])
        about = json.loads((folder / "Coat-remap_info.json").read_text())
        remap = about["os-remap"]
        self.assertEqual((remap["Frames"], about["rumple"]["object"]), (len(baked), "Coat"))
        size = about["rumple"]["width"], about["rumple"]["height"]
        document, mesh = textures.read_glb(folder / "Coat.glb")
        self.assertEqual(len(document["meshes"]), 1)
        uv = mesh["TEXCOORD_1"] * [1.0, -1.0] + [0.0, 1.0]  # v of glTF counts downwards
        first = mesh["POSITION"][:, [0, 2, 1]] * [1.0, -1.0, 1.0]  # y of glTF is up
        self.assertGreater(len(first), baked.shape[1])  # split at the seams of the first UV map
        points = numbers_of(uv, size, len(baked))
        self.assertEqual(set(points), set(range(baked.shape[1])))
        np.testing.assert_allclose(first, baked[0][points], atol=1e-6)
        for name, most in (("png", self.stated + 1e-6), ("exr", 1e-6)):
            picture = read(folder / f"Coat_vat.{name}")
            self.assertEqual(picture.shape[1::-1], size)
            farthest = 0.0
            for frame, positions in enumerate(baked):
                shown = first + self.decoded(fetched(picture, uv, frame), remap)
                farthest = max(farthest, np.abs(shown - positions[points]).max())
            self.assertLess(farthest, most)
            print(f"vat {name}: {1e3 * farthest:.2g} mm off, stated {1e3 * self.stated:.2g} mm")
        self.assertLess(self.stated, MOST)
        self.assertGreater(np.abs(baked - baked[0]).max(), 100.0 * MOST)  # it moves

    def test_the_first_frame_is_the_mesh_itself(self) -> None:
        folder = self.export()
        about = json.loads((folder / "Coat-remap_info.json").read_text())
        layout = vat.Layout.of(self.baked().shape[1], 6)
        offsets = self.decoded(fetched(read(folder / "Coat_vat.png"), layout.uv(), 0), about["os-remap"])
        self.assertLess(np.abs(offsets).max(), about["rumple"]["error"] + 1e-9)

    def test_normals_are_those_that_blender_shows_and_one_on_both_sides_of_a_seam(self) -> None:
        folder = self.export("--image", "both")
        obj = bpy.data.objects[self.NAME]
        layout = vat.Layout.of(self.baked().shape[1], 6)
        for suffix, most in (("png", 2.0 / vat.STEPS), ("exr", 1e-6)):
            picture = read(folder / f"Coat_vnrm.{suffix}")
            for number, frame in enumerate(self.FRAMES):
                bpy.context.scene.frame_set(frame)
                mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
                shown = np.empty(3 * len(mesh.vertices), np.float32)
                mesh.vertices.foreach_get("normal", shown)
                normals = 2.0 * fetched(picture, layout.uv(), number) - 1.0
                self.assertLess(np.abs(normals - shown.reshape(-1, 3)).max(), most)
        _, mesh = textures.read_glb(folder / "Coat.glb")
        points = numbers_of(mesh["TEXCOORD_1"] * [1.0, -1.0] + [0.0, 1.0], (layout.width, layout.height), 6)
        first = picture[layout.texels()]
        normal = mesh["NORMAL"][:, [0, 2, 1]] * [1.0, -1.0, 1.0]
        np.testing.assert_allclose(normal, 2.0 * first[points] - 1.0, atol=2e-3)

    def test_in_place_the_way_is_in_the_file_and_the_sum_is_the_clip(self) -> None:
        folder, baked = self.export("--image", "png", "--in-place"), self.baked()
        about = json.loads((folder / "Coat-remap_info.json").read_text())
        layout, way = vat.Layout.of(baked.shape[1], 6), np.array(about["rumple"]["way"])
        self.assertEqual((way[0].tolist(), way.shape), ([0.0] * 3, (6, 3)))
        picture = read(folder / "Coat_vat.png")
        for frame, positions in enumerate(baked):
            offsets = self.decoded(fetched(picture, layout.uv(), frame), about["os-remap"])
            np.testing.assert_allclose(offsets.mean(0), 0.0, atol=1e-5)  # the middle stays
            self.assertLess(np.abs(baked[0] + offsets + way[frame] - positions).max(), self.stated + 1e-6)
        self.assertGreater(np.abs(way).max(), 0.01)

    def test_the_scene_is_left_as_it_was(self) -> None:
        self.run_command("bake", "--frames", "1-3")
        self.run_command("attach")
        commands.open_file(self.blend, False)
        farm_scene.sleeve.make_active(bpy.data.objects[self.NAME])
        bpy.context.scene.frame_set(2)
        before = [len(getattr(bpy.data, kind)) for kind in ("scenes", "images", "meshes", "objects")]
        self.assertEqual(bpy.ops.object.rumple_vat(), {"FINISHED"})
        self.assertEqual(bpy.ops.object.rumple_publish(), {"FINISHED"})
        self.assertEqual([len(getattr(bpy.data, kind)) for kind in ("scenes", "images", "meshes", "objects")], before)
        self.assertEqual((bpy.context.scene.frame_current, bpy.context.object.name), (2, self.NAME))
        self.assertEqual(sorted(path.name.rsplit("-", 1)[1] for path in (self.folder / "publish").iterdir()),
                         ["3.usda", "3_vat"])


def read(path: Path) -> np.ndarray:
    """(height, width, 3) of 0..1, by readers that are not Blender's."""
    return textures.read_exr(path) if path.suffix == ".exr" else textures.read_png(path) / vat.STEPS


def numbers_of(uv: np.ndarray, size: tuple[int, int], frames: int) -> np.ndarray:
    """The points whose texels these are."""
    column = np.floor(uv[:, 0] * size[0]).astype(int)
    return np.floor((1.0 - uv[:, 1]) * size[1]).astype(int) // frames * size[0] + column


class Refused(farm_case.Case):

    def left(self) -> list[str]:
        folder = self.folder / "publish"
        return sorted(path.name for path in folder.iterdir()) if folder.exists() else []

    def test_without_a_whole_clip_nothing_is_written(self) -> None:
        self.assertEqual(self.run_command("vat"), 1)
        self.assertEqual(self.err.count("there is no whole clip of this file: bake first"), 3)
        self.assertFalse((self.folder / "publish").exists())

    def test_a_file_without_wrinkles_has_nothing_to_do(self) -> None:
        farm_scene.sleeve.empty_file()
        farm_scene.save(self.blend)
        for words in (("vat",), ("publish",), ("poses", "--count", "2")):
            self.assertEqual(self.run_command(*words), commands.NOTHING)
            self.assertIn("has no wrinkled objects that can be baked: there is nothing to do", self.err)
        self.assertFalse((self.folder / "publish").exists())

    def test_a_full_disk_leaves_nothing_and_a_former_export_as_it_was(self) -> None:
        self.run_command("bake", "--frames", "1-2")
        words = "vat", "--object", farm_scene.FREE
        self.assertEqual(self.run_command(*words), 0, self.err)
        (name,) = before = self.left()
        self.assertRegex(name, r"^shot-Scarf____a-[0-9a-f]{8}-1-2_vat$")
        folder = self.folder / "publish" / name
        hashes = self.read_all(folder)
        truncated = mock.patch.object(images, "_holds", return_value=False)  # as on a disk that is full
        full = mock.patch.object(Path, "write_text", side_effect=OSError(28, ""))
        for fault, said in ((truncated, "cannot be written whole"), (full, "is full: make room")):
            with fault:
                self.assertEqual(self.run_command(*words), 1)
            self.assertIn(said, self.err)
            self.assertEqual((self.left(), self.read_all(folder)), (before, hashes))
        self.assertEqual(self.run_command(*words), 0)  # the same bytes again
        self.assertEqual((self.left(), self.read_all(folder)), (before, hashes))

    def test_a_file_that_was_cut_short_is_seen(self) -> None:
        path = self.folder / "cut.png"
        picture = np.ones((64, 64, 3), np.float32)
        picture[5:] = np.random.default_rng(1).integers(0, vat.STEPS, (59, 64, 3)) / np.float32(vat.STEPS)
        images.write(path, picture, "PNG")
        values = np.ones((64, 64, 4), np.float32)
        values[..., :3] = picture[::-1]
        self.assertTrue(images._holds(path, values))
        path.write_bytes(path.read_bytes()[:-2000])
        self.assertFalse(images._holds(path, values))
        path.unlink()
        self.assertFalse(images._holds(path, values))

    def test_a_folder_that_is_a_file(self) -> None:
        self.run_command("bake", "--frames", "1-2")
        (self.folder / "publish").write_text("")
        self.assertEqual(self.run_command("vat"), 1)
        self.assertEqual(self.err.count("is no folder, or leads through a file"), 3)

    def test_leftovers_of_a_process_that_was_killed_are_swept(self) -> None:
        folder = self.folder / "publish"
        gone, other = (folder / f".x_vat.{clip_folder.HOST}.{process}-0.part" for process in (999999999, 1))
        for leftover in (gone, other):
            leftover.mkdir(parents=True)
            (leftover / "file").write_text("")
        clip_folder.make(folder, 0)
        self.assertEqual(self.left(), [other.name])

    def test_smooth_or_not_it_has_the_points_of_the_clip(self) -> None:
        """Faces that are not smooth are shown smooth: a texel for each point has one normal."""
        self.run_command("bake", "--frames", "1-2")
        self.assertEqual(self.run_command("vat", "--object", farm_scene.INNER), 0)
        obj = bpy.data.objects[farm_scene.INNER]
        count = len(compat.positions(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data))
        (name,) = self.left()
        _, mesh = textures.read_glb(self.folder / "publish" / name / "Sleeve.glb")
        self.assertEqual(len(np.unique(mesh["TEXCOORD_1"], axis=0)), count)
