# SPDX-License-Identifier: GPL-3.0-or-later
"""What undo leaves in memory as it is names nothing that undo frees or reads anew."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path
from unittest import mock

import bpy
import numpy as np
from rumple.blender import compat, scheduler
from rumple.blender.maps import modifier as maps_modifier, rebuild as maps_rebuild
from rumple.blender.nodes import field_shader
from rumple.blender.objects import modifier, output_mesh, undo_references
from support import face, sleeve


class MadeBetweenSteps(unittest.TestCase):
    """Handlers and timers make data-blocks between two undo steps; both steps have the same of the garment."""

    def setUp(self) -> None:
        self.obj = sleeve.scene()
        sleeve.at(20)
        self.steps()

    def steps(self) -> None:
        for step in range(4):
            bpy.context.scene["step"] = step
            bpy.ops.ed.undo_push(message=f"step {step}")

    def undo_twice(self, said: str = "") -> None:
        for _ in range(2):
            bpy.ops.ed.undo()
            sleeve.at(19)
            scheduler.sync_all()
            sleeve.at(20)
            self.assertEqual(self.garment().rumple.message, said)

    def garment(self) -> bpy.types.Object:
        return bpy.data.objects["Sleeve"]

    def test_an_output_object(self) -> None:
        """Blender crashed."""
        nodes_mod = modifier.find(self.obj)
        former = modifier.output_object(nodes_mod)
        made = output_mesh.copy_for(self.obj, former)
        modifier.set_output_object(nodes_mod, made, modifier.coarse_vertices(nodes_mod))
        bpy.data.objects.remove(former)
        self.undo_twice()
        self.assertGreater(np.abs(sleeve.attribute(self.garment(), "rumple_offset")).max(), 1e-3)
        self.assertEqual(len([obj for obj in bpy.data.objects if output_mesh.KEY in obj]), 1)

    def test_a_clip_that_was_baked(self) -> None:
        """A window bakes in a timer."""
        with tempfile.TemporaryDirectory() as folder:
            self.obj.rumple.bake_folder = folder
            bpy.ops.object.rumple_bake()
            self.assertIsNotNone(modifier.cache_object(modifier.find(self.garment())))
            self.undo_twice("Sleeve: the baked clip is not named any more: bake again, or free the bake")

    def test_a_mesh_that_other_modifiers_made(self) -> None:
        made = self.obj.data.copy()
        self.obj.rumple.captured = made
        self.undo_twice()
        self.assertIsNone(self.garment().rumple.captured)

    def test_the_group_of_a_field_beside_another_field(self) -> None:
        """The groups of one profile were one, so that another one took its place: the waves were gone after undo."""
        other = self.obj.copy()
        other.data = self.obj.data.copy()
        for slot, material in enumerate(other.data.materials):
            other.data.materials[slot] = material.copy()
        bpy.context.scene.collection.objects.link(other)
        for obj in (other, self.obj):
            sleeve.make_active(obj)
            bpy.ops.object.rumple_remove()
            bpy.ops.object.rumple_add(method="FIELD")
        self.test_the_group_of_a_field_with_another_profile()
        for obj in (self.garment(), bpy.data.objects[other.name]):
            for material in obj.data.materials:
                self.assertTrue([node for node in material.node_tree.nodes if field_shader.is_ours(
                    getattr(node, "node_tree", None))], (obj.name, material.name))

    def test_the_group_of_a_field_with_another_profile(self) -> None:
        """Blender crashed: a new group took the place of the one that both steps have."""
        if modifier.system(modifier.find(self.obj)).method != "FIELD":
            bpy.ops.object.rumple_remove()
            bpy.ops.object.rumple_add(method="FIELD")
        self.steps()
        group = next(node.node_tree for node in self.obj.data.materials[0].node_tree.nodes
                     if field_shader.is_ours(getattr(node, "node_tree", None))).as_pointer()
        self.obj.rumple.field.profile = "ACCORDION"
        scheduler.sync_all()
        for material in self.obj.data.materials:
            fields = [node.node_tree for node in material.node_tree.nodes if node.type == "GROUP"]
            self.assertEqual({(field.as_pointer(), field[field_shader.PROFILE_KEY]) for field in fields},
                             {(group, "ACCORDION")})
        self.undo_twice()


class AddressThatSomethingElseHas(unittest.TestCase):
    """In 3.4 the key of a data-block is its address. Of meshes and node groups only the type was looked at: the
    artist's own mesh at that address became the garment's incoming mesh."""

    ADDRESS = 1

    def setUp(self) -> None:
        self.obj = sleeve.scene()
        self.enterContext(mock.patch.object(compat, "session_key", self.key))
        self.here: set[bpy.types.ID] = set()

    def key(self, block: bpy.types.ID) -> int:
        return self.ADDRESS if block in self.here else block.as_pointer()

    def test_it_is_not_taken_for_ours(self) -> None:
        meshes, groups = bpy.data.meshes, bpy.data.node_groups
        for setting, blocks, more in (("incoming", meshes, ()), ("captured", meshes, ()),
                                      ("profile_curve", groups, ("ShaderNodeTree",))):
            ours = blocks.new("Ours", *more)
            setattr(self.obj.rumple, setting, ours)
            for is_there in (True, False):
                self.here = {ours}
                undo_references.clear_references()
                self.assertIsNone(getattr(self.obj.rumple, setting))
                if not is_there:
                    blocks.remove(ours)
                    self.here = {blocks.new("Theirs", *more)}
                undo_references.restore_references()
                self.assertEqual(getattr(self.obj.rumple, setting), ours if is_there else None, setting)
            setattr(self.obj.rumple, setting, None)

    def test_nor_an_object_that_has_settings_of_ours(self) -> None:
        """The settings of any object are custom properties whose names begin as our marks do."""
        nodes_mod = modifier.find(self.obj)
        ours = modifier.output_object(nodes_mod)
        self.here = {ours}
        undo_references.clear_references()
        bpy.data.objects.remove(ours)
        theirs = bpy.data.objects.new("Theirs", bpy.data.meshes.new("Theirs"))
        theirs.rumple_maps.gain = 0.5
        self.here = {theirs}
        undo_references.restore_references()
        self.assertIsNone(modifier.output_object(nodes_mod))


class MapsBetweenSteps(unittest.TestCase):

    def test_skin_and_skeleton(self) -> None:
        """Blender crashed."""
        obj, rig = face.scene()
        face.two_poses(obj, rig)
        for step in range(4):
            bpy.context.scene["step"] = step
            bpy.ops.ed.undo_push(message=f"step {step}")
        for hidden in maps_modifier.hidden(maps_modifier.find(obj)):
            modifier.delete_hidden(hidden)
        maps_rebuild.prepare(obj, maps_modifier.find(obj))
        for _ in range(2):
            bpy.ops.ed.undo()
            scheduler.sync_all()
            sleeve.at(bpy.context.scene.frame_current + 1)
            obj = next(obj for obj, _ in maps_modifier.mapped_objects())
            self.assertEqual(obj.rumple_maps.message, "")
            self.assertEqual(len(maps_modifier.hidden(maps_modifier.find(obj))), 2)


class LinkedGarment(unittest.TestCase):

    def setUp(self) -> None:
        library = str(Path(self.enterContext(tempfile.TemporaryDirectory())) / "library.blend")
        sleeve.scene()
        bpy.ops.wm.save_as_mainfile(filepath=library, copy=True)
        sleeve.empty_file()
        bpy.ops.ed.undo_push(message="before")
        with bpy.data.libraries.load(library, link=True) as (_, wanted):
            wanted.objects = ["Sleeve"]
        bpy.context.scene.collection.objects.link(wanted.objects[0])
        self.play()
        for message in ("linked", "something else"):
            bpy.ops.ed.undo_push(message=message)

    def garment(self) -> bpy.types.Object:
        return next(obj for obj in bpy.data.objects if obj.library is not None and modifier.find(obj) is not None)

    def play(self) -> None:
        sleeve.at(19)
        scheduler.sync_all()
        sleeve.at(20)

    def folds(self) -> float:
        return float(np.abs(sleeve.attribute(self.garment(), "rumple_offset")).max())

    def hidden(self) -> list[str]:
        return sorted(obj.name for obj in bpy.data.objects if obj.library is None and obj.name.startswith("Sleeve."))

    def test_while_it_is_undone_it_names_nothing_local_and_afterwards_the_same(self) -> None:
        """Blender 5.2 crashed."""
        named, before = [], self.hidden()

        def look(*_arguments: object) -> None:
            named.append(modifier.outputs(modifier.find(self.garment())))

        for handlers in (bpy.app.handlers.undo_pre, bpy.app.handlers.redo_pre):
            handlers.append(look)
            self.addCleanup(handlers.remove, look)
        self.assertEqual(len(modifier.outputs(modifier.find(self.garment()))), len(before))
        for step in (bpy.ops.ed.undo, bpy.ops.ed.redo, bpy.ops.ed.undo):
            step()
            self.assertEqual({output.name for output in modifier.outputs(modifier.find(self.garment()))}, set(before))
            self.play()
            self.assertEqual((self.garment().rumple.message, self.hidden()), ("", before))
            self.assertGreater(self.folds(), 1e-3)
        self.assertEqual(named, [[], [], []])

    def test_linking_is_undone_and_done_again(self) -> None:
        bpy.ops.ed.undo()
        bpy.ops.ed.undo()
        self.play()
        bpy.ops.ed.redo()
        self.play()
        self.assertEqual(self.garment().rumple.message, "")
        self.assertGreater(self.folds(), 1e-3)


if __name__ == "__main__":
    unittest.main()
