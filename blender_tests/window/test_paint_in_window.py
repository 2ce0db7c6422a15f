# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel of painted maps, and its operators as keys start them: in Weight Paint, with Blender's own undo."""
from __future__ import annotations

from typing import Iterator
from unittest import mock

import bpy
import numpy as np
from rumple.blender.objects import mesh_reader, modifier, painted_maps, runtimes
from rumple.blender.ui import paint_panel
from support import sleeve
from support.window_case import WindowCase

GROUP = "Rumple Radius"


class Maps(WindowCase):
    def make(self) -> Iterator[float]:
        obj = sleeve.scene()
        areas = bpy.context.window_manager.windows[0].screen.areas
        max(areas, key=lambda a: a.width * a.height).type = "VIEW_3D"
        group = obj.vertex_groups.new(name=GROUP)
        self.painted = np.random.default_rng(5).random(len(obj.data.vertices)).astype(np.float32)
        for vertex, weight in enumerate(self.painted.tolist()):
            group.add([vertex], weight, "REPLACE")
        obj.data.update()
        with self.area():
            bpy.ops.ed.undo_push(message="painted")
        yield 0.3

    @property
    def obj(self) -> bpy.types.Object:
        """Looked up each time: undo makes another one."""
        return bpy.data.objects["Sleeve"]

    def weights(self) -> np.ndarray:
        return mesh_reader.group_weights(self.obj, self.obj.data, [GROUP])[:, 0]

    def key(self, operator: str, **how: object) -> Iterator[float]:
        yield from self.press_for(f"object.rumple_{operator}", lambda: None, group="radius", **how)
        yield 0.2

    def undo(self) -> Iterator[float]:
        window = bpy.context.window_manager.windows[0]
        for value in ("PRESS", "RELEASE"):
            window.event_simulate("Z", value, x=window.width // 2, y=window.height // 2, ctrl=True)
        yield 0.3

    def test_undo_brings_back_the_exact_weights(self) -> Iterator[float]:
        for mode in ("OBJECT", "WEIGHT_PAINT"):
            for operator in ("paint_invert", "paint_from_border", "paint_clear"):
                yield from self.make()
                if mode == "WEIGHT_PAINT":
                    yield from self.key("paint")
                self.assertEqual(self.obj.mode, mode)
                yield from self.key(operator)
                self.assertGreater(np.abs(self.weights() - self.painted).max(), 0.1, operator)
                self.assertEqual(self.obj.mode, "OBJECT" if operator == "paint_clear" else mode)
                yield from self.undo()
                np.testing.assert_array_equal(self.weights(), self.painted, f"{mode} {operator}")
        with self.area():
            bpy.ops.object.mode_set(mode="OBJECT")

    def test_the_folds_follow(self) -> Iterator[float]:
        yield from self.make()
        with self.area():
            sleeve.at(sleeve.LAST)
        yield from self.key("paint_from_border", distance=10.0)
        yield from self.key("paint_invert")
        yield from self.until(lambda: self.weights().min() > 0.9 and np.array_equal(
            runtimes.of(self.obj).paint.values["radius"], self.weights()))
        np.testing.assert_array_equal(runtimes.of(self.obj).inputs.paint["radius"], self.weights())
        height = np.linalg.norm(sleeve.attribute(self.obj, "rumple_offset"), axis=1).max()
        yield from self.key("paint_invert")  # 0 nearly everywhere
        yield from self.until(lambda: np.linalg.norm(sleeve.attribute(self.obj, "rumple_offset"),
                                                     axis=1).max() < 0.2 * height)
        self.assertLess(np.linalg.norm(sleeve.attribute(self.obj, "rumple_offset"), axis=1).max(), 0.2 * height)

    def test_what_was_set_can_be_adjusted(self) -> Iterator[float]:
        yield from self.make()
        yield from self.key("paint_from_border", distance=0.25, falloff="LINEAR")
        last = bpy.context.window_manager.operators[-1]
        self.assertEqual((last.bl_idname, last.falloff, round(last.distance, 6)),
                         ("OBJECT_OT_rumple_paint_from_border", "LINEAR", 0.25))
        np.testing.assert_allclose(self.weights()[sleeve.AROUND], sleeve.LENGTH / (sleeve.ALONG - 1) / 0.25, atol=1e-5)

    def test_a_texture_is_asked_for(self) -> Iterator[float]:
        """By a dialog with the image that the file has; Enter takes it."""
        yield from self.make()
        bpy.data.images.new("Grey", 4, 4, float_buffer=True).pixels.foreach_set(np.full(64, 0.25, np.float32))
        yield from self.key("paint_from_texture")
        np.testing.assert_array_equal(self.weights(), self.painted)
        self.screenshot("paint_dialog")
        yield from self.enter()
        np.testing.assert_allclose(self.weights(), 0.25, atol=1e-6)

    def test_a_material_is_asked_for(self) -> Iterator[float]:
        """By a dialog with the active one, and the weight that takes its folds away. Undo brings them back."""
        yield from self.make()
        self.obj.data.materials.clear()
        self.obj.data.materials.append(bpy.data.materials.new("Skin"))
        yield from self.key("paint_from_material")
        np.testing.assert_array_equal(self.weights(), self.painted)
        self.screenshot("material_dialog")
        yield from self.enter()
        np.testing.assert_array_equal(self.weights(), 0.0)
        yield from self.undo()
        np.testing.assert_array_equal(self.weights(), self.painted)

    def enter(self) -> Iterator[float]:
        """Confirms a dialog."""
        window = bpy.context.window_manager.windows[0]
        place = dict(x=window.width // 2 - 220, y=window.height // 2 + 31)  # no field: Enter would be for that
        window.event_simulate("MOUSEMOVE", "NOTHING", **place)
        yield 0.2
        for value in ("PRESS", "RELEASE"):
            window.event_simulate("RET", value, **place)
        yield 0.3


class Panel(WindowCase):
    def open(self) -> Iterator[float]:
        """The modifier tab in the biggest area, with this sub-panel open."""
        cls = paint_panel.DATA_PT_rumple_paint

        def options(values: set[str]) -> None:
            bpy.utils.unregister_class(cls)
            cls.bl_options = values
            bpy.utils.register_class(cls)

        options(set())
        self.addCleanup(options, {"DEFAULT_CLOSED"})
        area = max(bpy.context.window_manager.windows[0].screen.areas, key=lambda a: a.width * a.height)
        area.type = "PROPERTIES"
        yield
        area.spaces.active.context = "MODIFIER"
        self.addCleanup(setattr, area, "type", "VIEW_3D")
        yield 0.3

    def test_it_draws_for_every_system_and_reads_once(self) -> Iterator[float]:
        for method in ("MESH", "FIELD", "PATHS"):
            obj = sleeve.scene(wrinkles=False)
            with sleeve.context():
                bpy.ops.object.rumple_add(method=method)
                bpy.ops.object.rumple_paint_from_border(group="smooth", distance=0.2)
            with mock.patch.object(painted_maps, "measured", wraps=painted_maps.measured) as drawn:
                yield from self.open()
                yield from self.until(lambda: "smooth" in painted_maps.measured(obj))
                yield from self.until(lambda: drawn.called)
                self.assertTrue(drawn.called)
            mean, share = painted_maps.measured(obj)["smooth"]
            self.assertTrue(0.1 < mean < 0.9 and 0.1 < share < 1.0)
            yield 0.3
            self.screenshot(f"paint_panel_{method.lower()}")
            self.doCleanups()

    def test_numbers_where_nothing_is_solved(self) -> Iterator[float]:
        """The modifier is switched off in the viewport: no frame reads what is painted, so a timer does."""
        obj = sleeve.scene()
        yield from self.open()
        modifier.find(obj).show_viewport = False
        yield 0.3
        with sleeve.context():
            bpy.ops.object.rumple_paint_from_border(group="radius", distance=0.2)
        paint = runtimes.of(obj).paint
        yield from self.until(lambda: paint.measured and "radius" in paint.measured[1])
        self.assertIn("radius", paint.measured[1])
