# SPDX-License-Identifier: GPL-3.0-or-later
"""What is done with a whole painted map, and the panel that lists them."""
from __future__ import annotations

import os
import tempfile
import unittest
from unittest import mock

import bpy
import numpy as np
from rumple.blender.objects import mesh_reader, painted_maps, properties, runtimes
from rumple.blender.ui import paint_operators, paint_panel
from support import sleeve

RING = sleeve.LENGTH / (sleeve.ALONG - 1)  # from one ring of the sleeve to the next


def weights(obj: bpy.types.Object, name: str = "Rumple Radius") -> np.ndarray:
    return mesh_reader.group_weights(obj, obj.data, [name])[:, 0]


def give(obj: bpy.types.Object, values: np.ndarray, name: str = "Rumple Radius") -> None:
    group = obj.vertex_groups.get(name) or obj.vertex_groups.new(name=name)
    for vertex, weight in enumerate(values.tolist()):
        group.add([vertex], weight, "REPLACE")
    obj.data.update()


def uneven(obj: bpy.types.Object) -> np.ndarray:
    return np.random.default_rng(3).random(len(obj.data.vertices)).astype(np.float32)


class Attributes(unittest.TestCase):

    def test_a_float_attribute_paints_as_a_vertex_group_does(self) -> None:
        """Of the Wrinkle Mesh some counted, and others did not."""
        shown = []
        for as_group in (True, False):
            obj = sleeve.scene(wrinkles=False)
            painted = np.float32(0.4) + np.float32(0.6) * uneven(obj)
            if as_group:
                give(obj, painted)
            else:
                obj.data.attributes.new("Rumple Radius", "FLOAT", "POINT").data.foreach_set("value", painted)
            bpy.ops.object.rumple_add(method="MESH")
            sleeve.play()
            shown.append(sleeve.shown(obj).copy())
        np.testing.assert_array_equal(*shown)


