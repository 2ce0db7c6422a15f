# SPDX-License-Identifier: GPL-3.0-or-later
"""A sleeve that is worn over a body, for tests of bodies."""
from __future__ import annotations

import unittest

import bpy
import numpy as np
from rumple.blender.objects import runtimes
from rumple.core.mesh.body import Body
from support import sleeve


def placed(obj: bpy.types.Object, place: tuple, turn: tuple, scale: tuple) -> None:
    obj.location, obj.rotation_euler, obj.scale = place, turn, scale


def solved_body(obj: bpy.types.Object) -> Body | None:
    """What the garment was solved for last."""
    return runtimes.of(obj).inputs.body


def posed(body: bpy.types.Object) -> np.ndarray:
    """World space, as the viewport shows it, (n, 3)."""
    matrix = np.array(sleeve.evaluated(body).matrix_world)
    return sleeve.shown(body) @ matrix[:3, :3].T + matrix[:3, 3]


def outward(body: Body) -> float:
    """Volume inside the triangles, positive where they are counter-clockwise seen from outside."""
    a, b, c = (body.positions[body.triangles[:, corner]].astype(float) for corner in range(3))
    middle = body.positions.mean(axis=0)
    return float(np.einsum("ij,ij->i", a - middle, np.cross(b - middle, c - middle)).sum() / 6.0)


class Worn(unittest.TestCase):

    def setUp(self) -> None:
        self.obj = sleeve.scene()
        self.body = sleeve.under(self.obj)

    def check_place(self, frame: int, message: str = "") -> None:
        sleeve.at(frame)
        world = np.array(sleeve.evaluated(self.obj).matrix_world)
        found = solved_body(self.obj)
        np.testing.assert_allclose(found.positions @ world[:3, :3].T + world[:3, 3], posed(self.body), atol=2e-6,
                                   err_msg=message)
