# SPDX-License-Identifier: GPL-3.0-or-later
"""What the fine mesh inherits from the coarse one."""
from __future__ import annotations

import os
import tempfile
import unittest

import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.frame import rebuild
from rumple.blender.objects import evaluator, mesh_reader, modifier, output_mesh, runtimes
from support import sleeve


class Carrying(unittest.TestCase):

    def test_materials_by_face(self) -> None:
        obj = sleeve.scene()
        mesh = sleeve.evaluated(obj).data
        self.assertEqual([m.name for m in mesh.materials], ["Outside", "Cuff"])
        indices = np.empty(len(mesh.polygons), np.int32)
        mesh.polygons.foreach_get("material_index", indices)
        coarse = np.empty(len(obj.data.polygons), np.int32)
        obj.data.polygons.foreach_get("material_index", coarse)
        np.testing.assert_array_equal(indices, coarse[runtimes.of(obj).evaluator.polygon_parent])

    def test_a_changed_material_is_carried_again(self) -> None:
        obj = sleeve.scene()
        obj.data.materials[0] = bpy.data.materials.new("Other")
        obj.data.update_tag()
        bpy.context.view_layer.update()
        self.assertEqual([m.name for m in sleeve.evaluated(obj).data.materials], ["Other", "Cuff"])

    def test_slots_linked_to_the_object(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        obj.material_slots[0].link = "OBJECT"
        obj.material_slots[0].material = bpy.data.materials.new("OfObject")
        bpy.ops.object.rumple_add(method="MESH")
        self.assertEqual(sleeve.output_object(obj).data.materials[0].name, "OfObject")

    def test_smooth_shading(self) -> None:
        obj = sleeve.scene()
        self.assertTrue(all(polygon.use_smooth for polygon in sleeve.evaluated(obj).data.polygons))

    @unittest.skipUnless(compat.HAS_AUTO_SMOOTH, "Auto Smooth is a modifier from Blender 4.1 on")
    def test_custom_normals_switch_off_the_angle_of_auto_smooth(self) -> None:
        """They are not carried. With the angle alone, skin of an import from glTF was full of flat faces."""
        obj = sleeve.scene(wrinkles=False)
        mesh = obj.data
        mesh.use_auto_smooth, mesh.auto_smooth_angle = True, 0.2
        for custom, angle in ((False, 0.2), (True, np.pi)):
            if custom:
                mesh.normals_split_custom_set_from_vertices([vertex.normal for vertex in mesh.vertices])
            sleeve.make_active(obj)
            bpy.ops.object.rumple_add(method="MESH")
            shown = modifier.output_object(modifier.find(obj)).data
            self.assertTrue(shown.use_auto_smooth)
            self.assertAlmostEqual(shown.auto_smooth_angle, angle, places=5)
            bpy.ops.object.rumple_remove()

    def test_uv_corners_stay_on_the_map_of_their_face(self) -> None:
        obj = sleeve.scene()
        fine, mesh = runtimes.of(obj).evaluator, sleeve.output_object(obj).data
        coarse_uv, fine_uv = self.uv(obj.data), self.uv(mesh)
        for polygon, parent in zip(mesh.polygons, fine.polygon_parent):
            within = coarse_uv[list(obj.data.polygons[parent].loop_indices)]
            inside = fine_uv[list(polygon.loop_indices)]
            self.assertTrue((inside >= within.min(0) - 1e-5).all() and (inside <= within.max(0) + 1e-5).all())

    def uv(self, mesh: bpy.types.Mesh) -> np.ndarray:
        flat = np.empty(len(mesh.loops) * 2, np.float32)
        mesh.uv_layers["UVMap"].data.foreach_get("uv", flat)
        return flat.reshape(-1, 2)

    def test_vertex_groups_by_name_and_weight(self) -> None:
        obj = sleeve.scene()
        held = sleeve.output_object(obj)
        self.assertEqual(sleeve.names(held.vertex_groups), sleeve.names(obj.vertex_groups))
        weights = mesh_reader.group_weights(held, held.data, ["upper", "lower"])
        np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-4)

    def test_an_empty_group_is_there_too(self) -> None:
        obj = sleeve.scene()
        obj.vertex_groups.new(name="empty")
        bpy.context.view_layer.update()
        sleeve.at(2)
        self.assertIn("empty", sleeve.output_object(obj).vertex_groups)

    def test_attributes_of_all_domains(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        mesh = obj.data
        compat.write_attribute(mesh, "height", "FLOAT", "POINT", compat.positions(mesh)[:, 0])
        compat.write_attribute(mesh, "tint", "FLOAT_COLOR", "CORNER", np.full((len(mesh.loops), 4), 0.25, np.float32))
        compat.write_attribute(mesh, "panel", "INT", "FACE", np.arange(len(mesh.polygons)))
        compat.write_attribute(mesh, "all", "BOOLEAN", "POINT", np.ones(len(mesh.vertices), bool))
        obj.rumple.mesh.source, obj.rumple.mesh.segments = "REGULAR", 3
        bpy.ops.object.rumple_add(method="MESH")
        fine, carried = runtimes.of(obj).evaluator, sleeve.output_object(obj).data.attributes
        values = {name: compat.read_attribute(carried[name]) for name in ("height", "tint", "panel", "all")}
        self.assertGreaterEqual(values["height"].min(), -1e-6)
        self.assertLessEqual(values["height"].max(), sleeve.LENGTH + 1e-6)
        np.testing.assert_allclose(values["tint"], 0.25, atol=1e-6)
        np.testing.assert_array_equal(values["panel"][:, 0], fine.polygon_parent)
        self.assertTrue(values["all"].all())

    @unittest.skipUnless("FLOAT4X4" in bpy.types.Attribute.bl_rna.properties["data_type"].enum_items, "new in 4.2")
    def test_matrices(self) -> None:
        """Nodes that turn what they scatter read them. They were dropped, as this type was not known."""
        obj = sleeve.scene(wrinkles=False)
        mesh, turn = obj.data, np.arange(16, dtype=np.float32)
        for domain, count in (("POINT", len(mesh.vertices)), ("CORNER", len(mesh.loops)), ("FACE", len(mesh.polygons))):
            compat.write_attribute(mesh, domain.lower(), "FLOAT4X4", domain, np.tile(turn, (count, 1)))
        bpy.ops.object.rumple_add(method="MESH")
        for domain in ("point", "corner", "face"):
            values = compat.read_attribute(sleeve.output_object(obj).data.attributes[domain])
            np.testing.assert_allclose(values, np.tile(turn, (len(values), 1)), atol=1e-5)

    def test_edge_marks_lie_on_their_coarse_edges(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        mesh = obj.data
        marked = [edge.index for edge in mesh.edges if max(edge.vertices) < sleeve.AROUND]
        for index in marked:
            mesh.edges[index].use_seam = mesh.edges[index].use_edge_sharp = True
        obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 2, 0
        bpy.ops.object.rumple_add(method="MESH")
        marks = compat.edge_marks(sleeve.output_object(obj).data)
        self.assertEqual(int(marks["use_seam"].sum()), 4 * len(marked))
        self.assertEqual(int(marks["use_edge_sharp"].sum()), 4 * len(marked))

    def test_nothing_is_carried_twice(self) -> None:
        obj = sleeve.scene()
        fine = runtimes.of(obj).evaluator
        self.assertFalse(output_mesh.carry_changes(sleeve.output_object(obj), fine, output_mesh.Inherited(obj, obj)))
        self.assertFalse(rebuild.prepare(obj, modifier.find(obj)))

    def test_an_own_mesh_brings_its_own_looks_and_the_groups_of_the_coarse_one(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        own = sleeve.skinned(self.denser(), bpy.data.objects["Arm"], "Own")
        own.modifiers.clear()
        own.data.materials.clear()
        own.data.materials.append(bpy.data.materials.new("OwnMaterial"))
        obj.rumple.mesh.source, obj.rumple.own_mesh, obj.rumple.mesh.display_steps = "OBJECT", own, 0
        bpy.ops.object.rumple_add(method="MESH")
        sleeve.at(15)
        self.assertEqual(obj.rumple.message, "")
        self.assertEqual(len(sleeve.shown(obj)), len(own.data.vertices))
        self.assertEqual([m.name for m in sleeve.output_object(obj).data.materials], ["OwnMaterial"])
        self.assertEqual(sleeve.names(sleeve.output_object(obj).vertex_groups), ["lower", "upper"])

    def test_an_own_mesh_stays_as_it_is_where_one_parent_moves_both(self) -> None:
        """Rounding made another mesh of every frame: what was stored and baked did not fit any more."""
        obj, rig = sleeve.scene(wrinkles=False), bpy.data.objects["Arm"]
        for frame, way in ((1, 0.0), (20, 1.3)):
            rig.location, rig.rotation_euler = (way, 0.3 * way, 0.0), (0.0, 0.0, way)
            rig.keyframe_insert("location", frame=frame)
            rig.keyframe_insert("rotation_euler", frame=frame)
        own = bpy.data.objects.new("Own", self.denser())
        bpy.context.scene.collection.objects.link(own)
        for parent in (rig, obj):
            with self.subTest(parent.name):
                obj.parent, own.parent = rig, parent
                sleeve.make_active(obj)
                obj.rumple.mesh.source, obj.rumple.own_mesh, obj.rumple.mesh.display_steps = "OBJECT", own, 0
                if modifier.find(obj) is None:
                    bpy.ops.object.rumple_add(method="MESH")
                shapes = set()
                for frame in (1, 2, 5, 13):
                    sleeve.at(frame)
                    shapes.add(evaluator.sources(obj).shape)
                self.assertEqual((len(shapes), obj.rumple.message), (1, ""))

    def test_an_own_mesh_is_bound_where_it_was_chosen(self) -> None:
        """It was bound by where a moving garment was when the file was opened."""
        obj, rig = sleeve.scene(wrinkles=False), bpy.data.objects["Arm"]
        for frame, way in ((1, 0.0), (20, 0.05)):
            rig.location.x = way
            rig.keyframe_insert("location", frame=frame)
        obj.parent = rig
        own = bpy.data.objects.new("Own", self.denser())
        bpy.context.scene.collection.objects.link(own)
        sleeve.at(1)
        sleeve.make_active(obj)
        obj.rumple.mesh.source, obj.rumple.own_mesh, obj.rumple.mesh.display_steps = "OBJECT", own, 0
        bpy.ops.object.rumple_add(method="MESH")
        sleeve.play()
        shown, shape = sleeve.shown(obj).copy(), evaluator.sources(obj).shape
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "scene.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
        self.addCleanup(sleeve.empty_file)
        obj = bpy.data.objects["Sleeve"]
        sleeve.play()
        np.testing.assert_array_equal(sleeve.shown(obj), shown)
        bpy.data.objects["Own"].location.x += 0.001
        sleeve.at(20)
        rebuild.prepare(obj, modifier.find(obj))
        self.assertNotEqual(evaluator.sources(obj).shape, shape)
        self.assertEqual(obj.rumple.message, "")
        sleeve.at(10)
        for is_chosen_again in (False, True):
            before = evaluator.sources(obj).shape
            if is_chosen_again:
                obj.rumple.own_mesh = obj.rumple.own_mesh
            rebuild.prepare(obj, modifier.find(obj))
            self.assertEqual(evaluator.sources(obj).shape != before, is_chosen_again)

    def denser(self) -> bpy.types.Mesh:
        """The tube, subdivided twice by Blender."""
        coarse = bpy.data.objects.new("Denser", sleeve.tube("Denser"))
        bpy.context.scene.collection.objects.link(coarse)
        subdivision = coarse.modifiers.new("Subdivision", "SUBSURF")
        subdivision.levels = 2
        mesh = bpy.data.meshes.new_from_object(sleeve.evaluated(coarse))
        bpy.data.objects.remove(coarse)
        return mesh