class Whole(unittest.TestCase):
    def test_inverted_twice_is_as_it_was(self) -> None:
        obj = sleeve.scene()
        painted = uneven(obj)
        give(obj, painted)
        bpy.ops.object.rumple_paint_invert(group="radius")
        np.testing.assert_allclose(weights(obj), 1.0 - painted, atol=1e-7)
        bpy.ops.object.rumple_paint_invert(group="radius")
        np.testing.assert_allclose(weights(obj), painted, atol=1e-7)

    def test_a_vertex_that_is_in_no_group_counts_as_0(self) -> None:
        obj = sleeve.scene()
        obj.vertex_groups.new(name="Rumple Radius").add([3], 0.25, "REPLACE")
        bpy.ops.object.rumple_paint_invert(group="radius")
        self.assertAlmostEqual(weights(obj)[3], 0.75, 6)
        self.assertEqual(weights(obj)[4], 1.0)

    def test_cleared_is_as_never_painted(self) -> None:
        for method, key, name in (("MESH", "radius", "Rumple Radius"), ("MESH", "smooth", "Rumple Keep Smooth"),
                                  ("FIELD", "mask", "Rumple Mask"), ("PATHS", "mask", "Rumple Mask")):
            with self.subTest(method):
                obj = sleeve.scene(wrinkles=False)
                obj.rumple.field.output = "GEOMETRY"
                obj.rumple.mesh.density, obj.rumple.mesh.level = "LEVEL", 1
                bpy.ops.object.rumple_add(method=method)
                sleeve.play()
                before = sleeve.shown(obj).copy()
                give(obj, 0.5 * uneven(obj), name)
                sleeve.play()
                self.assertGreater(np.abs(sleeve.shown(obj) - before).max(), 1e-5)
                bones = sleeve.names(obj.vertex_groups)
                bpy.ops.object.rumple_paint_clear(group=key)
                self.assertEqual(sleeve.names(obj.vertex_groups), sorted(set(bones) - {name}))
                sleeve.play()
                np.testing.assert_array_equal(sleeve.shown(obj), before)

    def test_the_active_group_stays(self) -> None:
        obj = sleeve.scene()
        give(obj, uneven(obj))
        give(obj, uneven(obj), "Rumple Bending")
        obj.vertex_groups.active_index = obj.vertex_groups["Rumple Bending"].index
        bpy.ops.object.rumple_paint_clear(group="radius")
        self.assertEqual(obj.vertex_groups.active.name, "Rumple Bending")

    def test_only_what_a_mask_selects_changes(self) -> None:
        for mask in ("use_paint_mask_vertex", "use_paint_mask"):
            with self.subTest(mask):
                obj = sleeve.scene()
                painted = uneven(obj)
                give(obj, painted)
                chosen = self.select(obj, mask)
                bpy.ops.object.rumple_paint_invert(group="radius")
                np.testing.assert_array_equal(weights(obj)[~chosen], painted[~chosen])
                np.testing.assert_allclose(weights(obj)[chosen], 1.0 - painted[chosen], atol=1e-7)
                bpy.ops.object.rumple_paint_clear(group="radius")
                np.testing.assert_array_equal(weights(obj)[~chosen], painted[~chosen])
                self.assertTrue((weights(obj)[chosen] == 1.0).all())

    def select(self, obj: bpy.types.Object, mask: str) -> np.ndarray:
        """The first two rings, or the faces between them."""
        mesh = obj.data
        mesh.vertices.foreach_set("select", np.arange(len(mesh.vertices)) < 2 * sleeve.AROUND)
        mesh.polygons.foreach_set("select", np.arange(len(mesh.polygons)) < sleeve.AROUND)
        if mask == "use_paint_mask":
            mesh.vertices.foreach_set("select", np.zeros(len(mesh.vertices), bool))
        setattr(mesh, mask, True)
        return np.arange(len(mesh.vertices)) < 2 * sleeve.AROUND

    def test_a_new_map_under_a_mask_changes_nothing_else(self) -> None:
        obj = sleeve.scene()
        chosen = self.select(obj, "use_paint_mask_vertex")
        bpy.ops.object.rumple_paint_from_border(group="radius", distance=10.0, falloff="LINEAR")
        self.assertTrue((weights(obj)[~chosen] == 1.0).all())
        self.assertLess(weights(obj)[chosen].max(), 0.01)

    def test_undo_brings_back_the_exact_weights(self) -> None:
        for operator in ("invert", "clear", "from_border"):
            with self.subTest(operator):
                obj = sleeve.scene()
                painted = uneven(obj)
                give(obj, painted)
                bpy.ops.ed.undo_push(message="painted")
                getattr(bpy.ops.object, f"rumple_paint_{operator}")(group="radius")
                bpy.ops.ed.undo_push(message="changed")
                bpy.ops.ed.undo()
                obj = bpy.data.objects["Sleeve"]
                np.testing.assert_array_equal(weights(obj), painted)


