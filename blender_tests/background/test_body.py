# SPDX-License-Identifier: GPL-3.0-or-later
"""What garments are worn over: it arrives where it stands in the frame, hidden or not."""
from __future__ import annotations

import os
import tempfile
import unittest
from dataclasses import replace
from typing import Callable
from unittest import mock

import bpy
import numpy as np
from rumple.blender import compat, scheduler
from rumple.blender.frame import clip_status
from rumple.blender.objects import bodies, modifier, runtimes
from rumple.core.mesh.body import Body
from support import sleeve, small_renders
from support.worn_sleeve import Worn, outward, placed, posed, solved_body


class Places(Worn):

    def test_without_a_body_there_is_none(self) -> None:
        sleeve.at(5)
        self.assertIsNone(solved_body(self.obj))

    def test_it_arrives_posed(self) -> None:
        self.obj.rumple.body = self.body
        for frame in (1, 12, 20, 3):
            self.check_place(frame)
            self.assertEqual(solved_body(self.obj).positions.dtype, np.float32)
            self.assertEqual(solved_body(self.obj).triangles.dtype, np.int32)
            self.assertEqual(len(solved_body(self.obj).triangles), 2 * len(self.body.data.polygons))
            self.assertEqual(self.obj.rumple.message, "")
        self.assertEqual(runtimes.of(self.obj).inputs.frame, 3.0)

    def test_in_the_space_of_a_garment_that_is_moved_turned_and_scaled(self) -> None:
        self.obj.rumple.body = self.body
        sleeve.at(1)
        self.assertGreater(outward(solved_body(self.obj)), 1e-4)
        for garment, body in ((1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)):
            placed(self.obj, (1, 2, 3), (0.3, 0.5, -0.7), (0.5 * garment, 2.0, 1.5))
            placed(self.body, (-1, 0.5, 0), (1.1, 0.2, 0.4), (1.5, body, 0.8))
            for frame in (7, 18):
                self.check_place(frame, f"{garment} {body}")
            sleeve.at(1)
            self.assertGreater(outward(solved_body(self.obj)), 1e-4)

    def test_curves_texts_and_metaballs_are_bodies_hidden_or_not(self) -> None:
        """They were silently left out. As Blender converts them to a mesh; each is 5 centimetres around."""
        made = {"CURVE": bpy.ops.curve.primitive_bezier_circle_add, "SURFACE":
                bpy.ops.surface.primitive_nurbs_surface_sphere_add, "FONT": bpy.ops.object.text_add,
                "META": bpy.ops.object.metaball_add}
        for kind, add in made.items():
            for hidden in (False, True) if kind != "META" else (False,):  # Blender makes no surface of hidden ones
                with self.subTest(kind=kind, hidden=hidden):
                    self.setUp()
                    add(location=(0.3, 0.1, 0.2))
                    thing = bpy.context.object
                    self.assertEqual(thing.type, kind)
                    thing.scale = (0.05, 0.05, 0.05)
                    if kind in ("CURVE", "FONT"):
                        thing.data.bevel_depth = 0.4
                    bpy.context.view_layer.update()
                    expected = sleeve.evaluated(thing).to_mesh()
                    expected = (expected.vertices[0].co.copy(), len(expected.vertices))
                    thing.hide_viewport = thing.hide_render = hidden
                    self.obj.rumple.body = thing
                    for frame in (3, 4, 9):
                        sleeve.at(frame)
                    found = solved_body(self.obj)
                    self.assertEqual(self.obj.rumple.message, "")
                    self.assertEqual(len(found.positions), expected[1])
                    np.testing.assert_allclose(found.positions[0], 0.05 * np.array(expected[0]) + (0.3, 0.1, 0.2),
                                               atol=1e-6)
                    self.assertGreater(outward(found), 0.0)

    def test_a_baked_clip_knows_the_shape_of_a_curve(self) -> None:
        bpy.ops.curve.primitive_bezier_circle_add()
        self.obj.rumple.body = circle = bpy.context.object
        circle.data.bevel_depth = 0.1
        before = clip_status.inputs_fingerprint(self.obj, bpy.context.scene)
        self.assertTrue(clip_status.is_baked_from(before, self.obj, bpy.context.scene))
        circle.data.bevel_depth = 0.2
        self.assertFalse(clip_status.is_baked_from(before, self.obj, bpy.context.scene))

    def test_the_mesh_of_a_curve_is_freed_whatever_goes_wrong(self) -> None:
        curve, wrong = mock.Mock(type="CURVE"), mock.Mock(side_effect=KeyError)
        with mock.patch.object(clip_status.mesh_reader, "basis_positions", wrong), self.assertRaises(KeyError):
            clip_status._content(curve)
        curve.to_mesh_clear.assert_called_once_with()

    def test_curves_without_faces_are_passed_over_in_a_collection(self) -> None:
        collection = bpy.data.collections.new("Bodies")
        bpy.context.scene.collection.children.link(collection)
        bpy.ops.curve.primitive_bezier_circle_add()
        line = bpy.context.object
        for obj in (self.body, line):
            collection.objects.link(obj)
        self.obj.rumple.body_collection = collection
        sleeve.at(3)
        self.assertEqual(len(solved_body(self.obj).positions), len(self.body.data.vertices))
        self.assertEqual(runtimes.of(self.obj).left_out, "")
        line.data.bevel_depth = 0.1
        self.assertTrue(bodies.can_be_body(line))
        line.rumple_guide.is_guide = True  # of folds, whatever it looks like
        self.assertFalse(bodies.can_be_body(line))
        line.rumple_guide.is_guide, line.data.bevel_depth = False, 0.0
        self.obj.rumple.body = line
        sleeve.at(4)
        self.assertRegex(runtimes.of(self.obj).left_out, "^Sleeve: its body .*Circle has no faces and is left out")

    def test_a_body_that_is_moved_is_seen_at_once(self) -> None:
        self.obj.rumple.body = self.body
        sleeve.at(9)
        before = solved_body(self.obj)
        self.body.location.z = 0.25
        bpy.context.view_layer.update()
        np.testing.assert_allclose(solved_body(self.obj).positions, before.positions + (0, 0, 0.25), atol=1e-6)

    def test_its_modifiers_count_and_its_triangles_stay_while_it_bends(self) -> None:
        self.body.modifiers.new("Subdivision", "SUBSURF").levels = 1
        self.obj.rumple.body = self.body
        sleeve.at(2)
        triangles = solved_body(self.obj).triangles
        self.assertEqual(len(triangles), 8 * len(self.body.data.polygons))
        self.check_place(14)
        np.testing.assert_array_equal(solved_body(self.obj).triangles, triangles)
        self.body.modifiers["Subdivision"].show_viewport = False
        self.check_place(15)
        self.assertEqual(len(solved_body(self.obj).triangles), 2 * len(self.body.data.polygons))

    def test_one_whose_faces_look_inwards_is_turned(self) -> None:
        self.obj.rumple.body = self.body
        sleeve.at(1)
        self.assertGreater(outward(solved_body(self.obj)), 1e-4)
        self.body.data.flip_normals()
        sleeve.at(2)
        self.assertGreater(outward(solved_body(self.obj)), 1e-4)

    def test_several_are_one(self) -> None:
        other = sleeve.under(self.obj, "Other", 0.5)
        group = bpy.data.collections.new("Bodies")
        bpy.context.scene.collection.children.link(group)
        group.objects.link(other)
        group.objects.link(self.body)
        group.objects.link(bpy.data.objects["Arm"])
        self.obj.rumple.body, self.obj.rumple.body_collection = self.body, group
        sleeve.at(13)
        found, count = solved_body(self.obj), len(self.body.data.vertices)
        np.testing.assert_allclose(found.positions[:count], posed(self.body), atol=1e-6)
        np.testing.assert_allclose(found.positions[count:], posed(other), atol=1e-6)
        np.testing.assert_array_equal(found.triangles[len(found.triangles) // 2:],
                                      found.triangles[:len(found.triangles) // 2] + count)
        self.assertEqual(self.obj.rumple.message, "")

    def test_a_wrinkled_body_is_raised_to_its_folds_but_not_by_waves_that_materials_draw(self) -> None:
        twin = sleeve.under(self.obj, "Twin")
        sleeve.make_active(self.body)
        self.body.rumple.mesh.density, self.body.rumple.mesh.level = "LEVEL", 1
        for method in ("MESH", "FIELD"):
            bpy.ops.object.rumple_add(method=method)
            self.obj.rumple.body = self.body
            for frame in (6, 19):
                sleeve.at(frame)
                found, bare = solved_body(self.obj), posed(twin)
                if method == "FIELD":
                    np.testing.assert_allclose(found.positions, bare, atol=1e-6)
                else:
                    self.assertGreater(outward(found), 1.01 * outward(replace(found, positions=bare)))
            bpy.ops.object.rumple_remove()

    def test_a_stored_frame_is_of_its_body(self) -> None:
        self.obj.rumple.body = self.body
        seen = []
        for place in (0.0, 0.1, 0.1, 0.0):
            self.body.location.y = place
            sleeve.at(8)
            seen.append(runtimes.of(self.obj).evaluator.frame_cache.get(8.0).input_digest)
        self.assertEqual(seen[1], seen[2])
        self.assertEqual(seen[0], seen[3])
        self.assertNotEqual(seen[0], seen[1])

    def test_while_the_body_is_edited_the_last_picture_stays(self) -> None:
        self.obj.rumple.body = self.body
        sleeve.at(5)
        sleeve.make_active(self.body)
        bpy.ops.object.mode_set(mode="EDIT")
        sleeve.at(12)
        self.assertEqual(runtimes.of(self.obj).inputs.frame, 5.0)
        bpy.ops.object.mode_set(mode="OBJECT")
        self.check_place(12)
        self.assertEqual(self.obj.rumple.message, "")

    def test_a_garment_whose_mesh_is_edited_elsewhere_waits(self) -> None:
        twin = self.obj.copy()  # a linked duplicate
        bpy.context.scene.collection.objects.link(twin)
        sleeve.at(5)
        sleeve.make_active(twin)
        bpy.ops.object.mode_set(mode="EDIT")
        runtimes.of(self.obj).stale = True
        scheduler.sync_all()
        self.assertEqual(self.obj.rumple.message, "")
        bpy.ops.object.mode_set(mode="OBJECT")
        sleeve.at(6)
        self.assertEqual(self.obj.rumple.message, "")


class Hidden(Worn):
    """Posed all the same, for the modifier names it."""

    def hide(self, how: str) -> None:
        if how == "collection":
            group = bpy.data.collections.new("Hidden")
            bpy.context.scene.collection.children.link(group)
            bpy.context.scene.collection.objects.unlink(self.body)
            group.objects.link(self.body)
            bpy.context.view_layer.layer_collection.children["Hidden"].exclude = True
        elif how == "hide_set":
            self.body.hide_set(True)
        else:
            self.body.hide_viewport = self.body.hide_render = True

    def expected(self) -> dict[int, np.ndarray]:
        """Positions at some frames, from a twin that is not hidden."""
        twin, found = sleeve.under(self.obj, "Twin"), {}
        for frame in (4, 11, 20):
            sleeve.at(frame)
            found[frame] = posed(twin)
        bpy.data.objects.remove(twin)
        return found

    def check(self, how: str, by_collection: bool) -> None:
        expected = self.expected()
        if by_collection:
            group = bpy.data.collections.new("Worn")
            bpy.context.scene.collection.children.link(group)
            group.objects.link(self.body)
            if how != "hide_set":
                group.hide_viewport = group.hide_render = True
            self.obj.rumple.body_collection = group
        else:
            self.obj.rumple.body = self.body
        self.hide(how)
        for frame, positions in expected.items():
            sleeve.at(frame)
            np.testing.assert_allclose(solved_body(self.obj).positions, positions, atol=1e-6, err_msg=str(frame))
        bpy.data.objects["Arm"].animation_data.action = None
        bpy.data.objects["Arm"].pose.bones["lower"].rotation_euler.z = 0.0
        bpy.context.view_layer.update()
        rest = compat.positions(self.body.data)
        np.testing.assert_allclose(solved_body(self.obj).positions, rest, atol=1e-6)

    def test_in_viewport_and_render(self) -> None:
        self.check("hide_viewport", by_collection=False)

    def test_by_its_eye(self) -> None:
        self.check("hide_set", by_collection=False)

    def test_by_a_collection_that_is_off(self) -> None:
        self.check("collection", by_collection=False)

    def test_among_bodies(self) -> None:
        for how in ("hide_viewport", "hide_set", "collection"):
            with self.subTest(how):
                self.setUp()
                self.check(how, by_collection=True)

    def test_saved_and_opened(self) -> None:
        expected = self.expected()
        self.obj.rumple.body = self.body
        self.hide("hide_viewport")
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "scene.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
        for frame, positions in expected.items():
            sleeve.at(frame)
            np.testing.assert_allclose(solved_body(bpy.data.objects["Sleeve"]).positions, positions, atol=1e-6)


class Rendered(unittest.TestCase):

    def seen_in(self, render: Callable[[], object]) -> dict[float, np.ndarray]:
        """Positions of the body by frame, as they are read while something renders."""
        found, read = {}, bodies.read

        def spy(obj: bpy.types.Object, evaluated: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Body:
            body = read(obj, evaluated, depsgraph)
            if depsgraph.mode == "RENDER":
                found[float(depsgraph.scene.frame_current)] = body.positions
            return body

        with mock.patch.object(bodies, "read", spy):
            render()
        return found

    def test_a_body_that_no_render_shows(self) -> None:
        obj = small_renders.stage("CYCLES")
        bpy.context.scene.cycles.samples = 1
        body = sleeve.under(obj)
        expected = {}
        for frame in (3.0, 4.0, 5.0, 16.0):
            sleeve.at(int(frame))
            expected[frame] = posed(body)
        obj.rumple.body = body
        body.hide_viewport = body.hide_render = True
        bpy.context.scene.frame_start = 3
        for render, frames in ((lambda: small_renders.clip(3, 5), (3.0, 4.0, 5.0)),
                               (lambda: small_renders.still(16), (16.0,))):
            found = self.seen_in(render)
            for frame in frames:
                np.testing.assert_allclose(found[frame], expected[frame], atol=1e-6, err_msg=str(frame))
        np.testing.assert_allclose(solved_body(obj).positions, expected[16.0], atol=1e-6)
        self.assertEqual(obj.rumple.message, "")


class Connected(Worn):

    def test_what_no_modifier_names_yet_is_not_read(self) -> None:
        self.obj.rumple.body = self.body
        self.body.hide_viewport = True
        sleeve.at(3)
        modifier.set_bodies(modifier.find(self.obj), None, None)  # as an undo may leave it
        sleeve.at(12)
        self.assertEqual(runtimes.of(self.obj).inputs.frame, 3.0)
        sleeve.at(13)
        found = solved_body(self.obj).positions
        self.body.hide_viewport = False
        self.check_place(13)
        np.testing.assert_array_equal(solved_body(self.obj).positions, found)


class Baked(Worn):

    def test_another_body_makes_the_clip_stale_and_shape_keys_know_it(self) -> None:
        self.obj.rumple.body = self.body
        self.obj.rumple.bake_end = 3
        with tempfile.TemporaryDirectory() as folder:
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "scene.blend"))
            bpy.ops.object.rumple_bake()
            self.assertEqual(clip_status.check(self.obj, sleeve.output_object(self.obj)), "")
            self.obj.rumple.body = None
            self.assertIn("bodies changed since the bake", clip_status.check(self.obj, sleeve.output_object(self.obj)))
            sleeve.at(2)
            self.assertIn("bodies changed", self.obj.rumple.message)
            self.obj.rumple.body = self.body
            sleeve.at(3)
            self.assertEqual(self.obj.rumple.message, "")
            bpy.ops.object.rumple_bake_free()
        bpy.ops.object.rumple_bake_shape_keys(start=1, end=3)
        self.check_place(2)


class Linked(unittest.TestCase):

    def test_an_override_gets_a_body_of_the_shot(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            self.addCleanup(sleeve.empty_file)
            library = os.path.join(folder, "character.blend")
            obj = sleeve.scene()
            group = bpy.data.collections.new("Character")
            bpy.context.scene.collection.children.link(group)
            for member in (obj, bpy.data.objects["Arm"]):
                bpy.context.scene.collection.objects.unlink(member)
                group.objects.link(member)
            bpy.ops.wm.save_as_mainfile(filepath=library)
            scene = sleeve.empty_file()
            with bpy.data.libraries.load(library, link=True) as (_, wanted):
                wanted.collections = ["Character"]
            scene.collection.children.link(wanted.collections[0])
            bpy.context.view_layer.update()
            wanted.collections[0].override_hierarchy_create(scene, bpy.context.view_layer, do_fully_editable=True)
            mesh = sleeve.tube("Prop")
            prop = bpy.data.objects.new("Prop", mesh)
            scene.collection.objects.link(prop)
            prop.hide_viewport = True
            self.check(prop)
            path = os.path.join(folder, "shot.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
            self.check(None)

    def check(self, prop: bpy.types.Object | None) -> None:
        """prop: to be set."""
        obj = next(o for o in bpy.data.objects if o.library is None and modifier.find(o) and o.users_collection)
        if prop is not None:
            obj.rumple.body = prop
        for frame in (3, 4, 12):
            sleeve.at(frame)
        self.assertEqual(obj.rumple.message, "")
        np.testing.assert_allclose(solved_body(obj).positions, compat.positions(bpy.data.meshes["Prop"]), atol=1e-6)


if __name__ == "__main__":
    unittest.main()
