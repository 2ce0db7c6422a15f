# SPDX-License-Identifier: GPL-3.0-or-later
"""The first click on garments as they come: appended, overridden, with the stacks that artists leave."""
from __future__ import annotations

import math
import tempfile
import threading
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

import bmesh
import bpy
import numpy as np
from rumple.blender import compat, scheduler
from rumple.blender.objects import mesh_reader, modifier, painted_maps, properties, runtimes, stack_notes
from rumple.blender.ui import operators
from rumple.core.paint.hangs_free import FREE
from rumple.native import kernels
from support import face, sleeve

WIDE = 0.16  # metres that the middle of the sleeve is wider
GROUP = mesh_reader.MESH_GROUPS[FREE]


def add_behind(obj: bpy.types.Object, kind: str, **settings: Any) -> bpy.types.Modifier:
    made = obj.modifiers.new(kind.title(), kind)
    for name, value in settings.items():
        setattr(made, name, value)
    return made


class Appended(unittest.TestCase):
    """Blender puts objects that are appended and are in no collection into the scene: three shirts were rendered."""

    def setUp(self) -> None:
        self.library = str(Path(self.enterContext(tempfile.TemporaryDirectory())) / "library.blend")

    def append(self, name: str) -> None:
        bpy.ops.wm.save_as_mainfile(filepath=self.library, copy=True)
        sleeve.empty_file()
        bpy.ops.wm.append(directory=f"{self.library}/Object/", filename=name)
        scheduler.sync_all()
        sleeve.at(5)

    def test_only_the_garment_is_in_the_scene_and_removed_it_leaves_nothing(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        sleeve.make_active(obj)
        bpy.ops.object.rumple_add(method="MESH")
        self.append("Sleeve")
        self.assertEqual({obj.name for obj in bpy.context.scene.objects}, {"Sleeve", "Arm"})
        self.assertEqual(len(modifier.outputs(modifier.find(bpy.data.objects["Sleeve"]))), 2)
        sleeve.make_active(bpy.data.objects["Sleeve"])
        bpy.ops.object.rumple_remove()
        self.assertEqual({obj.name for obj in bpy.data.objects}, {"Sleeve", "Arm"})

    def test_a_face_with_maps_too(self) -> None:
        obj, rig = face.scene()
        face.two_poses(obj, rig)
        before = {obj.name for obj in bpy.context.scene.objects if obj.type in ("MESH", "ARMATURE")}
        self.append(obj.name)
        self.assertEqual({obj.name for obj in bpy.context.scene.objects if obj.type in ("MESH", "ARMATURE")}, before)


class Stacks(unittest.TestCase):

    def setUp(self) -> None:
        self.obj = sleeve.scene(wrinkles=False)
        sleeve.make_active(self.obj)

    def click(self, method: str = "MESH") -> list[str]:
        """What is said of the stack then."""
        bpy.ops.object.rumple_add(method=method)
        return stack_notes.of(self.obj)

    def test_a_garment_is_healed_once_and_where_no_thread_is_left_it_is_built_all_the_same(self) -> None:
        self.obj.rumple.mesh.property_unset("base_cloth")  # the click looks whether it is a garment, and then builds
        with mock.patch.object(threading.Thread, "start", side_effect=RuntimeError("can't start new thread")), \
                mock.patch.object(kernels, "heal_mesh", wraps=kernels.heal_mesh) as heal_mesh:
            heal_mesh.__name__ = "heal_mesh"
            self.click()
        self.assertEqual(heal_mesh.call_count, 1)
        sleeve.at(8)
        self.assertTrue(sleeve.is_fine(self.obj))
        self.assertEqual(self.obj.rumple.message, "")

    def test_what_only_smooths_behind_a_subdivision_stays_behind_the_wrinkles(self) -> None:
        """They went behind the Subdivision, and renders had no wrinkles."""
        target = bpy.data.objects.new("Target", self.obj.data.copy())
        for kind, settings in (("SMOOTH", {}), ("DISPLACE", dict(strength=0.001)), ("SHRINKWRAP", dict(target=target))):
            with self.subTest(kind):
                add_behind(self.obj, "SUBSURF", levels=1, render_levels=2)
                add_behind(self.obj, kind, **settings)
                self.assertEqual(self.click(), [])
                self.assertEqual([m.type for m in self.obj.modifiers], ["ARMATURE", "NODES", "SUBSURF", kind])
                bpy.ops.object.rumple_remove()
                for m in list(self.obj.modifiers)[1:]:
                    self.obj.modifiers.remove(m)

    def test_what_poses_or_is_bound_keeps_its_points(self) -> None:
        for kind, settings in (("LATTICE", {}), ("CORRECTIVE_SMOOTH", dict(rest_source="BIND"))):
            with self.subTest(kind):
                add_behind(self.obj, "SUBSURF", levels=1, render_levels=1)
                add_behind(self.obj, kind, **settings)
                self.assertEqual(modifier.place_behind_deforming(self.obj), 3)
                for m in list(self.obj.modifiers)[1:]:
                    self.obj.modifiers.remove(m)

    def test_what_moves_it_behind_a_subdivision_is_followed(self) -> None:
        """Wave moves far, and where nothing else poses the mesh, Displace is all there is."""
        for posed, kind in ((True, "WAVE"), (False, "DISPLACE")):
            with self.subTest(kind):
                obj = sleeve.scene(wrinkles=False)
                if not posed:
                    obj.modifiers.clear()
                add_behind(obj, "SUBSURF", levels=1, render_levels=1)
                add_behind(obj, kind)
                self.assertEqual(modifier.place_behind_deforming(obj), len(obj.modifiers))

    def test_other_points_in_renders_are_said_before_it_is_rendered(self) -> None:
        made = add_behind(self.obj, "SUBSURF", levels=1, render_levels=2)
        bpy.context.view_layer.objects.active = self.obj
        self.obj.modifiers.move(1, 0) if hasattr(self.obj.modifiers, "move") else bpy.ops.object.modifier_move_up(
            modifier=made.name)
        self.assertRegex("\n".join(self.click()), '^Sleeve: the modifier "Subsurf" above .* other vertices in renders')
        made = self.obj.modifiers["Subsurf"]
        made.render_levels = 1
        self.assertEqual(stack_notes.of(self.obj), [])
        bpy.context.scene.render.use_simplify, bpy.context.scene.render.simplify_subdivision = True, 0
        self.assertRegex("\n".join(stack_notes.of(self.obj)), "^Sleeve: Simplify .*other vertices.*switch Sim")
        bpy.context.scene.render.use_simplify, made.show_render = False, False
        self.assertRegex("\n".join(stack_notes.of(self.obj)), "other vertices in renders")

    def test_a_subdivision_behind_that_makes_millions_is_said(self) -> None:
        add_behind(self.obj, "SUBSURF", levels=1, render_levels=2)
        self.assertEqual(self.click(), [])
        self.obj.modifiers["Subsurf"].render_levels = 4
        count = runtimes.of(self.obj).evaluator.vertex_count * 256
        self.assertGreater(count, 1_000_000)
        self.assertRegex("\n".join(stack_notes.of(self.obj)), f"makes {count:,} vertices in renders.* levels to 0")

    def test_an_armature_modifier_without_an_armature_is_said_and_makes_no_cloth_hang(self) -> None:
        self.obj.modifiers[0].object = None
        self.obj.rumple.mesh.property_unset("base_cloth")
        notes = self.click()
        self.assertRegex("\n".join(notes), 'the modifier "Armature" has no armature: choose it there')
        self.assertEqual(properties.group_of(self.obj).base_cloth, "OFF")

    def test_sculpt_mode_is_named(self) -> None:
        bpy.ops.object.mode_set(mode="SCULPT")
        self.addCleanup(bpy.ops.object.mode_set, mode="OBJECT")
        self.assertFalse(bpy.ops.object.rumple_add.poll())
        with self.assertRaisesRegex(RuntimeError, "Leave Sculpt Mode first"):
            bpy.ops.object.rumple_add(method="MESH")

    def test_a_loose_vertex_far_away_changes_no_length(self) -> None:
        lengths = []
        for far in (False, True):
            obj = sleeve.scene(wrinkles=False)
            obj.rumple.mesh.property_unset("base_cloth")
            if far:
                obj.data.vertices.add(1)
                obj.data.vertices[-1].co = (0.0, 0.0, 30.0)
            sleeve.make_active(obj)
            bpy.ops.object.rumple_add(method="MESH")
            settings = properties.group_of(obj)
            lengths.append((settings.wavelength, settings.room, settings.thickness))
        np.testing.assert_array_equal(*lengths)


if __name__ == "__main__":
    unittest.main()


class Thick(unittest.TestCase):
    """A garment whose thickness is modelled has no opening: it was no cloth. Its outer side is now."""

    def setUp(self) -> None:
        self.obj = sleeve.scene(wrinkles=False)
        sleeve.under(self.obj, "Human")
        for settings in (self.obj.rumple.mesh, self.obj.rumple.field):
            settings.property_unset("base_cloth")

    def thicken(self, apply: bool) -> None:
        solidify = self.obj.modifiers.new("Thickness", "SOLIDIFY")
        solidify.thickness, solidify.offset = 0.004, -1.0
        compat.move_modifier(self.obj, len(self.obj.modifiers) - 1, 0)
        sleeve.make_active(self.obj)
        if apply:
            bpy.ops.object.modifier_apply(modifier="Thickness")

    def click(self, method: str) -> list[str]:
        """What is said of it."""
        sleeve.make_active(self.obj)
        with mock.patch.object(operators.OBJECT_OT_rumple_add, "_report") as report:
            bpy.ops.object.rumple_add(method=method)
        return report.call_args.args[1]

    def test_it_hangs_by_its_outer_side_applied_or_not(self) -> None:
        for apply in (False, True):
            with self.subTest(apply=apply):
                self.setUp()
                self.thicken(apply)
                self.assertEqual(self.click("MESH"), [])
                self.assertEqual(self.obj.rumple.mesh.base_cloth, "HANG")
                self.assertAlmostEqual(runtimes.of(self.obj).evaluator.outer.thickness, 0.004, delta=0.0005)
                sleeve.play(last=4)
                self.assertEqual(self.obj.rumple.message, "")
                self.assertGreater(len(sleeve.shown(self.obj)), 4 * sleeve.AROUND * sleeve.ALONG)

    def test_under_a_field_it_hangs_by_its_outer_side_as_well(self) -> None:
        self.thicken(apply=True)
        self.assertEqual(self.click("FIELD"), [])
        self.assertEqual(self.obj.rumple.field.base_cloth, "HANG")
        self.assertEqual(self.obj.rumple.body.name, "Human")
        sleeve.play(last=2)
        evaluator = runtimes.of(self.obj).evaluator
        self.assertAlmostEqual(evaluator.cloth_mesh.outer.thickness, 0.004, delta=0.0005)

    def test_a_glove_is_told_that_it_is_no_cloth(self) -> None:
        mesh = self.obj.data
        vertices, faces = [v.co[:] for v in mesh.vertices], [tuple(p.vertices) for p in mesh.polygons]
        mesh.clear_geometry()
        mesh.from_pydata(vertices, [], [*faces, tuple(range(len(vertices) - sleeve.AROUND, len(vertices)))])
        self.assertRegex(self.click("MESH")[0], "^Sleeve: it lies over Human but is no sheet, as a cape or a flag is, "
                         "and has fewer than two openings, as hats and gloves have, so it is not made cloth")
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "OFF")


