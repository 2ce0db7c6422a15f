# SPDX-License-Identifier: GPL-3.0-or-later
"""Sleeves of cloth for the tests of the base cloth: over nothing, over a body, over one another."""
from __future__ import annotations

import math
import os
import tempfile
import unittest
from typing import Any, Iterable

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from rumple.blender.objects import runtimes
from support import sleeve

DEEPER = 1e-4  # metres that shown cloth may stand deeper inside the body than the bare garment


def hang(obj: bpy.types.Object, level: int = 1, **values: Any) -> bpy.types.Object:
    """Cloth in layers by one click, with some settings. It becomes the active object."""
    settings = obj.rumple.mesh
    settings.base_cloth, settings.layers = "HANG", "CLOTH"
    settings.density, settings.level, settings.display_steps = "LEVEL", level, 0
    for name, value in values.items():
        setattr(settings, name, value)
    sleeve.make_active(obj)
    bpy.ops.object.rumple_add(method="MESH")
    bpy.context.view_layer.update()
    return obj


def garment(**values: Any) -> bpy.types.Object:
    """A sleeve of cloth, over nothing."""
    obj = sleeve.scene(wrinkles=False)
    return hang(obj, **values)


def dressed(radius: float = 0.8, **values: Any) -> tuple[bpy.types.Object, bpy.types.Object]:
    """A sleeve of cloth and the body under it, that the first click finds."""
    obj = sleeve.scene(wrinkles=False)
    body = sleeve.under(obj, radius=radius)
    hang(obj, **values)
    assert obj.rumple.body == body
    return obj, body


def two() -> tuple[bpy.types.Object, bpy.types.Object]:
    """An outer and an inner garment, and a body under both. By the names the outer one would come first."""
    outer, body = dressed(0.7)
    inner = hang(sleeve.under(outer, "Undershirt", 0.85), room=0.02)
    inner.rumple.body, inner.rumple.body_collection = body, None
    outer.rumple.body = inner
    bpy.context.view_layer.update()
    return outer, inner


def bared(obj: bpy.types.Object) -> bpy.types.Object:
    """It shows the animated garment from now on: no cloth, no folds, no body."""
    settings = obj.rumple.mesh
    settings.base_cloth, settings.layers, settings.radius = "OFF", "ONE", 0.0
    obj.rumple.body = None
    return obj


def forget(obj: bpy.types.Object) -> None:
    sleeve.make_active(obj)
    bpy.ops.object.rumple_clear_frames()


def pictures(obj: bpy.types.Object, frames: Iterable[float]) -> dict[float, np.ndarray]:
    """What is shown at these times, one after the other."""
    found = {}
    for frame in frames:
        whole = math.floor(frame)
        sleeve.at(whole, frame - whole)
        found[frame] = sleeve.shown(obj)
    return found


def played(obj: bpy.types.Object, last: int = sleeve.LAST) -> dict[float, np.ndarray]:
    return pictures(obj, range(1, last + 1))


def off_animation(obj: bpy.types.Object) -> float:
    """Farthest way of the base cloth from the animated mesh, metres."""
    runtime = runtimes.of(obj)
    cloth = runtime.evaluator.state_of(runtime.inputs.frame).cloth
    return float(np.linalg.norm(cloth.positions - runtime.inputs.positions, axis=1).max())


def final(obj: bpy.types.Object, frame: float) -> bool:
    return runtimes.of(obj).evaluator.frame_cache.get(frame).final


def difference(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.linalg.norm(one - other, axis=1).max())


def depth(body: bpy.types.Object, positions: np.ndarray) -> float:
    """How deep the deepest of some positions is inside the body, metres; 0 where all are outside."""
    mesh = sleeve.evaluated(body).data
    tree = BVHTree.FromPolygons([vertex.co.copy() for vertex in mesh.vertices],
                                [tuple(polygon.vertices) for polygon in mesh.polygons])
    deepest = 0.0
    for position in map(Vector, positions):
        nearest = tree.find_nearest(position)[0]
        # At an edge one face alone may look the other way: the sum of all that meet there does not.
        normal = sum((face[1] for face in tree.find_nearest_range(nearest, 1e-6)), Vector())
        if (nearest - position).dot(normal) > 0.0:
            deepest = max(deepest, (nearest - position).length)
    return deepest


def depths(obj: bpy.types.Object, body: bpy.types.Object, frames: Iterable[float]) -> dict[float, float]:
    """depth() of what is shown at these times, one after the other."""
    return {frame: depth(body, pictures(obj, (frame,))[frame]) for frame in frames}


class Cloth(unittest.TestCase):

    def check_no_deeper(self, found: dict[float, float], bare: dict[float, float], message: object = "") -> None:
        """depths() of what was shown and of the bare garment."""
        for frame, deep in found.items():
            self.assertLess(deep, DEEPER + bare[frame], f"{message}, frame {frame}")

    def same(self, one: dict[float, np.ndarray], other: dict[float, np.ndarray]) -> None:
        """At the times that both have."""
        both = one.keys() & other.keys()
        self.assertTrue(both)
        for frame in both:
            np.testing.assert_array_equal(one[frame], other[frame], f"frame {frame}")

    def saved(self) -> str:
        """The file, in a folder that goes with the test."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = os.path.join(folder.name, "scene.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        return path
