# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist does first, by mouse and keys in Blender's window.

A trial of this kind once found fifteen things wrong: CONTRIBUTING.md says where each is tested.
"""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path
from typing import Any, Iterator
from unittest import mock

import bpy
import numpy as np
from bl_ui.space_toolsystem_common import ToolSelectPanelHelper
from mathutils import Vector
from rumple.blender.brush import overlay
from rumple.blender.objects import modifier, runtimes
from rumple.blender.ui import examples, held_mouse
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from support import sleeve
from support.artist import Artist

EXAMPLES_FROM_RIGHT = 115  # pixels, in the header of the panel
PAUSE = 0.6  # seconds: longer than a rebuild is put off after a change


class Hand(Artist):
    """A sleeve, and the modifier tab in full."""

    def begin(self, wrinkles: bool = True) -> Iterator[float]:
        """wrinkles: as the first click makes them."""
        sleeve.scene(wrinkles=False).rumple.mesh.property_unset("base_cloth")
        if wrinkles:
            with sleeve.context():
                bpy.ops.object.rumple_add(method="MESH")
                bpy.ops.ed.undo_push(message="begun")
        sleeve.at(10)
        yield 0.5

    @property
    def obj(self) -> bpy.types.Object:
        """Looked up each time: undo makes another one."""
        return bpy.data.objects["Sleeve"]

    def drag(self, places: list[tuple[int, int]], pause: float = PAUSE) -> Iterator[float]:
        """Press, along these with a pause at the last, and no release yet."""
        yield from self.move(places[0])
        self.event("LEFTMOUSE", "PRESS")
        yield 0.05
        for self.here in places[1:]:
            self.event("MOUSEMOVE", "NOTHING")
            yield 0.05
        yield pause

    def along(self, label: str, pixels: int) -> Iterator[Any]:
        """Places on a slider, from its middle to so many pixels right of it."""
        x, y = yield from self.beside(label)
        return [(x + round(pixels * step / 6), y) for step in range(7)]

    def see_part(self, words: str) -> Iterator[float]:
        """Within a longer text."""
        yield from self.until(lambda: self.places(words, "PROPERTIES", alone=False), 5.0)
        self.assertNotEqual(self.places(words, "PROPERTIES", alone=False), [])

    def let_go(self) -> Iterator[float]:
        self.event("LEFTMOUSE", "RELEASE")
        yield 0.1


class Drag(Hand):
    """The first drag of Wavelength froze Blender for two minutes."""

    def watch_builds(self) -> list[float]:
        """The wavelengths for which fine meshes are made from now on."""
        builds, plain = [], WrinkleMesh.build

        def build(base: Any, settings: Any, **more: Any) -> WrinkleMesh:
            builds.append(settings.wavelength)
            return plain(base, settings, **more)

        patch = mock.patch.object(WrinkleMesh, "build", build)
        patch.start()
        self.addCleanup(patch.stop)
        return builds

    def test_a_fine_mesh_waits_for_the_release(self) -> Iterator[float]:
        yield from self.begin()
        yield from self.modifier_tab()
        builds, before = self.watch_builds(), self.obj.rumple.mesh.wavelength
        places = yield from self.along("Wavelength", 24)
        yield from self.drag(places)
        held = self.obj.rumple.mesh.wavelength
        self.screenshot("wavelength_while_dragged")
        self.assertNotAlmostEqual(held, before, 4)
        self.assertLess(abs(held - before), 0.02 * before * 24)  # 24 pixels
        self.assertEqual(builds, [])
        yield PAUSE
        self.assertEqual(builds, [])
        yield from self.let_go()
        yield from self.until(lambda: builds and not runtimes.of(self.obj).stale)
        self.assertEqual(len(builds), 1)
        self.assertAlmostEqual(builds[0], self.obj.rumple.mesh.wavelength, 6)
        self.assertEqual(self.obj.rumple.message, "")
        yield from self.maximise("PROPERTIES")

    def test_what_is_cheap_follows_while_it_is_dragged(self) -> Iterator[float]:
        yield from self.begin()
        yield from self.modifier_tab()
        builds, shown = self.watch_builds(), sleeve.attribute(self.obj, "rumple_offset").copy()
        places = yield from self.along("Folds", -40)
        yield from self.drag(places, 0.1)
        yield from self.until(lambda: abs(sleeve.attribute(self.obj, "rumple_offset") - shown).max() > 1e-5)
        self.assertGreater(abs(sleeve.attribute(self.obj, "rumple_offset") - shown).max(), 1e-5)
        yield from self.let_go()
        yield PAUSE
        self.assertEqual(builds, [])
        yield from self.maximise("PROPERTIES")

    def test_esc_while_dragging_leaves_value_and_folds(self) -> Iterator[float]:
        yield from self.begin()
        yield from self.modifier_tab()
        builds, before = self.watch_builds(), self.obj.rumple.mesh.wavelength
        places = yield from self.along("Wavelength", 24)
        yield from self.drag(places)
        # On a busy machine the timer that asks for the mouse may come late, and it sees the last key alone.
        yield from self.until(lambda: held_mouse._down_in != -1)
        yield from self.press("ESC")
        yield PAUSE
        yield from self.let_go()
        self.assertAlmostEqual(self.obj.rumple.mesh.wavelength, before, 7)
        self.assertEqual(builds, [])
        self.assertFalse(runtimes.of(self.obj).stale)
        yield from self.maximise("PROPERTIES")

    def test_a_typed_value_waits_for_no_mouse(self) -> Iterator[float]:
        yield from self.begin()
        yield from self.modifier_tab()
        builds = self.watch_builds()
        yield from self.enter("Wavelength", "5 cm")
        yield from self.until(lambda: builds)
        self.assertEqual([round(wavelength, 4) for wavelength in builds], [0.05])
        yield from self.maximise("PROPERTIES")


class FirstClick(Hand):
    def test_one_click_and_one_screen(self) -> Iterator[float]:
        yield from self.begin(wrinkles=False)
        yield from self.modifier_tab()
        self.assertEqual(self.places("Apply", "PROPERTIES"), [])
        yield from self.add("Wrinkle Mesh")
        self.assertIsNotNone(modifier.find(self.obj))
        self.screenshot("first_click")
        yield from self.see("Cotton", "PROPERTIES")
        for words in ("Wrinkle Mesh", "Cotton"):  # in the header, and on the path above or the button below
            self.assertEqual(len(self.places(words, "PROPERTIES", alone=False)), 2)
        for words in ("Drape", "Wavelength", "Apply", "Cloth", "Bake", "Status"):
            yield from self.see(words, "PROPERTIES")
        self.assertEqual(self.obj.rumple.message, "")
        yield from self.maximise("PROPERTIES")

    def test_the_header_has_the_examples(self) -> Iterator[float]:
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        (folder / "A_sleeve.blend").touch()
        self.enterContext(mock.patch.object(examples, "FOLDER", folder))
        yield from self.begin()
        yield from self.modifier_tab()
        yield from self.see("Wrinkle Mesh", "PROPERTIES", which=-1)
        title = self.places("Cotton", "PROPERTIES", alone=False)[0]
        self.screenshot("header_with_examples")
        yield from self.click((self.box("PROPERTIES").right - EXAMPLES_FROM_RIGHT, title.middle[1]))
        yield from self.see("A sleeve")
        self.screenshot("examples_in_header")
        yield from self.press("ESC")
        yield from self.maximise("PROPERTIES")

    def test_a_field_and_paths_fit_into_one_screen(self) -> Iterator[float]:
        """What is not changed first is closed."""
        for system, first in (("Wrinkle Field", ("Output", "Strength", "Wavelength", "Remove from Materials", "Waves")),
                              ("Wrinkle Paths", ("Width", "Height", "Folds", "Cotton"))):
            yield from self.begin(wrinkles=False)
            yield from self.modifier_tab()
            yield from self.add(system)
            for words in (*first, "Cloth", "Bake", "Status"):
                yield from self.see(words, "PROPERTIES")
            self.assertEqual(self.places("Seed", "PROPERTIES"), [])
            self.screenshot(f"first_panel_{self.obj.rumple.method.lower()}")
            yield from self.maximise("PROPERTIES")

    def test_the_menu_has_a_picture_of_each_system(self) -> Iterator[float]:
        yield from self.begin(wrinkles=False)
        yield from self.modifier_tab()
        box = yield from self.see("Add Modifier", "PROPERTIES")
        if bpy.app.version >= (4, 0, 0):
            yield from self.click(box.middle)
        yield from self.choose("Wrinkles")
        found = {}
        for words in ("Wrinkle Mesh", "Wrinkle Field", "Wrinkle Paths", "Wrinkle Maps"):
            found[words] = yield from self.see(words)
        self.screenshot("menu_of_systems")
        for words, box in found.items():
            left = self.pixels()[::-1][box.low - 8:box.high + 8, box.left - 80:box.left - 30]
            self.assertGreater(np.ptp(left.reshape(-1, 3).astype(int), axis=0).max(), 60, words)
        yield from self.press("ESC")
        yield from self.press("ESC")
        yield from self.maximise("PROPERTIES")

    def test_a_field_is_seen_in_solid(self) -> Iterator[float]:
        yield from self.begin(wrinkles=False)
        space = self.editor("VIEW_3D").spaces.active
        self.assertEqual(space.shading.type, "SOLID")
        with self.area():
            bpy.ops.view3d.view_all()
        yield 0.3
        before = self.pixels().astype(int)
        yield from self.modifier_tab()
        yield from self.add("Wrinkle Field")
        yield from self.maximise("PROPERTIES")
        yield 0.5
        box = self.box("VIEW_3D")
        change = np.abs(self.pixels() - before)[::-1][box.low:box.high - 60, box.left + 60:box.right - 60].max(axis=2)
        self.screenshot("first_click_field")
        self.assertGreater((change > 8).sum(), 300)

    def test_adjust_last_operation(self) -> Iterator[float]:
        yield from self.begin(wrinkles=False)
        with self.area():
            bpy.ops.ed.undo_push(message="bare")
            bpy.ops.object.rumple_add("EXEC_DEFAULT", True, method="MESH")
        suggested = self.obj.rumple.mesh.wavelength
        yield from self.move(self.box("VIEW_3D").middle)
        yield from self.press("F9")
        box = yield from self.see("Wavelength", "VIEW_3D")
        yield from self.click((box.right + 60, box.middle[1]))
        yield from self.type("7 cm")
        yield from self.press("RET")
        yield from self.until(lambda: abs(self.obj.rumple.mesh.wavelength - 0.07) < 1e-6)
        self.screenshot("adjust_last")
        self.assertNotAlmostEqual(suggested, 0.07, 3)
        self.assertAlmostEqual(self.obj.rumple.mesh.wavelength, 0.07, 6)
        self.assertIsNotNone(modifier.find(self.obj))
        yield from self.press("ESC")

    def test_the_brush_stands_where_it_paints(self) -> Iterator[float]:
        yield from self.begin()
        tools = ToolSelectPanelHelper._tool_class_from_space_type("VIEW_3D")
        with self.area():
            self.assertNotIn(overlay._tool, self.names(tools))
            bpy.ops.object.rumple_remove()
            bpy.ops.object.rumple_add(method="FIELD")
            self.assertIn(overlay._tool, self.names(tools))
        yield

    @staticmethod
    def names(tools: Any) -> list[str]:
        return [tool.idname for tool in ToolSelectPanelHelper._tools_flatten(tools.tools_from_context(bpy.context))
                if tool is not None]


@unittest.skipIf(bpy.app.version[:2] == (4, 3), "Debian's 4.3 has no brushes")
class Paint(Hand):
    def test_the_first_stroke_and_the_way_out(self) -> Iterator[float]:
        yield from self.begin()
        with self.area():
            bpy.ops.view3d.view_axis(type="TOP")
            bpy.ops.view3d.view_all()
        yield from self.modifier_tab()
        yield from self.brush("Drape")
        self.assertEqual(self.obj.mode, "WEIGHT_PAINT")
        yield from self.see_part("Paint with weight 0 where Drape fades")
        self.screenshot("paint_how")
        yield from self.maximise("PROPERTIES")
        yield 0.3
        before = self.painted()
        self.assertTrue((before == 1.0).all())
        ends = [Vector(self.seen_at(Vector((x, 0.0, 0.06)))) for x in (0.02, 0.25)]
        yield from self.drag([tuple(int(c) for c in ends[0].lerp(ends[1], step / 8)) for step in range(9)], 0.1)
        yield from self.until(lambda: self.of_output().min() < 0.5, 10.0)
        self.screenshot("first_stroke")
        self.assertLess(self.of_output().min(), 0.5)  # what is seen under the brush, while it is still held
        yield from self.let_go()
        yield from self.until(lambda: self.painted().min() < 0.5, 10.0)
        self.assertLess(self.painted().min(), 0.5)
        yield from self.modifier_tab()
        yield from self.brush("Drape")
        self.assertEqual(self.obj.mode, "OBJECT")
        yield from self.maximise("PROPERTIES")

    def of_output(self) -> np.ndarray:
        """The weights that the fine mesh of viewports has, where it has any."""
        output = modifier.outputs(modifier.find(self.obj))[-1]
        if "Rumple Drape" not in output.vertex_groups:
            return np.ones(1)
        index = output.vertex_groups["Rumple Drape"].index
        return np.array([next((g.weight for g in vertex.groups if g.group == index), 1.0)
                         for vertex in output.data.vertices[:len(self.obj.data.vertices)]])

    def painted(self) -> np.ndarray:
        group = self.obj.vertex_groups["Rumple Drape"]
        return np.array([group.weight(vertex.index) for vertex in self.obj.data.vertices])


class Baked(Hand):
    def bake(self) -> Iterator[float]:
        yield from self.begin()
        self.obj.rumple.bake_end = 12
        with self.area():
            bpy.ops.object.rumple_bake()
        sleeve.at(5)
        yield from self.modifier_tab()

    def test_the_header_says_so_and_frees_it(self) -> Iterator[float]:
        yield from self.bake()
        yield from self.see("Baked 1\u201312", "PROPERTIES")
        self.screenshot("baked_header")
        before = self.obj.rumple.mesh.folds
        places = yield from self.along("Folds", -40)
        yield from self.drag(places, 0.1)
        yield from self.let_go()
        self.assertEqual(self.obj.rumple.mesh.folds, before)  # greyed
        yield from self.button("Free")
        self.assertFalse(modifier.is_baked(modifier.find(self.obj)))
        yield from self.maximise("PROPERTIES")

    def test_what_was_changed_is_said_at_once(self) -> Iterator[float]:
        yield from self.bake()
        self.assertEqual(self.places("changed since", "PROPERTIES", alone=False), [])
        self.obj.rumple.mesh.bending = 0.1
        yield from self.see_part("changed since")
        self.screenshot("changed_since_bake")
        yield from self.maximise("PROPERTIES")

    def test_outside_its_range_folds_are_live(self) -> Iterator[float]:
        yield from self.bake()
        yield from self.maximise("PROPERTIES")
        yield from self.go_to_frame(18)
        self.assertIn("is outside the bake", self.obj.rumple.message)
        self.screenshot("outside_the_bake")
        np.testing.assert_allclose(sleeve.shown(self.obj), sleeve.picture(self.obj).positions, atol=1e-6)
        yield from self.go_to_frame(6)
        self.assertEqual(self.obj.rumple.message, "")

    def test_shape_keys_hide_the_garment(self) -> Iterator[float]:
        yield from self.begin()
        self.obj.rumple.bake_end = 6
        yield from self.modifier_tab()
        yield from self.button("Bake")
        yield from self.button("Bake to Shape Keys")
        yield from self.until(lambda: bpy.context.object.name != "Sleeve")
        copy = bpy.context.object
        self.assertEqual(len(copy.data.shape_keys.key_blocks), 7)
        self.assertEqual((self.obj.hide_get(), self.obj.hide_render, copy.hide_get()), (True, True, False))
        yield from self.maximise("PROPERTIES")
        self.screenshot("shape_keys_alone")
