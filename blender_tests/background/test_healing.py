# SPDX-License-Identifier: GPL-3.0-or-later
"""A garment with every fault that a mesh can have: from the first click to the render as one without."""
from __future__ import annotations

import unittest

import bpy
import numpy as np
from rumple.blender.objects import modifier, output_mesh, runtimes
from support import sleeve


def break_mesh(mesh: bpy.types.Mesh) -> None:
    """Turned faces, faces that lie on others (one the other way round), a flap on a ring of edges, a wire, a loose
    vertex. With the sleeve's UV map, materials and numbers on the faces."""
    vertices = [tuple(vertex.co) for vertex in mesh.vertices]
    quads = [tuple(polygon.vertices) for polygon in mesh.polygons]
    for face in (3, 40, 77):
        quads[face] = quads[face][::-1]
    quads += [quads[60], quads[61][::-1]]
    ring = [quads[5 * sleeve.AROUND + i][0] for i in range(sleeve.AROUND)]
    first = len(vertices)
    vertices += [(x, 1.6 * y, 1.6 * z) for x, y, z in (vertices[v] for v in ring)]
    for i in range(sleeve.AROUND):
        j = (i + 1) % sleeve.AROUND
        quads.append((ring[i], ring[j], first + j, first + i))
    vertices += [(0.0, 0.0, 0.0), (0.1, 0.0, 0.0)]
    mesh.clear_geometry()
    mesh.from_pydata(vertices, [(len(vertices) - 2, 0)], quads)
    mesh.uv_layers.new(name="UVMap")
    uv = np.array([vertices[loop.vertex_index][:2] for loop in mesh.loops], np.float32)
    mesh.uv_layers["UVMap"].data.foreach_set("uv", uv.ravel())
    mesh.polygons.foreach_set("material_index", np.arange(len(quads), dtype=np.int32) % 2)
    number = mesh.attributes.new("number", "INT", "FACE")
    number.data.foreach_set("value", np.arange(len(quads), dtype=np.int32))
    mesh.update()


class Broken:
    """What holds with every system."""

    method: str

    def setUp(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        mesh = obj.data
        break_mesh(mesh)
        self.faces = len(mesh.polygons)
        bpy.data.objects.remove(obj)
        self.obj = sleeve.skinned(mesh, bpy.data.objects["Arm"])
        sleeve.make_active(self.obj)
        bpy.ops.object.rumple_add(method=self.method)
        bpy.context.view_layer.update()

    def evaluated(self) -> bpy.types.Mesh:
        return self.obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data

    def test_it_plays_and_shows_every_face(self) -> None:
        sleeve.play(1, 6)
        self.assertEqual(self.obj.rumple.message, "")
        mesh = self.evaluated()
        self.assertTrue(np.isfinite(sleeve.shown(self.obj)).all())
        numbers = np.empty(len(mesh.polygons), np.int32)
        mesh.attributes["number"].data.foreach_get("value", numbers)
        self.assertEqual(sorted(set(numbers.tolist())), list(range(self.faces)))
        slots = np.empty(len(mesh.polygons), np.int32)
        mesh.polygons.foreach_get("material_index", slots)
        np.testing.assert_array_equal(slots, numbers % 2)

    def test_every_face_keeps_its_own_texture(self) -> None:
        """At rest, where the shown mesh is the bare one, the UV map of every corner is where that corner is. The fine
        mesh may round the tube: by less than a centimetre."""
        bpy.data.objects["Arm"].data.pose_position = "REST"
        sleeve.at(1)
        mesh = self.evaluated()
        uv = np.empty(len(mesh.loops) * 2, np.float32)
        mesh.uv_layers["UVMap"].data.foreach_get("uv", uv)
        where = np.array([mesh.vertices[loop.vertex_index].co[:2] for loop in mesh.loops])
        self.assertLess(np.abs(uv.reshape(-1, 2) - where).max(), 0.01)

    def test_what_was_healed_is_said_and_can_be_selected(self) -> None:
        origin = runtimes.of(self.obj).evaluator.base.origin
        self.assertEqual(origin.kinds(), ["turned", "cut", "doubled"])
        bpy.ops.object.rumple_select_healed(kind="turned")
        self.assertEqual(self.obj.mode, "EDIT")
        bpy.ops.object.mode_set(mode="OBJECT")
        chosen = [polygon.index for polygon in self.obj.data.polygons if polygon.select]
        self.assertTrue({3, 40, 77} <= set(chosen), chosen)
        bpy.ops.object.rumple_select_healed(kind="cut")
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assertEqual(sum(edge.select for edge in self.obj.data.edges), sleeve.AROUND)
        bpy.ops.mesh.primitive_cube_add()
        with self.assertRaises(RuntimeError):
            bpy.ops.object.rumple_select_healed(kind="cut")

    def test_the_output_mesh_is_known_again_and_frames_are_replayed(self) -> None:
        sleeve.play(1, 3)
        before = sleeve.shown(self.obj)
        fine = runtimes.of(self.obj).evaluator
        output = modifier.output_object(modifier.find(self.obj)).data
        self.assertTrue(output_mesh.is_embedding_of(output, fine))
        sleeve.at(3)
        np.testing.assert_array_equal(sleeve.shown(self.obj), before)


class BrokenMesh(Broken, unittest.TestCase):
    method = "MESH"


class BrokenField(Broken, unittest.TestCase):
    method = "FIELD"


class BrokenPaths(Broken, unittest.TestCase):
    method = "PATHS"


if __name__ == "__main__":
    unittest.main()
