# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist expects of any panel in Blender: no slider stops it, buttons say what they do, nothing stands in the
way before it is used."""
from __future__ import annotations

import unittest
from typing import Any, Iterator
from unittest import mock

import bpy
import numpy as np
from rumple.blender import ui_base
from rumple.blender.nodes import field_shader
from rumple.blender.objects import building, evaluator, properties, runtimes
from rumple.blender.ui import menus, panels
from rumple.core.settings.system_settings import MeshSettings
from rumple.core.systems.all_systems import SYSTEMS
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from rumple.native.library import Stopped
from support import sleeve
from support.registered import own_classes


class Budget(unittest.TestCase):
    """The first drag of Wavelength froze Blender for two minutes: 12 pixels to the left asked for three million
    vertices."""

    def garment(self, method: str) -> bpy.types.Object:
        obj = sleeve.scene(wrinkles=False)
        obj.rumple.most_vertices = 10_000
        bpy.ops.object.rumple_add(method=method)
        return obj

    def dragged_to_the_end(self, obj: bpy.types.Object, name: str) -> int:
        settings = properties.group_of(obj)
        setattr(settings, name, settings.bl_rna.properties[name].hard_min)
        sleeve.at(2)
        sleeve.at(3)
        return runtimes.of(obj).evaluator.vertex_count

    def test_folds_become_as_fine_as_it_allows_and_it_is_said(self) -> None:
        for method, name in (("MESH", "wavelength"), ("PATHS", "width")):
            obj = self.garment(method)
            count = self.dragged_to_the_end(obj, name)
            self.assertLessEqual(count, 10_000 * 1.1)
            self.assertGreater(count, 10_000 / 5)
            self.assertEqual(obj.rumple.message, "")
            self.assertIn("raise Most Vertices", " ".join(line for line, _icon in panels.status_lines(obj)))
            obj.rumple.most_vertices = 50_000
            sleeve.at(4)
            sleeve.at(5)
            self.assertGreater(runtimes.of(obj).evaluator.vertex_count, 3 * count)

    def test_layers_over_a_base_cloth_too(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        obj.rumple.mesh.property_unset("base_cloth")
        obj.rumple.most_vertices = 10_000
        bpy.ops.object.rumple_add(method="MESH")
        self.assertEqual(obj.rumple.mesh.layers, "CLOTH")
        self.assertLessEqual(self.dragged_to_the_end(obj, "wavelength"), 10_000 * 1.1)

    def test_a_density_that_is_set_by_hand_is_refused_and_the_last_mesh_stays(self) -> None:
        obj = self.garment("MESH")
        before = sleeve.shown(obj)
        obj.rumple.mesh.density, obj.rumple.mesh.level = "LEVEL", 5
        sleeve.at(1)
        sleeve.at(1)
        self.assertRegex(obj.rumple.message, "^Sleeve: .* vertices, more than")
        self.assertEqual(len(sleeve.shown(obj)), len(before))
        obj.rumple.mesh.level = 1
        sleeve.at(2)
        sleeve.at(3)
        self.assertEqual(obj.rumple.message, "")

    def test_one_step_is_always_allowed(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        obj.rumple.most_vertices = 1000
        obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 1, 0
        bpy.ops.object.rumple_add(method="MESH")
        self.assertEqual(obj.rumple.message, "")
        self.assertGreater(runtimes.of(obj).evaluator.vertex_count, 3 * len(obj.data.vertices))


class Sliders(unittest.TestCase):
    """By a mouse: test_artist_in_window.py."""

    def of_systems(self) -> Iterator[Any]:
        for system in SYSTEMS.values():
            yield from getattr(bpy.data.objects.new("Any", None).rumple, system.group).bl_rna.properties

    def test_a_length_can_be_dragged(self) -> None:
        """It is drawn as a slider, of some 200 pixels."""
        for about in self.of_systems():
            if getattr(about, "unit", "") == "LENGTH":
                self.assertLess((about.soft_max - about.soft_min) / 200.0, 0.02 * about.default, about.identifier)
                self.assertLessEqual(about.soft_min, about.default / 10.0, about.identifier)
                self.assertGreaterEqual(about.soft_max, 2.0 * about.default, about.identifier)

    def test_a_plain_number_takes_some_hundred_pixels_through_its_values(self) -> None:
        """A pixel is a hundredth of Blender's step. Ten times the default is all that anybody sets by hand."""
        for about in self.of_systems():
            if about.type == "FLOAT" and (about.unit, about.subtype) == ("NONE", "NONE"):
                span = min(about.soft_max - about.soft_min, 10.0 * (about.default - about.soft_min))
                self.assertLess(0.01 * about.step, span / 100.0, about.identifier)
                self.assertGreater(0.01 * about.step, span / 1000.0, about.identifier)


