# SPDX-License-Identifier: GPL-3.0-or-later
"""What is wrong with a body is said in a sentence that names the object, and the last picture stays."""
from __future__ import annotations

import contextlib
import io
import math
from unittest import mock

import bmesh
import bpy
import numpy as np
from rumple.blender import compat, scheduler
from rumple.blender.nodes import wrinkle_tree
from rumple.blender.objects import bodies, modifier, runtimes, stack_notes
from support import sleeve
from support.worn_sleeve import Worn, outward, solved_body


def instances() -> bpy.types.NodeTree:
    """Nodes that leave an instance of what comes in, and no faces."""
    tree = bpy.data.node_groups.new("Instances", "GeometryNodeTree")
    for in_out in ("INPUT", "OUTPUT"):
        compat.new_group_socket(tree, "Geometry", in_out, "NodeSocketGeometry")
    first, middle, last = (tree.nodes.new(name) for name in ("NodeGroupInput", "GeometryNodeGeometryToInstance",
                                                             "NodeGroupOutput"))
    tree.links.new(first.outputs[0], middle.inputs[0])
    tree.links.new(middle.outputs[0], last.inputs[0])
    return tree


class Wrong(Worn):
    """Said with the name of the object, and the last good picture stays."""

    def setUp(self) -> None:
        super().setUp()
        sleeve.at(5)

    def check_said(self, obj: bpy.types.Object, words: str, frame: int = 9) -> None:
        before = runtimes.of(obj).result
        sleeve.at(frame)
        self.assertRegex(obj.rumple.message, f"^{obj.name}: .*{words}")
        self.assertIs(runtimes.of(obj).result, before)

    def check_right(self, obj: bpy.types.Object, frame: int = 10) -> None:
        sleeve.at(frame)
        self.assertEqual(obj.rumple.message, "")
        self.assertEqual(runtimes.of(obj).inputs.frame, float(frame))

    def test_no_faces(self) -> None:
        self.body.data.clear_geometry()
        self.obj.rumple.body = self.body
        self.check_left_out("Human")
        self.obj.rumple.body = None
        self.check_right(self.obj)
        self.assertEqual(runtimes.of(self.obj).left_out, "")

    def check_left_out(self, name: str) -> None:
        """All stood still for one of several bodies."""
        for frame in (8, 9):
            self.check_right(self.obj, frame)
        self.assertRegex(runtimes.of(self.obj).left_out, f"^Sleeve: its body {name} has no faces and is left out")

    def test_no_faces_among_others(self) -> None:
        group = bpy.data.collections.new("All")
        bpy.context.scene.collection.children.link(group)
        group.objects.link(bpy.data.objects.new("Empty", bpy.data.meshes.new("Empty")))
        group.objects.link(self.body)
        self.obj.rumple.body_collection = group
        self.check_left_out("Empty")
        self.assertEqual(len(solved_body(self.obj).positions), len(self.body.data.vertices))

    def test_nodes_make_instances_of_it(self) -> None:
        self.body.modifiers.new("Instances", "NODES").node_group = instances()
        self.obj.rumple.body = self.body
        self.check_left_out("Human")
        self.assertIsNone(solved_body(self.obj))
        self.body.modifiers["Instances"].show_viewport = False
        self.check_right(self.obj)
        self.assertEqual(runtimes.of(self.obj).left_out, "")
        self.assertIsNotNone(solved_body(self.obj))

    def test_nodes_above_the_wrinkles_make_instances(self) -> None:
        """It was told to add faces, and the console: "positions: expected 192 vertices, got 0"."""
        made = self.obj.modifiers.new("Instances", "NODES")
        made.node_group = instances()
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            compat.move_modifier(self.obj, len(self.obj.modifiers) - 1, 0)
            self.check_said(self.obj, 'the modifier "Instances" above the wrinkles leaves no faces: add Realize Inst')
        self.assertNotIn("expected", printed.getvalue())
        self.obj.modifiers.remove(made)
        self.check_right(self.obj)

    def test_not_finite(self) -> None:
        self.body.modifiers.clear()
        self.body.data.vertices[7].co.y = self.body.data.vertices[9].co.z = math.nan
        self.obj.rumple.body = self.body
        self.check_said(self.obj, "vertex 7 of its body Human has no valid position in this frame")
        self.body.data.vertices[7].co.y = self.body.data.vertices[9].co.z = 0.0
        self.check_right(self.obj)

    def test_far_away(self) -> None:
        """Of a garment that is scaled to nothing: "body positions: vertex 32 is 1.09e+08 away"."""
        self.obj.rumple.body = self.body
        self.obj.scale = (1e-9,) * 3
        self.check_said(self.obj, r"vertex \d+ of its bodies is \S+ away from the origin in this frame: look at")

    def test_the_garment_itself(self) -> None:
        self.assertFalse(bodies.can_be_body(sleeve.output_object(self.obj)))
        self.obj.rumple.body = self.obj
        self.check_said(self.obj, "worn over itself")
        self.obj.rumple.body = None
        self.check_right(self.obj)
        self.obj.rumple.body_collection = group = bpy.data.collections.new("All")
        bpy.context.scene.collection.children.link(group)
        group.objects.link(self.obj)
        self.check_said(self.obj, "worn over itself")

    def wrinkled(self) -> bpy.types.Object:
        other = sleeve.under(self.obj, "Other")
        sleeve.make_active(other)
        other.rumple.mesh.density, other.rumple.mesh.level = "LEVEL", 1
        bpy.ops.object.rumple_add(method="MESH")
        other.rumple.body = None
        sleeve.at(6)
        return other

    def test_two_garments_over_one_another(self) -> None:
        other = self.wrinkled()
        self.obj.rumple.body = other
        self.check_right(self.obj, 7)
        other.rumple.body = self.obj
        self.check_said(self.obj, "Other is worn over Sleeve in turn")
        self.check_right(other)
        self.assertEqual(modifier.bodies(modifier.find(self.obj)), (None, None))
        other.rumple.body = None
        self.check_right(self.obj, 11)
        self.assertEqual(modifier.bodies(modifier.find(self.obj)), (other, None))

    def test_a_garment_comes_after_what_it_is_worn_over(self) -> None:
        other = self.wrinkled()
        order = [obj.name for obj, _ in bodies.in_order(list(modifier.wrinkled_objects()))]
        self.assertEqual(order, ["Other", "Sleeve"])
        other.rumple.body = self.obj
        order = [obj.name for obj, _ in bodies.in_order(list(modifier.wrinkled_objects()))]
        self.assertEqual(order, ["Sleeve", "Other"])

    def test_one_that_is_in_no_collection_yet_counts(self) -> None:
        """A script had appended it, and would link it to a collection. It was let go of for good."""
        for collection in self.body.users_collection:
            collection.objects.unlink(self.body)
        bodies.forget_all()
        self.obj.rumple.body = self.body
        self.check_right(self.obj, 8)
        scheduler.sync_all()
        self.check_right(self.obj, 9)
        self.assertEqual(self.obj.rumple.body, self.body)
        self.assertIsNotNone(solved_body(self.obj))
        bpy.context.scene.collection.objects.link(self.body)
        sleeve.at(10)
        bpy.data.objects.remove(self.body)
        self.check_right(self.obj, 11)
        self.assertIsNone(solved_body(self.obj))

    def test_an_output_object_is_no_body(self) -> None:
        self.assertFalse(bodies.can_be_body(sleeve.output_object(self.obj)))

    def test_a_deleted_body_is_none(self) -> None:
        for delete in (lambda: bpy.data.objects.remove(self.body), bpy.ops.object.delete):
            self.obj.rumple.body = self.body
            self.check_place(8)
            sleeve.make_active(self.body)
            delete()
            self.check_right(self.obj, 12)
            sleeve.at(13)
            self.assertIsNone(solved_body(self.obj))
            self.assertEqual(modifier.bodies(modifier.find(self.obj)), (None, None))
            self.assertIsNone(self.obj.rumple.body)
            self.body = sleeve.under(self.obj)

    def test_the_arrays_of_a_body_that_is_gone_are_freed(self) -> None:
        self.obj.rumple.body = self.body
        self.check_place(8)
        self.assertNotEqual(bodies._triangulated, {})
        bpy.data.objects.remove(self.body)
        scheduler.sync_all()
        self.assertEqual(bodies._triangulated, {})


