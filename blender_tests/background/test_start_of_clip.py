# SPDX-License-Identifier: GPL-3.0-or-later
"""Which frame needs none before it: the first of the clip, wherever the scene's Start is moved to."""
from __future__ import annotations

import contextlib
import io
import os
import tempfile
import unittest
from pathlib import Path

import bpy
import numpy as np
from rumple.blender.frame import clip_status
from rumple.blender.objects import modifier, runtimes, stack_notes
from rumple.core.files import clip_file
from support import sleeve

JUMPED = "reached by a jump"


class FirstFrame(unittest.TestCase):
    """The scene's Start was taken for it, which an artist moves to render a part again, and a farm for its chunks."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = os.path.join(folder.name, "shot.blend")
        self.obj = sleeve.scene(wrinkles=False)
        mesh = self.obj.rumple.mesh
        mesh.density, mesh.level, mesh.display_steps, mesh.base_cloth = "LEVEL", 1, 0, "SWING"
        bpy.ops.object.rumple_add(method="MESH")
        sleeve.bend_until(8)
        bpy.ops.wm.save_as_mainfile(filepath=self.path)

    def opened(self, start: int) -> None:
        bpy.ops.wm.open_mainfile(filepath=self.path)
        self.obj = bpy.data.objects["Sleeve"]
        sleeve.make_active(self.obj)
        bpy.context.scene.frame_start = start

    def baked(self, start: int, first: int) -> np.ndarray:
        """The samples of a clip from `first` to 12."""
        self.opened(start)
        self.obj.rumple.bake_start, self.obj.rumple.bake_end = first, 12
        bpy.ops.object.rumple_bake()
        path = clip_status.clip_path(self.obj)
        about = clip_file.read_manifest(path)
        points = np.frombuffer(path.read_bytes(), np.float32, 3 * about.points * about.sample_count, offset=32)
        return points.reshape(about.sample_count, -1)

    def test_a_part_that_is_rendered_again_shows_what_was_played(self) -> None:
        sleeve.play(1, 10)
        sleeve.at(8)
        played = sleeve.shown(self.obj)
        bpy.context.scene.frame_start = 8
        sleeve.at(9)
        sleeve.at(8)
        np.testing.assert_array_equal(sleeve.shown(self.obj), played)
        self.assertTrue(sleeve.picture(self.obj).replayed)
        self.assertEqual(runtimes.of(self.obj).unplayed, "")

    def test_a_chunk_of_a_farm_is_a_jump_and_says_so(self) -> None:
        self.opened(start=8)  # as blender -s 8 does
        sleeve.at(8)
        self.assertIn("play from frame 1", runtimes.of(self.obj).unplayed)
        self.assertIn(JUMPED, runtimes.of(self.obj).unplayed)
        sleeve.at(9)
        self.assertEqual(runtimes.of(self.obj).unplayed, "", "it was reached from frame 8, and swings")

    def test_a_render_that_goes_on_behind_pictures_says_that_it_jumps(self) -> None:
        """Its pictures did not go on from those that were there."""
        self.obj.rumple.mesh.base_cloth = "HANG"
        scene, folder = bpy.context.scene, tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        scene.render.filepath, scene.render.image_settings.file_format = f"{folder.name}/f", "PNG"
        for frame in range(1, 4):
            Path(scene.render.frame_path(frame=frame)).touch()
        sleeve.at(1)
        self.assertEqual(stack_notes.resumed(self.obj), [])
        scene.render.use_overwrite = False
        note = "Sleeve: Overwrite is off and pictures exist, so a render goes on in frame 4 as after a jump: play " \
               "all frames first, switch it on, or bake"
        self.assertEqual(stack_notes.resumed(self.obj), [note])
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            clip_status.check_before_render()
        self.assertIn(note, printed.getvalue())
        sleeve.play(1, 3)
        self.assertEqual(stack_notes.resumed(self.obj), [])

    def test_the_first_frame_is_no_jump(self) -> None:
        for start, first in ((1, 1), (4, 6), (6, 4)):
            self.opened(start)
            self.obj.rumple.bake_start = first
            sleeve.at(min(start, first))
            self.assertEqual(runtimes.of(self.obj).unplayed, "")
            sleeve.at(min(start, first) + 2)
            self.assertIn(JUMPED, runtimes.of(self.obj).unplayed)

    def test_frames_before_it_say_that_they_hang(self) -> None:
        """They hang, each by itself, and nothing said so. The shutter of the first frame opens half a frame before."""
        self.opened(start=1)
        for frame, subframe, hangs in ((0, 0.0, True), (-3, 0.0, True), (0, 0.5, False), (1, 0.0, False)):
            sleeve.at(frame, subframe)
            self.assertEqual(runtimes.of(self.obj).unplayed, f"Sleeve: frame {frame} is before frame 1, with which the "
                             "clip begins, so its cloth hangs and does not swing: set Start of the scene to an earlier "
                             "frame" if hangs else "", (frame, subframe))
        bpy.context.scene.frame_start = -3
        sleeve.play(-3, 0)
        self.assertEqual(runtimes.of(self.obj).unplayed, "")
        self.obj.rumple.mesh.base_cloth = "HANG"
        bpy.context.scene.frame_start = 1
        sleeve.at(-4)
        self.assertEqual(runtimes.of(self.obj).unplayed, "")

    def test_a_bake_goes_on_from_its_frames_before_start(self) -> None:
        """Each of them was solved alone, and the cloth came to Start without having moved."""
        expected = self.baked(start=1, first=1)
        np.testing.assert_array_equal(self.baked(start=10, first=1), expected)
        self.assertGreater(np.abs(self.baked(start=4, first=4)[0] - expected[3]).max(), 1e-4)  # they differ at all

    def test_a_bake_in_another_scene_is_not_wrong(self) -> None:
        """It was compared with what the first scene by name would make of the clip."""
        self.opened(start=1)
        there = bpy.data.scenes.new("Zweite")
        for each in (self.obj, bpy.data.objects["Arm"]):
            there.collection.objects.link(each)
        there.frame_start, there.frame_end, there.unit_settings.scale_length = -2, 12, 0.5
        self.obj.rumple.bake_end = 12
        with bpy.context.temp_override(scene=there, view_layer=there.view_layers[0], object=self.obj,
                                       active_object=self.obj):
            bpy.ops.object.rumple_bake()
        output = modifier.output_object(modifier.find(self.obj))
        self.assertEqual(clip_status.check(self.obj, output), "")
        self.obj.rumple.mesh.radius = 3.0
        self.assertIn("bake again", clip_status.check(self.obj, output))

    def test_another_start_does_not_make_a_bake_wrong(self) -> None:
        self.baked(start=1, first=1)
        output = modifier.output_object(modifier.find(self.obj))
        self.assertEqual(clip_status.check(self.obj, output), "")
        bpy.context.scene.frame_start = 8
        self.assertEqual(clip_status.check(self.obj, output), "")
        bpy.context.scene.frame_start = 0  # played from there, it would be another clip
        self.assertIn("bake again", clip_status.check(self.obj, output))


if __name__ == "__main__":
    unittest.main()
