# SPDX-License-Identifier: GPL-3.0-or-later
"""Rest-pose wrinkles painted with a simulated mouse: what an artist's hand does, in a real window."""
from __future__ import annotations

import math
import os
from typing import Iterator

import bpy
import numpy as np
from bpy_extras import view3d_utils
from mathutils import Vector
from rumple.blender import compat
from rumple.blender.brush import operators as brush_operators
from rumple.blender.objects import mesh_reader, runtimes
from support import sleeve
from support.window_case import WindowCase

FLAT = 1e-4  # metres: the height of a wave that is nothing but the root of a rounding
MOVES = 4  # events of the mouse in a stroke


class Painting(WindowCase):
    """The sleeve with a Wrinkle Field, seen from above."""

    def make(self, frame: int = 1) -> Iterator[float]:
        sleeve.scene(wrinkles=False)
        with sleeve.context():
            bpy.ops.object.rumple_add(method="FIELD")
            sleeve.at(frame)
        yield from self.look_down(Vector((0.25, 0.1, 0.0)))

    def look_down(self, at: Vector) -> Iterator[float]:
        areas = bpy.context.window_manager.windows[0].screen.areas
        self.view = max(areas, key=lambda a: a.width * a.height)
        self.view.type = "VIEW_3D"
        yield 0.2
        region = self.view.spaces.active.region_3d
        region.view_perspective, region.view_rotation = "ORTHO", (1.0, 0.0, 0.0, 0.0)
        region.view_location, region.view_distance = at, 0.6
        settings = bpy.context.scene.rumple_brush
        settings.radius, settings.strength = 60, 1.0
        with self.area():
            self.assertEqual(bpy.ops.object.rumple_brush(), {"FINISHED"})
        self.addCleanup(self.put_away)
        yield 0.3

    def put_away(self) -> None:
        """Its circle would stand in the pictures of other tests."""
        with self.area():
            bpy.ops.wm.tool_set_by_id(name="builtin.select_box")

    @property
    def obj(self) -> bpy.types.Object:
        """Looked up each time: undo makes another one."""
        return bpy.data.objects["Sleeve"]

    def painted(self) -> np.ndarray:
        found = self.obj.data.attributes.get(mesh_reader.REST_WRINKLE)
        return np.zeros((len(self.obj.data.vertices), 3)) if found is None else compat.read_attribute(found)

    def lengths(self) -> np.ndarray:
        return np.linalg.norm(self.painted(), axis=1)

    # ---- the hand
    def pixel(self, point: Vector) -> tuple[int, int]:
        """Of the window, where a point of the world is seen."""
        region = next(region for region in self.view.regions if region.type == "WINDOW")
        place = view3d_utils.location_3d_to_region_2d(region, self.view.spaces.active.region_3d, Vector(point))
        return int(region.x + place.x), int(region.y + place.y)

    def event(self, kind: str, value: str, pixel: tuple[int, int], **keys: bool) -> None:
        bpy.context.window_manager.windows[0].event_simulate(kind, value, x=pixel[0], y=pixel[1], **keys)

    def press(self, start: Vector, end: Vector, **keys: bool) -> Iterator[float]:
        """Everything of a stroke but its end."""
        ends = Vector(self.pixel(start)), Vector(self.pixel(end))
        here = self.pixel(start)
        self.event("MOUSEMOVE", "NOTHING", here, **keys)
        yield 0.05
        self.event("LEFTMOUSE", "PRESS", here, **keys)
        yield 0.05
        for step in range(1, MOVES + 1):
            here = tuple(int(c) for c in ends[0].lerp(ends[1], step / MOVES))
            self.event("MOUSEMOVE", "NOTHING", here, **keys)
            yield 0.02
        self.here = here

    def stroke(self, start: Vector, end: Vector, **keys: bool) -> Iterator[float]:
        yield from self.press(start, end, **keys)
        self.event("LEFTMOUSE", "RELEASE", self.here, **keys)
        yield 0.2

    # ---- what it does
    def test_folds_follow_the_hand_on_a_bent_arm_and_are_stored_at_rest(self) -> Iterator[float]:
        yield from self.make(frame=sleeve.LAST)
        # The lower arm has turned about z, at (0.3, 0): the stroke goes down its middle.
        angle = math.radians(100.0)
        along = Vector((math.cos(angle), math.sin(angle), 0.0))
        elbow = Vector((0.3, 0.0, 0.06))
        yield from self.stroke(elbow + 0.16 * along, elbow + 0.28 * along)
        painted, lengths = self.painted(), self.lengths()
        strong = np.flatnonzero(lengths > 0.3)
        self.assertGreater(len(strong), 6)
        rest = mesh_reader.rest_positions(self.obj, "REST_POSE", "")[strong]
        self.assertGreater(rest[:, 0].min(), 0.38)
        # At rest the lower arm lies along x: folds along it are stored as vectors across x.
        self.assertLess(np.abs(painted[strong, 0] / lengths[strong]).max(), 0.05)
        self.assertLess(lengths.max(), 1.0)

    def test_the_wrinkle_appears_along_the_stroke(self) -> Iterator[float]:
        yield from self.make()
        self.assertLess(sleeve.attribute(self.obj, "rumple_amplitude").max(), FLAT)
        yield from self.stroke(Vector((0.15, -0.03, 0.05)), Vector((0.45, 0.03, 0.05)))
        way = np.array((0.3, 0.06)) / math.hypot(0.3, 0.06)
        yield from self.until(lambda: sleeve.attribute(self.obj, "rumple_amplitude").max() > FLAT)
        count = len(self.obj.data.vertices)
        amplitude = sleeve.attribute(self.obj, "rumple_amplitude")[:count, 0]
        direction = sleeve.attribute(self.obj, "rumple_direction")[:count]
        lengths = self.lengths()
        self.assertTrue((amplitude[lengths == 0.0] < FLAT).all())
        # On top of the tube, where it is seen without foreshortening, waves stand across the stroke.
        top = (lengths > 0.3) & (mesh_reader.rest_positions(self.obj, "REST_POSE", "")[:, 2] > 0.055)
        self.assertGreater(top.sum(), 3)
        self.assertTrue((amplitude[top] > 10.0 * FLAT).all())
        self.assertLess(np.abs(direction[top, :2] @ way).max(), 0.1)
        self.assertEqual(self.obj.rumple.message, "")

    def test_the_folds_that_are_seen_run_as_they_were_painted(self) -> Iterator[float]:
        # By the picture alone: what paint changes in it has its steepest slope across the strokes.
        yield from self.make()
        self.obj.rumple.field.output, self.obj.rumple.field.wavelength = "GEOMETRY", 0.03
        bpy.context.scene.rumple_brush.show_overlay = False
        view = self.view.spaces.active
        view.overlay.show_outline_selected = view.overlay.show_cursor = view.overlay.show_object_origins = False
        view.region_3d.view_location, view.region_3d.view_distance = (0.3, 0.0, 0.0), 0.4
        away = Vector((0.3, -0.12, 0.0))
        self.event("MOUSEMOVE", "NOTHING", self.pixel(away))
        yield from self.until(lambda: len(sleeve.output_object(self.obj).data.vertices) > 1000)
        yield 0.5
        before = self.pixels().astype(float)
        for x in (0.24, 0.28, 0.32):
            yield from self.stroke(Vector((x, -0.045, 0.04)), Vector((x + 0.09, 0.045, 0.04)))
        self.event("MOUSEMOVE", "NOTHING", self.pixel(away))
        yield 0.5
        self.screenshot("brush_painted")
        (left, low), (right, high) = self.pixel(Vector((0.26, -0.03, 0.0))), self.pixel(Vector((0.38, 0.03, 0.0)))
        height = before.shape[0]
        change = (self.pixels() - before).mean(axis=2)[height - high:height - low, left:right]
        down, along = np.gradient(change)
        self.assertGreater(np.abs(change).mean(), 3.0)
        steepest = 0.5 * math.atan2(2.0 * (along * -down).mean(), (along**2 - down**2).mean())  # from x, upwards
        self.assertLess(abs(math.degrees(steepest) + 45.0), 15.0)

    def test_every_stroke_is_one_step_of_undo(self) -> Iterator[float]:
        yield from self.make()
        with self.area():
            bpy.ops.ed.undo_push(message="made")  # scripts leave no step
        yield from self.stroke(Vector((0.1, 0.0, 0.06)), Vector((0.2, 0.0, 0.06)))
        first = self.painted()
        yield from self.stroke(Vector((0.4, 0.0, 0.06)), Vector((0.5, 0.0, 0.06)))
        second = self.painted()
        self.assertFalse(np.array_equal(first, second))
        for expected, act in ((first, bpy.ops.ed.undo), (np.zeros_like(first), bpy.ops.ed.undo),
                              (first, bpy.ops.ed.redo), (second, bpy.ops.ed.redo)):
            with self.area():
                act()
            yield 0.4
            np.testing.assert_array_equal(self.painted(), expected)
        self.assertEqual(self.obj.rumple.message, "")
        yield from self.stroke(Vector((0.3, 0.0, 0.06)), Vector((0.4, 0.0, 0.06)))
        self.assertFalse(np.array_equal(self.painted(), second))

    def test_ctrl_erases_and_shift_smooths(self) -> Iterator[float]:
        yield from self.make()
        ends = Vector((0.15, 0.0, 0.06)), Vector((0.35, 0.0, 0.06))
        yield from self.stroke(*ends)
        lengths = self.lengths()
        bpy.context.scene.rumple_brush.radius = 120
        yield from self.stroke(*ends, shift=True)
        self.assertGreater(np.count_nonzero(self.lengths()), np.count_nonzero(lengths))
        self.assertLess(self.lengths().max(), lengths.max())
        bpy.context.scene.rumple_brush.radius, bpy.context.scene.rumple_brush.falloff = 250, "CONSTANT"
        yield from self.stroke(*ends, ctrl=True)
        rest = mesh_reader.rest_positions(self.obj, "REST_POSE", "")
        self.assertEqual(self.lengths()[rest[:, 2] > 0.01].max(), 0.0)

    def test_escape_takes_the_stroke_back(self) -> Iterator[float]:
        yield from self.make()
        for before in (None, 1):
            if before:
                yield from self.stroke(Vector((0.1, 0.0, 0.06)), Vector((0.2, 0.0, 0.06)))
            kept, had = self.painted(), mesh_reader.REST_WRINKLE in self.obj.data.attributes
            yield from self.press(Vector((0.15, 0.0, 0.06)), Vector((0.4, 0.0, 0.06)))
            self.assertFalse(np.array_equal(self.painted(), kept))
            self.event("ESC", "PRESS", self.here)
            yield 0.1
            self.event("ESC", "RELEASE", self.here)
            self.event("LEFTMOUSE", "RELEASE", self.here)
            yield 0.2
            np.testing.assert_array_equal(self.painted(), kept)
            self.assertEqual(mesh_reader.REST_WRINKLE in self.obj.data.attributes, had)

    def test_mirror(self) -> Iterator[float]:
        sleeve.empty_file()
        with sleeve.context():
            mesh = sleeve.tube()
            compat.set_positions(mesh, compat.positions(mesh) - np.float32((0.5 * sleeve.LENGTH, 0.0, 0.0)))
            mesh.update()
            obj = bpy.data.objects.new("Sleeve", mesh)
            bpy.context.scene.collection.objects.link(obj)
            obj.location, obj.rotation_euler, obj.scale = (0.1, 0.2, 0.0), (0.3, 0.0, 0.5), (1.2, 1.2, 1.2)
            sleeve.make_active(obj)
            bpy.ops.object.rumple_add(method="FIELD")
        world = obj.matrix_world.copy()
        yield from self.look_down(world.translation)
        bpy.context.scene.rumple_brush.mirror_x = True
        yield from self.stroke(world @ Vector((0.1, -0.02, 0.055)), world @ Vector((0.2, 0.03, 0.05)))
        rings = self.painted().reshape(sleeve.ALONG, sleeve.AROUND, 3)
        self.assertGreater(np.count_nonzero(self.lengths()), 12)
        # The middle of the stroke, in the object's own space: folds along it, so vectors across it.
        rest = mesh_reader.rest_positions(self.obj, "REST_POSE", "")
        middle = np.linalg.norm(rest - (0.15, 0.0, 0.06), axis=1).argmin()
        way = np.array((0.1, 0.05)) / math.hypot(0.1, 0.05)
        self.assertGreater(self.lengths()[middle], 0.3)
        self.assertLess(abs(self.painted()[middle, :2] @ way) / self.lengths()[middle], 0.15)
        image = rings[::-1] * (-1.0, 1.0, 1.0)
        apart = np.minimum(np.linalg.norm(rings - image, axis=2), np.linalg.norm(rings + image, axis=2))
        self.assertLess(apart[1:-1].max(), 1e-4)
        self.assertLess(apart.max(), 0.01)  # diagonals are not mirrored, so at the open ends neither are normals

    def test_what_is_painted_is_in_the_file(self) -> Iterator[float]:
        yield from self.make()
        yield from self.stroke(Vector((0.1, 0.0, 0.06)), Vector((0.4, 0.0, 0.06)))
        kept = self.painted()
        bpy.context.scene.rumple_brush.radius = 77
        path = os.path.join(os.environ["RUMPLE_OUT"], "painted.blend")
        with sleeve.context():
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
        yield 0.3
        np.testing.assert_array_equal(self.painted(), kept)
        self.assertEqual(bpy.context.scene.rumple_brush.radius, 77)
        yield from self.until(lambda: sleeve.attribute(self.obj, "rumple_amplitude").max() > FLAT)
        self.assertEqual(self.obj.rumple.message, "")
        yield from self.look_down(Vector((0.25, 0.1, 0.0)))
        yield from self.stroke(Vector((0.4, 0.0, 0.06)), Vector((0.5, 0.0, 0.06)))
        self.assertFalse(np.array_equal(self.painted(), kept))

    def test_f_changes_the_radius_and_shift_f_the_strength(self) -> Iterator[float]:
        yield from self.make()
        settings = bpy.context.scene.rumple_brush
        settings.strength = 0.5
        for keys, name in (({}, "radius"), ({"shift": True}, "strength")):
            before = getattr(settings, name)
            x, y = self.pixel(Vector((0.2, 0.0, 0.0)))
            self.event("MOUSEMOVE", "NOTHING", (x, y))
            yield 0.1
            self.event("F", "PRESS", (x, y), **keys)
            yield 0.1
            self.event("F", "RELEASE", (x, y), **keys)
            for step in range(1, 6):
                self.event("MOUSEMOVE", "NOTHING", (x + 8 * step, y))
                yield 0.05
            self.event("LEFTMOUSE", "PRESS", (x + 40, y))
            yield 0.05
            self.event("LEFTMOUSE", "RELEASE", (x + 40, y))
            yield 0.1
            self.assertGreater(getattr(settings, name), before)
        self.assertEqual(self.lengths().max(), 0.0)

    def test_a_direction_of_the_screen_does_not_ask_for_the_hand(self) -> Iterator[float]:
        yield from self.make()
        settings = bpy.context.scene.rumple_brush
        for direction, run, along in (("HORIZONTAL", "ALONG", 0), ("VERTICAL", "ALONG", 1), ("VERTICAL", "ACROSS", 0)):
            settings.direction, settings.run = direction, run
            yield from self.stroke(Vector((0.1, 0.0, 0.06)), Vector((0.3, 0.03, 0.06)))
            top = (self.lengths() > 0.3) & (mesh_reader.rest_positions(self.obj, "REST_POSE", "")[:, 2] > 0.055)
            self.assertGreater(top.sum(), 3)
            self.assertLess(np.abs(self.painted()[top, along]).max(), 0.05, (direction, run))
            with self.area():
                bpy.ops.object.rumple_clear_rest_wrinkles()

    def test_what_comes_from_elsewhere_is_refused_by_name_and_kept(self) -> Iterator[float]:
        yield from self.make()
        values = np.zeros((len(self.obj.data.vertices), 3), np.float32)
        values[7] = (0.0, 1.5, 0.0)
        compat.write_attribute(self.obj.data, mesh_reader.REST_WRINKLE, "FLOAT_VECTOR", "POINT", values)
        self.obj.data.update()
        yield from self.until(lambda: self.obj.rumple.message)
        self.assertIn("vertex 7 has length 1.5", self.obj.rumple.message)
        yield from self.stroke(Vector((0.1, 0.0, 0.06)), Vector((0.3, 0.03, 0.06)))
        np.testing.assert_array_equal(self.painted(), values)
        with self.area():
            bpy.ops.object.rumple_clear_rest_wrinkles()
        yield from self.until(lambda: not self.obj.rumple.message)
        self.assertEqual(self.obj.rumple.message, "")

    def test_without_a_wrinkle_field_nothing_is_painted(self) -> Iterator[float]:
        yield from self.make()
        with self.area():
            bpy.ops.object.rumple_remove()
        yield from self.stroke(Vector((0.1, 0.0, 0.06)), Vector((0.3, 0.0, 0.06)))
        self.assertNotIn(mesh_reader.REST_WRINKLE, self.obj.data.attributes)

    def test_the_overlay_is_drawn_on_the_bent_arm(self) -> Iterator[float]:
        yield from self.make(frame=12)
        yield from self.stroke(Vector((0.02, 0.0, 0.06)), Vector((0.3, 0.0, 0.06)))
        bpy.context.scene.rumple_brush.run = "ACROSS"
        yield from self.stroke(Vector((0.32, 0.02, 0.06)), Vector((0.4, 0.25, 0.06)))
        self.event("MOUSEMOVE", "NOTHING", self.pixel(Vector((0.1, 0.2, 0.0))))
        yield 0.3
        with_lines = self.pixels().astype(int)
        self.screenshot("brush_overlay")
        bpy.context.scene.rumple_brush.show_overlay = False
        yield 0.3
        without = self.pixels().astype(int)
        changed = np.abs(with_lines - without).max(axis=2) > 40
        self.assertGreater(changed.sum(), 300)
        bpy.context.scene.rumple_brush.show_overlay = True
        bpy.context.scene.rumple_brush.show_vectors = True
        yield 0.3
        self.screenshot("brush_vectors")
        self.assertGreater((np.abs(self.pixels().astype(int) - with_lines).max(axis=2) > 40).sum(), 300)
        self.assertEqual(runtimes.message(self.obj), "")
        self.assertTrue(brush_operators.refusal(None))
