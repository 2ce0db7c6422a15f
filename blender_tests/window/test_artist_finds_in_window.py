# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist reads and finds: tooltips, labels at the default width and in a narrow editor, F3, the overlay of the
paths. By mouse and keys; see test_artist_in_window.py."""
from __future__ import annotations

import unittest
from typing import Iterator

import bpy
import numpy as np
from rumple.blender.objects import modifier
from support import sleeve
from support.artist import Artist

DEFAULT_WIDTH = 333  # of the properties editor, with Blender's own layout on a screen of 1920 x 1080
TIPS = {"Wrinkle Mesh": "Geometry: the garment becomes", "Wrinkle Field": "Shading or geometry: parallel",
        "Wrinkle Paths": "Geometry: single crisp folds"}


class Found(Artist):
    def begin(self, method: str = "") -> Iterator[float]:
        """A sleeve, and what the first click makes of it."""
        obj = sleeve.scene(wrinkles=False)
        for settings in (obj.rumple.mesh, obj.rumple.field, obj.rumple.paths):
            settings.property_unset("base_cloth")
        if method:
            with sleeve.context():
                bpy.ops.object.rumple_add(method=method)
        for one in obj.modifiers:
            one.show_expanded = False
        sleeve.at(10)
        self.editor("PROPERTIES").spaces.active.context = "MODIFIER"
        yield 0.5

    @property
    def obj(self) -> bpy.types.Object:
        """Looked up each time: undo makes another one."""
        return bpy.data.objects["Sleeve"]

    def search(self, words: str) -> Iterator[float]:
        """F3 over the viewport, the words, Enter."""
        yield from self.move(self.box("VIEW_3D").middle)
        yield from self.press("F3")
        yield 0.3
        yield from self.type(words)
        yield 0.3
        self.screenshot(f"search_{words.replace(' ', '_')}")
        yield from self.press("RET")
        yield 0.3

    def widen(self, pixels: int) -> Iterator[float]:
        """Drag the border of the properties editor."""
        area = self.editor("PROPERTIES")
        x, y = area.x - 1, area.y + area.height // 2
        yield from self.stroke([(x, y), (x - pixels // 2, y), (x - pixels, y)])
        yield 0.3


class Words(Found):
    @unittest.skipIf(bpy.app.version[:2] == (4, 3), "shows simulated events no tooltip of a menu")
    def test_each_system_has_a_tooltip_of_its_own(self) -> Iterator[float]:
        yield from self.begin()
        bpy.context.preferences.view.show_tooltips = True
        yield from self.modifier_tab()
        # 3.4 shows simulated events no second tooltip; background/test_habits.Words has the others.
        for system, tip in list(TIPS.items())[:None if bpy.app.version >= (5, 0, 0) else 1]:
            box = yield from self.see("Add Modifier", "PROPERTIES")
            if bpy.app.version >= (4, 0, 0):
                yield from self.click(box.middle)
            yield from self.choose("Wrinkles")
            entry = yield from self.see(system)
            for beside in range(4):  # Blender takes a tooltip back when it draws again: the next move asks for it anew
                yield from self.move((entry.middle[0] + beside, entry.middle[1]))
                yield from self.until(lambda: self.places(tip, alone=False), 10.0)
                if self.places(tip, alone=False):
                    break
            self.assertNotEqual(self.places(tip, alone=False), [], self.screenshot("tooltip_not_found"))
            self.screenshot(f"tooltip_{system.replace(' ', '_')}")
            yield from self.press("ESC")
            yield from self.press("ESC")
            yield from self.move((self.box("PROPERTIES").middle[0], 60))
            yield 0.3
        yield from self.maximise("PROPERTIES")

    def test_no_label_is_cut_off_at_the_default_width_or_in_a_narrow_editor(self) -> Iterator[float]:
        """In a narrow one names stand above their fields, and icons in place of words."""
        yield from self.begin("MESH")
        narrow = self.editor("PROPERTIES").width
        self.assertLess(narrow, 200)
        for words in ("Drape", "Folds", "Detail", "Wavelength", "Apply"):
            yield from self.see(words, "PROPERTIES")
        self.screenshot("panel_narrow")
        self.assertEqual(self.places("Remove", "PROPERTIES"), [])
        yield from self.widen(DEFAULT_WIDTH - narrow)
        for words in ("Drape", "Wavelength", "Apply", "Remove", "Add Wrinkle Maps"):
            yield from self.see(words, "PROPERTIES")
        self.screenshot("panel_default_width")
        yield from self.button("Attachment & Constraints")
        for words in ("Bend Stiffness", "Max Gather Ratio", "Hem Fade"):
            yield from self.scroll_to(words)
        self.screenshot("panel_constraints")
        yield from self.button("Attachment & Constraints")
        yield from self.widen(narrow - self.editor("PROPERTIES").width)


class Search(Found):
    def test_f3_adds_wrinkles(self) -> Iterator[float]:
        yield from self.begin()
        yield from self.search("wrinkle mesh")
        self.assertIsNotNone(modifier.find(self.obj))
        self.assertEqual(self.obj.rumple.method, "MESH")

    def test_f3_copies_settings_to_the_selected(self) -> Iterator[float]:
        yield from self.begin("MESH")
        with sleeve.context():
            sleeve.make_active(self.obj)
            bpy.ops.object.duplicate()
        other = bpy.context.object
        yield 0.5
        other.rumple.mesh.folds = 0.3
        self.obj.select_set(True)
        yield from self.search("copy wrinkle")
        yield from self.until(lambda: abs(self.obj.rumple.mesh.folds - 0.3) < 1e-6)
        self.assertAlmostEqual(self.obj.rumple.mesh.folds, 0.3, 6)


class Overlay(Found):
    def test_labels_and_ellipses_let_the_cloth_through(self) -> Iterator[float]:
        """They were opaque: nothing of cloth and folds was to be seen behind them."""
        yield from self.begin("PATHS")
        with self.area():
            bpy.ops.view3d.view_all()
        self.clear_view(self.editor("VIEW_3D").spaces.active)
        yield 0.5
        plain = self.view()
        yield from self.modifier_tab()
        yield from self.button("Curves & Overlay")
        yield from self.button("Labels & Ellipses")
        self.assertTrue(self.obj.rumple.paths.show_overlay)
        yield from self.maximise("PROPERTIES")
        yield 0.5
        self.screenshot("labels_and_ellipses")
        shown = self.view()
        colored = np.abs(shown - plain).max(2) > 12.0
        self.assertGreater(colored.sum(), 1000)
        # Where the cloth is darker, it is darker below the colours.
        light = np.corrcoef(plain.mean(2)[colored], shown.mean(2)[colored])[0, 1]
        self.assertGreater(light, 0.5)

    def view(self) -> np.ndarray:
        """The pixels of the viewport's middle, as numbers."""
        box = self.box("VIEW_3D")
        return self.pixels().astype(float)[::-1][box.low:box.high - 60, box.left + 60:box.right - 60]
