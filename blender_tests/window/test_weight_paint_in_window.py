# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own tools of Weight Paint on a garment with wrinkles, by mouse and keys.

The law: the same events paint the same weights, and select the same, as where the wrinkles are switched off. Gradients,
samples and selections once did nothing: what a viewport shows has none of the artist's own vertices.
"""
from __future__ import annotations

import unittest
from typing import Any, Callable, Generator, Iterator
from unittest import mock

import bpy
import numpy as np
from mathutils import Matrix, Vector
from rumple.blender.frame import rebuild
from rumple.blender.objects import mesh_reader, modifier, output_mesh, weight_paint
from rumple.blender.ui import paint_words
from support import sleeve
from support.artist import HELD, Artist

GROUP = "Rumple Radius"
NEW_BRUSHES = bpy.app.version >= (4, 3, 0)
ESSENTIALS = "brushes/essentials_brushes-mesh_weight.blend/Brush/"
STEP = 1.0 / output_mesh.WEIGHT_STEPS
Steps = Generator[float, None, Any]


class Tools(Artist):
    def begin(self, wrinkles: bool) -> Steps:
        """A sleeve seen from above, its middle at x = 0, in Weight Paint; half of it painted in a pattern. Whatever
        key another test held is let go: with it a drag is another tool's."""
        for key in HELD.values():
            self.event(key, "RELEASE")
        obj = sleeve.scene(wrinkles=False)
        obj.data.transform(Matrix.Translation((-sleeve.LENGTH / 2, 0.0, 0.0)))
        with sleeve.context():
            bpy.ops.object.rumple_add(method="MESH")
        group = obj.vertex_groups.new(name=GROUP)
        for number, vertex in enumerate(obj.data.vertices):
            group.add([number], 1.0 if vertex.co.x > 0.0 else 0.125 * (number % 8), "REPLACE")
        sleeve.at(1)
        with self.area():
            bpy.ops.view3d.view_axis(type="TOP")
            bpy.ops.view3d.view_all()
            bpy.ops.object.rumple_paint(group="radius")
        modifier.find(obj).show_viewport = wrinkles
        self.set_weight(0.0)
        yield from self.settle()

    def settle(self) -> Steps:
        """A redraw, what it asks for, and what structural work waits for."""
        for _ in range(3):
            yield 0.2

    @property
    def obj(self) -> bpy.types.Object:
        """Looked up each time: undo makes another one."""
        return bpy.data.objects["Sleeve"]

    def weights(self) -> np.ndarray:
        return mesh_reader.group_weights(self.obj, self.obj.data, [GROUP])[:, 0]

    def at(self, x: float, y: float = 0.0) -> tuple[int, int]:
        return self.seen_at(Vector((x, y, sleeve.RADIUS)))

    def tool(self, name: str) -> Steps:
        with self.area():
            bpy.ops.wm.tool_set_by_id(name=name)
        yield from self.settle()

    def brush_tool(self, kind: str) -> Steps:
        """From the toolbar, or in Blender 5 an asset of its own library."""
        if not NEW_BRUSHES:
            yield from self.tool(f"builtin_brush.{kind}")
            return
        yield from self.tool("builtin.brush")
        with self.area():
            bpy.ops.brush.asset_activate(asset_library_type="ESSENTIALS", relative_asset_identifier=ESSENTIALS
                                         + {"Draw": "Paint"}.get(kind, kind))
        yield from self.settle()
        self.assertEqual(bpy.context.tool_settings.weight_paint.brush.name,
                         {"Draw": "Paint"}.get(kind, kind))

    @property
    def shared(self) -> Any:
        """What brushes have in common; Blender 5 keeps it with the mode."""
        settings = bpy.context.tool_settings
        return getattr(settings, "unified_paint_settings", None) or settings.weight_paint.unified_paint_settings

    def set_weight(self, weight: float) -> None:
        self.shared.use_unified_weight, self.shared.weight = True, weight

    def both_ways(self, act: Callable[[], Steps]) -> Steps:
        """Without wrinkles and with them: what act() returns is the same."""
        found = []
        for wrinkles in (False, True):
            yield from self.begin(wrinkles)
            found.append((yield from act()))
        np.testing.assert_array_equal(found[0], found[1])
        return found[1]

    def changed(self, act: Callable[[], Steps]) -> Callable[[], Steps]:
        """As act(), and it returns the weights; it must have painted something."""
        def painted() -> Steps:
            before = self.weights()
            yield from act()
            yield from self.settle()
            self.assertGreater((np.abs(self.weights() - before) > 1e-3).sum(), 4)
            return self.weights()
        return painted


