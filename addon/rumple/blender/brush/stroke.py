# SPDX-License-Identifier: GPL-3.0-or-later
"""One stroke of the brush, from the press to the release."""
from __future__ import annotations

import math

import bpy
import numpy as np
from bpy_extras import view3d_utils
from mathutils import Vector

from ...core.systems.brush import SPACING, Hand, Place
from . import canvas as brush_canvas

_FIXED = {"HORIZONTAL": 0.0, "VERTICAL": 0.5 * math.pi}  # directions on the screen, radians


class Stroke:
    """Paints on an object while the mouse moves. All methods may raise UserError."""

    def __init__(self, obj: bpy.types.Object, brush: bpy.types.PropertyGroup, touch: str, region: bpy.types.Region,
                 view: bpy.types.RegionView3D, depsgraph: bpy.types.Depsgraph) -> None:
        """touch: PAINT, ERASE or SMOOTH. brush: RUMPLE_Brush."""
        self.canvas = brush_canvas.canvas_of(obj)
        self.canvas.pose(obj, depsgraph)
        self.mesh, self.brush, self.touch, self.region, self.view = obj.data, brush, touch, region, view
        self.before = brush_canvas.read(self.mesh)
        self.painted = np.zeros((len(self.mesh.vertices), 3), np.float32) if self.before is None else self.before.copy()
        self.changed = False
        self.hand = Hand(SPACING * brush.radius)

    def press(self, x: float, y: float, pressure: float) -> None:
        """Begin the stroke. x, y: pixels of the region. There is no direction before the mouse moves. If the brush
        needs none, the first dab is made at once."""
        place = self.hand.press(x, y, pressure)
        if self.touch != "PAINT" or self.brush.direction != "STROKE":
            self._set_down([place])

    def move(self, x: float, y: float, pressure: float) -> None:
        self._set_down(self.hand.move(x, y, pressure))

    def cancel(self) -> None:
        """Restore the values from before the stroke."""
        if self.changed:
            brush_canvas.write(self.mesh, self.before)

    def _set_down(self, places: list[Place]) -> None:
        painted = self.painted
        for place in places:
            painted = self._dab(painted, place)
        if np.array_equal(painted, self.painted):
            return
        self.painted, self.changed = painted, True
        brush_canvas.write(self.mesh, painted)

    def _dab(self, painted: np.ndarray, place: Place) -> np.ndarray:
        at = Vector((place.x, place.y))
        view = view3d_utils.region_2d_to_vector_3d(self.region, self.view, at)
        hit = self.canvas.hit(view3d_utils.region_2d_to_origin_3d(self.region, self.view, at), view)
        if hit is None:
            return painted
        centre, normal = hit
        brush = self.brush
        pixels = brush.radius * (place.pressure if brush.pressure_radius else 1.0)
        return self.canvas.easel.dab(
            painted, brush.mirror_x, touch=self.touch, centre=tuple(centre), normal=tuple(normal), view=tuple(view),
            direction=tuple(self._way(centre, at, self._direction(place))), across=brush.run == "ACROSS",
            radius=max(self._way(centre, at, Vector((pixels, 0.0))).length, 1e-6),
            strength=brush.strength * (min(place.pressure, 1.0) if brush.pressure_strength else 1.0),
            length=brush.length, falloff=brush.falloff)

    def _direction(self, place: Place) -> Vector:
        """The direction of the stroke or of the setting, in pixels. The vector is long, to lose less in single
        precision."""
        if self.brush.direction == "STROKE":
            return 100.0 * Vector((place.dx, place.dy))
        angle = _FIXED.get(self.brush.direction, self.brush.angle)
        return 100.0 * Vector((math.cos(angle), math.sin(angle)))

    def _way(self, centre: Vector, at: Vector, pixels: Vector) -> Vector:
        """A vector in pixels, converted to world space at the depth of a point, parallel to the screen."""
        start = view3d_utils.region_2d_to_location_3d(self.region, self.view, at, centre)
        return view3d_utils.region_2d_to_location_3d(self.region, self.view, at + pixels, centre) - start
