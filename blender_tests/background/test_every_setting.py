# SPDX-License-Identifier: GPL-3.0-or-later
"""Every setting of every system: keyframes, drivers, library overrides."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path
from typing import Any, Iterator

import bpy
from rumple.blender.objects import modifier, properties, runtimes
from rumple.core.systems.all_systems import SYSTEMS
from support import sleeve


def settings(obj: bpy.types.Object) -> Iterator[tuple[str, Any, Any]]:
    """(path from the object, property, its field) of all that an artist sets."""
    for method, system in SYSTEMS.items():
        obj.rumple.method = method
        group = getattr(obj.rumple, system.group)
        for name, field in properties.fields_of(obj).items():
            yield f"rumple.{system.group}.{name}", group.bl_rna.properties[name], field


def another(about: Any, now: Any) -> Any:
    """Another value of a property, as a driver or a key has it: a number."""
    if about.type == "ENUM":
        return next(item.value for item in about.enum_items if item.identifier != now)
    if about.type == "BOOLEAN":
        return float(not now)
    low, high = about.hard_min, min(about.hard_max, about.soft_max)
    step = 1.0 if about.type == "INT" else 0.25 * (high - low)
    return now + step if now + step <= high else now - step


class EverySetting(unittest.TestCase):
    def setUp(self) -> None:
        self.obj = sleeve.scene(wrinkles=False)

    def solved(self) -> list[tuple[str, Any]]:
        """What may change from frame to frame. What the fine mesh is made of may not, as Subdivision's levels should
        not."""
        return [(path, about) for path, about, field in settings(self.obj)
                if field.metadata["affects"] == "SOLVE" and about.type != "STRING"]

    def shown(self, path: str) -> Any:
        """Of the evaluated object, which is what is solved."""
        return self.obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).path_resolve(path)

    def as_number(self, path: str, about: Any) -> float:
        value = self.shown(path)
        return float(about.enum_items[value].value if about.type == "ENUM" else value)

    def test_there_are_many(self) -> None:
        self.assertGreater(len(self.solved()), 60)

    def test_keyframes(self) -> None:
        wanted = {}
        for path, about in self.solved():
            now = self.obj.path_resolve(path)
            self.assertTrue(self.obj.keyframe_insert(path, frame=1), path)
            group, _, name = path.rpartition(".")
            value = another(about, now)
            if about.type == "ENUM":
                now = next(item.identifier for item in about.enum_items if item.value == value)
            setattr(self.obj.path_resolve(group), name, now if about.type == "ENUM" else type(now)(value))
            self.obj.keyframe_insert(path, frame=9)
            wanted[path] = value
        sleeve.at(9)
        for path, about in self.solved():
            self.assertAlmostEqual(self.as_number(path, about), wanted[path], 4, path)
        sleeve.at(1)
        self.assertEqual([path for path, about in self.solved()
                          if abs(self.as_number(path, about) - wanted[path]) < 1e-6], [])

    def test_drivers(self) -> None:
        wanted = {}
        for path, about in self.solved():
            now = self.obj.path_resolve(path)
            wanted[path] = another(about, now)
            group, _, name = path.rpartition(".")  # one that was never set is made by its driver. Blender evaluates
            setattr(self.obj.path_resolve(group), name, now)  # drivers in threads, and one of two may get lost
            self.obj.driver_add(path).driver.expression = repr(float(wanted[path]))
        sleeve.at(2)
        for path, about in self.solved():
            self.assertAlmostEqual(self.as_number(path, about), wanted[path], 4, path)

    def test_a_key_changes_what_is_solved(self) -> None:
        with sleeve.context():
            bpy.ops.object.rumple_add(method="MESH")
        mesh = self.obj.rumple.mesh
        for frame, radius in ((1, 1.0), (15, 0.0)):
            mesh.radius = radius
            mesh.keyframe_insert("radius", frame=frame)
        sleeve.at(14)
        self.assertGreater(abs(sleeve.attribute(self.obj, "rumple_offset")).max(), 1e-5)
        sleeve.at(15)
        self.assertLess(abs(sleeve.attribute(self.obj, "rumple_offset")).max(), 1e-7)

    def test_a_setting_that_a_script_changes_before_it_goes_on_is_no_key(self) -> None:
        """The next frame went on from the one before, under the former setting, and was called final."""
        for keyed in (False, True):
            with self.subTest(keyed=keyed):
                obj = sleeve.scene()
                if keyed:
                    obj.rumple.mesh.keyframe_insert("radius", frame=1)
                    obj.rumple.mesh.radius = 0.4
                    obj.rumple.mesh.keyframe_insert("radius", frame=20)
                sleeve.play(1, 6)
                if not keyed:
                    obj.rumple.mesh.radius = 0.4
                sleeve.at(7)
                stored = runtimes.of(obj).evaluator.frame_cache.frames()
                self.assertEqual(stored[-1], (7.0, keyed))
                self.assertEqual(len(stored), 7 if keyed else 1)

    def test_library_overrides(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            library = Path(folder, "library.blend")
            self.obj.rumple.method = "NONE"
            with sleeve.context():
                bpy.ops.object.rumple_add(method="MESH")
            bpy.ops.wm.save_as_mainfile(filepath=str(library))
            sleeve.empty_file()
            with bpy.data.libraries.load(str(library), link=True) as (there, here):
                here.objects = ["Sleeve"]
            self.obj = bpy.data.objects["Sleeve"].override_create()
            bpy.context.scene.collection.objects.link(self.obj)
            refused = [name for group, name in self.overridable() if not group.is_property_overridable_library(name)]
            self.assertEqual(refused, [])
            self.obj.rumple.mesh.bending = 0.25
            self.assertAlmostEqual(self.obj.rumple.mesh.bending, 0.25, 6)
            self.assertIsNotNone(modifier.find(self.obj))

    def overridable(self) -> Iterator[tuple[Any, str]]:
        """(group, name), also of what belongs to no system."""
        about = self.obj.rumple
        for group in (about, *(getattr(about, system.group) for system in SYSTEMS.values())):
            for name in group.bl_rna.properties.keys():
                if name not in ("rna_type", "name", "message"):
                    yield group, name


if __name__ == "__main__":
    unittest.main()