class FromBorder(unittest.TestCase):
    def grown(self, key: str = "radius", **how: object) -> np.ndarray:
        obj = sleeve.scene()
        self.assertEqual(bpy.ops.object.rumple_paint_from_border(group=key, **how), {"FINISHED"})
        return weights(obj, mesh_reader.MESH_GROUPS[key]).reshape(sleeve.ALONG, sleeve.AROUND)

    def test_it_is_0_at_the_border_and_1_behind_the_distance(self) -> None:
        along = np.minimum(np.arange(sleeve.ALONG), np.arange(sleeve.ALONG)[::-1]) * RING
        for falloff in ("LINEAR", "SMOOTH"):
            rings = self.grown(distance=3.0 * RING, falloff=falloff)
            share = np.clip(along / (3.0 * RING), 0.0, 1.0)
            share = share if falloff == "LINEAR" else share * share * (3.0 - 2.0 * share)
            np.testing.assert_allclose(rings, np.repeat(share[:, None], sleeve.AROUND, 1), atol=1e-5)

    def test_what_is_0_without_a_map_grows_the_other_way(self) -> None:
        rings = self.grown("smooth", distance=2.5 * RING)
        self.assertTrue((rings[[0, -1]] == 1.0).all() and (rings[3:-3] == 0.0).all())
        np.testing.assert_allclose(self.grown("smooth", distance=2.5 * RING, reverse=False), 1.0 - rings, atol=1e-6)

    def test_the_distance_is_in_metres(self) -> None:
        """5 cm where none is given, whatever the unit and the size of the object."""
        plain = self.grown(falloff="LINEAR")
        np.testing.assert_allclose(plain[1], RING / 0.05 if RING < 0.05 else 1.0, atol=1e-5)
        obj = sleeve.scene()
        obj.scale = (3.0, 3.0, 3.0)
        bpy.context.scene.unit_settings.scale_length = 0.01
        bpy.context.view_layer.update()
        bpy.ops.object.rumple_paint_from_border(group="radius", distance=30.0 * RING, falloff="LINEAR")
        np.testing.assert_allclose(weights(obj)[sleeve.AROUND:2 * sleeve.AROUND], 0.1, atol=1e-5)
        bpy.ops.object.rumple_paint_from_border(group="radius", falloff="LINEAR")  # 5 cm are 5 units
        np.testing.assert_allclose(weights(obj)[sleeve.AROUND:2 * sleeve.AROUND], 3.0 * RING / 5.0, atol=1e-5)

    def test_of_a_garment_whose_scale_is_zero(self) -> None:
        """It has an open border, but the message said that there is none. What pops up from a scale of zero is measured
        at the scale that its wrinkles are made for."""
        expected = self.grown(distance=2.5 * RING).ravel()
        obj = sleeve.scene(wrinkles=False)
        for frame, scale in ((1, 0.0), (5, 1.0)):
            obj.scale = (scale, scale, scale)
            obj.keyframe_insert("scale", frame=frame)
        sleeve.at(1)
        sleeve.click(obj)
        bpy.ops.object.rumple_paint_from_border(group="radius", distance=2.5 * RING)
        np.testing.assert_allclose(weights(obj, mesh_reader.MESH_GROUPS["radius"]), expected, atol=1e-6)
        obj.animation_data_clear()
        obj.scale = (0.0, 0.0, 0.0)
        sleeve.at(2)
        with self.assertRaisesRegex(RuntimeError, "Sleeve: its scale is zero"):
            bpy.ops.object.rumple_paint_from_border(group="radius", distance=2.5 * RING)

    def test_without_a_border_it_says_so(self) -> None:
        obj = sleeve.scene()
        closed = bpy.data.meshes.new("Closed")
        closed.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [],
                           [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
        obj.data = closed
        with self.assertRaisesRegex(RuntimeError, "Sleeve: it has no open border"):
            bpy.ops.object.rumple_paint_from_border(group="radius")
        self.assertNotIn("Rumple Radius", obj.vertex_groups)


class FromTexture(unittest.TestCase):
    def sheet(self) -> bpy.types.Object:
        """One quad, whose UV coordinates are the middles of the pixels of an image of 2 x 2, and half of a second quad
        beside it."""
        sleeve.empty_file()
        mesh = bpy.data.meshes.new("Sheet")
        mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)], [],
                         [(0, 1, 2, 3), (1, 4, 5, 2)])
        obj = bpy.data.objects.new("Sheet", mesh)
        bpy.context.scene.collection.objects.link(obj)
        sleeve.make_active(obj)
        bpy.ops.object.rumple_add(method="MESH")
        return obj

    def unwrap(self, obj: bpy.types.Object) -> None:
        uv = ((0.25, 0.25), (0.75, 0.25), (0.75, 0.75), (0.25, 0.75), (0.25, 0.25), (0.5, 0.25), (0.5, 0.5),
              (0.25, 0.75))
        obj.data.uv_layers.new(name="UVMap").data.foreach_set("uv", np.array(uv, np.float32).ravel())

    def image(self) -> None:
        image = bpy.data.images.new("Mask", 2, 2, float_buffer=True, alpha=True)
        image.pixels.foreach_set(np.array(((0.0, 0.2, 0.4, 1.0), (1.0, 0.4, 0.4, 0.5), (0.5, 0.6, 0.4, 0.25),
                                           (0.25, 0.8, 0.4, 0.0)), np.float32).ravel())

    def test_by_hand(self) -> None:
        """Vertex 1 has two corners: 1.0 and 0.0 of the red; so has vertex 2: 0.25 and 0.5."""
        obj = self.sheet()
        self.unwrap(obj)
        self.image()
        for channel, expected in (
                ("RED", (0.0, (1.0 + 0.0) / 2, (0.25 + 0.5) / 2, 0.5, 0.5, 0.4375)),
                ("ALPHA", (1.0, (0.5 + 1.0) / 2, (0.0 + 0.25) / 2, 0.25, 0.75, 0.4375)),
                ("BLUE", (0.4,) * 6)):
            bpy.ops.object.rumple_paint_from_texture(group="radius", image="Mask", channel=channel)
            np.testing.assert_allclose(weights(obj), expected, atol=1e-6)

    def test_what_is_missing_is_said(self) -> None:
        obj = self.sheet()
        for wrong, ready in (("it has no UV map .* unwrap it", lambda: self.unwrap(obj)),
                             ("there is no image \"Mask\"", self.image)):
            with self.assertRaisesRegex(RuntimeError, f"Sheet: {wrong}"):
                bpy.ops.object.rumple_paint_from_texture(group="radius", image="Mask")
            ready()
        lost = bpy.data.images.new("Lost", 4, 4)
        lost.source, lost.filepath = "FILE", "//nowhere.png"
        with self.assertRaisesRegex(RuntimeError, "Sheet: the pixels of \"Lost\" cannot be read"):
            bpy.ops.object.rumple_paint_from_texture(group="radius", image="Lost")
        with self.assertRaisesRegex(RuntimeError, "Sheet: choose an image first"):
            bpy.ops.object.rumple_paint_from_texture(group="radius")
        self.assertNotIn("Rumple Radius", obj.vertex_groups)
        bpy.ops.object.rumple_paint_from_texture(group="radius", image="Mask")

    def test_the_image_of_the_material_is_offered(self) -> None:
        obj = self.sheet()
        self.assertEqual(paint_operators._likely_image(obj), "")
        self.image()
        self.assertEqual(paint_operators._likely_image(obj), "Mask")


