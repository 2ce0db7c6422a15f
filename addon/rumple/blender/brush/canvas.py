# SPDX-License-Identifier: GPL-3.0-or-later
"""The canvas of the brush: the Wrinkle Field of an object in its visible pose, and the painted attribute."""
from __future__ import annotations

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...core.base.wording import UserError
from ...core.systems.brush import Easel
from ...core.systems.wrinkle_field import WrinkleField
from .. import compat
from ..objects import incoming_mesh, mesh_reader, modifier, posed_coarse, runtimes, units


class Canvas:
    """An object that is painted on. It is kept between strokes, as long as the object has the same evaluator."""

    def __init__(self, field: WrinkleField) -> None:
        self.easel = Easel(field)
        self._tree: BVHTree | None = None

    def pose(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
        """Take the pose from this depsgraph. Raises UserError."""
        evaluated = obj.evaluated_get(depsgraph)
        count = len(obj.data.vertices)
        positions = posed_coarse.positions(obj, count, depsgraph)
        if positions is None:
            positions = mesh_reader.plain_positions(evaluated, count)
        if positions is None:
            raise UserError(f"{obj.name}: its wrinkles do not show: switch the modifier on in the viewport first")
        positions = self.easel.field.solved_over(units.frame_of(depsgraph.scene), positions)
        matrix = np.array(evaluated.matrix_world, np.float32)
        if self.easel.pose(positions @ matrix[:3, :3].T + matrix[:3, 3]):
            self._tree = None

    def hit(self, origin: Vector, direction: Vector) -> tuple[Vector, Vector] | None:
        """Where a ray hits the coarse mesh, and the normal of the triangle there; world space."""
        if self._tree is None:
            self._tree = BVHTree.FromPolygons(self.easel.positions.tolist(), self.easel.triangles().tolist(),
                                              all_triangles=True)
        place, normal, _index, _distance = self._tree.ray_cast(origin, direction)
        return None if place is None else (place, normal)


_last: Canvas | None = None


def canvas_of(obj: bpy.types.Object) -> Canvas:
    """The canvas of an object with a Wrinkle Field. Raises UserError."""
    global _last
    nodes_mod = modifier.find(obj)
    if nodes_mod is None or modifier.system(nodes_mod).method != "FIELD":
        raise UserError(f"{obj.name}: it has no Wrinkle Field to paint on: add one first")
    if modifier.is_baked(nodes_mod):
        raise UserError(f"{obj.name}: its wrinkles are baked: free the bake first")
    runtime = runtimes.known(obj)
    if runtime is None or not isinstance(runtime.evaluator, WrinkleField):
        raise UserError(runtimes.message(obj) or f"{obj.name}: nothing is solved yet: go to another frame first")
    if not incoming_mesh.is_own(obj):
        raise UserError(f"{obj.name}: a modifier above the wrinkles changes the number of vertices: apply it to "
                        "paint")
    if runtime.evaluator.coarse_count != len(obj.data.vertices):
        raise UserError(f"{obj.name}: its mesh was edited: wait a moment")
    if _last is None or _last.easel.field is not runtime.evaluator:
        _last = Canvas(runtime.evaluator)
    return _last


def forget() -> None:
    """Drop the canvas, after another file was opened or the add-on was disabled."""
    global _last
    _last = None


# ---------------------------------------------------------------- the painted attribute
def read(mesh: bpy.types.Mesh) -> np.ndarray | None:
    """The painted values of a coarse mesh, (n, 3) float32; None if it was never painted. Raises UserError."""
    found = mesh.attributes.get(mesh_reader.REST_WRINKLE)
    if found is None:
        return None
    if (found.domain, found.data_type) != ("POINT", "FLOAT_VECTOR"):
        raise UserError(f"{mesh.name}: its attribute \"{mesh_reader.REST_WRINKLE}\" is not a vector for each point: "
                        "rename it or remove it")
    return compat.read_attribute(found)


def write(mesh: bpy.types.Mesh, painted: np.ndarray | None) -> None:
    """Store painted values; None removes the attribute."""
    if painted is not None:
        compat.write_attribute(mesh, mesh_reader.REST_WRINKLE, "FLOAT_VECTOR", "POINT", painted)
    elif mesh_reader.REST_WRINKLE in mesh.attributes:
        mesh.attributes.remove(mesh.attributes[mesh_reader.REST_WRINKLE])
    mesh.update()