class OtherPointsInRenders(Worn):

    def test_a_body_with_other_levels_of_subdivision_is_said(self) -> None:
        """Folds differed by a centimetre from those that were played, in silence."""
        subdivision = self.body.modifiers.new("Subdivision", "SUBSURF")
        self.assertNotEqual(subdivision.levels, subdivision.render_levels)
        self.assertEqual(stack_notes.of(self.obj), [])
        self.obj.rumple.body = self.body
        self.assertEqual(stack_notes.of(self.obj), [
            "Sleeve: its body Human has other levels of Subdivision in renders, so folds differ there: set the same "
            "for viewport and renders"])
        subdivision.levels = subdivision.render_levels
        self.assertEqual(stack_notes.of(self.obj), [])
        subdivision.show_render = False
        self.assertEqual(len(stack_notes.of(self.obj)), 1)


class InsideOut(Worn):

    def test_what_mirrors_it_in_a_frame_turns_it(self) -> None:
        """Nodes that scale by -1 leave the connections alone, so a body that they turned inside out pulled cloth in."""
        group = bpy.data.node_groups.new("Mirrored", "GeometryNodeTree")
        for side in ("INPUT", "OUTPUT"):
            compat.new_group_socket(group, "Geometry", side, "NodeSocketGeometry")
        row = [group.nodes.new(kind) for kind in ("NodeGroupInput", "GeometryNodeTransform", "NodeGroupOutput")]
        for before, after in zip(row, row[1:]):
            group.links.new(before.outputs[0], after.inputs[0])
        self.body.modifiers.new("Mirrored", "NODES").node_group = group
        self.obj.rumple.body = self.body
        for frame, mirrored in ((1, -1.0), (2, 1.0), (3, -1.0), (20, -1.0)):
            row[1].inputs["Scale"].default_value = (1.0, mirrored, 1.0)
            self.check_place(frame)
            self.assertGreater(outward(solved_body(self.obj)), 1e-4, frame)
        bone = bpy.data.objects["Arm"].pose.bones["upper"]
        bone.scale.x = -1.0  # and so does a bone
        self.check_place(1)
        self.assertGreater(outward(solved_body(self.obj)), 1e-4)

    def test_what_is_open_keeps_its_side_when_it_is_bent_through(self) -> None:
        """A hood that wind blows through looks like its mirrored self, and nothing has mirrored it."""
        bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8)
        hood = bpy.context.object
        bowl = bmesh.new()
        bowl.from_mesh(hood.data)
        bmesh.ops.delete(bowl, geom=[vertex for vertex in bowl.verts if vertex.co.z < 0.3], context="VERTS")
        bowl.to_mesh(hood.data)
        hood.shape_key_add(name="Basis")
        blown = hood.shape_key_add(name="Blown Through")
        for point in blown.data:
            point.co.z = 0.6 - point.co.z
        self.obj.rumple.body = hood
        triangles = []
        for value in (0.0, 1.0):
            blown.value = value
            depsgraph = bpy.context.evaluated_depsgraph_get()
            triangles.append(bodies.read(self.obj, self.obj.evaluated_get(depsgraph), depsgraph).triangles)
        np.testing.assert_array_equal(*triangles)