class Refused(unittest.TestCase):
    OPERATORS = ("rumple_paint", "rumple_paint_clear", "rumple_paint_invert", "rumple_paint_from_border",
                 "rumple_paint_from_texture", "rumple_paint_from_material")

    def refused(self, words: str, **how: str) -> None:
        for name in self.OPERATORS:
            with self.subTest(name), self.assertRaisesRegex(RuntimeError, words):
                getattr(bpy.ops.object, name)(**how)

    def test_a_linked_mesh_and_an_override_of_it(self) -> None:
        obj = sleeve.scene()
        give(obj, uneven(obj))
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "sleeve.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            sleeve.empty_file()
            with bpy.data.libraries.load(path, link=True) as (_, wanted):
                wanted.objects = ["Sleeve"]
            linked = bpy.data.objects["Sleeve"]
            bpy.context.scene.collection.objects.link(linked)
            bpy.context.view_layer.objects.active = linked
            self.refused("This object is linked from another file", group="radius")
            ours = linked.override_create(remap_local_usages=True)
            bpy.context.view_layer.objects.active = ours
            self.refused("This mesh is linked from another file: append it", group="radius")
            with self.assertRaisesRegex(RuntimeError, "This mesh is linked from another file: append it"):
                bpy.ops.object.rumple_capture_rest(frame=1)
            mesh = ours.data.override_create(remap_local_usages=True)
            self.assertEqual(ours.data, mesh)
            self.refused("This mesh is a library override, which keeps no paint", group="radius")
            sleeve.empty_file()

    def test_a_locked_group_and_one_that_is_not_there(self) -> None:
        obj = sleeve.scene()
        for name in ("clear", "invert"):
            with self.assertRaisesRegex(RuntimeError, "Sleeve: nothing is painted in Rumple Radius yet"):
                getattr(bpy.ops.object, f"rumple_paint_{name}")(group="radius")
        give(obj, uneven(obj))
        obj.vertex_groups["Rumple Radius"].lock_weight = True
        for name in ("clear", "invert", "from_border"):
            with self.assertRaisesRegex(RuntimeError, "Sleeve: the vertex group Rumple Radius is locked"):
                getattr(bpy.ops.object, f"rumple_paint_{name}")(group="radius")
        with self.assertRaisesRegex(RuntimeError, "Sleeve: its wrinkles have no mask to paint"):
            bpy.ops.object.rumple_paint_from_border(group="mask")

    def test_edit_mode(self) -> None:
        sleeve.scene()
        bpy.ops.object.mode_set(mode="EDIT")
        self.addCleanup(lambda: bpy.ops.object.mode_set(mode="OBJECT"))
        self.refused("Leave Edit Mode first", group="radius")


