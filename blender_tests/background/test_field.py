# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Field on the sleeve: one click, settings, paint, materials, clips."""
from __future__ import annotations

import os
import tempfile
import unittest
import unittest.mock

import bpy
import numpy as np
from rumple.blender import compat, scheduler
from rumple.blender.nodes import field_profile, field_shader
from rumple.blender.objects import changes, mesh_reader, modifier, runtimes
from rumple.blender.ui import wave_materials
from rumple.core.base.wording import UserError
from rumple.core.systems.wrinkle_field import PHASE, U_GRADIENT, VECTORS, WEIGHT, WrinkleField
from support import sleeve, wave_shader_cases
from support.one_blender import long_one


def waving(**settings: object) -> bpy.types.Object:
    """The sleeve with a Wrinkle Field."""
    obj = sleeve.scene(wrinkles=False)
    for name, value in settings.items():
        setattr(obj.rumple.field, name, value)
    with sleeve.context():
        bpy.ops.object.rumple_add(method="FIELD")
    return obj


def kinds() -> list[list[str]]:
    return [sleeve.names(getattr(bpy.data, kind)) for kind in ("objects", "meshes", "node_groups", "materials")]


class Rendered(wave_shader_cases.Waves, unittest.TestCase):
    """In -b; the window suite has the same."""

    test_eevee = long_one(wave_shader_cases.Waves.test_eevee)

    def test_a_face_that_is_folded_over_is_lit_as_those_around_it(self) -> None:
        """Seen from behind Blender turns its normals round, which point away then: it was a black slit in the cloth.
        All that is seen from behind, as the inside of a leg, stays as Blender has it."""
        self.stage("CYCLES")
        self.obj.rumple.field.strength = 0.0
        bpy.context.view_layer.update()
        faces = modifier.output_object(modifier.find(self.obj)).data.polygons
        faces[len(faces) // 2].flip()
        self.assertGreater(self.render("Normal", 0.4, 0.5)[:, 2].min(), 0.9)
        self.camera.location.z, self.camera.rotation_euler.x = -3.0, np.pi
        self.assertLess(self.render("Normal", 0.4, 0.5)[:, 2].max(), -0.9)


class OneClick(unittest.TestCase):
    def test_waves_where_it_bends_and_nowhere_else(self) -> None:
        obj = waving()
        sleeve.at(1)
        self.assertLess(sleeve.attribute(obj, "rumple_amplitude").max(), 1e-4)
        sleeve.at(20)
        amplitude = sleeve.attribute(obj, "rumple_amplitude")[:, 0]
        x = compat.positions(obj.data)[:, 0]
        self.assertGreater(amplitude.max(), 0.05 * obj.rumple.field.wavelength)
        self.assertLess(amplitude[x < 0.15].max(), 1e-4)
        self.assertEqual(obj.rumple.message, "")

    def test_the_coarse_mesh_keeps_its_points_in_their_order(self) -> None:
        obj = waving()
        sleeve.at(15)
        modifier.find(obj).show_viewport = False
        plain = sleeve.shown(obj)
        modifier.find(obj).show_viewport = True
        sleeve.at(15)
        np.testing.assert_allclose(sleeve.shown(obj), plain, atol=1e-6)

    def test_geometry_is_a_fine_mesh_that_leaves_the_surface_where_it_waves(self) -> None:
        obj = waving(output="GEOMETRY")
        sleeve.at(20)
        self.assertGreater(len(sleeve.shown(obj)), 3 * len(obj.data.vertices))
        amplitude = sleeve.attribute(obj, "rumple_amplitude").max()
        offset = np.sqrt((sleeve.attribute(obj, "rumple_offset")**2).sum(1)).max()
        self.assertGreater(offset, 0.5 * amplitude)
        self.assertLessEqual(offset, 1.001 * amplitude)

    def test_its_attributes_say_what_the_docs_say(self) -> None:
        obj = waving()
        sleeve.at(20)
        mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        corners = len(mesh.loops)
        for name in (PHASE, WEIGHT, *VECTORS, U_GRADIENT):
            self.assertEqual(mesh.attributes[name].domain, "CORNER")
            self.assertEqual(mesh.attributes[name].data_type, "FLOAT_VECTOR")
        weight = compat.read_attribute(mesh.attributes[WEIGHT])
        self.assertEqual(len(weight), corners)
        for corner in range(3):
            others = [axis for axis in range(3) if axis != corner]
            np.testing.assert_array_equal(weight[corner::3, others], 0.0)
        lengths = np.sqrt((sleeve.attribute(obj, "rumple_direction")**2).sum(1))
        np.testing.assert_allclose(lengths, 1.0, atol=1e-5)
        self.assertLessEqual(np.abs(sleeve.attribute(obj, "rumple_phase")).max(), np.pi + 1e-5)

    def test_removing_leaves_nothing(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        before = kinds()
        bpy.ops.object.rumple_add(method="FIELD")
        sleeve.at(9)
        self.assertTrue(any(field_shader.is_ours(g) for g in bpy.data.node_groups))
        bpy.ops.object.rumple_remove()
        self.assertEqual(kinds(), before)
        self.assertEqual([a.name for a in obj.data.attributes if a.name.startswith("rumple")], [])

    def test_applied_they_are_geometry_whatever_shows_them(self) -> None:
        """Materials drew the waves, so the applied mesh had none. So did a baked clip."""
        obj = waving(output="GEOMETRY")
        sleeve.at(20)
        seen = sleeve.shown(obj)
        for baked in (False, True):
            with self.subTest(baked=baked), tempfile.TemporaryDirectory() as folder:
                obj = waving(output="SHADING")
                sleeve.at(20)
                flat = sleeve.shown(obj)
                if baked:
                    bpy.context.scene.frame_end = 20
                    bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "sleeve.blend"))
                    bpy.ops.object.rumple_bake()
                    sleeve.at(20)
                self.assertEqual(bpy.ops.object.rumple_apply(), {"FINISHED"})
                applied = compat.positions(obj.data)
                self.assertEqual(len(applied), len(seen))
                self.assertGreater(len(applied), 3 * len(flat))
                np.testing.assert_array_equal(applied, seen)
                self.assertEqual((list(obj.modifiers), sleeve.names(bpy.data.objects)), ([], ["Arm", "Sleeve"]))
                self.assertFalse(any(map(field_shader.shows_waves, obj.data.materials)))
                self.assertEqual(obj.rumple.field.output, "SHADING")  # for another one on the same object

    def test_a_refused_apply_changes_nothing(self) -> None:
        obj = waving(output="SHADING")
        sleeve.at(20)
        before = sleeve.shown(obj)
        with unittest.mock.patch.object(WrinkleField, "build", side_effect=UserError("Sleeve: too fine")):
            with self.assertRaisesRegex(RuntimeError, "Sleeve: too fine"):
                bpy.ops.object.rumple_apply()
        sleeve.at(20)
        np.testing.assert_array_equal(sleeve.shown(obj), before)
        self.assertEqual((obj.rumple.field.output, obj.rumple.message), ("SHADING", ""))

    def test_played_frames_come_back_to_the_bit(self) -> None:
        obj = waving()
        played = {}
        for frame in range(1, 13):
            sleeve.at(frame)
            played[frame] = sleeve.attribute(obj, "rumple_phase")
        for frame in (7, 2, 12, 5):
            sleeve.at(frame)
            np.testing.assert_array_equal(sleeve.attribute(obj, "rumple_phase"), played[frame])


