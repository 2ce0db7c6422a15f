# SPDX-License-Identifier: GPL-3.0-or-later
"""A sleeve with a button: it is shown as it was modelled, on the cloth, live, baked and in every system."""
from __future__ import annotations

import os
import tempfile
import unittest

import bpy
import numpy as np
from support import sleeve

CUBE = np.array([(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)])
SIDE = 0.01


def add_button(mesh: bpy.types.Mesh) -> None:
    """On the inner side of the elbow, with the second material, numbers on its faces and a sharp edge."""
    vertices = [tuple(vertex.co) for vertex in mesh.vertices]
    quads = [tuple(polygon.vertices) for polygon in mesh.polygons]
    ring = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    for z in (-0.3, 0.3):
        vertices += [(0.5 * sleeve.LENGTH + SIDE * x, sleeve.RADIUS + 0.005 + SIDE * z, SIDE * y)
                     for x, y in ring[::-1]]
    quads += (len(vertices) - 8 + CUBE).tolist()
    mesh.clear_geometry()
    mesh.from_pydata(vertices, [], quads)
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", np.linspace(0.0, 1.0, 2 * len(mesh.loops)))
    mesh.polygons.foreach_set("material_index", np.repeat((0, 1), (len(quads) - 6, 6)))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(quads), bool))
    mesh.attributes.new("number", "INT", "FACE").data.foreach_set("value", np.arange(len(quads), dtype=np.int32))
    mesh.update()


def distances(points: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[:, None].astype(np.float64) - points[None], axis=2)


class Button:
    """What holds with every system. The last eight points shown are the button's."""

    method: str

    def setUp(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        mesh = obj.data
        add_button(mesh)
        bpy.data.objects.remove(obj)
        self.obj = sleeve.skinned(mesh, bpy.data.objects["Arm"])
        for settings in (self.obj.rumple.mesh, self.obj.rumple.field, self.obj.rumple.paths):
            settings.base_cloth = "HANG"
        sleeve.make_active(self.obj)
        bpy.ops.object.rumple_add(method=self.method)
        sleeve.play(1, 15)

    def animated(self) -> np.ndarray:
        """As the armature alone has it."""
        self.obj.modifiers[-1].show_viewport = False
        bpy.context.view_layer.update()
        found = sleeve.shown(self.obj)[-8:]
        self.obj.modifiers[-1].show_viewport = True
        bpy.context.view_layer.update()
        return found

    def test_it_keeps_its_shape_and_goes_with_the_cloth(self) -> None:
        found, animated = sleeve.shown(self.obj)[-8:], self.animated()
        np.testing.assert_allclose(distances(found), distances(animated), atol=1e-6)
        self.assertGreater(np.linalg.norm(found.mean(0) - animated.mean(0)), 0.0005)
        self.assertEqual(self.obj.rumple.message, "")

    def test_its_faces_are_those_that_were_modelled(self) -> None:
        mesh = sleeve.evaluated(self.obj).data
        first = len(self.obj.data.polygons) - 6
        last = [polygon for polygon in mesh.polygons][-6:]
        self.assertEqual([polygon.material_index for polygon in last], 6 * [1])
        self.assertTrue(all(polygon.use_smooth for polygon in last))
        np.testing.assert_array_equal(np.array([tuple(polygon.vertices) for polygon in last]),
                                      len(mesh.vertices) - 8 + CUBE)
        numbers = sleeve.attribute(self.obj, "number").ravel()
        np.testing.assert_array_equal(numbers[-6:], first + np.arange(6))
        uv = np.array([corner.uv for corner in mesh.uv_layers["UVMap"].data][-24:])
        np.testing.assert_allclose(uv, np.linspace(0.0, 1.0, 2 * len(self.obj.data.loops)).reshape(-1, 2)[-24:],
                                   atol=1e-6)

    def test_a_baked_clip_has_it(self) -> None:
        self.obj.rumple.viewport_steps = 2  # what is baked is the mesh of renders
        sleeve.play(1, 15)
        live = sleeve.shown(self.obj)
        with tempfile.TemporaryDirectory() as folder:
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "button.blend"))
            self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
            sleeve.at(4)
            sleeve.at(15)
            np.testing.assert_allclose(sleeve.shown(self.obj)[-8:], live[-8:], atol=2e-6)

    def test_as_cloth_it_is_subdivided(self) -> None:
        count = len(sleeve.shown(self.obj))
        getattr(self.obj.rumple, self.method.lower()).rigid_parts = False
        sleeve.play(1, 15)
        mesh = sleeve.evaluated(self.obj).data
        self.assertNotEqual(len(mesh.vertices), count)
        self.assertEqual(self.obj.rumple.message, "")


class MeshButton(Button, unittest.TestCase):
    method = "MESH"


class PathsButton(Button, unittest.TestCase):
    method = "PATHS"


class FieldButton(Button, unittest.TestCase):
    method = "FIELD"

    def setUp(self) -> None:
        super().setUp()
        self.obj.rumple.field.output = "GEOMETRY"
        sleeve.play(1, 15)
