# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake reads what is solved: it writes and shows nothing, and leaves garments alone that it does not need."""
from __future__ import annotations

import os
import tempfile
import unittest
from unittest import mock
from typing import Any

import bpy
import numpy as np
from rumple.blender.bake.clip import ClipBake
from rumple.blender.frame import baking, first_pass
from rumple.blender.nodes.output_flags import Flag, is_set
from rumple.blender.objects import modifier, output_mesh, runtimes
from support import sleeve


class BakeReads(unittest.TestCase):

    def setUp(self) -> None:
        self.obj = sleeve.scene()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.obj.rumple.bake_folder, self.obj.rumple.bake_start, self.obj.rumple.bake_end = folder.name, 1, 5

    def bake(self) -> Any:
        """Half-way through."""
        sleeve.make_active(self.obj)
        with sleeve.context():
            running = ClipBake(bpy.context, self.obj)
        for _ in range(3):
            self.assertTrue(running.step())
        return running

    def assert_shown(self, *objects: Any) -> None:
        self.assertTrue(objects)
        for obj in objects:
            self.assertFalse(is_set(modifier.output_object(modifier.find(obj)), Flag.COARSE_ONLY))
            self.assertEqual(len(sleeve.shown(obj)), runtimes.of(obj).evaluator.vertex_count)
            np.testing.assert_allclose(sleeve.shown(obj), sleeve.picture(obj).positions, atol=1e-5)

    def test_no_mesh_is_written_and_none_is_fine(self) -> None:
        other, counts = sleeve.another("Other"), set()
        sleeve.play(1, 3)
        with mock.patch.object(output_mesh, "write_result", side_effect=AssertionError) as write:
            running = self.bake()
            counts |= {len(sleeve.shown(obj)) for obj in (self.obj, other)}
            while running.step():
                counts |= {len(sleeve.shown(obj)) for obj in (self.obj, other)}
        write.assert_not_called()
        self.assertEqual(counts, {len(self.obj.data.vertices)})
        running.finish()
        sleeve.at(7)
        self.assert_shown(other)

    def test_garments_it_does_not_need_are_not_solved_and_those_under_it_are(self) -> None:
        under, beside = sleeve.another("Under", 0.8), sleeve.another("Beside", 1.5)
        self.obj.rumple.body = under
        sleeve.at(1)
        for obj in (self.obj, under, beside):
            runtimes.of(obj).evaluator.frame_cache.clear()
        self.bake().cancel()
        frames = [{frame for frame, _ in runtimes.of(obj).evaluator.frame_cache.frames()} for obj in (under, beside)]
        self.assertLessEqual({1.0, 2.0, 3.0}, frames[0])
        self.assertLessEqual(frames[1], {1.0})  # where the scene stood, and stands again

    def test_what_it_follows_rests_on_what_it_lies_on(self) -> None:
        """B follows A by a modifier, and A is worn over C: that was not solved, and A lay on C's bare mesh."""
        cuff, under = sleeve.cuff(self.obj, "SHRINKWRAP", "Cuff"), sleeve.another("Under", 0.8)
        self.obj.rumple.body = under
        cuff.rumple.bake_folder, cuff.rumple.bake_start, cuff.rumple.bake_end = self.folder, 1, 5
        sleeve.at(1)
        runtimes.of(under).evaluator.frame_cache.clear()
        sleeve.make_active(cuff)
        with sleeve.context():
            running = ClipBake(bpy.context, cuff)
        for _ in range(3):
            running.step()
        running.cancel()
        self.assertLessEqual({1.0, 2.0, 3.0}, {frame for frame, _ in
                                               runtimes.of(under).evaluator.frame_cache.frames()})

    def test_given_up_everything_is_shown_again(self) -> None:
        other = sleeve.another("Other")
        sleeve.play(1, 3)
        self.bake().cancel()
        sleeve.at(4)
        self.assert_shown(self.obj, other)

    def test_a_file_that_is_saved_meanwhile_shows_its_folds(self) -> None:
        """Without the add-on, too: nothing in it says that a bake was under way."""
        running, path = self.bake(), os.path.join(self.folder, "saved.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
        with bpy.data.libraries.load(path) as (there, here):
            here.objects = [name for name in there.objects if name.startswith("Sleeve.wrinkles")]
        self.assertEqual([tuple(obj.location) for obj in here.objects], [(0.0, 0.0, 0.0)])
        while running.step():
            pass
        running.finish()

    def test_another_file_ends_it(self) -> None:
        """A window frees the operator that bakes without a word: garments of the next file would not be solved."""
        self.obj.name = "Of the former file"
        baking.begin(self.obj)
        obj = sleeve.scene()
        self.assertTrue(first_pass.must_be_solved(obj, modifier.find(obj)))
        sleeve.play(1, 3)
        self.assert_shown(obj)

    def test_what_follows_a_garment_sees_its_fine_mesh(self) -> None:
        cuff = sleeve.cuff(self.obj, "SHRINKWRAP", "Cuff")
        cuff.rumple.bake_folder, cuff.rumple.bake_start, cuff.rumple.bake_end = self.folder, 1, 5
        sleeve.make_active(cuff)
        with sleeve.context():
            running = ClipBake(bpy.context, cuff)
        for _ in range(3):
            running.step()
            self.assertEqual(len(sleeve.shown(self.obj)), runtimes.of(self.obj).evaluator.vertex_count)
            self.assertEqual(runtimes.of(self.obj).inputs.frame, bpy.context.scene.frame_current)
        running.cancel()
        self.assertFalse(baking.is_running())


if __name__ == "__main__":
    unittest.main()