class OlderTree(Worn):

    def test_it_gets_the_inputs_and_modifiers_keep_theirs(self) -> None:
        group = modifier.find(self.obj).node_group
        output_object = sleeve.output_object(self.obj)
        self.make_older(group)
        self.assertFalse(modifier.can_name_bodies(modifier.find(self.obj)))
        scheduler.sync_all()
        self.assertEqual(sleeve.output_object(self.obj), output_object)
        self.body.hide_viewport = True
        self.obj.rumple.body = self.body
        sleeve.at(12)
        self.assertEqual(modifier.bodies(modifier.find(self.obj)), (self.body, None))
        self.assertGreater(np.abs(solved_body(self.obj).positions - compat.positions(self.body.data)).max(), 0.1)
        self.assertEqual(self.obj.rumple.message, "")

    def make_older(self, group: bpy.types.NodeTree) -> None:
        for name in (wrinkle_tree.BODY, wrinkle_tree.BODIES):
            if hasattr(group, "interface"):
                group.interface.remove(group.interface.items_tree[name])
            else:
                group.inputs.remove(group.inputs[name])
        group[wrinkle_tree.VERSION_KEY] = 4

    def test_linked_it_cannot_be_upgraded_and_that_is_said(self) -> None:
        self.make_older(modifier.find(self.obj).node_group)
        with mock.patch.object(wrinkle_tree, "upgrade", return_value=False):
            sleeve.at(12)
            self.assertEqual(self.obj.rumple.message, "")
            self.obj.rumple.body = self.body
            sleeve.at(13)
            self.assertRegex(self.obj.rumple.message, "^Sleeve: its node group is linked from a file of an older")
            self.assertEqual(runtimes.of(self.obj).inputs.frame, 12.0)