@unittest.skipIf(bpy.app.version[:2] == (4, 3), "Debian's 4.3 has no brushes, and draws no gradient without one")
class Gradient(Tools):
    def drawn(self) -> Steps:
        """In steps with a pause: the tool waits until a press has become a drag."""
        yield from self.move(self.at(-0.2))
        self.event("LEFTMOUSE", "PRESS")
        for step in range(9):
            self.here = self.at(0.05 * step - 0.2)
            self.event("MOUSEMOVE", "NOTHING")
            yield 0.1
        self.event("LEFTMOUSE", "RELEASE")
        yield 0.1

    def test_the_tool(self) -> Iterator[float]:
        def act() -> Steps:
            yield from self.tool("builtin.gradient")
            yield from self.drawn()

        weights = yield from self.both_ways(self.changed(act))
        rings = weights.reshape(sleeve.ALONG, sleeve.AROUND).mean(axis=1)
        self.assertTrue((np.diff(rings) >= -1e-6).all() and rings[0] == 0.0 and rings[-1] == 1.0)
        self.screenshot("weight_paint_gradient")
        yield from self.tool("builtin.annotate")
        self.assertFalse(weight_paint.needs_coarse(self.obj))

    def test_its_shortcut(self) -> Iterator[float]:
        def act() -> Steps:
            if bpy.app.version < (4, 0, 0):
                yield from self.stroke([self.at(-0.2), self.at(0.0), self.at(0.2)], alt=True)
                return
            yield from self.move(self.at(-0.2))
            yield from self.press("A", shift=True)
            yield from self.drawn()

        yield from self.both_ways(self.changed(act))
        self.assertFalse(weight_paint.needs_coarse(self.obj))  # and the folds are shown again
        yield from self.until(lambda: sleeve.is_fine(self.obj))
        self.assertTrue(sleeve.is_fine(self.obj))

    def test_undo(self) -> Iterator[float]:
        yield from self.begin(wrinkles=True)
        with self.area():
            bpy.ops.ed.undo_push(message="begun")
        before = self.weights()
        yield from self.tool("builtin.gradient")
        yield from self.drawn()
        yield from self.settle()
        self.assertGreater(np.abs(self.weights() - before).max(), 0.1)
        yield from self.press("Z", ctrl=True)
        yield from self.settle()
        np.testing.assert_array_equal(self.weights(), before)


