# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's attribute rest_position on a wrinkled garment: hair curves that grow on it follow, and materials find
it."""
from __future__ import annotations

import unittest

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree
from rumple.blender import compat
from rumple.blender.objects import modifier, rest_position
from support import sleeve

HAIRS, POINTS = 12, 3


def rest_positions(obj: bpy.types.Object) -> np.ndarray:
    return sleeve.attribute(obj, rest_position.NAME)


def fur(obj: bpy.types.Object) -> bpy.types.Object:
    """Hair curves on some of its faces, deformed by Blender's node."""
    curves = bpy.data.hair_curves.new("Fur")
    curves.add_curves([POINTS] * HAIRS)
    curves.surface, curves.surface_uv_map = obj, "UVMap"
    mesh, uv = obj.data, compat.uv_values(obj.data.uv_layers["UVMap"])
    faces = [mesh.polygons[40 + 11 * hair] for hair in range(HAIRS)]
    places = np.array([face.center + face.normal * 0.01 * point for face in faces for point in range(POINTS)])
    curves.attributes["position"].data.foreach_set("vector", np.ascontiguousarray(places, np.float32).ravel())
    roots = np.array([uv[list(face.loop_indices)].mean(axis=0) for face in faces], np.float32)
    curves.attributes.new("surface_uv_coordinate", "FLOAT2", "CURVE").data.foreach_set("vector", roots.ravel())
    grown = bpy.data.objects.new("Fur", curves)
    bpy.context.scene.collection.objects.link(grown)
    grown.parent = obj
    group = bpy.data.node_groups.new("Deform", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        compat.new_group_socket(group, "Geometry", way, "NodeSocketGeometry")
    row = [group.nodes.new(kind) for kind in ("NodeGroupInput", "GeometryNodeDeformCurvesOnSurface", "NodeGroupOutput")]
    for before, after in zip(row, row[1:]):
        group.links.new(before.outputs[0], after.inputs[0])
    grown.modifiers.new("Deform", "NODES").node_group = group
    return grown


class RestPosition(unittest.TestCase):
    """Blender adds it before the first modifier, to the mesh that the wrinkles replace: it was lost."""

    def check(self, obj: bpy.types.Object) -> None:
        """It is that of the coarse mesh, under each point that is shown."""
        mesh = modifier.output_object(modifier.find(obj)).data
        corners = [compat.read_attribute(mesh.attributes[f"rumple_corner_{k}"])[:, 0] for k in range(3)]
        places = compat.read_attribute(mesh.attributes["rumple_barycentric"])[:, :2]
        weights = np.c_[1.0 - places.sum(axis=1), places]
        coarse = compat.positions(obj.data)
        expected = sum(weights[:, k, None] * coarse[corners[k]] for k in range(3))
        np.testing.assert_allclose(rest_positions(obj), expected, atol=1e-6)

    @unittest.skipUnless(bpy.app.version >= (4, 0, 0), "scripts cannot make hair curves in this Blender")
    def test_hair_curves_follow_the_folds(self) -> None:
        """Their node needs it, and left them where they grew: 15 cm beside the bent sleeve."""
        obj = sleeve.scene()
        grown = fur(obj)
        obj.add_rest_position_attribute = True  # as Blender does when it adds hair curves
        bpy.context.view_layer.update()
        sleeve.play()
        places = compat.read_attribute(sleeve.evaluated(grown).data.attributes["position"]).reshape(HAIRS, POINTS, 3)
        shown = sleeve.evaluated(obj).data
        tree = BVHTree.FromPolygons([v.co for v in shown.vertices], [tuple(p.vertices) for p in shown.polygons])
        self.assertLess(max(tree.find_nearest(tuple(root))[3] for root in places[:, 0]), 1e-5)
        self.assertGreater(np.abs(places[:, 0, 1]).max(), 0.2)

    def test_it_comes_and_goes_with_its_switch(self) -> None:
        obj = sleeve.scene()
        sleeve.play()
        seen = sleeve.shown(obj)
        for wanted in (True, False, True):
            obj.add_rest_position_attribute = wanted
            bpy.context.view_layer.update()
            sleeve.at(19)
            sleeve.at(20)
            self.assertEqual(rest_position.NAME in sleeve.evaluated(obj).data.attributes, wanted)
            np.testing.assert_array_equal(sleeve.shown(obj), seen)
        self.check(obj)

    def test_it_is_of_the_mesh_that_was_edited(self) -> None:
        obj = sleeve.scene()
        obj.add_rest_position_attribute = True
        sleeve.at(3)
        self.check(obj)
        for vertex in obj.data.vertices:
            vertex.co.x *= 1.25
        obj.data.update()
        sleeve.at(4)
        sleeve.at(5)
        self.assertGreater(rest_positions(obj)[:, 0].max(), 1.2 * sleeve.LENGTH)
        self.check(obj)

    def test_a_captured_rest_shape_is_another_thing(self) -> None:
        """The output mesh itself stands in that shape."""
        obj = sleeve.scene()
        obj.add_rest_position_attribute = True
        bpy.ops.object.rumple_capture_rest(frame=15)
        sleeve.play(1, 4)
        self.check(obj)

    def test_a_baked_clip_has_it_and_the_clip_stays(self) -> None:
        obj = sleeve.scene()
        bpy.ops.object.rumple_bake()
        obj.add_rest_position_attribute = True
        bpy.context.view_layer.update()
        sleeve.at(9)
        self.check(obj)
        self.assertTrue(modifier.plays_clip(modifier.find(obj)))
        self.assertEqual(obj.rumple.message, "")

    def test_an_attribute_of_that_name_is_carried_as_others(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        values = np.full((len(obj.data.vertices), 3), 0.5, np.float32)
        compat.write_attribute(obj.data, rest_position.NAME, "FLOAT_VECTOR", "POINT", values)
        obj.add_rest_position_attribute = True
        bpy.ops.object.rumple_add(method="MESH")
        sleeve.play(1, 4)
        np.testing.assert_array_equal(rest_positions(obj), 0.5)
