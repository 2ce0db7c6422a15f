# SPDX-License-Identifier: GPL-3.0-or-later
"""The artist's own presets: the same cloth in any scene, and nothing that is not a setting."""
from __future__ import annotations

import json
import unittest
from pathlib import Path
from typing import Any

import bpy
from rumple.blender.objects import properties
from rumple.blender.ui import saved_settings
from support import sleeve

FOLDER = "presets/rumple_mesh"


def preset_file(name: str) -> Path:
    return Path(bpy.utils.user_resource("SCRIPTS", path=FOLDER)) / f"{name}.py"


def use(path: Path) -> Any:
    return bpy.ops.script.execute_preset(filepath=str(path), menu_idname="DATA_PT_rumple_saved_settings")


class SavedSettings(unittest.TestCase):

    def setUp(self) -> None:
        self.obj = sleeve.scene()

    def saved(self, name: str = "curtain") -> Path:
        with sleeve.context():
            self.assertEqual(bpy.ops.object.rumple_save_settings(name=name), {"FINISHED"})
        return preset_file(name)

    def test_a_saved_preset_brings_every_setting_back_in_a_scene_of_another_unit(self) -> None:
        mesh = self.obj.rumple.mesh
        mesh.bending, mesh.wavelength, mesh.iterations, mesh.collision, mesh.stateless = 0.25, 0.09, 17, "NONE", True
        wanted = saved_settings.values_of(self.obj, bpy.context.scene)
        path = self.saved()
        obj = sleeve.scene()
        bpy.context.scene.unit_settings.scale_length = 0.01
        self.assertNotEqual(saved_settings.values_of(obj, bpy.context.scene)["wavelength"], wanted["wavelength"])
        with sleeve.context():
            use(path)
        found = saved_settings.values_of(obj, bpy.context.scene)
        for name, value in wanted.items():
            if isinstance(value, float):
                self.assertAlmostEqual(found[name], value, delta=1e-5 * abs(value), msg=name)
            else:
                self.assertEqual(found[name], value, name)
        sleeve.at(4)
        self.assertEqual(obj.rumple.message, "")

    def test_names_with_any_letters_are_read_back(self) -> None:
        """A quotation mark ended the text, and a backslash was lost."""
        self.obj = sleeve.scene(wrinkles=False)
        with sleeve.context():
            bpy.ops.object.rumple_add(method="FIELD")
        for number, name in enumerate(('My "best" mask', "a\\new\\", "\u00e4rmel", '"""')):
            self.obj.rumple.field.mask = name
            path = Path(str(self.saved(f"letters_{number}")).replace("rumple_mesh", "rumple_field"))
            self.obj.rumple.field.mask = ""
            with sleeve.context():
                use(path)
            self.assertEqual(self.obj.rumple.field.mask, name)

    def test_it_is_a_step_of_undo_also_from_a_file_of_an_older_rumple(self) -> None:
        """Undo took back what had been done before it, too."""
        path = self.saved("undone")
        before = self.obj.rumple.mesh.radius
        self.obj.rumple.mesh.radius = 2 * before
        with sleeve.context():
            for place in (1.0, 5.0):
                self.obj.location.x = place
                bpy.ops.ed.undo_push(message="moved")
            bpy.ops.script.execute_preset("EXEC_DEFAULT", True, filepath=str(path),
                                          menu_idname="DATA_PT_rumple_saved_settings")
            self.assertAlmostEqual(bpy.data.objects["Sleeve"].rumple.mesh.radius, before, 6)
            bpy.ops.ed.undo()
        obj = bpy.data.objects["Sleeve"]
        self.assertAlmostEqual(obj.rumple.mesh.radius, 2 * before, 6)
        self.assertEqual(obj.location.x, 5.0)

    def test_what_belongs_to_a_mesh_is_not_in_it(self) -> None:
        self.assertFalse(saved_settings.OWN & set(saved_settings.values_of(self.obj, bpy.context.scene)))

    def test_it_is_removed_by_its_name(self) -> None:
        path = self.saved("gone")
        self.assertTrue(path.is_file())
        with sleeve.context():
            bpy.ops.object.rumple_save_settings(remove_name=True, name="gone")
        self.assertFalse(path.exists())

    def test_values_that_are_none_are_left_out_and_named(self) -> None:
        good = {"bending": 1, "iterations": 12}
        bad = {"radius": "wide", "iterations_": 3, "stateless": 1, "collision": "WALL", "damping": float("nan"),
               "source": "REGULAR", "level": 2.5}
        known, refused = saved_settings.checked(self.obj, json.dumps({**good, **bad}))
        self.assertEqual(known, {"bending": 1.0, "iterations": 12})
        self.assertEqual(sorted(refused), sorted(bad))

    def test_what_is_no_preset_of_this_system_is_refused_in_words(self) -> None:
        before = properties.settings_of(self.obj, bpy.context.scene)
        for method, values, words in (("PATHS", "{}", "not of a Wrinkle Mesh"), ("MESH", "[]", "no settings"),
                                      ("MESH", "{", "cannot be read")):
            with sleeve.context(), self.assertRaisesRegex(RuntimeError, words):
                bpy.ops.object.rumple_use_settings(method=method, values=values)
        self.assertEqual(properties.settings_of(self.obj, bpy.context.scene), before)


if __name__ == "__main__":
    unittest.main()