class Listed(unittest.TestCase):
    def keys(self, obj: bpy.types.Object) -> list[str]:
        return [painted.key for painted in painted_maps.of(obj)]

    def test_what_acts_and_what_is_painted(self) -> None:
        obj = sleeve.scene()  # one layer, no base cloth
        self.assertEqual(self.keys(obj), ["radius", "prestretch", "bending", "inside", "smooth", "rigid"])
        obj.rumple.mesh.collision = "NONE"
        give(obj, uneven(obj), "Rumple Drape")
        self.assertEqual(self.keys(obj), ["drape", "radius", "prestretch", "bending", "smooth", "rigid"])
        obj.rumple.mesh.base_cloth, obj.rumple.mesh.layers = "HANG", "CLOTH"
        self.assertEqual(self.keys(obj), ["drape", "folds", "detail", "radius", "prestretch", "bending", "room", "free",
                                          "follow", "smooth", "rigid"])
        bpy.ops.object.rumple_remove()
        bpy.ops.object.rumple_add(method="FIELD")
        self.assertEqual(self.keys(obj), ["mask", "wavelength", "smooth", "rigid"])
        obj.rumple.field.mask = "Mine"
        self.assertEqual(painted_maps.find(obj, "mask").name, "Mine")
        obj.rumple.field.mask = ""
        self.assertEqual(self.keys(obj), ["wavelength", "smooth", "rigid"])

    def test_names_are_those_of_the_settings(self) -> None:
        labels = painted_maps.LABELS
        self.assertEqual((labels["detail"], labels["radius"], labels["wavelength"], labels["room"]),
                         ("Detail", "Radius", "Wavelength Scale", "Room"))

    def test_every_map_of_every_system_is_known(self) -> None:
        for method in ("MESH", "FIELD", "PATHS"):
            obj = sleeve.scene(wrinkles=False)
            bpy.ops.object.rumple_add(method=method)
            names = mesh_reader.paint_groups(properties.settings_of(obj, bpy.context.scene))
            self.assertEqual(names.keys() - set(painted_maps.KEYS), set())

    def test_numbers_are_of_what_was_read_and_computed_once(self) -> None:
        obj = sleeve.scene()
        self.assertEqual(painted_maps.measured(obj), {})
        values = np.ones(len(obj.data.vertices), np.float32)
        values[:48] = 0.25
        give(obj, values)
        sleeve.at(2)
        sleeve.at(3)
        mean, share = painted_maps.measured(obj)["radius"]
        self.assertAlmostEqual(mean, float(values.mean()), 6)
        self.assertAlmostEqual(share, 48 / len(values), 6)
        with mock.patch.object(painted_maps.paint_maps, "numbers", side_effect=AssertionError), \
                mock.patch.object(mesh_reader, "group_weights", side_effect=AssertionError):
            self.assertEqual(painted_maps.measured(obj)["radius"], (mean, share))
            runtimes.of(obj).paint.values = None  # to be read again: the former ones stay meanwhile
            self.assertEqual(painted_maps.measured(obj)["radius"], (mean, share))
        bpy.ops.object.rumple_paint_invert(group="radius")
        sleeve.at(4)
        self.assertAlmostEqual(painted_maps.measured(obj)["radius"][0], 1.0 - mean, 6)
        bpy.ops.object.rumple_paint_clear(group="radius")
        sleeve.at(5)
        self.assertEqual(painted_maps.measured(obj), {})

    def test_numbers_while_nothing_is_solved(self) -> None:
        """As while a clip is shown: the timer of the panel reads."""
        obj = sleeve.scene()
        give(obj, uneven(obj))
        runtimes.of(obj).paint.values = None
        self.assertTrue(painted_maps._read_for_panel(obj))
        self.assertAlmostEqual(painted_maps.measured(obj)["radius"][0], float(uneven(obj).mean()), 5)

    def test_words(self) -> None:
        self.assertEqual(paint_panel.words((0.618, 0.314)), "mean 0.62 \u00b7 31 % of the vertices")
        self.assertEqual(paint_panel.words((1.0, 0.0)), "mean 1.00 \u00b7 0 % of the vertices")
        self.assertEqual(paint_panel.words((1.0, 0.001)), "mean 1.00 \u00b7 < 1 % of the vertices")


if __name__ == "__main__":
    unittest.main()