class Settings(unittest.TestCase):
    def test_the_wavelength_is_metres_whatever_the_scale(self) -> None:
        obj = waving(wavelength=0.05)
        sleeve.at(20)
        lengths = []
        for scale in (1.0, 0.5):
            obj.scale = (scale,) * 3
            runtimes.of(obj).stale = True  # the scale is read when something is made anew
            scheduler.sync_all()
            sleeve.at(19)
            sleeve.at(20)
            k = runtimes.of(obj).result.attributes[VECTORS[0]]
            lengths.append(np.median(np.sqrt((k**2).sum(1))) / scale)  # radians per metre
        self.assertAlmostEqual(lengths[0] / lengths[1], 1.0, places=2)  # the arm is not scaled along: other poses

    def test_the_profile_changes_the_group_of_the_materials(self) -> None:
        obj = waving()
        obj.rumple.field.profile = "ACCORDION"
        scheduler.sync_all()
        groups = {n.node_tree[field_shader.PROFILE_KEY] for m in obj.data.materials for n in m.node_tree.nodes
                  if n.type == "GROUP"}
        self.assertEqual(groups, {"ACCORDION"})

    def test_a_drawn_profile_reaches_materials_and_geometry(self) -> None:
        obj = waving(profile="CURVE")
        sleeve.at(20)
        first = field_profile.heights(obj)
        np.testing.assert_allclose(first, np.cos(np.pi * np.linspace(0.0, 1.0, 65)), atol=0.03)  # a new curve is a sine
        keys = {group[field_shader.PROFILE_KEY] for group in bpy.data.node_groups if field_shader.is_ours(group)}
        self.assertEqual(keys, {field_profile.key(obj)})
        mapping = field_profile.node(obj).mapping
        for point in mapping.curves[0].points:
            point.location = (point.location[0], 0.25)
        mapping.update()
        changes.note_drawn_profile(obj)
        scheduler.sync_all()
        np.testing.assert_allclose(field_profile.heights(obj), -0.5, atol=1e-4)
        keys = {group[field_shader.PROFILE_KEY] for group in bpy.data.node_groups if field_shader.is_ours(group)}
        self.assertEqual(keys, {field_profile.key(obj)})
        obj.rumple.field.output = "GEOMETRY"  # a flat profile: every point at half the amplitude below the surface
        scheduler.sync_all()
        sleeve.at(19)
        sleeve.at(20)
        offset = np.sqrt((sleeve.attribute(obj, "rumple_offset")**2).sum(1))
        np.testing.assert_allclose(offset, 0.5 * sleeve.attribute(obj, "rumple_amplitude")[:, 0], atol=1e-6)
        bpy.ops.object.duplicate()
        scheduler.sync_all()
        self.assertNotEqual(bpy.context.object.rumple.profile_curve, obj.rumple.profile_curve)

    def test_mask_by_vertex_group_and_by_attribute(self) -> None:
        obj = waving()
        obj.rumple.field.dissolve = False  # it goes by the neighbours that have waves at all, which the mask changes
        sleeve.at(20)
        full = sleeve.attribute(obj, "rumple_amplitude").copy()
        bpy.ops.object.rumple_paint(group="mask")
        obj.vertex_groups["Rumple Mask"].add(range(len(obj.data.vertices)), 0.5, "REPLACE")
        obj.update_tag()
        sleeve.at(19)
        sleeve.at(20)
        np.testing.assert_allclose(sleeve.attribute(obj, "rumple_amplitude"), 0.5 * full, atol=1e-6)
        obj.vertex_groups.remove(obj.vertex_groups["Rumple Mask"])
        attribute = obj.data.attributes.new("Rumple Mask", "FLOAT", "POINT")
        attribute.data.foreach_set("value", np.full(len(obj.data.vertices), 0.25, np.float32))
        obj.data.update()
        scheduler.sync_all()
        sleeve.at(19)
        sleeve.at(20)
        np.testing.assert_allclose(sleeve.attribute(obj, "rumple_amplitude"), 0.25 * full, atol=1e-6)

    def test_painted_rest_wrinkles_show_at_rest_along_their_direction(self) -> None:
        obj = waving()
        painted = np.zeros((len(obj.data.vertices), 3), np.float32)
        painted[:, 0] = 0.6
        compat.write_attribute(obj.data, mesh_reader.REST_WRINKLE, "FLOAT_VECTOR", "POINT", painted)
        obj.data.update()
        scheduler.sync_all()
        sleeve.at(2)
        sleeve.at(1)
        shrunk = 1.0 - 0.6**2
        expected = 0.25 * obj.rumple.field.wavelength * (1.0 - shrunk**2)**0.5
        np.testing.assert_allclose(sleeve.attribute(obj, "rumple_amplitude"), expected, rtol=1e-3)
        np.testing.assert_allclose(np.abs(sleeve.attribute(obj, "rumple_direction")[:, 0]), 1.0, atol=1e-3)

    def test_a_painted_vector_that_is_too_long_is_named_and_the_last_picture_stays(self) -> None:
        obj = waving()
        sleeve.at(20)
        before = sleeve.attribute(obj, "rumple_amplitude")
        painted = np.zeros((len(obj.data.vertices), 3), np.float32)
        painted[7, 1] = 1.5
        compat.write_attribute(obj.data, mesh_reader.REST_WRINKLE, "FLOAT_VECTOR", "POINT", painted)
        obj.data.update()
        scheduler.sync_all()
        sleeve.at(20)
        self.assertRegex(obj.rumple.message, "^Sleeve: the painted rest wrinkle of vertex 7 has length 1.5, "
                         "expected below 1: press Clear")
        np.testing.assert_array_equal(sleeve.attribute(obj, "rumple_amplitude"), before)
        stored = compat.read_attribute(obj.data.attributes[mesh_reader.REST_WRINKLE])
        np.testing.assert_array_equal(stored, painted)


