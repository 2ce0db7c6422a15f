# SPDX-License-Identifier: GPL-3.0-or-later
"""Modifiers in front of the wrinkles that make points are part of the coarse mesh: played, rendered, opened again."""
from __future__ import annotations

import contextlib
import io
import tempfile
import unittest
from pathlib import Path
from unittest import mock
from typing import Any

import bmesh
import bpy
import numpy as np
from rumple.blender import compat, scheduler
from rumple.blender.frame import clip_status
from rumple.blender.objects import incoming_mesh, modifier, runtimes, stack_notes
from support import sleeve, small_renders
from support.arriving import Arriving


def in_front(obj: bpy.types.Object, kind: str, **settings: Any) -> bpy.types.Modifier:
    """A modifier before the Armature."""
    made = obj.modifiers.new(kind.title(), kind)
    for name, value in settings.items():
        setattr(made, name, value() if callable(value) else value)
    while list(obj.modifiers).index(made) > 0:
        with bpy.context.temp_override(object=obj) if hasattr(bpy.context, "temp_override") else sleeve.context():
            bpy.ops.object.modifier_move_up(modifier=made.name)
    return obj.modifiers[kind.title()]


def half(mesh: bpy.types.Mesh) -> None:
    """Of the sleeve, the part with y below 0: what Mirror is there for. Only faces that lie there whole."""
    work = bmesh.new()
    work.from_mesh(mesh)
    bmesh.ops.delete(work, geom=[v for v in work.verts if v.co.y > 1e-5], context="VERTS")
    work.to_mesh(mesh)
    work.free()


def nodes_that_subdivide() -> bpy.types.NodeTree:
    return nodes_with("GeometryNodeSubdivideMesh")


def nodes_that_move() -> bpy.types.NodeTree:
    """As simulation zones do: points move, faces stay."""
    group = nodes_with("GeometryNodeSetPosition")
    node = next(node for node in group.nodes if node.bl_idname == "GeometryNodeSetPosition")
    node.inputs["Offset"].default_value = (0.0, 0.0, 0.25)
    return group


def nodes_with(kind: str) -> bpy.types.NodeTree:
    """A node group with one node."""
    group = bpy.data.node_groups.new("Nodes", "GeometryNodeTree")
    if hasattr(group, "interface"):
        for way in ("INPUT", "OUTPUT"):
            group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    else:
        group.inputs.new("NodeSocketGeometry", "Geometry")
        group.outputs.new("NodeSocketGeometry", "Geometry")
    start, finer, end = (group.nodes.new(kind) for kind in
                         ("NodeGroupInput", kind, "NodeGroupOutput"))
    group.links.new(start.outputs[0], finer.inputs[0])
    group.links.new(finer.outputs[0], end.inputs[0])
    return group


