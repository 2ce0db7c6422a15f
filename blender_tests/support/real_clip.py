# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments of a real scene with a Wrinkle Mesh alone, and what is measured in each frame, for the real suite."""
from __future__ import annotations

import hashlib
from dataclasses import dataclass

import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.objects import properties, runtimes
from rumple.core.frame import engine

from .real_garment import DATA


@dataclass
class Seen:
    """What was seen and measured at one frame."""

    frame: int
    message: str
    vertices: int
    finite: bool
    digest: str  # of the shown positions, all bits
    off_solved: float  # object units: largest distance of a shown point from where it was solved
    spike: float  # largest shown edge over the same edge unwrinkled, or at rest
    attachment_violation: float
    compressed_area_before: float
    compressed_area_after: float
    edge_error_before_rms: float
    edge_error_after_rms: float
    largest_offset: float
    largest_offset_change: float  # from the frame before, in the triangle's frame, object units


def digest(positions: np.ndarray) -> str:
    return hashlib.blake2b(positions.tobytes(), digest_size=16).hexdigest()


def add_wrinkles(garment: bpy.types.Object) -> None:
    """The fine mesh alone, as in the paper: test_real_cloth.py plays garments as cloth over their bodies."""
    bpy.context.view_layer.objects.active = garment
    garment.rumple.mesh.base_cloth = "OFF"
    garment.rumple.body = None  # set: none is looked for
    garment.rumple.viewport_steps = garment.rumple.mesh.display_steps  # the mesh of renders is measured
    assert bpy.ops.object.rumple_add(method="MESH") == {"FINISHED"}, garment.rumple.message


class Clip:
    """Garments of one file, wrinkled and ready to play; the first one is measured."""

    def __init__(self, file: str, *garments: str) -> None:
        bpy.ops.wm.open_mainfile(filepath=str(DATA / f"{file}.blend"))
        self.scene = bpy.context.scene
        self.garments = [bpy.data.objects[name] for name in garments]
        self.garment = self.garments[0]
        for other in bpy.data.objects:  # bodies and lights do not matter here, and cost time
            collides = "COLLISION" in {m.type for m in other.modifiers}
            if other.type == "MESH" and other not in self.garments and not collides:
                other.hide_viewport = True
        self.frames = range(self.scene.frame_start, self.scene.frame_end + 1)
        self.scene.frame_set(self.frames[0])
        for garment in self.garments:
            add_wrinkles(garment)
        self.fine = runtimes.of(self.garment).evaluator
        self.edges = sides(self.fine.polygon_start, self.fine.corner_vertex)
        self.rest_lengths = self.lengths(self.fine.positions_rest)
        self.offsets: np.ndarray | None = None

    def show(self, frame: int, garment: bpy.types.Object | None = None) -> np.ndarray:
        """Positions that Blender shows at a frame, (d, 3)."""
        self.scene.frame_set(frame)
        return self.shown(garment or self.garment)

    def shown(self, garment: bpy.types.Object) -> np.ndarray:
        return compat.positions(garment.evaluated_get(bpy.context.evaluated_depsgraph_get()).data)

    def lengths(self, positions: np.ndarray) -> np.ndarray:
        return np.linalg.norm(positions[self.edges[:, 0]] - positions[self.edges[:, 1]], axis=1)

    def spike(self, shown: np.ndarray, picture: engine.FrameResult) -> float:
        unwrinkled = self.lengths(shown - picture.offset)
        allowed = np.maximum(np.maximum(unwrinkled, self.rest_lengths), 0.5 * self.rest_lengths.mean())
        return float((self.lengths(shown) / allowed).max())

    def look(self, frame: int) -> Seen:
        """Show a frame and measure it."""
        shown = self.show(frame)
        runtime = runtimes.of(self.garment)
        found = self.fine.measure_frame(float(frame), runtime.inputs.positions,
                                        properties.settings_of(self.garment, self.scene))
        former, self.offsets = self.offsets, np.array(found.offsets)
        change = 0.0 if former is None else float(np.linalg.norm(self.offsets - former, axis=1).max())
        return Seen(frame, self.garment.rumple.message, len(shown), bool(np.isfinite(shown).all()), digest(shown),
                    float(np.abs(shown - runtime.result.positions).max()), self.spike(shown, runtime.result),
                    found.attachment_violation, found.compressed_area_before, found.compressed_area_after,
                    found.edge_error_before_rms, found.edge_error_after_rms, found.largest_offset, change)

    def play(self) -> list[Seen]:
        return [self.look(frame) for frame in self.frames]

    def hold_from(self, frame: int) -> None:
        """Every animation curve keeps its value from this frame on."""
        users = (block.animation_data for block in (*bpy.data.objects, *bpy.data.shape_keys))
        for user in filter(None, users):
            for curve in compat.keyed_curves(user):
                flat = np.empty(2 * len(curve.keyframe_points), np.float32)
                curve.keyframe_points.foreach_get("co", flat)
                flat[1::2][flat[::2] > frame] = curve.evaluate(frame)
                curve.keyframe_points.foreach_set("co", flat)
                curve.update()


def sides(polygon_start: np.ndarray, corner_vertex: np.ndarray) -> np.ndarray:
    """The sides of all polygons, (c, 2)."""
    following = np.arange(1, len(corner_vertex) + 1)
    following[polygon_start[1:] - 1] = polygon_start[:-1]
    return np.stack([corner_vertex, corner_vertex[following]], axis=1)