class Materials(unittest.TestCase):
    def material(self) -> bpy.types.Material:
        """A Principled shader whose normal comes from a bump."""
        sleeve.empty_file()
        material = bpy.data.materials.new("Cloth")
        compat.use_nodes(material)
        tree = material.node_tree
        bump = tree.nodes.new("ShaderNodeBump")
        shader = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
        tree.links.new(bump.outputs[0], shader.inputs["Normal"])
        return material

    @staticmethod
    def links(material: bpy.types.Material) -> set[tuple[str, str, str, str]]:
        return {(link.from_node.name, link.from_socket.name, link.to_node.name, link.to_socket.name)
                for link in material.node_tree.links}

    def test_in_and_out_again_leaves_the_links_as_they_were(self) -> None:
        material = self.material()
        before = self.links(material)
        obj = sleeve.skinned(sleeve.tube(), sleeve.arm())
        field_shader.shade(material, obj)
        between = self.links(material)
        self.assertIn(("Bump", "Normal", field_shader.NAME, "Normal"), between)
        self.assertIn((field_shader.NAME, "Normal", "Principled BSDF", "Normal"), between)
        field_shader.shade(material, obj)
        self.assertEqual(self.links(material), between)
        field_shader.unshade(material)
        self.assertEqual(self.links(material), before)
        self.assertFalse(any(n.type == "GROUP" for n in material.node_tree.nodes))

    def test_a_normal_map_of_a_texture_without_coordinates_makes_no_cycle(self) -> None:
        """One node gave the texture its coordinates and took the normal that is made of it: Blender 5.2 drew black."""
        material = bpy.data.materials.new("Denim")
        compat.use_nodes(material)
        nodes, links = material.node_tree.nodes, material.node_tree.links
        image, normal_map = nodes.new("ShaderNodeTexImage"), nodes.new("ShaderNodeNormalMap")
        shader = next(n for n in nodes if n.type == "BSDF_PRINCIPLED")
        links.new(image.outputs["Color"], normal_map.inputs["Color"])
        links.new(normal_map.outputs["Normal"], shader.inputs["Normal"])
        before = self.links(material)
        obj = sleeve.skinned(sleeve.tube(), sleeve.arm())

        def coordinates() -> bpy.types.Node:
            return image.inputs["Vector"].links[0].from_node

        for _ in range(2):
            field_shader.shade(material, obj)
            self.assertFalse(coordinates().inputs["Normal"].is_linked)
            self.assertTrue(all(link.is_valid for link in links))
            waves = shader.inputs["Normal"].links[0].from_node
            self.assertEqual(waves.inputs["Normal"].links[0].from_node, normal_map)
        links.new(waves.outputs["UV"], image.inputs["Vector"])  # as an older file has it
        nodes.remove(next(n for n in nodes if n.type == "GROUP" and n != waves))
        obj.data.materials.clear()
        obj.data.materials.append(material)
        self.assertTrue(field_shader.set_profile(material, obj))
        self.assertNotEqual(coordinates(), waves)
        field_shader.unshade(material)
        self.assertEqual(self.links(material), before)

    def test_a_shader_inside_of_a_node_group_is_said(self) -> None:
        """The button said that the material shows the waves."""
        obj = sleeve.scene(wrinkles=False)
        material = bpy.data.materials.new("Grouped")
        compat.use_nodes(material)
        nodes = material.node_tree.nodes
        nodes.remove(next(n for n in nodes if n.type == "BSDF_PRINCIPLED"))
        inside = bpy.data.node_groups.new("Inside", "ShaderNodeTree")
        compat.new_group_socket(inside, "BSDF", "OUTPUT", "NodeSocketShader")
        nodes.new("ShaderNodeGroup").node_tree = inside
        for slot in obj.material_slots:
            slot.material = material
        self.assertEqual(wave_materials.unshaded(obj), [
            "Sleeve: the material \"Grouped\" shows no waves, for its shader is inside of a node group: connect a "
            "shader outside of it, or set Output to Geometry"])
        plain = bpy.data.materials.new("Plain")
        compat.use_nodes(plain)
        obj.material_slots[0].material = plain
        field_shader.shade_object(obj)
        self.assertEqual(len(wave_materials.unshaded(obj)), 1)
        obj.material_slots[1].material = obj.material_slots[0].material
        self.assertEqual(wave_materials.unshaded(obj), [])

    def test_a_material_without_a_shader_is_said(self) -> None:
        """The message looked for its shader inside of a node group."""
        obj = sleeve.scene(wrinkles=False)
        material = obj.material_slots[0].material
        compat.use_nodes(material)
        nodes = material.node_tree.nodes
        obj.material_slots[1].material = material
        for kept in ("ShaderNodeEmission", "ShaderNodeSubsurfaceScattering"):
            nodes.clear()
            nodes.new(kept)
            field_shader.shade(material, obj)
            self.assertEqual(wave_materials.unshaded(obj), [
                "Sleeve: the material \"Outside\" shows no waves, for it has no shader that takes a normal: connect a "
                "Principled BSDF, or set Output to Geometry"] if kept == "ShaderNodeEmission" else [])

    def test_a_material_that_another_waving_object_shows_keeps_its_waves(self) -> None:
        obj = waving()
        with sleeve.context():
            bpy.ops.object.duplicate()
            scheduler.sync_all()
            bpy.ops.object.rumple_remove()
        self.assertTrue(any(n.type == "GROUP" for m in obj.data.materials for n in m.node_tree.nodes))


class Baked(unittest.TestCase):
    def test_a_clip_has_the_waves_too_and_phases_do_not_jump_between_samples(self) -> None:
        obj = waving()
        names = ("rumple_amplitude", "rumple_phase", PHASE, WEIGHT, *VECTORS, U_GRADIENT)
        live = {}
        for frame in range(1, 21):
            sleeve.at(frame)
            live[frame] = {name: sleeve.attribute(obj, name) for name in names}
        with tempfile.TemporaryDirectory() as folder:
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "scene.blend"))
            self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
            for frame in (20, 3, 11):
                sleeve.at(frame)
                for name in names:
                    found, right = sleeve.attribute(obj, name), live[frame][name]
                    if name in (PHASE, "rumple_phase"):
                        turns = (found - right) / (2.0 * np.pi)
                        np.testing.assert_allclose(turns, np.round(turns), atol=1e-4, err_msg=name)
                    else:
                        np.testing.assert_allclose(found, right, atol=1e-5, err_msg=name)
            sleeve.at(11)
            before = sleeve.attribute(obj, PHASE)
            sleeve.at(12)
            self.assertLess(np.abs(sleeve.attribute(obj, PHASE) - before).max(), np.pi + 1e-4)
