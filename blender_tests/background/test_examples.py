# SPDX-License-Identifier: GPL-3.0-or-later
"""The examples: small files that open as new ones and fold at once."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path
from unittest import mock

import bpy
from rumple.blender.nodes import wrinkle_tree
from rumple.blender.objects import modifier, output_mesh, runtimes
from rumple.blender.ui import examples
from support import sleeve


class Examples(unittest.TestCase):

    def open_made(self) -> bpy.types.Object:
        """A file as scripts/examples makes it: wrinkled, without its fine mesh."""
        obj = sleeve.scene()
        nodes_mod = modifier.find(obj)
        modifier.set_output_object(nodes_mod, None, 0)
        for hidden in [one for one in bpy.data.objects if output_mesh.KEY in one]:
            modifier.delete_hidden(hidden)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        bpy.ops.wm.save_as_mainfile(filepath=str(Path(folder.name) / "A_sleeve.blend"), copy=True)
        with mock.patch.object(examples, "FOLDER", Path(folder.name)):
            self.assertEqual(list(examples.files()), ["A sleeve"])
            self.assertEqual(bpy.ops.wm.rumple_open_example(name="A sleeve"), {"FINISHED"})
        return bpy.data.objects["Sleeve"]

    def test_it_opens_as_a_new_file_and_shows_folds(self) -> None:
        obj = self.open_made()
        self.assertEqual(bpy.data.filepath, "")
        sleeve.play(1, 6)
        self.assertEqual(obj.rumple.message, "")
        self.assertIn(wrinkle_tree.BASE_POSITION, sleeve.evaluated(obj).data.attributes)
        self.assertEqual(len(sleeve.shown(obj)), runtimes.of(obj).evaluator.vertex_count)

    def test_one_that_is_not_there_is_said(self) -> None:
        with mock.patch.object(examples, "FOLDER", Path("/nowhere")):
            with self.assertRaisesRegex(RuntimeError, "no example named \"Cape\": none here"):
                bpy.ops.wm.rumple_open_example(name="Cape")


if __name__ == "__main__":
    unittest.main()