class Words(unittest.TestCase):
    def test_every_method_has_a_tooltip_of_its_own(self) -> None:
        class Chosen:
            method = ""
        tips = set()
        for method in (*SYSTEMS, "MAPS"):
            Chosen.method = method
            tips.add(bpy.types.OBJECT_OT_rumple_add.description(bpy.context, Chosen))
        self.assertEqual(len(tips), len(SYSTEMS) + 1)

    def test_the_header_says_system_and_fabric(self) -> None:
        obj = sleeve.scene()
        self.assertEqual(panels.title(obj), "Wrinkle Mesh \u00b7 Cotton")
        bpy.ops.object.rumple_preset(preset="DENIM")
        self.assertEqual(panels.title(obj), "Wrinkle Mesh \u00b7 Denim")
        bpy.ops.object.rumple_remove()
        bpy.ops.object.rumple_add(method="FIELD")
        self.assertEqual(panels.title(obj), "Wrinkle Field")

    def test_what_a_single_layer_does_not_have_is_not_drawn(self) -> None:
        """With an adaptive rest shape there is one layer, whatever *Layers* says: its sliders did nothing."""
        obj = sleeve.scene()
        settings, drawn = obj.rumple.mesh, mock.Mock()
        settings.layers = "CLOTH"
        for rest_shape, layers in (("REST_POSE", True), ("ADAPTIVE", False)):
            settings.rest_shape = rest_shape
            with mock.patch.object(panels.cloth_panel, "painted", drawn):
                panels._draw_first(mock.MagicMock(), obj)
            self.assertEqual([call.args[2] for call in drawn.call_args_list], ["drape", "folds", "detail"] * layers)
            drawn.reset_mock()

    def test_the_status_in_one_line(self) -> None:
        obj = sleeve.scene()
        self.assertRegex(panels.status_line(obj), r"^[\d,]+ vertices, \d+ ms$")
        runtimes.forget(obj)
        self.assertEqual(panels.status_line(obj), "")

    def test_the_button_of_materials_says_what_it_will_do(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        bpy.ops.object.rumple_add(method="FIELD")
        self.assertTrue(field_shader.is_shaded(obj))
        bpy.ops.object.rumple_unshade()
        self.assertFalse(field_shader.is_shaded(obj))

    def test_the_panel_is_hidden_before_it_is_used(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        self.assertFalse(panels.DATA_PT_rumple.poll(bpy.context))
        bpy.ops.object.rumple_add(method="MESH")
        self.assertTrue(panels.DATA_PT_rumple.poll(bpy.context))
        self.assertEqual(bpy.context.object, obj)


class Menu(unittest.TestCase):
    """F3 finds what stands in a menu."""
    # Of another button, of a list in the panel, or not for hands
    ELSEWHERE = {"object.rumple_brush_stroke", "object.rumple_save_settings", "object.rumple_use_settings",
                 "object.rumple_select_healed", "rumple.pose_move", "rumple.pose_rename", "rumple.pose_mute",
                 "rumple.pose_solo", "wm.rumple_rebuild_wait", "wm.rumple_held_mouse",
                 "object.rumple_paint_tool"}

    def layout_of(self, menu: type) -> mock.Mock:
        """What it is drawn into."""
        layout = mock.Mock()
        layout.row.return_value = layout.column.return_value = layout  # an entry beside its picture
        menu.draw(mock.Mock(layout=layout), bpy.context)
        return layout

    def drawn(self, menu: type) -> list[str]:
        """Operators and menus that it shows."""
        layout = self.layout_of(menu)
        calls = (*layout.operator.call_args_list, *layout.operator_menu_enum.call_args_list,
                 *layout.menu.call_args_list)
        return [call.args[0] for call in calls]

    def notes(self) -> list[str]:
        """Lines of Add Modifier > Wrinkles that are no entries."""
        return [call.kwargs["text"] for call in self.layout_of(menus.OBJECT_MT_rumple_add).label.call_args_list]

    def test_where_no_system_can_be_added_it_says_why(self) -> None:
        sleeve.scene(wrinkles=False)
        self.assertEqual(self.notes(), [])
        self.assertEqual(self.drawn(menus.OBJECT_MT_rumple_add).count("object.rumple_add"), len(SYSTEMS))
        bpy.ops.object.rumple_add(method="MESH")
        self.assertEqual(self.notes(), ["This object has wrinkles already: press Remove in their panel first"])
        self.assertNotIn("object.rumple_add", self.drawn(menus.OBJECT_MT_rumple_add))
        self.assertIn("rumple.maps_add", self.drawn(menus.OBJECT_MT_rumple_add))
        bpy.ops.object.rumple_remove()
        self.assertEqual(self.notes(), [])
        with mock.patch.object(ui_base.compat, "is_editable", return_value=False):
            self.assertIn("linked from another file", self.notes()[0])

    def test_bake_all_is_an_entry_beside_bake(self) -> None:
        sleeve.scene()
        layout, made = mock.Mock(), []

        def operator(name: str, **words: str) -> mock.Mock:
            made.append((name, words, mock.Mock(every=False)))
            return made[-1][2]
        layout.operator.side_effect = operator
        menus.OBJECT_MT_rumple.draw(mock.Mock(layout=layout), bpy.context)
        self.assertEqual([(words, entry.every) for name, words, entry in made if name == "object.rumple_bake"],
                         [({}, False), ({"text": "Bake All"}, True)])

    def test_every_operator_is_in_one(self) -> None:
        sleeve.scene(wrinkles=False)
        found = set(self.drawn(menus.OBJECT_MT_rumple)) | set(self.drawn(menus.OBJECT_MT_rumple_add))
        self.assertIn("OBJECT_MT_rumple_add", found)
        operators = {cls.bl_idname for cls in own_classes(bpy.types.Operator)}
        self.assertEqual(operators - found - self.ELSEWHERE, {"wm.rumple_open_example"})  # in a checkout without any
        self.assertEqual(self.ELSEWHERE & found, set())

    def test_it_hangs_in_the_object_menu(self) -> None:
        self.assertIn(menus._object_entry, bpy.types.VIEW3D_MT_object.draw._draw_funcs)
        menus.unregister()
        self.addCleanup(menus.register)
        self.assertNotIn(menus._object_entry, bpy.types.VIEW3D_MT_object.draw._draw_funcs)


class CopyToSelected(unittest.TestCase):
    def test_other_garments_get_fabric_and_sliders_and_keep_what_is_theirs(self) -> None:
        obj = sleeve.scene()
        other = sleeve.skinned(sleeve.tube("Other"), bpy.data.objects["Arm"], "Other")
        bare = sleeve.skinned(sleeve.tube("Bare"), bpy.data.objects["Arm"], "Bare")
        sleeve.make_active(other)
        bpy.ops.object.rumple_add(method="MESH")
        other.rumple.mesh.up, other.rumple.mesh.bending = "-X", 0.1
        sleeve.make_active(obj)
        with self.assertRaisesRegex(RuntimeError, "Select other objects"):
            bpy.ops.object.rumple_copy_settings()
        bpy.ops.object.rumple_preset(preset="DENIM")
        obj.rumple.mesh.damping = 0.7
        other.select_set(True)
        bare.select_set(True)
        bpy.ops.object.rumple_copy_settings()
        ours, theirs = (properties.settings_of(o, bpy.context.scene) for o in (obj, other))
        different = {name for name in vars(ours) if getattr(ours, name) != getattr(theirs, name)}
        self.assertEqual(different, {"up"})
        self.assertEqual(other.rumple.mesh.preset, "DENIM")
        sleeve.make_active(other)
        bpy.ops.object.rumple_preset(preset="COTTON")  # the way back is known there too
        self.assertAlmostEqual(other.rumple.mesh.damping, 0.7, 5)
        self.assertEqual(bare.rumple.method, "NONE")


class FirstClick(unittest.TestCase):
    """What Adjust Last Operation has: it undoes the click, and does it again with other values."""

    def add(self, **values: object) -> bpy.types.Object:
        obj = sleeve.scene(wrinkles=False)
        bpy.ops.object.rumple_add(method="MESH", **values)
        return obj

    def test_edit_mode_shows_the_mesh_that_is_edited(self) -> None:
        """Folds of the pose once lay over its vertices, on the mesh at rest."""
        for method in ("MESH", "FIELD", "PATHS"):
            obj = sleeve.scene(wrinkles=False)
            bpy.ops.object.rumple_add(method=method)
            sleeve.at(10)
            coarse = len(obj.data.vertices)
            bpy.ops.object.mode_set(mode="EDIT")
            bpy.context.view_layer.update()
            self.assertLessEqual(len(sleeve.evaluated(obj).data.vertices), coarse, method)
            bpy.ops.object.mode_set(mode="OBJECT")

    def test_a_fabric_is_what_its_button_makes(self) -> None:
        by_button = self.add()
        bpy.ops.object.rumple_preset(preset="DENIM")
        wanted = properties.settings_of(by_button, bpy.context.scene)
        self.assertEqual(properties.settings_of(self.add(preset="DENIM"), bpy.context.scene), wanted)

    def test_a_wavelength_of_the_fabric_that_is_shown_counts(self) -> None:
        suggested = self.add().rumple.mesh.wavelength
        self.assertAlmostEqual(self.add(width=0.06, width_of="COTTON", preset="COTTON").rumple.mesh.wavelength, 0.06, 6)
        denim = self.add(width=suggested, width_of="COTTON", preset="DENIM").rumple.mesh.wavelength
        self.assertGreater(denim, 1.05 * suggested)  # another fabric brings its own

    def test_a_body_and_none(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        body = bpy.data.objects.new("Trunk", sleeve.tube("Trunk"))
        bpy.context.scene.collection.objects.link(body)
        bpy.ops.object.rumple_add(method="MESH", body="Trunk")
        self.assertEqual(obj.rumple.body, body)
        bpy.ops.object.rumple_remove()
        bpy.ops.object.rumple_add(method="MESH", body="")
        self.assertIsNone(obj.rumple.body)
        bpy.ops.object.rumple_remove()
        bpy.ops.object.rumple_add(method="MESH", body="Sleeve")  # over itself
        self.assertIsNone(obj.rumple.body)


@unittest.skipIf(bpy.app.version[:2] == (4, 3), "Debian's 4.3 has no brushes: Weight Paint without a window breaks it")
class Paint(unittest.TestCase):
    def test_a_new_group_is_full_and_the_brush_takes_away(self) -> None:
        obj = sleeve.scene()
        bpy.ops.object.mode_set(mode="WEIGHT_PAINT")  # has a brush from then on
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.ops.object.rumple_paint(group="radius")
        tools = bpy.context.tool_settings
        shared = getattr(tools, "unified_paint_settings", None) or tools.weight_paint.unified_paint_settings
        self.assertEqual(shared.weight, 0.0)
        weights = np.array([obj.vertex_groups["Rumple Radius"].weight(v.index) for v in obj.data.vertices])
        self.assertTrue((weights == 1.0).all())
        shared.weight = 0.5
        bpy.ops.object.rumple_paint(group="radius")  # it is there already: the brush is the artist's
        self.assertEqual(shared.weight, 0.5)

    def test_the_button_leaves_the_mode_again(self) -> None:
        obj = sleeve.scene()
        bpy.ops.object.rumple_paint(group="radius")
        bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
        bpy.ops.object.rumple_paint(group="bending")
        self.assertEqual((obj.mode, obj.vertex_groups.active.name), ("WEIGHT_PAINT", "Rumple Bending"))
        bpy.ops.object.rumple_paint(group="bending")
        self.assertEqual(obj.mode, "OBJECT")


class Dropped(unittest.TestCase):
    """What is built in a thread and wanted no more went on to its end, beside what was wanted in its place."""

    def setUp(self) -> None:
        self.obj = sleeve.scene()
        sleeve.at(1)
        self.runtime = runtimes.of(self.obj)

    def long(self) -> building.Building:
        """Work that ends by itself after a minute."""
        base = self.runtime.evaluator.base

        def build() -> WrinkleMesh:
            for _ in range(2000):
                made = WrinkleMesh.build(base, MeshSettings(density="LEVEL", level=3))
            return made

        return building.Building("Sleeve", "", build)

    def test_its_thread_ends(self) -> None:
        work, other = self.long(), self.long()
        work.drop()
        self.assertFalse(work.is_running(20.0))
        self.assertRaises(Stopped, work.result)
        self.assertTrue(other.is_running())
        sleeve.empty_file()
        self.assertFalse(other.is_running(20.0))

    def test_esc_and_another_value_drop_it(self) -> None:
        with mock.patch.object(building.Building, "is_running", return_value=True), mock.patch.object(
                building.Building, "drop", autospec=True) as dropped:
            self.obj.rumple.mesh.level = 2
            first = evaluator.begin(self.obj, self.runtime)
            self.obj.rumple.mesh.level = 0
            second = evaluator.begin(self.obj, self.runtime)
            self.assertIsNot(second, first)
            dropped.assert_called_once_with(first)
            evaluator.cancel(self.obj, self.runtime)
            dropped.assert_called_with(second)
            self.obj.rumple.mesh.level = 0
            third = evaluator.begin(self.obj, self.runtime)
            self.obj.rumple.mesh.level = 2
            evaluator.ensure(self.obj, self.runtime)
            dropped.assert_called_with(third)


if __name__ == "__main__":
    unittest.main()
