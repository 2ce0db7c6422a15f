# SPDX-License-Identifier: GPL-3.0-or-later
"""The examples: small files that open as new ones and fold at once."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path
from unittest import mock

import bpy
from mathutils import Vector
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

    def test_viewports_look_at_the_meshes_from_the_side_of_the_camera(self) -> None:
        """They are those of the file before: a figure was 40 pixels high in them."""
        obj = sleeve.scene(wrinkles=False)
        camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        bpy.context.scene.collection.objects.link(camera)
        bpy.context.scene.camera, camera.rotation_euler = camera, (1.2, 0.0, 0.3)
        obj.modifiers.clear()  # the armature stays where it is
        obj.location = (3.0, 0.0, 0.0)
        bpy.context.view_layer.update()
        views = [area.spaces.active.region_3d for window in bpy.context.window_manager.windows
                 for area in window.screen.areas if area.type == "VIEW_3D"]
        self.assertTrue(views)
        for view in views:
            view.view_perspective, view.view_location, view.view_distance = "CAMERA", (9.0, 9.0, 9.0), 50.0
        examples.look_at_it()
        for view in views:
            self.assertEqual(view.view_perspective, "PERSP")
            self.assertLess((view.view_location - Vector((3.0 + sleeve.LENGTH / 2, 0.0, 0.0))).length, 1e-3)
            self.assertLess(view.view_distance, sleeve.LENGTH)
            self.assertLess(view.view_rotation.rotation_difference(camera.matrix_world.to_quaternion()).angle, 1e-3)

    def test_one_that_is_not_there_is_said(self) -> None:
        with mock.patch.object(examples, "FOLDER", Path("/nowhere")):
            with self.assertRaisesRegex(RuntimeError, "no example named \"Cape\": none here"):
                bpy.ops.wm.rumple_open_example(name="Cape")


if __name__ == "__main__":
    unittest.main()
