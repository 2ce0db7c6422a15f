# SPDX-License-Identifier: GPL-3.0-or-later
"""Edge creases and sharp edges of a garment, as Blender's own Subdivision has them."""
from __future__ import annotations

import unittest

import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.objects import mesh_reader, runtimes
from rumple.core.settings.system_settings import MeshSettings
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from support import sleeve

LEVELS = 2
ROUNDING = 1e-4  # a wave is as high as the root of what its cloth is squeezed by: a rounding of that is seen
FINEST = 6  # quality of Blender's limit: levels that creases are followed for


def crease(mesh: bpy.types.Mesh, ring: int, value: float) -> np.ndarray:
    """The edges of one ring of the tube; their number."""
    pairs = np.array([edge.vertices[:] for edge in mesh.edges])
    creased = (pairs // sleeve.AROUND == ring).all(1)
    values = compat.edge_creases(mesh)
    values[creased] = value
    compat.set_edge_marks(mesh, {"crease": values})
    return creased


def widen(mesh: bpy.types.Mesh, ring: int) -> None:
    """One ring of the tube becomes a rim."""
    for vertex in mesh.vertices:
        if vertex.index // sleeve.AROUND == ring:
            vertex.co.yz *= 1.4


def by_blender(mesh: bpy.types.Mesh, limit: bool) -> np.ndarray:
    """Points of the same mesh under Blender's Subdivision."""
    obj = bpy.data.objects.new("Blender", mesh)
    bpy.context.scene.collection.objects.link(obj)
    subdivision = obj.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels, subdivision.quality = LEVELS, FINEST
    subdivision.use_limit_surface, subdivision.boundary_smooth = limit, "PRESERVE_CORNERS"
    found = compat.positions(sleeve.evaluated(obj).data).copy()
    bpy.data.objects.remove(obj)
    return found


def by_rumple(obj: bpy.types.Object) -> np.ndarray:
    """Points of the fine mesh at rest."""
    settings = MeshSettings(density="LEVEL", level=LEVELS, display_steps=0)
    return WrinkleMesh.build(mesh_reader.base_mesh(obj, "REST_POSE", ""), settings).positions_rest


def farthest(one: np.ndarray, other: np.ndarray) -> float:
    """Of the points of two meshes in any order: how far each has its nearest."""
    distance = np.linalg.norm(one[:, None].astype(np.float64) - other[None], axis=2)
    return float(max(distance.min(0).max(), distance.min(1).max()))


class AsBlenderHasThem(unittest.TestCase):
    def setUp(self) -> None:
        self.obj = sleeve.scene(wrinkles=False)
        self.obj.modifiers.clear()
        for vertex in self.obj.data.vertices:  # round what rings are rounded to
            ring = vertex.index // sleeve.AROUND
            vertex.co.yz *= 1.0 + 0.3 * (ring % 2)

    def test_at_the_limit_to_rounding(self) -> None:
        without = by_rumple(self.obj)
        for value in (0.0, 0.2, 0.45, 0.6, 1.0):
            with self.subTest(value):
                crease(self.obj.data, 5, value)
                crease(self.obj.data, 8, 0.5 * value)
                ours = by_rumple(self.obj)
                self.assertLess(farthest(ours, by_blender(self.obj.data, True)), 2e-6)
                if value > 0.0:
                    self.assertGreater(farthest(ours, without), 1e-3)

    def test_a_cube_of_sharp_edges_stays_the_cube(self) -> None:
        bpy.ops.mesh.primitive_cube_add(size=0.2)
        cube = bpy.context.object
        compat.set_edge_marks(cube.data, {"crease": np.ones(12, np.float32)})
        sleeve.make_active(cube)
        cube.rumple.mesh.density, cube.rumple.mesh.level = "LEVEL", LEVELS
        for method in ("MESH", "FIELD", "PATHS"):
            with self.subTest(method):
                cube.rumple.field.output = "GEOMETRY"
                bpy.ops.object.rumple_add(method=method)
                found = sleeve.shown(cube)
                self.assertGreater(len(found), 8)
                self.assertLess(np.abs(np.abs(found).max(1) - 0.1).max(), ROUNDING)
                bpy.ops.object.rumple_remove()


class Live(unittest.TestCase):
    def test_a_new_crease_is_taken_at_once(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        widen(obj.data, 6)
        obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", LEVELS, 0
        bpy.ops.object.rumple_add(method="MESH")
        sleeve.at(1)
        before = sleeve.shown(obj)
        former = runtimes.of(obj).evaluator
        crease(obj.data, 6, 1.0)
        obj.data.update_tag()
        bpy.context.view_layer.update()
        sleeve.at(2)
        sleeve.at(1)
        self.assertIsNot(runtimes.of(obj).evaluator, former)
        self.assertGreater(np.abs(sleeve.shown(obj) - before).max(), 1e-4)
        crease(obj.data, 6, 0.0)
        obj.data.update_tag()
        bpy.context.view_layer.update()
        sleeve.at(2)
        sleeve.at(1)
        np.testing.assert_allclose(sleeve.shown(obj), before, atol=1e-6)

    def test_behind_a_mirror(self) -> None:
        """A modifier in front makes the mesh that is read."""
        obj = sleeve.scene(wrinkles=False)
        crease(obj.data, 6, 1.0)
        mirror = obj.modifiers.new("Mirror", "MIRROR")
        mirror.use_axis = (True, False, False)
        sleeve.make_active(obj)
        bpy.ops.object.modifier_move_to_index(modifier=mirror.name, index=0)
        bpy.ops.object.rumple_add(method="MESH")
        base = mesh_reader.base_mesh(obj, "REST_POSE", "")
        self.assertEqual(len(base.crease_edge), 2 * sleeve.AROUND)
        np.testing.assert_array_equal(base.crease_sharpness, 10.0)
        self.assertEqual(obj.rumple.message, "")


class SharpEdges(unittest.TestCase):
    """Marked edges have a normal for each of their sides."""

    def normals(self, mesh: bpy.types.Mesh) -> np.ndarray:
        if compat.HAS_AUTO_SMOOTH:
            mesh.calc_normals_split()
            flat = np.empty(3 * len(mesh.loops), np.float32)
            mesh.loops.foreach_get("normal", flat)
        else:
            flat = np.empty(3 * len(mesh.loops), np.float32)
            mesh.corner_normals.foreach_get("vector", flat)
        return flat.reshape(-1, 3)

    def split_at(self, obj: bpy.types.Object) -> np.ndarray:
        """x of the shown vertices whose corners have several normals."""
        mesh = sleeve.evaluated(obj).data
        vertex = np.empty(len(mesh.loops), np.int32)
        mesh.loops.foreach_get("vertex_index", vertex)
        normals = self.normals(mesh)
        first = np.zeros((len(mesh.vertices), 3), np.float32)
        first[vertex[::-1]] = normals[::-1]
        split = np.unique(vertex[np.abs(normals - first[vertex]).max(1) > 0.05])
        return compat.positions(mesh)[split, 0]

    def test_they_keep_split_normals(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        mesh = obj.data
        creased = crease(mesh, 6, 1.0)
        widen(mesh, 6)
        for index in np.flatnonzero(creased):
            mesh.edges[int(index)].use_edge_sharp = True
        if compat.HAS_AUTO_SMOOTH:
            mesh.use_auto_smooth, mesh.auto_smooth_angle = True, np.pi
        for method in ("MESH", "FIELD", "PATHS"):
            with self.subTest(method):
                obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 1, 1
                obj.rumple.field.output = "GEOMETRY"
                sleeve.make_active(obj)
                bpy.ops.object.rumple_add(method=method)
                sleeve.at(1)
                split = self.split_at(obj)
                self.assertGreaterEqual(len(split), 2 * sleeve.AROUND)
                np.testing.assert_allclose(split, sleeve.LENGTH * 6 / (sleeve.ALONG - 1), atol=0.01)
                bpy.ops.object.rumple_remove()


if __name__ == "__main__":
    unittest.main()