class HangsFree(unittest.TestCase):
    """It is painted where a garment hangs free of the body."""

    def setUp(self) -> None:
        self.obj = sleeve.to_be_cloth()

    def widen(self, narrow: int = 2) -> np.ndarray:
        """A balloon sleeve, of a shorter balloon the greater `narrow` is. (n,) bool: the vertices in its middle."""
        rest = compat.positions(self.obj.data)
        bulge = np.sin(np.pi * np.clip(rest[:, 0] / sleeve.LENGTH, 0.0, 1.0)) ** narrow
        rest[:, 1:] *= 1.0 + WIDE / sleeve.RADIUS * bulge[:, None]
        self.obj.data.vertices.foreach_set("co", rest.ravel())
        self.obj.data.update()
        return bulge > 0.9

    def click(self, method: str = "MESH") -> np.ndarray:
        """(n,) weights of the map; empty without one."""
        sleeve.make_active(self.obj)
        bpy.ops.object.rumple_add(method=method)
        if GROUP not in self.obj.vertex_groups:
            return np.zeros(0, np.float32)
        return mesh_reader.group_weights(self.obj, self.obj.data, [GROUP])[:, 0]

    def test_a_balloon_sleeve_hangs_free_in_its_middle_and_is_worn_at_its_cuffs(self) -> None:
        middle = self.widen()
        for method in ("MESH", "FIELD", "PATHS"):
            with self.subTest(method):
                weights = self.click(method)
                self.assertGreater(weights[middle].min(), 0.9)
                self.assertLess(weights[[0, -1]].max(), 0.25)  # a ring of vertices is far from the next
                settings = getattr(self.obj.rumple, method.lower())
                self.assertAlmostEqual(settings.free_room, 0.25, places=2)
                sleeve.at(4)
                bpy.ops.object.rumple_remove()
                self.obj.vertex_groups.remove(self.obj.vertex_groups[GROUP])

    def test_it_is_found_where_faces_look_inwards_and_in_centimetres(self) -> None:
        middle = self.widen()
        self.obj.data.flip_normals()
        scene = bpy.context.scene
        scene.unit_settings.scale_length = 0.01
        for obj in (self.obj, bpy.data.objects["Human"], bpy.data.objects["Arm"]):
            if obj.parent is None:
                obj.scale = (100.0, 100.0, 100.0)
        bpy.context.view_layer.update()
        weights = self.click()
        self.assertGreater(weights[middle].min(), 0.9)

    def test_a_sheet_hangs_from_its_upper_end(self) -> None:
        """A cape got no base cloth, for it has no opening, and stayed the stiff cone that it was animated as."""
        half = bmesh.new()
        half.from_mesh(self.obj.data)
        bmesh.ops.delete(half, geom=[v for v in half.verts if v.co.y < -1e-4], context="VERTS")
        half.to_mesh(self.obj.data)
        for name in ("Sleeve", "Human", "Arm"):
            if bpy.data.objects[name].parent is None:
                bpy.data.objects[name].rotation_euler.y = math.pi / 2.0  # X points down
        bpy.context.view_layer.update()
        weights, along = self.click(), compat.positions(self.obj.data)[:, 0]
        settings = self.obj.rumple.mesh
        self.assertEqual(settings.base_cloth, "HANG")
        self.assertEqual(settings.up, "-X")
        self.assertEqual(weights[along == along.min()].max(), 0.0)
        self.assertEqual(weights[along > 0.5 * along.max()].min(), 1.0)
        pinned = painted_maps.follow_weights(self.obj)
        self.assertEqual(pinned[along == along.min()].min(), 1.0)
        self.assertEqual(pinned[along == along.max()].max(), 0.0)

    def test_a_thick_garment_counts_by_its_outer_side(self) -> None:
        """A sixth of that hangs free, and a twelfth of all vertices, of which a tenth was needed."""
        self.widen(narrow=10)
        solidify = self.obj.modifiers.new("Thickness", "SOLIDIFY")
        solidify.thickness, solidify.offset = 0.004, -1.0
        compat.move_modifier(self.obj, len(self.obj.modifiers) - 1, 0)
        sleeve.make_active(self.obj)
        bpy.ops.object.modifier_apply(modifier="Thickness")
        weights = self.click()
        self.assertLess((weights > 0.5).mean(), 0.1)
        self.assertGreater(weights.max(), 0.5)

    def test_it_is_of_the_vertices_that_no_modifier_made(self) -> None:
        """The click stopped with an IndexError where a Mirror stood in front: its vertices have no paint."""
        middle = self.widen()
        front = (("MIRROR", {}), ("SOLIDIFY", {"thickness": 0.004, "offset": 1.0}),
                 ("SOLIDIFY", {"thickness": 0.004, "offset": -1.0}), ("SUBSURF", {"levels": 1}),
                 ("DECIMATE", {"ratio": 0.5}))
        for kind, values in front:
            with self.subTest(kind, **values):
                added = self.obj.modifiers.new("Front", kind)
                for name, value in values.items():
                    setattr(added, name, value)
                compat.move_modifier(self.obj, len(self.obj.modifiers) - 1, 0)
                weights = self.click()
                self.assertGreater(weights[middle].mean(), 0.9)
                bpy.ops.object.rumple_remove()
                self.obj.vertex_groups.remove(self.obj.vertex_groups[GROUP])
                self.obj.modifiers.remove(self.obj.modifiers["Front"])

    def test_half_a_body_and_a_mirror_count_as_the_whole(self) -> None:
        """Half of a skirt hung free: the other half of the body was not known."""
        self.widen()
        work = bmesh.new()
        work.from_mesh(self.obj.data)
        bmesh.ops.subdivide_edges(work, edges=work.edges[:], cuts=3, use_grid_fill=True)
        work.to_mesh(self.obj.data)
        work.free()
        whole, body = self.click(), bpy.data.objects["Human"]
        bpy.ops.object.rumple_remove()
        self.obj.vertex_groups.remove(self.obj.vertex_groups[GROUP])
        work = bmesh.new()
        work.from_mesh(body.data)
        bmesh.ops.delete(work, geom=[v for v in work.verts if v.co.y > 1e-5], context="VERTS")
        work.to_mesh(body.data)
        work.free()
        body.modifiers.new("Mirror", "MIRROR").use_axis = (False, True, False)
        compat.move_modifier(body, len(body.modifiers) - 1, 0)
        meshes = sleeve.names(bpy.data.meshes)
        np.testing.assert_allclose(self.click(), whole, atol=0.051)
        bpy.ops.object.rumple_remove()
        self.assertEqual(sleeve.names(bpy.data.meshes), meshes)

    def test_a_plain_sleeve_has_no_map(self) -> None:
        self.assertEqual(len(self.click()), 0)

    def test_without_a_body_nothing_is_known(self) -> None:
        self.widen()
        bpy.data.objects.remove(bpy.data.objects["Human"])
        self.assertEqual(len(self.click()), 0)

    def test_where_the_body_was_deleted_nothing_is_known(self) -> None:
        # The edge of a hole was the nearest: the front of a sweater hung free of the waistband of the trousers.
        self.widen()
        body = bmesh.new()
        body.from_mesh(bpy.data.objects["Human"].data)
        elsewhere = [v for v in body.verts if abs(v.co.x - 0.5 * sleeve.LENGTH) > 0.04]
        bmesh.ops.delete(body, geom=elsewhere, context="VERTS")  # a strip is left: each face of it is at an edge
        body.to_mesh(bpy.data.objects["Human"].data)
        self.assertGreater(len(body.faces), 0)
        self.obj.rumple.body = bpy.data.objects["Human"]
        self.assertEqual(len(self.click()), 0)

    def test_what_was_painted_stays(self) -> None:
        self.widen()
        self.obj.vertex_groups.new(name=GROUP).add([3], 0.25, "REPLACE")
        weights = self.click()
        self.assertEqual((weights[3], np.count_nonzero(weights)), (0.25, 1))

    def test_the_map_is_among_those_that_are_painted(self) -> None:
        self.widen()
        self.click()
        found = {one.key: one for one in painted_maps.of(self.obj)}
        self.assertTrue(found[FREE].exists)
        self.assertEqual((found[FREE].label, found[FREE].rest), ("Hangs Free", 0.0))
