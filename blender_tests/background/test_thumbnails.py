# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of the fabrics: one for every preset, in the menu; and nothing breaks where they are missing."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path
from unittest import mock

import bpy
from rumple.blender.objects import properties
from rumple.blender.ui import thumbnails
from rumple.core.settings.presets import MESH_PRESETS
from rumple.core.systems.all_systems import SYSTEMS
from support import sleeve

MOST_BYTES = 10_000
PRESETS = [(method, key) for method, system in SYSTEMS.items() for key in system.presets]
WITHOUT_PRESETS = [method for method, system in SYSTEMS.items() if not system.presets] + ["MAPS"]


class Thumbnails(unittest.TestCase):

    def setUp(self) -> None:
        thumbnails.unregister()
        thumbnails.register()

    tearDown = setUp

    def test_every_preset_and_system_has_a_small_one_and_no_other_file_is_there(self) -> None:
        self.assertGreater(len(PRESETS), 10)
        files = {thumbnails.path(*preset) for preset in PRESETS} | {thumbnails.path(name) for name in WITHOUT_PRESETS}
        self.assertEqual(files, set(thumbnails.FOLDER.iterdir()))
        for file in files:
            self.assertLess(file.stat().st_size, MOST_BYTES, file.name)

    def test_each_is_a_picture_of_its_own(self) -> None:
        """Icons themselves are there in a window alone: window/test_thumbnails_in_window.py."""
        seen = set()
        for preset in PRESETS:
            image = bpy.data.images.load(str(thumbnails.path(*preset)))
            self.assertEqual(tuple(image.size), (112, 112))
            seen.add(tuple(image.pixels[:4096]))
            self.assertGreater(len(set(image.pixels[:])), 20)
            bpy.data.images.remove(image)
        self.assertEqual(len(seen), len(PRESETS))

    def test_the_menu_has_the_presets_as_before(self) -> None:
        for method, system in SYSTEMS.items():
            items = thumbnails.items(method)
            self.assertEqual([(*item[:3], item[4]) for item in items],
                             [(*item[:3], item[4]) for item in properties.preset_items(system)])

    def test_a_choice_in_the_large_pictures_is_a_choice_in_the_menu(self) -> None:
        obj = sleeve.scene()
        bpy.context.view_layer.objects.active = obj
        manager = bpy.context.window_manager
        self.assertEqual(manager.rumple_fabric, "COTTON")
        manager.rumple_fabric = "DENIM"
        self.assertEqual((obj.rumple.mesh.preset, manager.rumple_fabric), ("DENIM", "DENIM"))
        self.assertAlmostEqual(obj.rumple.mesh.bending, MESH_PRESETS["DENIM"].values["bending"], 6)

    def test_without_pictures_or_with_broken_ones_there_are_words(self) -> None:
        with tempfile.TemporaryDirectory() as place:
            for folder in (Path(place) / "gone", Path(place)):
                (Path(place) / "MESH_COTTON.png").write_bytes(b"no picture")
                with mock.patch.object(thumbnails, "FOLDER", folder):
                    self.setUp()
                    self.assertEqual([item[0] for item in thumbnails.items("MESH")], list(SYSTEMS["MESH"].presets))
                    self.assertEqual(thumbnails.icon("MESH", "DENIM"), 0)
        obj = sleeve.scene()
        bpy.context.view_layer.objects.active = obj
        self.assertEqual(bpy.ops.object.rumple_preset(preset="SILK"), {"FINISHED"})

    def test_no_object_and_one_without_wrinkles(self) -> None:
        for obj in (None, sleeve.scene(wrinkles=False)):
            bpy.context.view_layer.objects.active = obj
            self.assertTrue(bpy.context.window_manager.rumple_fabric in ("COTTON", ""))
            bpy.context.window_manager.rumple_fabric = "DENIM"


if __name__ == "__main__":
    unittest.main()