class Selection(Tools):
    def selected(self) -> np.ndarray:
        return np.array([vertex.select for vertex in self.obj.data.vertices])

    def masked(self, faces: bool) -> Steps:
        """Nothing is selected."""
        setattr(self.obj.data, "use_paint_mask" if faces else "use_paint_mask_vertex", True)
        with self.area():
            (bpy.ops.paint.face_select_all if faces else bpy.ops.paint.vert_select_all)(action="DESELECT")
        if NEW_BRUSHES:
            yield from self.tool("builtin.select_box")
        yield from self.settle()

    def test_vertices_in_a_box(self) -> Iterator[float]:
        def act() -> Steps:
            yield from self.masked(faces=False)
            yield from self.move(self.at(-0.1, -0.1))
            if not NEW_BRUSHES:
                yield from self.press("B")
            yield from self.stroke([self.at(-0.1, -0.1), self.at(0.0, 0.0), self.at(0.1, 0.1)])
            yield from self.settle()
            return self.selected()

        self.assertTrue(4 <= (yield from self.both_ways(act)).sum() < len(self.obj.data.vertices) // 2)
        self.screenshot("weight_paint_mask")

    def test_a_vertex_and_a_face_by_a_click(self) -> Iterator[float]:
        ring, across = sleeve.LENGTH / (sleeve.ALONG - 1), 0.02
        for faces, place in ((False, (ring / 2, 0.0)), (True, (0.0, across))):
            def act() -> Steps:
                yield from self.masked(faces)
                yield from self.click(self.at(*place), **({} if NEW_BRUSHES else {"ctrl": True}))
                yield from self.settle()
                return self.selected() if not faces else np.array([face.select for face in self.obj.data.polygons])

            self.assertEqual((yield from self.both_ways(act)).sum(), 1)

    @unittest.skipIf(bpy.app.version[:2] == (4, 3), "Debian's 4.3 has no brushes")
    def test_only_what_is_selected_is_painted(self) -> Iterator[float]:
        def act() -> Steps:
            self.obj.data.use_paint_mask_vertex = True
            for vertex in self.obj.data.vertices:
                vertex.select = vertex.co.y > 0.0
            yield from self.brush_tool("Draw")
            before = self.weights()
            yield from self.stroke([self.at(0.02 * step) for step in range(8)])
            yield from self.settle()
            self.assertFalse((self.weights() != before)[~self.selected()].any())
            return self.weights()

        yield from self.both_ways(self.changed(act))
        self.obj.data.use_paint_mask_vertex = False
        yield from self.until(lambda: sleeve.is_fine(self.obj))
        self.assertTrue(sleeve.is_fine(self.obj))


@unittest.skipIf(bpy.app.version[:2] == (4, 3), "Debian's 4.3 has no brushes")
class Brushes(Tools):
    def stroked(self, kind: str) -> Callable[[], Steps]:
        def act() -> Steps:
            yield from self.brush_tool(kind)
            self.set_weight(0.0)
            yield from self.stroke([self.at(0.02 * step - 0.25) for step in range(12)])
        return act

    def test_every_brush(self) -> Iterator[float]:
        for kind in ("Draw", "Blur", "Average", "Smear"):
            yield from self.both_ways(self.changed(self.stroked(kind)))

    def test_ctrl_paints_what_was_taken_away_again(self) -> Iterator[float]:
        """As the panel says, where Blender has such keys: not in 3.4."""
        if not paint_words.ctrl_inverts():
            self.assertLess(bpy.app.version, (4, 3, 0))
            return
        yield from self.begin(wrinkles=True)
        yield from self.brush_tool("Draw")
        self.set_weight(0.0)
        places = [self.at(0.02 * step + 0.1) for step in range(6)]
        yield from self.stroke(places)
        yield from self.settle()
        before = self.weights()
        taken = (before < 0.7) & (self.ring() > sleeve.ALONG // 2)  # it was 1 there
        self.assertGreater(taken.sum(), 4)
        yield from self.stroke(places, ctrl=True)
        yield from self.settle()
        self.assertGreater((self.weights() > before + 0.1)[taken].sum(), 4)

    def ring(self) -> np.ndarray:
        """Of each vertex."""
        return np.arange(sleeve.ALONG * sleeve.AROUND) // sleeve.AROUND

    def test_symmetry(self) -> Iterator[float]:
        def act() -> Steps:
            self.obj.data.use_mirror_x = True
            yield from self.brush_tool("Draw")
            self.set_weight(0.0)
            yield from self.stroke([self.at(0.1 + 0.02 * step) for step in range(6)])

        rings = (yield from self.both_ways(self.changed(act))).reshape(sleeve.ALONG, sleeve.AROUND)
        painted = rings < 1e-3
        self.assertTrue(painted[sleeve.ALONG // 2:].any())
        self.assertTrue((painted[::-1] & ~painted)[sleeve.ALONG // 2:].sum() <= 8)  # the pattern's own zeros

    def test_sample(self) -> Iterator[float]:
        """By the tool and by its shortcut."""
        for by_key in (False, True):
            def act() -> Steps:
                if not by_key:
                    yield from self.tool("builtin.sample_weight")
                place = self.at(sleeve.LENGTH / (sleeve.ALONG - 1) / 2)
                if not by_key:
                    yield from self.click(place)
                else:
                    yield from self.move(place)
                    yield from self.press(*(("X",) if NEW_BRUSHES else ("RIGHTMOUSE",)),
                                          **({"shift": True} if NEW_BRUSHES else {"ctrl": True}))
                yield from self.settle()
                return self.shared.weight

            self.assertGreater((yield from self.both_ways(act)), 0.0)  # it was 0

    def test_colours_follow_a_brush_that_never_rests(self) -> Iterator[float]:
        """They once came a quarter of a second after it rested, and each rest rebuilt all."""
        yield from self.begin(wrinkles=True)
        yield from self.brush_tool("Draw")
        self.set_weight(0.0)
        yield from self.move(self.at(-0.2))
        with mock.patch.object(rebuild, "prepare", wraps=rebuild.prepare) as rebuilt:
            self.event("LEFTMOUSE", "PRESS")
            for step in range(12):
                self.here = self.at(0.03 * step - 0.2)
                self.event("MOUSEMOVE", "NOTHING")
                yield 0.1
            self.assertGreater((self.weights() == 0.0).sum(), 8)
            yield from self.until(lambda: np.allclose(self.shown(), self.weights(), atol=STEP), 5.0)
            np.testing.assert_allclose(self.shown(), self.weights(), atol=STEP)
            yield 0.6  # it rests, held
            rebuilt.assert_not_called()
            self.event("LEFTMOUSE", "RELEASE")
            yield from self.until(lambda: rebuilt.called)
            rebuilt.assert_called_once()
        np.testing.assert_allclose(self.shown(), self.weights(), atol=STEP)

    def shown(self) -> np.ndarray:
        """The weights of the fine mesh's first vertices, which are the coarse ones."""
        outputs = modifier.outputs(modifier.find(self.obj))
        return mesh_reader.group_weights(outputs[-1], outputs[-1].data, [GROUP])[:len(self.obj.data.vertices), 0]
