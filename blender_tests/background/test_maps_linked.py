# SPDX-License-Identifier: GPL-3.0-or-later
"""Characters linked from another file, and library overrides of them: the usual way of productions."""
from __future__ import annotations

import os
import tempfile
import unittest
from typing import Any

import bpy
import numpy as np
from rumple.blender.maps import modifier as maps_modifier
from rumple.blender.nodes import maps_shader
from support import face, sleeve

ROUNDING = 1e-4  # of a mask


class Character(unittest.TestCase):
    """A face in a file of its own."""

    def prepare(self, obj: bpy.types.Object) -> None:
        """What is done to it before it is saved."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(sleeve.empty_file)
        self.library, self.shot = (os.path.join(folder.name, name) for name in ("character.blend", "shot.blend"))
        obj, rig = face.scene()
        face.two_poses(obj, rig)
        face.animate(rig)
        self.prepare(obj)
        collection, scene = bpy.data.collections.new("Character"), bpy.context.scene
        scene.collection.children.link(collection)
        for member in (obj, rig):
            scene.collection.objects.unlink(member)
            collection.objects.link(member)
        bpy.ops.wm.save_as_mainfile(filepath=self.library)
        self.shares = face.weights(obj, "brow.L"), face.weights(obj, "brow.R")
        sleeve.empty_file()

    def link(self, kind: str, name: str) -> Any:
        with bpy.data.libraries.load(self.library, link=True) as (_, wanted):
            setattr(wanted, kind, [name])
        return getattr(wanted, kind)[0]

    def override(self) -> tuple[bpy.types.Object, bpy.types.Object]:
        """(face, rig) of an override of the whole character."""
        collection = self.link("collections", "Character")
        scene = bpy.context.scene
        scene.collection.children.link(collection)
        bpy.context.view_layer.update()
        collection.override_hierarchy_create(scene, bpy.context.view_layer, do_fully_editable=True)
        bpy.context.view_layer.update()
        return self.found()

    def found(self) -> tuple[bpy.types.Object, bpy.types.Object]:
        obj = next(o for o in bpy.data.objects if o.library is None and maps_modifier.find(o) and o.users_collection)
        sleeve.make_active(obj)
        obj.rumple_maps.active = 0
        return obj, obj.find_armature()

    def reopened(self) -> tuple[bpy.types.Object, bpy.types.Object]:
        bpy.ops.wm.save_as_mainfile(filepath=self.shot)
        bpy.ops.wm.open_mainfile(filepath=self.shot)
        return self.found()


class Linked(Character):

    def check(self, obj: bpy.types.Object, left: float, right: float = 0.0, name: str = "Surprise") -> None:
        np.testing.assert_allclose(face.mask(obj, name), left * self.shares[0] + right * self.shares[1], atol=ROUNDING)
        self.assertEqual(obj.rumple_maps.message, "")

    def test_linked_it_follows_its_bones_and_nothing_is_made(self) -> None:
        collection = self.link("collections", "Character")
        bpy.context.scene.collection.children.link(collection)
        before = sorted(obj.name_full for obj in bpy.data.objects)
        obj = collection.objects["Face"]
        for frame in (11, 3, 8):
            bpy.context.scene.frame_set(frame)
            self.check(obj, face.risen(frame))
            self.assertAlmostEqual(obj.rumple_maps.poses["Surprise"].present, face.risen(frame) / 2, 4)
        self.assertEqual(sorted(obj.name_full for obj in bpy.data.objects), before)

    def test_linked_it_knows_that_its_rig_was_scaled_since(self) -> None:
        """The scale is applied in the file that it comes from, the pose is stored in it or in the shot."""
        self.override()
        bpy.ops.wm.save_as_mainfile(filepath=self.shot)
        bpy.ops.wm.open_mainfile(filepath=self.library)
        rig = bpy.data.objects["Rig"]
        rig.animation_data_clear()
        rig.scale = (100.0,) * 3
        sleeve.make_active(rig)
        bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
        bpy.ops.wm.save_as_mainfile(filepath=self.library)
        bpy.ops.wm.open_mainfile(filepath=self.shot)
        obj, rig = self.found()
        face.pose(rig, brow_L=1.0, brow_R=0.5)
        self.check(obj, 1.0, 0.5)
        self.assertEqual(face.notes(obj), "")

    def test_an_instanced_collection(self) -> None:
        empty = bpy.data.objects.new("Character", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", self.link("collections", "Character")
        bpy.context.scene.collection.objects.link(empty)
        bpy.context.scene.frame_set(7)
        self.check(empty.instance_collection.objects["Face"], face.risen(7))

    def test_an_override_is_posed_and_reopened(self) -> None:
        obj, rig = self.override()
        rig.animation_data.action = None
        face.pose(rig, brow_L=0.01, brow_R=0.005)
        self.check(obj, 1.0, 0.5)
        self.assertEqual([pose.name for pose in obj.rumple_maps.poses], ["Surprise", "Anger"])
        obj, rig = self.reopened()
        rig.animation_data.action = None
        face.pose(rig, brow_L=0.005, brow_R=0.01)
        self.check(obj, 0.5, 1.0)

    def test_settings_of_an_override_count_and_are_kept(self) -> None:
        obj, rig = self.override()
        rig.animation_data.action = None
        obj.rumple_maps.poses["Surprise"].strength = 0.5
        face.pose(rig, brow_L=0.01, brow_R=0.01)
        self.check(obj, 0.5, 0.5)
        obj, rig = self.reopened()
        rig.animation_data.action = None
        face.pose(rig, brow_L=0.01, brow_R=0.01)
        self.check(obj, 0.5, 0.5)
        bpy.ops.rumple.pose_mute()
        bpy.context.view_layer.update()
        self.assertFalse(face.mask(obj, "Surprise").any())

    def test_poses_are_added_and_updated_in_an_override(self) -> None:
        obj, rig = self.override()
        rig.animation_data.action = None
        face.pose(rig, brow_L=0.02, brow_R=0.02)
        self.assertEqual(bpy.ops.rumple.pose_update(), {"FINISHED"})
        face.pose(rig, jaw=0.01)
        self.assertEqual(bpy.ops.rumple.pose_add(name="Open"), {"FINISHED"})
        for _ in range(2):
            rig.animation_data.action = None
            face.pose(rig, brow_L=0.01, brow_R=0.02)
            self.check(obj, 0.5, 1.0)
            face.pose(rig, jaw=0.005)
            np.testing.assert_allclose(face.mask(obj, "Open"), 0.5 * face.weights(obj, "jaw"), atol=ROUNDING)
            obj, rig = self.reopened()

    def test_what_blender_forbids_in_an_override_is_said(self) -> None:
        obj, _rig = self.override()
        for refused in (bpy.ops.rumple.pose_remove, lambda: bpy.ops.rumple.pose_move(direction="DOWN")):
            with self.assertRaisesRegex(RuntimeError, "Face: it is a library override.*mute a pose instead"):
                refused()
        self.assertEqual([pose.name for pose in obj.rumple_maps.poses], ["Surprise", "Anger"])

    def test_a_linked_rig_with_a_local_mesh(self) -> None:
        rig = self.link("objects", "Rig")
        bpy.context.scene.collection.objects.link(rig)
        mesh = face.sheet()
        obj = bpy.data.objects.new("Mine", mesh)
        bpy.context.scene.collection.objects.link(obj)
        for name, share in zip(face.BROWS, self.shares):
            group = obj.vertex_groups.new(name=name)
            for vertex, weight in enumerate(share):
                group.add([vertex], float(weight), "REPLACE")
        head = obj.vertex_groups.new(name="head")
        for vertex, weight in enumerate(1.0 - self.shares[0] - self.shares[1]):
            head.add([vertex], float(weight), "REPLACE")
        obj.modifiers.new("Armature", "ARMATURE").object = rig
        sleeve.make_active(obj)
        bpy.ops.rumple.maps_add()
        bpy.context.scene.frame_set(11)
        bpy.ops.rumple.pose_add(name="Surprise")
        for frame in (1, 6, 11):
            bpy.context.scene.frame_set(frame)
            self.check(obj, face.risen(frame))
        bpy.context.scene.frame_set(6)
        self.check(self.reopened()[0], face.risen(6))


def made_map(name: str) -> bpy.types.Image:
    image = bpy.data.images.new(name, 4, 4, is_data=True)
    image.pack()
    image.use_fake_user = True
    return image


def images(group: bpy.types.NodeTree) -> list[str]:
    return sorted(node.image.name for node in group.nodes if node.type == "TEX_IMAGE")


class InMaterials(Character):
    """The character shows a map for each pose. In the shot another one is chosen."""

    WHY = "Face: its material Skin is linked from another file and cannot show the maps of this one"

    def prepare(self, obj: bpy.types.Object) -> None:
        for pose in obj.rumple_maps.poses:
            pose.image = made_map(pose.name)
        bpy.ops.rumple.maps_show()

    def choose(self, obj: bpy.types.Object) -> None:
        obj.rumple_maps.poses["Surprise"].image = made_map("New")
        bpy.context.view_layer.update()

    def own_material(self, obj: bpy.types.Object) -> bpy.types.Material:
        material = obj.material_slots[0].material.copy()
        obj.material_slots[0].link = "OBJECT"
        obj.material_slots[0].material = material
        return material

    def shows(self, obj: bpy.types.Object, names: list[str]) -> None:
        """By a group of this file, in front of the Normal Map of a material of this file."""
        group, material = obj.rumple_maps.group, obj.material_slots[0].material
        self.assertEqual((group.library, material.library), (None, None))
        self.assertEqual(images(group), names)
        self.assertEqual(maps_shader.shown_in(material), group)
        normal_map = next(node for node in material.node_tree.nodes if node.type == "NORMAL_MAP")
        self.assertEqual(normal_map.inputs["Color"].links[0].from_node.node_tree, group)
        self.assertEqual(face.notes(obj), "")

    def test_maps_of_the_shot_reach_a_material_of_the_shot(self) -> None:
        """The shader kept those of the linked file, and Show in Materials wrote them there, until the file was opened
        again."""
        obj, _rig = self.override()
        linked = obj.rumple_maps.group
        self.own_material(obj)
        self.choose(obj)
        self.shows(obj, ["Anger", "New"])
        self.assertEqual(images(linked), ["Anger", "Surprise"])
        obj, _rig = self.reopened()
        self.shows(obj, ["Anger", "New"])
        self.assertEqual(bpy.ops.rumple.maps_hide(), {"FINISHED"})
        self.assertIsNone(maps_shader.shown_in(obj.material_slots[0].material))

    def test_a_linked_material_is_named_until_the_object_has_one_of_this_file(self) -> None:
        obj, _rig = self.override()
        self.choose(obj)
        self.assertIn(self.WHY, face.notes(obj))
        with self.assertRaisesRegex(RuntimeError, self.WHY):
            bpy.ops.rumple.maps_show()
        shown = maps_shader.shown_in(obj.material_slots[0].material)
        self.assertIsNotNone(shown.library)
        self.assertEqual(images(shown), ["Anger", "Surprise"])
        self.own_material(obj)
        for _ in range(2):
            self.assertEqual(bpy.ops.rumple.maps_show(), {"FINISHED"})
            bpy.context.view_layer.update()
            self.shows(obj, ["Anger", "New"])
            obj, _rig = self.reopened()

    def test_unchanged_maps_are_those_of_the_linked_file(self) -> None:
        obj, _rig = self.override()
        self.assertIsNotNone(obj.rumple_maps.group.library)
        with self.assertRaisesRegex(RuntimeError, "Face: its material Skin is linked from another file and still"):
            bpy.ops.rumple.maps_hide()
        self.assertEqual(bpy.ops.rumple.maps_show(), {"FINISHED"})
        bpy.context.view_layer.update()
        self.assertEqual(face.notes(obj), "")
        self.assertIsNotNone(maps_shader.shown_in(obj.material_slots[0].material).library)

    def test_of_two_overrides_only_the_changed_one_has_a_group_of_its_own(self) -> None:
        first, _rig = self.override()
        collection = next(c for c in bpy.data.collections if c.library is not None)
        collection.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer, do_fully_editable=True)
        bpy.context.view_layer.update()
        second = next(o for o in bpy.data.objects
                      if o.library is None and o.type == "MESH" and maps_modifier.find(o) and o != first)
        material = self.own_material(second)
        first.material_slots[0].link = "OBJECT"
        first.material_slots[0].material = material
        linked = second.rumple_maps.group
        self.choose(first)
        self.assertEqual((second.rumple_maps.group, linked.library is None), (linked, False))
        self.assertEqual(maps_shader.shown_in(material), linked)
        with self.assertRaisesRegex(RuntimeError, "material Skin[.0-9]* shows the maps of another object"):
            bpy.ops.rumple.maps_show()
        self.own_material(first)
        self.assertEqual(bpy.ops.rumple.maps_show(), {"FINISHED"})
        bpy.context.view_layer.update()
        self.shows(first, ["Anger", "New"])
        self.assertEqual(maps_shader.shown_in(material), linked)