class Stack(Arriving, unittest.TestCase):
    def garment(self, *fronts: tuple, method: str = "MESH", cut: bool = False) -> bpy.types.Object:
        """The sleeve with modifiers in front of its Armature, and then wrinkles by one click."""
        obj = sleeve.scene(wrinkles=False)
        if cut:
            mesh = obj.data
            half(mesh)
            bpy.data.objects.remove(obj)
            obj = sleeve.skinned(mesh, bpy.data.objects["Arm"])
        for kind, settings in reversed(fronts):
            in_front(obj, kind, **settings)
        obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 1, 0
        sleeve.make_active(obj)
        bpy.ops.object.rumple_add(method=method)
        bpy.context.view_layer.update()
        return obj

    def test_every_modifier_that_makes_points(self) -> None:
        for fronts, cut in (
                ([("MIRROR", dict(use_axis=(False, True, False)))], True),
                ([("SOLIDIFY", dict(thickness=0.01))], False),
                ([("SUBSURF", dict(levels=1, render_levels=1))], False),
                ([("TRIANGULATE", {})], False),
                ([("ARRAY", dict(count=2, relative_offset_displace=(0.0, 2.0, 0.0)))], False),
                ([("WELD", dict(merge_threshold=1e-5))], False),
                ([("NODES", dict(node_group=nodes_that_subdivide))], False),
                ([("MIRROR", dict(use_axis=(False, True, False))),
                  ("SUBSURF", dict(levels=1, render_levels=1))], True)):
            self.check(self.garment(*fronts, cut=cut))
            yield

    def test_nodes_that_only_move_points_deform_and_are_no_rest_shape(self) -> None:
        obj = self.garment(("NODES", dict(node_group=nodes_that_move)))
        sleeve.play(1, 4)
        self.assertEqual(obj.rumple.message, "")
        self.assertTrue(incoming_mesh.is_own(obj))
        base = runtimes.of(obj).evaluator.base
        np.testing.assert_array_equal(base.positions, compat.positions(obj.data))
        self.assertGreater(runtimes.of(obj).inputs.positions[:, 2].mean(), 0.2)
        obj = self.garment(("NODES", dict(node_group=nodes_that_move)), ("SUBSURF", dict(levels=1, render_levels=1)))
        self.assertEqual(obj.rumple.message, "")
        self.assertLess(abs(runtimes.of(obj).evaluator.base.positions[:, 2].mean()), 0.01)

    @unittest.skipUnless(hasattr(bpy.types, modifier.SIMULATION_NODE), "this Blender has no simulation zones")
    def test_wrinkles_go_behind_simulation_nodes_and_rest_is_before_them(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        group = nodes_that_move()
        start, end = (group.nodes.new(f"GeometryNodeSimulation{way}put") for way in ("In", "Out"))
        start.pair_with_output(end)
        obj.modifiers.new("Simulation", "NODES").node_group = group
        sleeve.make_active(obj)
        bpy.ops.object.rumple_add(method="MESH")
        names = [m.name for m in obj.modifiers]
        self.assertEqual(names.index("Wrinkle Mesh"), names.index("Simulation") + 1)
        self.assertTrue(incoming_mesh.is_own(obj))
        self.assertEqual(obj.rumple.message, "")

    def test_a_multires_is_in_front_of_the_wrinkles(self) -> None:
        """Blender from 4.3 on lets nothing be moved in front of it: the first click ended in a traceback and left half
        a modifier."""
        for method in ("MESH", "FIELD", "PATHS"):
            with self.subTest(method):
                obj = sleeve.scene(wrinkles=False)
                obj.modifiers.new("Multires", "MULTIRES")
                bpy.ops.object.multires_subdivide(modifier="Multires")
                obj.rumple.mesh.density, obj.rumple.mesh.level = "LEVEL", 1
                bpy.ops.object.rumple_add(method=method)
                self.assertEqual([m.type for m in obj.modifiers], ["ARMATURE", "MULTIRES", "NODES"])
                sleeve.at(8)
                self.assertEqual(runtimes.message(obj), "")

    def test_particles_are_in_front_of_the_wrinkles_or_it_is_said(self) -> None:
        """They lay at the object's origin, two metres away."""
        obj = sleeve.scene(wrinkles=False)
        obj.modifiers.new("Hair", "PARTICLE_SYSTEM")
        obj.rumple.mesh.density, obj.rumple.mesh.level = "LEVEL", 1
        bpy.ops.object.rumple_add(method="MESH")
        self.assertEqual([m.type for m in obj.modifiers], ["ARMATURE", "PARTICLE_SYSTEM", "NODES"])
        self.assertEqual(stack_notes.of(obj), [])
        obj.modifiers.new("Later", "PARTICLE_SYSTEM")
        self.assertEqual(stack_notes.of(obj), [
            "Sleeve: the particles of \"Later\" do not find their places on the fine mesh: move Wrinkle Mesh below it "
            "in the stack"])

    def test_what_loses_its_point_cache_is_said(self) -> None:
        """Folds are an edit of the mesh that a Cloth collides with, and rendered it far from where it was played."""
        obj = sleeve.scene(wrinkles=False)
        obj.modifiers.new("Collision", "COLLISION")
        obj.rumple.mesh.density, obj.rumple.mesh.level = "LEVEL", 1
        bpy.ops.mesh.primitive_grid_add(size=0.5, location=(0, 0, 2))
        sheet = bpy.context.object
        sheet.name = "Sheet"
        cloth = sheet.modifiers.new("Cloth", "CLOTH")
        cloth.point_cache.frame_end = 4
        sleeve.play(1, 4)
        self.assertFalse(cloth.point_cache.is_outdated)
        self.assertEqual(stack_notes.of(obj), [])
        sleeve.make_active(obj)
        bpy.ops.object.rumple_add(method="MESH")
        sleeve.play(1, 4)
        self.assertTrue(cloth.point_cache.is_outdated)
        note = "Sleeve: \"Sheet\" collides with it, and loses its cache with every new fold: bake that cache before " \
               "you render"
        self.assertEqual(stack_notes.of(obj), [note])
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            clip_status.check_before_render()
        self.assertIn(note, printed.getvalue())
        with mock.patch.object(modifier, "is_baked", return_value=True):
            self.assertEqual(stack_notes.of(obj), [note])
        cloth.collision_settings.collection = bpy.data.collections.new("Others")
        self.assertEqual(stack_notes.of(obj), [])
        cloth.collision_settings.collection = None
        bpy.ops.ptcache.bake_all(bake=True)
        self.assertEqual(stack_notes.of(obj), [])

    def test_every_system(self) -> None:
        for method in ("MESH", "FIELD", "PATHS"):
            self.check_only_message(self.garment(("SUBSURF", dict(levels=1, render_levels=1)), method=method))
            yield

    def check_only_message(self, obj: bpy.types.Object) -> None:
        sleeve.play(1, 6)
        self.assertEqual(obj.rumple.message, "")
        self.assertEqual(runtimes.of(obj).evaluator.coarse_count, len(self.bare(obj)))

    def test_uv_maps_materials_and_groups_are_those_of_what_arrives(self) -> None:
        obj = self.garment(("SUBSURF", dict(levels=1, render_levels=1)))
        mesh = sleeve.evaluated(obj).data
        self.assertEqual([layer.name for layer in mesh.uv_layers], ["UVMap"])
        incoming = incoming_mesh.of(obj)
        self.assertIsNot(incoming, obj.data)
        for number in (0, 1):
            weights = [g.weight for v in incoming.vertices for g in v.groups if g.group == number]
            self.assertGreater(sum(weights), 10.0)
        slots = np.empty(len(mesh.polygons), np.int32)
        mesh.polygons.foreach_get("material_index", slots)
        self.assertAlmostEqual(slots.mean(), 1.0 / (sleeve.ALONG - 1), delta=0.01)

    def test_a_setting_in_front_that_changes_the_number_is_followed(self) -> None:
        obj = self.garment(("SUBSURF", dict(levels=1, render_levels=1)))
        before = runtimes.of(obj).evaluator.coarse_count
        obj.modifiers["Subsurf"].levels = obj.modifiers["Subsurf"].render_levels = 2
        sleeve.at(2)
        sleeve.at(3)
        self.assertEqual(obj.rumple.message, "")
        self.assertGreater(runtimes.of(obj).evaluator.coarse_count, 3 * before)
        obj.modifiers.remove(obj.modifiers["Subsurf"])
        sleeve.at(4)
        sleeve.at(5)
        self.assertEqual(obj.rumple.message, "")
        self.assertEqual(runtimes.of(obj).evaluator.coarse_count, len(obj.data.vertices))
        self.assertIsNone(obj.rumple.incoming)
        self.assertEqual([m.name for m in bpy.data.meshes if m.name.endswith(incoming_mesh.SUFFIX)], [])

    def test_a_number_that_changes_from_frame_to_frame_is_said_and_the_other_frames_are_right(self) -> None:
        obj = self.garment(("BUILD", dict(frame_start=6.0, frame_duration=10.0, use_reverse=True)))
        sleeve.play(1, 5)
        self.assertEqual(obj.rumple.message, "")
        before = sleeve.shown(obj)
        for frame in (8, 5):
            for _ in range(3):  # seen, made anew, evaluated with it
                sleeve.at(frame)
            self.assertEqual(obj.rumple.message, "")
            self.assertRegex("\n".join(runtimes.of(obj).notes),
                             f'Sleeve: the modifier "Build" .* makes \\d+ vertices in frame {frame}, \\d+ before')
            self.assertEqual(runtimes.of(obj).evaluator.coarse_count, len(self.bare(obj)))
        self.assertLess(np.abs(sleeve.shown(obj) - before).max(), 0.02)

    def test_after_an_edit_it_is_made_once_and_then_no_more(self) -> None:
        """Making it touched the garment, which was taken for an edit: it was made anew in every frame."""
        obj = self.garment(("SUBSURF", dict(levels=1, render_levels=1)))
        sleeve.play(1, 2)
        made = []
        with mock.patch.object(incoming_mesh, "_evaluated", side_effect=incoming_mesh._evaluated) as evaluated:
            sleeve.play(3, 6)
            made.append(evaluated.call_count)
            obj.modifiers["Subsurf"].levels = obj.modifiers["Subsurf"].render_levels = 2
            sleeve.play(7, 10)
            made.append(evaluated.call_count)
        self.assertEqual(made[0], 0)
        self.assertIn(made[1], (1, 2))
        self.assertFalse(runtimes.of(obj).stale)
        scheduler.sync_all()
        runtimes.of(obj).stale = True
        scheduler.sync_all()
        bpy.context.view_layer.update()  # as a window does next
        self.assertFalse(runtimes.of(obj).stale)

    def test_a_hidden_garment_and_a_modifier_that_is_off_lose_nothing(self) -> None:
        obj = self.garment(("SUBSURF", dict(levels=1, render_levels=1)))
        count = len(incoming_mesh.of(obj).vertices)
        bpy.ops.object.rumple_capture_rest(frame=6)
        captured = compat.read_attribute(incoming_mesh.of(obj).attributes["rumple_rest_position"])
        obj.hide_viewport = True
        runtimes.of(obj).stale = True
        scheduler.sync_all()
        self.assertEqual(len(incoming_mesh.of(obj).vertices), count)
        obj.hide_viewport = False
        for shown in (False, True):
            obj.modifiers["Subsurf"].show_viewport = obj.modifiers["Subsurf"].show_render = shown
            runtimes.of(obj).stale = True
            scheduler.sync_all()
        now = compat.read_attribute(incoming_mesh.of(obj).attributes["rumple_rest_position"])
        np.testing.assert_array_equal(now, captured)

    def test_an_armature_as_parent_deforms_and_is_no_rest_shape(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        obj.modifiers.remove(obj.modifiers["Armature"])
        obj.parent, obj.parent_type = bpy.data.objects["Arm"], "ARMATURE"
        in_front(obj, "SUBSURF", levels=1, render_levels=1)
        obj.modifiers.new("Lattice", "LATTICE")  # poses, so the wrinkles go behind it
        sleeve.at(20)
        bpy.ops.object.rumple_add(method="MESH")
        self.assertFalse(incoming_mesh.is_own(obj))
        rest = compat.positions(incoming_mesh.of(obj))
        self.assertLess(np.abs(rest[:, 1]).max(), 1.01 * sleeve.RADIUS)  # the arm bends in y

    def test_a_duplicate_captures_for_itself(self) -> None:
        obj = self.garment(("SUBSURF", dict(levels=1, render_levels=1)))
        bpy.ops.object.rumple_capture_rest(frame=1)
        before = compat.read_attribute(incoming_mesh.of(obj).attributes["rumple_rest_position"])
        bpy.ops.object.duplicate()
        scheduler.sync_all()
        bpy.ops.object.rumple_capture_rest(frame=15)
        self.assertIsNot(bpy.context.object, obj)
        after = compat.read_attribute(incoming_mesh.of(obj).attributes["rumple_rest_position"])
        np.testing.assert_array_equal(after, before)

    def test_a_garment_that_is_worn_under_another_is_the_whole_of_it(self) -> None:
        inner = self.garment(("SUBSURF", dict(levels=1, render_levels=1)), method="FIELD")
        outer = sleeve.skinned(sleeve.tube("Outer"), bpy.data.objects["Arm"], "Outer")
        sleeve.make_active(outer)
        outer.rumple.body = inner
        bpy.ops.object.rumple_add(method="MESH")
        sleeve.play(1, 2)
        self.assertEqual(outer.rumple.message, "")
        body, count = runtimes.of(outer).inputs.body, len(incoming_mesh.of(inner).vertices)
        self.assertEqual(len(body.positions), count)
        self.assertEqual(sorted(set(body.triangles.ravel().tolist())), list(range(count)))

    def test_the_fingerprint_sees_every_setting(self) -> None:
        obj = self.garment(("MIRROR", dict(use_axis=(False, True, False))), cut=True)
        before = incoming_mesh.stack_fingerprint(obj)
        self.assertEqual(before, incoming_mesh.stack_fingerprint(obj))
        obj.modifiers["Mirror"].use_axis = (False, True, True)
        self.assertNotEqual(before, incoming_mesh.stack_fingerprint(obj))

    def test_renders_show_it_where_they_have_the_same_points_and_say_so_where_not(self) -> None:
        obj = small_renders.stage("CYCLES")
        bpy.ops.object.rumple_remove()
        in_front(obj, "SUBSURF", levels=1, render_levels=1)
        bpy.ops.object.rumple_add(method="MESH")
        small_renders.still(4)
        self.assertEqual(obj.rumple.message, "")
        self.assertGreater(np.abs(runtimes.of(obj).result.offset).max(), 1e-4)
        obj.modifiers["Subsurf"].render_levels = 2
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            small_renders.still(5)
        self.assertRegex(said.getvalue(), 'Rumple: Sleeve: the modifier "Subsurf".* number of vertices .* set the same')

    def test_in_one_render_job_frames_before_and_after_a_change_are_as_without_it(self) -> None:
        pictures: dict[tuple[int, ...], dict[int, np.ndarray]] = {}
        for levels in ((1, 1, 1), (1, 2, 1), ()):  # of the Subdivision in front; (): no wrinkles
            obj = small_renders.stage("CYCLES")
            bpy.ops.object.rumple_remove()
            made = in_front(obj, "SUBSURF", levels=1, render_levels=1)
            obj.rumple.mesh.stateless = True  # else the frames after it begin anew, and differ a little
            bpy.ops.object.rumple_add(method="MESH")
            modifier.find(obj).show_render = bool(levels)
            for frame, level in zip((1, 3, 5), levels or (1, 2, 1)):
                made.render_levels = level
                made.keyframe_insert("render_levels", frame=frame)
            for key in next(compat.keyed_curves(obj.animation_data)).keyframe_points:
                key.interpolation = "CONSTANT"
            with contextlib.redirect_stdout(io.StringIO()) as said:
                pictures[levels] = small_renders.clip(1, 6)
            self.assertEqual("no wrinkles here: set the same" in said.getvalue(), levels == (1, 2, 1))
        even, changed, bare = pictures.values()
        for frame, picture in changed.items():
            np.testing.assert_array_equal(picture, (bare if frame in (3, 4) else even)[frame], f"frame {frame}")
        self.assertGreater(np.abs(even[6] - bare[6]).max(), 0.05)

    def test_one_that_is_switched_off_and_on_is_followed(self) -> None:
        obj = self.garment(("MIRROR", dict(use_axis=(False, True, False))), cut=True)
        mirror = obj.modifiers["Mirror"]
        for frame, shown in ((2, False), (4, True)):
            mirror.show_viewport = mirror.show_render = shown
            sleeve.play(frame, frame + 1)
            self.assertEqual(obj.rumple.message, "")
            self.assertEqual(incoming_mesh.is_own(obj), not shown)

    def test_it_is_kept_in_the_file_and_frames_are_the_same_bits(self) -> None:
        obj = self.garment(("SUBSURF", dict(levels=1, render_levels=1)))
        sleeve.play(1, 4)
        before = sleeve.shown(obj)
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "stack.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
            obj = bpy.data.objects["Sleeve"]
            sleeve.play(1, 4)
            np.testing.assert_array_equal(sleeve.shown(obj), before)
        bpy.ops.object.rumple_remove()
        self.assertEqual([m.name for m in bpy.data.meshes if m.name.endswith(incoming_mesh.SUFFIX)], [])

    def test_paint_on_the_artists_vertices_counts(self) -> None:
        obj = self.garment(("SUBSURF", dict(levels=1, render_levels=1)))
        bpy.ops.object.rumple_paint(group="radius")
        group = obj.vertex_groups["Rumple Radius"]
        group.add(range(len(obj.data.vertices)), 0.0, "REPLACE")
        obj.data.update()
        sleeve.play(1, 8)
        self.assertEqual(obj.rumple.message, "")
        self.assertLess(np.abs(runtimes.of(obj).result.offset).max(), 1e-4)


if __name__ == "__main__":
    unittest.main()
