# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of the fabrics as icons, which Blender has in a window alone."""
from __future__ import annotations

from typing import Iterator

import bpy
from rumple.blender.ui import thumbnails
from rumple.core.systems.all_systems import SYSTEMS
from support import sleeve
from support.window_case import WindowCase

PRESETS = [(method, key) for method, system in SYSTEMS.items() for key in system.presets]


class Thumbnails(WindowCase):

    def test_every_preset_has_an_icon_of_its_own_and_the_panel_draws_them(self) -> Iterator[float]:
        icons = [thumbnails.icon(*preset) for preset in PRESETS]
        self.assertNotIn(0, icons)
        self.assertEqual(len(set(icons)), len(PRESETS))
        self.assertEqual([item[3] for method in ("MESH", "PATHS") for item in thumbnails.items(method)], icons)
        for method, key in PRESETS:
            picture = thumbnails._pictures[thumbnails.path(method, key).stem]
            # As it is in the file, or in the size of Blender's own previews where a panel has drawn it before.
            self.assertIn(tuple(picture.image_size), ((112, 112), (128, 128)))
        sleeve.scene()
        areas = bpy.context.window_manager.windows[0].screen.areas
        area = next(area for area in areas if area.type == "PROPERTIES")
        area.spaces.active.context = "MODIFIER"
        area.tag_redraw()
        yield 1.0
        self.screenshot("thumbnails")

    def test_a_choice_in_the_pictures_can_be_undone(self) -> Iterator[float]:
        obj = sleeve.scene()
        bpy.context.view_layer.objects.active = obj
        with self.area():
            bpy.ops.ed.undo_push(message="cotton")
        yield 0.3
        with self.area():
            bpy.context.window_manager.rumple_fabric = "LEATHER"
        yield 0.3
        self.assertEqual(bpy.data.objects["Sleeve"].rumple.mesh.preset, "LEATHER")
        window = bpy.context.window_manager.windows[0]
        for value in ("PRESS", "RELEASE"):
            window.event_simulate("Z", value, x=window.width // 2, y=window.height // 2, ctrl=True)
        yield 0.5
        self.assertEqual(bpy.data.objects["Sleeve"].rumple.mesh.preset, "COTTON")
